//! What `taxel --help` and the help of every verb end with: verbs by what they are for, and examples.

use std::fmt::Write;

use clap::Command;

/// Verbs by what they are for.
const GROUPS: [(&str, &[&str]); 6] = [
    (
        "Measure",
        &[
            "live", "grip", "view", "record", "replay", "stream", "convert", "recover", "devices",
        ],
    ),
    (
        "Look",
        &["info", "measure", "analyse", "plot", "selftest", "identify"],
    ),
    (
        "Fit and compensate",
        &[
            "calibrate",
            "check",
            "compensate",
            "batch",
            "dataset",
            "train",
            "compare",
            "model",
        ],
    ),
    ("Publish", &["evaluate", "report"]),
    (
        "Design and simulate",
        &[
            "demo",
            "simulate",
            "design",
            "budget",
            "rig",
            "crosstalk",
            "netlist",
            "bench",
        ],
    ),
    ("Set up", &["completions"]),
];

/// One to three examples of every verb. Files that are read are those that another example writes, where one does.
const EXAMPLES: [(&str, &[&str]); 34] = [
    (
        "live",
        &[
            "taxel live                                              # a simulated e-Cone, gripped by a hand",
            "taxel live 'serial:/dev/ttyACM0?baud=2000000' --sensor sensor.toml",
            "taxel live udp:0.0.0.0:5005 --sensor sensor.toml --record run.mcap",
        ],
    ),
    (
        "grip",
        &[
            "taxel grip                                # a simulated person grips a simulated e-Cone",
            "taxel grip serial:/dev/ttyACM0 --sensor calibrated.toml --person P01",
            "taxel grip compare grips -o retest.pdf",
        ],
    ),
    (
        "view",
        &[
            "taxel view run.mcap",
            "taxel view presses.txt --sensor sensor.toml",
            "taxel view before.mcap --beside after.mcap",
        ],
    ),
    (
        "record",
        &[
            "taxel record serial:/dev/ttyACM0?baud=2000000 --sensor sensor.toml -o run.mcap --secs 10",
            "taxel record 'sim:econe?hand' -o hand.mcap --frames 200",
        ],
    ),
    ("replay", &["taxel replay run.mcap --to udp:127.0.0.1:5005"]),
    (
        "stream",
        &[
            "taxel stream sim:mat-16x16-cd4067 --frames 1",
            "taxel stream serial:/dev/ttyUSB0 --sensor mat.toml --sums --to udp:127.0.0.1:9000",
            "taxel stream rpi:board.toml --sensor econe --counts --to listen:0.0.0.0:9000 --record run.mcap",
        ],
    ),
    (
        "convert",
        &[
            "taxel convert run.mcap -o run.csv",
            "taxel convert presses.txt --sensor econe --frames-per-second 30 -o presses.mcap",
        ],
    ),
    ("recover", &["taxel recover run.mcap -o whole.mcap"]),
    ("devices", &["taxel devices"]),
    (
        "info",
        &[
            "taxel info run.mcap",
            "taxel info hand.txt --sensor calibrated.toml --json",
        ],
    ),
    (
        "analyse",
        &[
            "taxel analyse run.mcap --taxel 3,4 -o taxel.png --export taxel.csv",
            "taxel analyse hand.txt --sensor calibrated.toml --unit g --row 12",
        ],
    ),
    (
        "measure",
        &[
            "taxel measure run.mcap -o force.csv --picture force.png",
            "taxel measure hand.txt --sensor calibrated.toml --frames-per-second 60 --regions hand.toml",
            "taxel measure run.mcap --trials 2.5..10.5,70..78 --json",
        ],
    ),
    (
        "plot",
        &[
            "taxel plot hand.txt --sensor calibrated.toml --frame 68 -o picture.png",
            "taxel plot run.mcap --frames 100..300 --speed 0.5 -o run.gif    # a movie at half the pace",
            "taxel plot run.mcap --frame 40 --body --range 0..50 --title 'Left hand' -o left.png",
        ],
    ),
    (
        "selftest",
        &[
            "taxel selftest --empty empty.mcap --rubbed rubbed.mcap --sensor sensor.toml",
            "taxel selftest --live 'serial:/dev/ttyACM0?baud=2000000' --sensor sensor.toml",
        ],
    ),
    (
        "identify",
        &[
            "taxel identify hand.txt --rows 64",
            "taxel identify run.mcap --sensor sensor.toml --equilibration uniform.csv --json",
        ],
    ),
    (
        "calibrate",
        &[
            "taxel calibrate --live sim:mat-16x16-cd4067 -o calibrated.toml    # guided",
            "taxel calibrate --sensor sensor.toml --presses experiments.csv -o calibrated.toml",
            "taxel calibrate --sensor calibrated.toml --series run.txt --loads g.csv --period 0.05 -o d.toml",
        ],
    ),
    (
        "check",
        &[
            "taxel check --sensor calibrated.toml --presses check.csv -o today.toml",
            "taxel check --sensor calibrated.toml --empty empty.txt --total 812.5N standing.mcap",
        ],
    ),
    (
        "compensate",
        &[
            "taxel compensate hand.txt --sensor calibrated.toml --unit g -o loads.csv",
            "taxel compensate hand.txt --sensor calibrated.toml -o loads.npy --marks marks.npy",
            "taxel compensate hand.txt --sensor calibrated.toml --method model.safetensors -o loads.csv",
        ],
    ),
    (
        "batch",
        &[
            "taxel batch study/*/*.mcap --out results --pictures",
            "taxel batch --list recordings.txt --sensor calibrated.toml --out results --shard 3/8",
        ],
    ),
    (
        "dataset",
        &[
            "taxel dataset --sensor sensor.toml --presses experiments.csv -o rows.csv",
            "taxel dataset --sensor econe --simulate 10000 --shard 1000 -o shards",
        ],
    ),
    (
        "train",
        &[
            "taxel train row-set --sensor sensor.toml --presses experiments.csv -o model.safetensors",
            "taxel train hybrid --sensor calibrated.toml --presses experiments.csv -o model.safetensors",
        ],
    ),
    (
        "compare",
        &[
            "taxel compare --sensor sensor.toml --presses experiments.csv",
            "taxel compare hand.txt --truth truth.csv --sensor sensor.toml --presses experiments.csv -o t.csv",
        ],
    ),
    (
        "model",
        &[
            "taxel model show model.safetensors",
            "taxel model export model.safetensors -o model.onnx",
            "taxel model import net.onnx --sensor sensor.toml --presses experiments.csv -o m.safetensors",
        ],
    ),
    (
        "evaluate",
        &[
            "taxel evaluate plan.toml                                # examples/evaluate has a plan",
            "taxel evaluate plan.toml -o report.html",
            "taxel evaluate plan.toml --live 'serial:/dev/ttyACM0?baud=2000000'",
        ],
    ),
    (
        "report",
        &[
            "taxel report plan.toml -o report.pdf",
            "taxel report --paper -o paper.html",
        ],
    ),
    ("demo", &["taxel demo"]),
    (
        "simulate",
        &[
            "taxel simulate --sensor econe --pattern press --frames 120 --presses experiments.csv -o p.txt",
            "taxel simulate --sensor econe --pattern hand --frames 160 --truth truth.csv -o hand.txt",
            "taxel simulate --sensor econe --pattern uniform --load-g 0 --frames 100 -o empty.txt",
        ],
    ),
    (
        "design",
        &[
            "taxel design --taxel 500..3000 --rows 64 --columns 128",
            "taxel design --topology divider-grounded-columns --bits 12 --rows 16 --columns 16 -o sensor.toml",
            "taxel design --sensor mat-16x16-cd4067 --taxel 1k..30k --line-ohms 2",
        ],
    ),
    (
        "budget",
        &["taxel budget econe", "taxel budget sensor.toml --json"],
    ),
    (
        "rig",
        &[
            "taxel rig --pressure 0.2MPa",
            "taxel rig --load 132g --spring 0.5 --area 8",
            "taxel rig --margin 5g --standard-deviation 12g",
        ],
    ),
    (
        "crosstalk",
        &[
            "taxel crosstalk -n 10",
            "taxel crosstalk --setting 'R_mux=10,name=as built' --points measured.csv -o picture.png",
        ],
    ),
    (
        "netlist",
        &["taxel netlist --sensor sensor.toml --conductance siemens.csv --taxel 3,4 -o taxel.cir"],
    ),
    ("bench", &["taxel bench --sensor econe"]),
    (
        "completions",
        &[
            "taxel completions bash > ~/.local/share/bash-completion/completions/taxel",
            "taxel completions zsh > ~/.zfunc/_taxel    # a folder of $fpath",
            "taxel completions fish > ~/.config/fish/completions/taxel.fish",
        ],
    ),
];

