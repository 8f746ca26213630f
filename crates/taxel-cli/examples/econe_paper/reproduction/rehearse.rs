//! The paper's experiments, made on a virtual e-Cone: recordings, tables of trials, sensor files, a plan.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;

use taxel::calibrate::CalibrationData;
use taxel::sensor::preset;
use taxel::simulate::{
    Grams, Pattern, ReadingFaults, Tip, VirtualSensor, labelled_presses, press_tips,
};
use taxel::{Counts, Frame, Sensor};
use taxel_io::NpyWriter;
use taxel_io::npy::Element;
use taxel_learn::fit::{self, TrainingData};
use taxel_learn::models::paper_mlp::HIDDEN;
use taxel_learn::train::Settings;
use taxel_learn::{Rows, Split};

use taxel_app::{Error, Reporter};
use taxel_io::AtomicFile;

/// Standard deviation of a tip's shift, share of a taxel.
const MISALIGNMENT: f64 = 0.1;
/// Load of the sweeps, grams: the paper's.
const SWEEP_G: f64 = 132.0;
/// Areas, replicates, readings and largest N of the sweeps: the paper's.
const AREAS: u64 = 7;
const REPLICATES: u64 = 2;
const READINGS: u64 = 10;
const MAX_OTHERS: usize = 9;
/// Presses that the network learns from; the paper's.
const PRESSES: usize = 1400;
/// Shuffled copies of each and epochs: fewer than the paper's 100, for its error is the same within its interval and a
/// reader waits for it.
const COPIES: usize = 10;
const EPOCHS: usize = 30;

const PLAN: &str = r#"format = 1
title = "The e-Cone paper on a simulated e-Cone"
sensor = "sensor.toml"
seed = 1

[[experiment]]
kind = "repeatability"
name = "Table IV, Figs. 19 and 20: repeatability, 100 readings of one load"
trials = "repeatability.csv"
note = "The paper counts 22 % of outliers before its connectors were repaired and 5 % after; readings that stand at an end of the converter are simulated with these shares. Of those, one that stands at the end that the load would reach is not told from a saturated one."

[[experiment]]
kind = "response"
name = "Figs. 24 and 25: response to a 10 mm² tip on two taxels"
trials = "response.csv"
[experiment.settings]
"R_k 22 kΩ" = "sensor-r-k.toml"
"V_test 10 mV" = "sensor-v-test.toml"

[[experiment]]
kind = "cross-talk"
name = "Fig. 28: ten mechanisms in a row, removed one by one"
trials = "row.csv"
[experiment.settings]
"R_v 1 kΩ" = "sensor-r-v.toml"

[[experiment]]
kind = "cross-talk"
name = "Fig. 31: the same along a column"
trials = "column.csv"
along = "column"
[experiment.settings]
"R_v 1 kΩ" = "sensor-r-v.toml"

[[experiment]]
kind = "accuracy"
name = "Section VI.B: error on presses that nothing learnt from"
trials = "presses.csv"
methods = ["raw", "network.taxel", "auto"]
ranges_g = [0, 50, 100, 200, 400]

[[experiment]]
kind = "accuracy"
name = "Section VI.B: error on whole hands"
recording = "hand.npy"
truth_g = "hand-load-g.npy"
methods = ["raw", "network.taxel", "auto"]
ranges_g = [0, 50, 100, 200, 400]
note = "Twelve gripping hands, each an experiment; the loads of all taxels are known."
"#;

