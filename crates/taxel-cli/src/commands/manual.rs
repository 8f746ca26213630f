//! `taxel manual`: what a package of the command ships beside it, written by the command itself. Hidden, and only in
//! builds with the feature `manual`.

use std::fs;
use std::io;
use std::path::PathBuf;

use clap::{CommandFactory, ValueEnum};
use clap_complete::Shell;

use crate::error::Error;
use crate::{Cli, Exit, help};

/// Write completions for every shell and a man page for every verb; for who packages the command
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder for `completions` and `man`
    folder: PathBuf,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    write(args).map_err(|source| taxel_io::Error::Create {
        file: args.folder.clone(),
        source,
    })?;
    Ok(Exit::Good)
}

fn write(args: &Args) -> io::Result<()> {
    let mut command = help::with_examples(Cli::command(), usize::MAX);
    let completions = args.folder.join("completions");
    fs::create_dir_all(&completions)?;
    for shell in Shell::value_variants() {
        clap_complete::generate_to(*shell, &mut command, "taxel", &completions)?;
    }
    let man = args.folder.join("man");
    fs::create_dir_all(&man)?;
    clap_mangen::generate_to(command, &man)
}
