//! `taxel completions`: what lets a shell complete the command's verbs, options and names.

use clap::{CommandFactory, ValueEnum};
use clap_complete::{Shell, generate};

use crate::error::Error;
use crate::{Cli, Exit, help, out};

/// Print the script by which a shell completes verbs and options
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// For which shell
    #[arg(value_enum)]
    shell: ShellName,
}

/// The shells that people type into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ShellName {
    Bash,
    Zsh,
    Fish,
}

impl From<ShellName> for Shell {
    fn from(name: ShellName) -> Self {
        match name {
            ShellName::Bash => Shell::Bash,
            ShellName::Zsh => Shell::Zsh,
            ShellName::Fish => Shell::Fish,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    // Into memory first: what clap_complete writes to a closed pipe ends in a panic.
    let mut script = Vec::new();
    let mut command = help::with_examples(Cli::command(), usize::MAX);
    generate(Shell::from(args.shell), &mut command, "taxel", &mut script);
    out::result(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Good)
}