/// Writes everything that the plan needs; gives the number of presses that the network learnt from.
pub(super) fn write_all(folder: &Path, seed: u64, reporter: &dyn Reporter) -> Result<usize, Error> {
    let sensor = preset("econe")?;
    let r_k = sensor.edited(|spec| spec.readout.r_feedback_ohms = Some(22_000.0))?;
    let v_test = sensor.edited(|spec| spec.readout.v_test_volts = 0.01)?;
    let r_v = sensor.edited(|spec| spec.readout.r_source_ohms = 1000.0)?;
    for (name, sensor) in [
        ("sensor", &sensor),
        ("sensor-r-k", &r_k),
        ("sensor-v-test", &v_test),
        ("sensor-r-v", &r_v),
    ] {
        write(
            &folder.join(name).with_extension("toml"),
            sensor.to_toml().as_bytes(),
        )?;
    }
    repeatability(folder, &sensor, seed)?;
    let settings = [
        ("as built", &sensor),
        ("R_k 22 kΩ", &r_k),
        ("V_test 10 mV", &v_test),
    ];
    response(folder, &settings, seed)?;
    let settings = [("as built", &sensor), ("R_v 1 kΩ", &r_v)];
    sweep(folder, "row", &settings, seed)?;
    sweep(folder, "column", &settings, seed)?;
    hands(folder, &sensor, seed)?;
    reporter.note("training the paper's network");
    let presses = network(folder, &sensor, seed)?;
    write(&folder.join("plan.toml"), PLAN.as_bytes())?;
    Ok(presses)
}

/// A recording as it is written.
fn record(folder: &Path, name: &str, frames: &[Frame<Counts>]) -> Result<(), Error> {
    let (rows, columns) = (frames[0].rows(), frames[0].columns());
    let mut writer = NpyWriter::create(folder.join(name), rows, columns, Element::U2)?;
    for frame in frames {
        writer.write(frame)?;
    }
    Ok(writer.commit()?)
}

/// 100 readings of one load with each share of stuck readings.
fn repeatability(folder: &Path, sensor: &Sensor, seed: u64) -> Result<(), Error> {
    let mut table = "recording,row,column,load_g,setting\n".to_owned();
    let tip = Tip {
        row: 7,
        column: 22,
        taxels: 1,
        load_g: SWEEP_G,
    };
    let loads = press_tips(sensor.array(), &[tip], 0.0, seed, 0);
    for (setting, share, seed) in [("before", 0.22, seed), ("after", 0.05, seed + 1)] {
        let mut faults = ReadingFaults::default();
        faults.stuck_share = share;
        let virtual_sensor = VirtualSensor::new(sensor, seed)?.with_faults(faults);
        let frames: Vec<_> = (0..100)
            .map(|i| virtual_sensor.read(&loads, i).counts)
            .collect();
        let name = format!("repeatability-{setting}.npy");
        record(folder, &name, &frames)?;
        let _ = writeln!(
            table,
            "{name},{},{},{SWEEP_G},{setting}",
            tip.row, tip.column
        );
    }
    write(&folder.join("repeatability.csv"), table.as_bytes())
}

/// Loads from nothing to the strongest spring's, in five places.
fn response(folder: &Path, settings: &[(&str, &Sensor)], seed: u64) -> Result<(), Error> {
    let mut table = "recording,frame,row,column,load_g,setting,experiment\n".to_owned();
    for (number, (setting, sensor)) in settings.iter().enumerate() {
        let virtual_sensor = VirtualSensor::new(sensor, seed)?;
        let name = format!("response-{number}.npy");
        let mut frames = Vec::new();
        for area in 0..5u64 {
            let (row, column) = (8 + 10 * area as usize, 20 + 20 * area as usize);
            for step in 0..=12u32 {
                let load_g = 30.0 * f64::from(step);
                let tip = Tip {
                    row,
                    column,
                    taxels: 2,
                    load_g,
                };
                let loads = press_tips(sensor.array(), &[tip], MISALIGNMENT, seed, 100 + area);
                for _ in 0..3 {
                    let _ = writeln!(
                        table,
                        "{name},{},{row},{column},{load_g},{setting},area {area}",
                        frames.len()
                    );
                    frames.push(virtual_sensor.read(&loads, frames.len() as u64).counts);
                }
            }
        }
        record(folder, &name, &frames)?;
    }
    write(&folder.join("response.csv"), table.as_bytes())
}