/// The widest that a help is.
pub(crate) const WIDEST: usize = 100;

/// How wide a help is here: as the terminal, or as `COLUMNS` says where there is none.
pub(crate) fn width() -> usize {
    let terminal = terminal_size::terminal_size().map(|(width, _)| usize::from(width.0));
    let told = || std::env::var("COLUMNS").ok()?.parse().ok();
    terminal.or_else(told).unwrap_or(WIDEST).min(WIDEST)
}

/// An example in lines no longer than that, as a shell takes them: one that is too long goes on behind `\`, and its remark stands above.
fn wrapped(line: &str, width: usize) -> String {
    if line.chars().count() + 2 <= width {
        return format!("\n  {line}");
    }
    let (command, remark) = match line.split_once(" # ") {
        Some((command, remark)) => (command.trim_end(), Some(remark)),
        None => (line, None),
    };
    let mut text = remark.map_or_else(String::new, |remark| format!("\n  # {remark}"));
    let mut so_far = String::new();
    for piece in pieces(command) {
        // Indented, and with what says that it goes on.
        let long = so_far.chars().count() + 1 + piece.chars().count() + 2;
        if so_far.is_empty() {
            so_far = format!("  {piece}");
        } else if long > width {
            let _ = write!(text, "\n{so_far} \\");
            so_far = format!("    {piece}");
        } else {
            let _ = write!(so_far, " {piece}");
        }
    }
    text + "\n" + &so_far
}

