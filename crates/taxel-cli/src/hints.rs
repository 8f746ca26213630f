//! What a person at the command can type after an error: the library's errors know no options and no verbs.

use crate::error::Error;

/// The error as it is printed: what the library says, and what helps here. `verb` is the command that was typed: what it
/// has no option for does not help.
pub(crate) fn told(error: &Error, verb: &clap::Command) -> String {
    let text = error.to_string();
    let Some(help) = help(error).filter(|help| has_options(verb, help)) else {
        return text;
    };
    if text.contains("\nhint: ") {
        format!("{text}; {help}")
    } else {
        format!("{text}\nhint: {help}")
    }
}

/// Whether a verb knows the options that a sentence names; one that names another program's or verb's says so.
fn has_options(verb: &clap::Command, help: &str) -> bool {
    if help.contains("`taxel ") || help.contains("`cargo ") {
        return true;
    }
    let words = help.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
    words
        .filter_map(|word| word.strip_prefix("--"))
        .all(|option| {
            let mut known = verb.get_arguments();
            known.any(|known| known.get_long() == Some(option))
        })
}

fn help(error: &Error) -> Option<&'static str> {
    use taxel_app::Error as App;
    match error {
        Error::Io(error) | Error::App(App::Io(error)) => of_files(error),
        Error::Taxel(error) | Error::App(App::Taxel(error) | App::InFile { source: error, .. }) => {
            of_mathematics(error)
        }
        Error::Learn(error)
        | Error::App(App::Learn(error) | App::TrainingSet { source: error, .. }) => {
            of_models(error)
        }
        Error::App(App::NoSensor { .. }) => Some(SENSOR),
        Error::App(App::MethodMemory { .. }) => Some("`--method newton`, where a command has it"),
        Error::App(App::Board { .. }) => Some("`cargo install --features rpi` on the board"),
        Error::App(App::Listen { .. }) => Some("`--listen 127.0.0.1:0`"),
        Error::App(App::Request { hint, .. }) => of_requests(hint),
        _ => None,
    }
}

fn of_requests(hint: &str) -> Option<&'static str> {
    use taxel_app::remedy;
    Some(match hint {
        remedy::READ_AS_COUNTS => "leave `--input-unit` out",
        remedy::COMPENSATE => "`taxel compensate` does that",
        remedy::SCAN => "`taxel simulate --conductance` does that",
        remedy::ROWS => "`--rows N`",
        remedy::CHECK_TIMES => "`--frames-per-second` gives a rate",
        remedy::CALIBRATE => "`taxel calibrate` finds a [material]",
        _ => return None,
    })
}

/// Where a sensor may come from.
pub(crate) const SENSOR: &str = "--sensor takes a sensor file or the name of a preset (econe, mat-16x16-cd4067, mat-32x32-adg732)";

fn of_files(error: &taxel_io::Error) -> Option<&'static str> {
    use taxel_io::{BROKEN_READING, Error, ParquetError, SensorFileError, ShapeFault};
    Some(match error {
        Error::SensorFile(SensorFileError::Invalid { source, .. }) => {
            return of_mathematics(source);
        }
        Error::LineShape { hint, .. } | Error::FileShape { hint, .. } => match hint {
            ShapeFault::Swapped => "read it with `--transpose`",
            ShapeFault::NotSwapped => "read it without `--transpose`",
            ShapeFault::Torn => FRAME_OUT,
            _ => return None,
        },
        Error::CutShort { .. }
        | Error::NoExtraLine { .. }
        | Error::NotFinite { .. }
        | Error::Message { .. } => FRAME_OUT,
        // Other separators than commas are in every line: no frame would be left.
        Error::Word { found, .. } if !found.contains([';', '\t', ' ']) => FRAME_OUT,
        // Of a reader; a writer's is not helped by it, nor is that of another converter.
        Error::Value { hint, .. } if *hint == BROKEN_READING => FRAME_OUT,
        Error::NpyCutShort { .. } => "`--keep-going` reads the frames before",
        Error::RecordingCut { .. } => {
            "`taxel recover` makes a whole file of it; `--keep-going` reads as far as it goes"
        }
        Error::RecordingDamaged { .. } => {
            "`taxel recover` makes a whole file of it; `--keep-going` does without what is missing"
        }
        Error::NotBuilt { feature, .. } => match *feature {
            "parquet" => "`cargo install --path crates/taxel-cli --features parquet`",
            _ => "`cargo install --path crates/taxel-cli --features xlsx`",
        },
        Error::Parquet(ParquetError::NoColumn { is_counts, .. }) => {
            if *is_counts {
                "`--values` reads loads"
            } else {
                "`taxel compensate -o FILE.parquet` computes loads"
            }
        }
        Error::Parquet(ParquetError::ColumnType { .. }) => {
            "`taxel convert` and `taxel compensate` write such tables"
        }
        Error::NoLoads { .. } => {
            "`taxel record --loads` records loads, `taxel compensate -o FILE.mcap` computes them"
        }
        _ => return None,
    })
}

const FRAME_OUT: &str = "`--keep-going` leaves its frame out";

fn of_mathematics(error: &taxel::Error) -> Option<&'static str> {
    Some(match error {
        taxel::Error::MissingKey { key, .. } if *key == "material" => {
            "`taxel calibrate` finds one, `--unit siemens` does without"
        }
        taxel::Error::PressOutside { .. } => "`--transpose` reads rows as columns",
        _ => return None,
    })
}

fn of_models(error: &taxel_learn::Error) -> Option<&'static str> {
    use taxel_learn::Error;
    Some(match error {
        Error::LoadOutOfRange { .. } => "raise --most-load if this one is right",
        Error::Checkpoint(..) => "leave --resume out",
        Error::NotAModel { .. } => "`taxel train` writes models",
        _ => return None,
    })
}