/// Ten mechanisms beside each other, removed one by one, in seven areas, set down twice, ten readings each.
fn sweep(folder: &Path, along: &str, settings: &[(&str, &Sensor)], seed: u64) -> Result<(), Error> {
    let mut table = "recording,frame,row,column,load_g,others,setting,experiment\n".to_owned();
    for (number, (setting, sensor)) in settings.iter().enumerate() {
        let virtual_sensor = VirtualSensor::new(sensor, seed)?;
        for area in 0..AREAS {
            let name = format!("{along}-{number}-{area}.npy");
            let mut frames = Vec::new();
            let (row, column) = (4 + 6 * area as usize, 10 + 12 * area as usize);
            for replicate in 0..REPLICATES {
                let placement = 1000 + 10 * area + replicate;
                let tip = |i: usize| Tip {
                    row: row + if along == "row" { 0 } else { i },
                    column: column + if along == "row" { i } else { 0 },
                    taxels: 1,
                    load_g: SWEEP_G,
                };
                for others in (0..=MAX_OTHERS).rev() {
                    let tips: Vec<_> = (0..=others).map(tip).collect();
                    let loads = press_tips(sensor.array(), &tips, MISALIGNMENT, seed, placement);
                    for _ in 0..READINGS {
                        let _ = writeln!(
                            table,
                            "{name},{},{row},{column},{SWEEP_G},{others},{setting},area {area} replicate {replicate}",
                            frames.len()
                        );
                        frames.push(virtual_sensor.read(&loads, frames.len() as u64).counts);
                    }
                }
            }
            record(folder, &name, &frames)?;
        }
    }
    write(&folder.join(along).with_extension("csv"), table.as_bytes())
}

/// Twelve gripping hands, no two of one movement.
fn hands(folder: &Path, sensor: &Sensor, seed: u64) -> Result<(), Error> {
    let virtual_sensor = VirtualSensor::new(sensor, seed)?;
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let mut frames = Vec::new();
    let mut truths =
        NpyWriter::<Grams>::create(folder.join("hand-load-g.npy"), rows, columns, Element::F8)?;
    for hand in 0..12 {
        let loads = Pattern::hand().loads(sensor.array(), seed + hand, 80);
        frames.push(virtual_sensor.read(&loads, hand).counts);
        truths.write(&loads)?;
    }
    truths.commit()?;
    record(folder, "hand.npy", &frames)
}

/// The paper's network, trained with labelled presses as the paper does it, but for the split.
fn network(folder: &Path, sensor: &Sensor, seed: u64) -> Result<usize, Error> {
    let data = labelled_presses(&VirtualSensor::new(sensor, seed + 7)?, PRESSES);
    let mut rows = Rows::new(sensor.columns());
    for press in &data.presses {
        let frame = &data.frames[press.frame];
        let row = &frame.values()[press.row * sensor.columns()..][..sensor.columns()];
        rows.push(
            frame.at(press.row, press.column),
            row.iter().copied(),
            press.load_g,
        );
    }
    let split = Split::new(rows.len(), 0.1, 0.1, seed);
    let training_data = TrainingData {
        sensor,
        rows: &rows,
        split: &split,
        sources: Vec::new(),
    };
    let mut settings = Settings::default();
    settings.epochs = EPOCHS;
    settings.seed = seed;
    let model = fit::paper_mlp(
        &training_data,
        &settings,
        &HIDDEN,
        COPIES,
        None,
        &mut |_, _| ControlFlow::Continue(()),
    )?;
    write(&folder.join("network.taxel"), &model.to_bytes())?;
    held_out(folder, &data, &split)?;
    Ok(split.train.len())
}

/// The presses that the network has not seen, as a recording with its trials.
fn held_out(folder: &Path, data: &CalibrationData, split: &Split) -> Result<(), Error> {
    let mut table = "recording,frame,row,column,load_g\n".to_owned();
    let mut frames = Vec::new();
    for press in split.test.iter().map(|&i| &data.presses[i]) {
        let (row, column, load_g) = (press.row, press.column, press.load_g);
        let _ = writeln!(
            table,
            "presses.npy,{},{row},{column},{load_g}",
            frames.len()
        );
        frames.push(data.frames[press.frame].clone());
    }
    record(folder, "presses.npy", &frames)?;
    write(&folder.join("presses.csv"), table.as_bytes())
}

fn write(file: &Path, bytes: &[u8]) -> Result<(), Error> {
    Ok(AtomicFile::write_whole(file, bytes)?)
}
