//! The `taxel` command: from raw frames of a resistive pressure-sensor matrix to calibrated loads.
//!
//! This file parses, dispatches, and turns one outcome into one exit code. Every verb has its file in
//! `commands/`; the mathematics is in crate `taxel`, reading and writing in `taxel-io`, pictures in
//! `taxel-plot`.

mod commands;
mod doubts;
mod enter;
mod error;
mod help;
mod hints;
mod interrupt;
mod news;
mod out;
mod outputs;
mod patience;
mod progress;
mod recorded;
mod sending;
mod training_files;
mod values;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use commands::{
    analyse, batch, bench, calibrate, compare, compensate, convert, dataset, demo, devices,
    evaluate, info, model, netlist, plot, record, recover, replay, report, simulate, stream, train,
};

/// From raw frames of a resistive pressure-sensor matrix to calibrated loads.
///
/// Results go to standard output, everything else to standard error. Exit codes: 0 good, 1 failed, 2 bad
/// arguments, 3 finished but data was lost or left out.
#[derive(Debug, Parser)]
#[command(name = "taxel", version, max_term_width = help::WIDEST)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Live(commands::live::Args),
    Grip(commands::grip::Args),
    View(commands::live::ViewArgs),
    Record(record::Args),
    Replay(replay::Args),
    Stream(stream::Args),
    Convert(convert::Args),
    Recover(recover::Args),
    Devices(devices::Args),
    Info(info::Args),
    Analyse(analyse::Args),
    Measure(commands::measure::Args),
    Selftest(commands::selftest::Args),
    Identify(commands::identify::Args),
    Calibrate(Box<calibrate::Args>),
    Check(commands::check::Args),
    Compensate(compensate::Args),
    Batch(batch::Args),
    Dataset(dataset::Args),
    Train(train::Args),
    Compare(compare::Args),
    Model(model::Args),
    Plot(Box<plot::Args>),
    Evaluate(evaluate::Args),
    Report(report::Args),
    Simulate(simulate::Args),
    Netlist(netlist::Args),
    Budget(commands::budget::Args),
    Design(commands::design::Args),
    Rig(commands::rig::Args),
    Crosstalk(commands::crosstalk::Args),
    Bench(bench::Args),
    Demo(demo::Args),
    Completions(commands::completions::Args),
    #[cfg(feature = "manual")]
    #[command(hide = true)]
    Manual(commands::manual::Args),
}

/// How a command that did not fail ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Exit {
    /// All of it.
    Good,
    /// Finished, but data was lost or left out.
    DataLost,
    /// A test found something.
    Found,
}

fn main() -> ExitCode {
    interrupt::guard();
    let matches = help::with_examples(Cli::command(), help::width()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    patience::watch_pipes(std::env::args_os().skip(1).map(Into::into));
    let result = match cli.command {
        Command::Live(args) => commands::live::run(&args),
        Command::Grip(args) => commands::grip::run(&args),
        Command::View(args) => commands::live::run_view(&args),
        Command::Record(args) => record::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Stream(args) => stream::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Recover(args) => recover::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Analyse(args) => analyse::run(&args),
        Command::Measure(args) => commands::measure::run(&args),
        Command::Selftest(args) => commands::selftest::run(&args),
        Command::Identify(args) => commands::identify::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Netlist(args) => netlist::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Calibrate(args) => calibrate::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Compensate(args) => compensate::run(&args),
        Command::Batch(args) => batch::run(&args),
        Command::Simulate(args) => simulate::run(&args),
        Command::Budget(args) => commands::budget::run(&args),
        Command::Design(args) => commands::design::run(&args),
        Command::Rig(args) => commands::rig::run(&args),
        Command::Crosstalk(args) => commands::crosstalk::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Dataset(args) => dataset::run(&args),
        Command::Train(args) => train::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Model(args) => model::run(&args),
        Command::Completions(args) => commands::completions::run(&args),
        #[cfg(feature = "manual")]
        Command::Manual(args) => commands::manual::run(&args),
    };
    match result {
        Ok(Exit::Good) => ExitCode::SUCCESS,
        Ok(Exit::DataLost | Exit::Found) => ExitCode::from(3),
        // Who reads our output has read enough.
        Err(error) if error.is_broken_pipe() => ExitCode::SUCCESS,
        Err(error) => {
            let typed = matches.subcommand_name().unwrap_or_default();
            let all = Cli::command();
            let verb = all.find_subcommand(typed).unwrap_or(&all);
            out::note(&format!("error: {}", hints::told(&error, verb)));
            ExitCode::from(error.exit_code())
        }
    }
}