/// What stays on a line of its own: a word with what is quoted in it, and an option with its value.
fn pieces(command: &str) -> Vec<String> {
    let mut words: Vec<String> = vec![String::new()];
    let mut is_quoted = false;
    for letter in command.chars() {
        is_quoted ^= letter == '\'';
        match letter {
            ' ' if !is_quoted => words.push(String::new()),
            letter => words.last_mut().expect("there is one").push(letter),
        }
    }
    let mut pieces: Vec<String> = Vec::new();
    for word in words.into_iter().filter(|word| !word.is_empty()) {
        match pieces.last_mut() {
            Some(option)
                if option.starts_with('-') && !option.contains(' ') && !word.starts_with('-') =>
            {
                *option = format!("{option} {word}");
            }
            _ => pieces.push(word),
        }
    }
    pieces
}

/// The command with its verbs grouped, and examples at the end of the help of each, in lines of this width.
pub(crate) fn with_examples(command: Command, width: usize) -> Command {
    let mut verbs = String::new();
    for (group, names) in GROUPS {
        let _ = writeln!(verbs, "{group}:");
        for name in names {
            let about = command
                .find_subcommand(name)
                .and_then(Command::get_about)
                .map_or(String::new(), ToString::to_string);
            let _ = writeln!(verbs, "  {name:<13}{about}");
        }
        verbs.push('\n');
    }
    let command = EXAMPLES.iter().fold(command, |command, (verb, lines)| {
        let lines = lines.iter().map(|line| wrapped(line, width));
        let text = format!("Examples:{}", lines.collect::<String>());
        command.mut_subcommand(*verb, |verb| verb.after_help(text))
    });
    command
        .help_template(format!(
            "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{verbs}Options:\n{{options}}{{after-help}}"
        ))
        .after_help("`taxel VERB --help` tells more of a verb, with examples.")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;
    use crate::Cli;

    fn names() -> BTreeSet<String> {
        let command = Cli::command();
        let shown = command.get_subcommands().filter(|verb| !verb.is_hide_set());
        let verbs = shown.map(Command::get_name);
        verbs.map(str::to_owned).collect()
    }

    #[test]
    fn every_verb_is_in_one_group_and_has_examples() {
        let grouped: Vec<&str> = GROUPS.iter().flat_map(|group| group.1).copied().collect();
        assert_eq!(grouped.len(), names().len());
        let grouped: BTreeSet<String> = grouped.into_iter().map(str::to_owned).collect();
        assert_eq!(grouped, names());
        let shown: BTreeSet<String> = EXAMPLES.iter().map(|e| e.0.to_owned()).collect();
        assert_eq!(shown, names());
        assert!(EXAMPLES.iter().all(|e| (1..=3).contains(&e.1.len())));
    }

    /// The words of a line as a shell makes them, its remark left out, and the file that its output goes to.
    fn words(line: &str) -> Vec<String> {
        let mut words = vec![String::new()];
        let mut quoted = false;
        let line = line.split(" # ").next().unwrap_or(line);
        let line = line.split(" > ").next().unwrap_or(line);
        for letter in line.trim().chars() {
            match letter {
                '\'' => quoted = !quoted,
                ' ' if !quoted => words.push(String::new()),
                other => words.last_mut().unwrap().push(other),
            }
        }
        words
    }

    #[test]
    fn an_example_is_as_wide_as_the_terminal_and_a_shell_reads_the_same() {
        for width in [40, 60, 80, 100] {
            for line in EXAMPLES.iter().flat_map(|(_, lines)| *lines) {
                let shown = wrapped(line, width);
                for one in shown.lines() {
                    let is_one_piece = pieces(one.trim_end_matches('\\')).len() == 1;
                    let long = one.chars().count();
                    assert!(
                        long <= width || is_one_piece || one.contains('#'),
                        "{width}: {one}"
                    );
                }
                let commands = shown.lines().filter(|one| !one.starts_with("  # "));
                let read: String = commands.collect::<Vec<_>>().join("\n");
                let read = read.replace("\\\n", " ");
                let given = |text: &str| -> Vec<String> {
                    words(text)
                        .into_iter()
                        .filter(|word| !word.is_empty())
                        .collect()
                };
                assert_eq!(given(&read), given(line), "{shown}");
            }
        }
        assert_eq!(
            wrapped("taxel view presses.txt --sensor sensor.toml    # held", 40),
            "\n  # held\n  taxel view presses.txt \\\n    --sensor sensor.toml"
        );
    }

    #[test]
    fn every_example_is_one_that_the_command_takes() {
        for (verb, lines) in EXAMPLES {
            for line in lines {
                let words = words(line);
                assert!(line.chars().count() <= 98, "wrapped at 100: {line}");
                assert_eq!(words[..2], ["taxel".to_owned(), verb.to_owned()], "{line}");
                if let Err(error) = Cli::command().try_get_matches_from(words) {
                    panic!("{line}\n{error}");
                }
            }
        }
    }
}
