//! A folder of small files, and the binary run in it.

use std::fmt;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use tempfile::TempDir;

/// A 4 × 6 sensor with everything known; 10 bits, no noise.
pub const SENSOR: &str = r#"format = 1
name = "small"

[array]
rows = 4
columns = 6
pitch_mm = [2.0, 2.0]
taxel_area_mm2 = 5.0

[readout]
topology = "tia-grounded-columns"
v_test_volts = 0.4
r_feedback_ohms = 2000.0
open_loop_gain = 1e5
r_mux_column_ohms = 10.0
r_mux_row_ohms = 10.0

[converter]
bits = 16
full_scale_volts = 2.2
inverted = true

[material]
g_zero_siemens = 1e-6
factor = 8.29e-6
exponent = 0.857
"#;

/// A folder of its own for a test; gone afterwards.
pub struct Folder {
    folder: TempDir,
}

impl Folder {
    /// With `sensor.toml` in it.
    pub fn new() -> Self {
        let folder = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        folder.write("sensor.toml", SENSOR);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// A column of a table; what is no number is NaN.
    pub fn column(&self, table: &str, name: &str) -> Vec<f64> {
        let text = self.read(table);
        let mut lines = text.lines();
        let at = lines.next().unwrap().split(',').position(|n| n == name);
        let at = at.unwrap_or_else(|| panic!("no {name} in {text:.300}"));
        let cell = |line: &str| line.split(',').nth(at).unwrap().parse().unwrap_or(f64::NAN);
        lines.map(cell).collect()
    }

    pub fn exists(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    /// The names of the files in it, hidden ones too.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// Whether a program is writing a file in it that has not its name yet: one without any, or a hidden one.
    pub fn is_written_by(&self, child: &Child) -> bool {
        let open = fs::read_dir(format!("/proc/{}/fd", child.id()));
        let folder = fs::canonicalize(self.folder.path()).unwrap();
        let nameless = open.into_iter().flatten().flatten().any(|file| {
            fs::read_link(file.path()).is_ok_and(|to| {
                to.starts_with(&folder) && to.to_string_lossy().ends_with(" (deleted)")
            })
        });
        nameless || self.names().iter().any(|name| name.starts_with(".taxel-"))
    }

    /// The numbers of a CSV, in order.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        numbers(&self.read(name))
    }

    /// Starts `taxel` with these words, separated by spaces; all that goes in and out is piped.
    pub fn spawn(&self, words: &str) -> Child {
        Command::new(env!("CARGO_BIN_EXE_taxel"))
            .args(words.split_whitespace())
            .current_dir(self.folder.path())
            .env("COLUMNS", "100")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    /// Runs `taxel` with these words, separated by spaces.
    pub fn taxel(&self, words: &str) -> Run {
        self.taxel_with(words, "")
    }

    /// The same with something on standard input.
    pub fn taxel_with(&self, words: &str, input: &str) -> Run {
        let mut child = self.spawn(words);
        // It may well end without reading all of it.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        Run::from(child.wait_with_output().unwrap())
    }

    /// The same for output that is no text.
    pub fn taxel_bytes(&self, words: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_taxel"))
            .args(words.split_whitespace())
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    /// Runs a command that must fail, saying why.
    pub fn fails(&self, words: &str) -> Run {
        let run = self.taxel(words);
        assert!(matches!(run.code, Some(1 | 2)), "{run}");
        assert!(run.err.contains("error: "), "{run}");
        run
    }

    /// Runs what must succeed.
    pub fn good(&self, words: &str) -> Run {
        let run = self.taxel(words);
        assert_eq!(run.code, Some(0), "{run}");
        run
    }
}

/// The numbers in a text, in order.
pub fn numbers(text: &str) -> Vec<f64> {
    let cells = text.split([',', '\n']).map(str::trim);
    let cells = cells.filter(|cell| !cell.is_empty());
    cells.map(|cell| cell.parse().unwrap()).collect()
}

/// What a run left behind. Shown with everything masked that differs from run to run.
pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

impl fmt::Display for Run {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let code = self.code.map_or("none".to_owned(), |code| code.to_string());
        writeln!(f, "exit code: {code}")?;
        writeln!(f, "----- stdout -----\n{}", masked(&self.out))?;
        write!(f, "----- stderr -----\n{}", masked(&self.err))
    }
}

/// Times and speeds as `[time]`.
fn masked(text: &str) -> String {
    let lines = text.lines().map(|line| {
        let timed = ["\"seconds\":", "\"frames_per_second\":"];
        if let Some(key) = timed
            .iter()
            .find(|key| line.trim_start().starts_with(**key))
        {
            let indent = &line[..line.len() - line.trim_start().len()];
            return format!("{indent}{key} [time],");
        }
        if !line.contains("frames/s") {
            return line.to_owned();
        }
        let words: Vec<&str> = line.split(' ').collect();
        let is_time = |i: usize| matches!(words.get(i + 1), Some(&"s," | &"frames/s"));
        let mask = |(i, word): (usize, &&str)| {
            if is_time(i) {
                "[time]".to_owned()
            } else {
                (*word).to_owned()
            }
        };
        words
            .iter()
            .enumerate()
            .map(mask)
            .collect::<Vec<_>>()
            .join(" ")
    });
    lines.collect::<Vec<_>>().join("\n")
}
