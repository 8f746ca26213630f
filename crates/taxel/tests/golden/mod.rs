//! Reads `testdata/ngspice`: one folder a case, with sensor.toml, conductance.csv and v_out.csv.

use std::fs;
use std::path::{Path, PathBuf};

use taxel::{Frame, Sensor, Siemens};

/// One circuit and what ngspice says that it reads.
pub struct Case {
    /// Name of its folder.
    pub name: String,
    /// sensor.toml.
    pub sensor: Sensor,
    /// conductance.csv.
    pub conductance: Frame<Siemens>,
    /// v_out.csv: row, column, volts; empty when the case has no answers yet.
    pub v_out: Vec<(usize, usize, f64)>,
}

/// Where the cases are.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/ngspice")
}

/// All cases, by name.
pub fn cases() -> Vec<Case> {
    cases_in(&folder())
}

/// All cases of a folder, by name.
pub fn cases_in(folder: &Path) -> Vec<Case> {
    let mut folders: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the folder is part of the repository")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.join("sensor.toml").exists())
        .collect();
    folders.sort();
    folders.iter().map(|path| read(path)).collect()
}

fn read(path: &Path) -> Case {
    let name = path.file_name().expect("a folder has a name");
    let text = |file: &str| {
        let path = path.join(file);
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    };
    let sensor = Sensor::from_toml(&text("sensor.toml")).expect("a valid sensor file");
    let conductance = numbers(&text("conductance.csv")).concat();
    let conductance = Frame::new(sensor.rows(), sensor.columns(), conductance)
        .expect("one conductance per taxel");
    let v_out = if path.join("v_out.csv").exists() {
        numbers(text("v_out.csv").trim_start_matches("row,column,v_out_volts\n"))
    } else {
        Vec::new()
    };
    Case {
        name: name.to_string_lossy().into_owned(),
        sensor,
        conductance,
        v_out: v_out
            .iter()
            .map(|line| (line[0] as usize, line[1] as usize, line[2]))
            .collect(),
    }
}

fn numbers(text: &str) -> Vec<Vec<f64>> {
    let number = |word: &str| word.parse().expect("a number");
    text.lines()
        .map(|line| line.split(',').map(number).collect())
        .collect()
}
