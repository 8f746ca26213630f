//! `taxel evaluate` and `taxel report`: constructed recordings whose figures are known, and everything that a plan can get
//! wrong.

mod accuracy;
mod live;
mod lost;
mod refused;
mod regions;
mod report;
mod series;

use std::fmt::Write;

use serde_json::Value;

use crate::run::{Folder, SENSOR};

/// Conductance of a taxel without load, as `SENSOR` has it.
const REST: f64 = 1e-6;

/// Conductance under a load, by `SENSOR`'s law.
fn siemens(load_g: f64) -> f64 {
    REST + 8.29e-6 * load_g.powf(0.857)
}

/// Pressed taxels of a frame: row, column, conductance.
type Pressed = Vec<(usize, usize, f64)>;

/// Frames of conductances as text; what is not pressed conducts `rest`.
fn conductances(frames: &[Pressed], rest: f64) -> String {
    let mut text = String::new();
    for frame in frames {
        let mut values = [[rest; 6]; 4];
        for &(row, column, siemens) in frame {
            values[row][column] = siemens;
        }
        for row in values {
            let cells: Vec<String> = row.iter().map(f64::to_string).collect();
            writeln!(text, "{}", cells.join(",")).unwrap();
        }
    }
    text
}

impl Folder {
    /// A recording of counts of a sensor whose conductances are these.
    fn scan(&self, sensor: &str, name: &str, frames: &[Pressed]) {
        self.write("siemens.csv", &conductances(frames, REST));
        self.good(&format!(
            "simulate --sensor {sensor} --conductance siemens.csv --unit counts -o {name}"
        ));
    }

    /// A plan of these experiments.
    fn plan(&self, experiments: &str) {
        let text = format!(
            "format = 1\ntitle = \"A mat\"\nsensor = \"sensor.toml\"\nresamples = 200\n{experiments}"
        );
        self.write("plan.toml", &text);
    }

    /// What an evaluation says, as scripts see it.
    fn evaluated(&self) -> Report {
        let run = self.good("evaluate plan.toml --json");
        Report(serde_json::from_str(&run.out).unwrap())
    }

    /// A sensor file like `SENSOR` but for this.
    fn other_sensor(&self, name: &str, from: &str, to: &str) {
        assert_eq!(SENSOR.matches(from).count(), 1);
        self.write(name, &SENSOR.replace(from, to));
    }
}

struct Report(Value);

impl Report {
    fn table(&self, section: usize, table: usize) -> &Value {
        &self.0["sections"][section]["tables"][table]
    }

    /// A cell by the name of its column (the last of that name) and its row.
    fn cell(&self, (section, table): (usize, usize), row: usize, column: &str) -> &Value {
        let table = self.table(section, table);
        let head = table["head"].as_array().unwrap();
        let place = head.iter().rposition(|name| name == column);
        &table["rows"][row][place.unwrap_or_else(|| panic!("{column}: {head:?}"))]
    }

    /// A number, or the value of a figure.
    fn number(&self, table: (usize, usize), row: usize, column: &str) -> f64 {
        let cell = self.cell(table, row, column);
        let number = cell.as_f64().or_else(|| cell["value"].as_f64());
        number.unwrap_or_else(|| panic!("{column} is {cell}"))
    }

    /// A figure with its interval, which must hold it; the number of experiments.
    fn estimate(&self, table: (usize, usize), row: usize, column: &str) -> (f64, f64, f64, u64) {
        let cell = self.cell(table, row, column);
        let part = |name: &str| {
            let part = cell[name].as_f64();
            part.unwrap_or_else(|| panic!("{column} is {cell}"))
        };
        let (value, low, high) = (part("value"), part("low"), part("high"));
        assert!(low <= high, "{cell}");
        (value, low, high, cell["experiments"].as_u64().unwrap())
    }

    fn paragraphs(&self, section: usize) -> String {
        let all = self.0["sections"][section]["paragraphs"]
            .as_array()
            .unwrap();
        let words: Vec<&str> = all.iter().map(|words| words.as_str().unwrap()).collect();
        words.join("\n")
    }
}

#[track_caller]
fn near(found: f64, wanted: f64, tolerance: f64) {
    let off = (found - wanted).abs();
    assert!(off <= tolerance, "{found}, expected {wanted} ± {tolerance}");
}

/// Slope, offset of the straight line of least squares.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let xy = mean(&|p| (p.0 - x) * (p.1 - y));
    let slope = xy / mean(&|p| (p.0 - x) * (p.0 - x));
    (slope, y - slope * x)
}

#[test]
fn repeated_readings_have_the_outliers_and_the_variation_that_they_were_given() {
    let folder = Folder::new();
    // Counts as they are: a taxel that reads 9990 and 10010 in turn, and 0 in some frames.
    let mut table = "recording,row,column,setting\n".to_owned();
    for (setting, lost) in [("before", 4), ("after", 2)] {
        let mut text = String::new();
        for frame in 0..20 {
            let value = match frame {
                frame if frame < lost => 0,
                frame if frame % 2 == 0 => 9990,
                _ => 10010,
            };
            for row in 0..4 {
                let pressed = if row == 1 { value } else { 24 };
                writeln!(text, "24,24,{pressed},24,24,24,").unwrap();
            }
        }
        folder.write(&format!("{setting}.txt"), &text);
        writeln!(table, "{setting}.txt,1,2,{setting}").unwrap();
    }
    folder.write("t.csv", &table);
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"r\"\ntrials = \"t.csv\"\n");
    let report = folder.evaluated();
    for (row, lost) in [(0, 4.0), (1, 2.0)] {
        let (share, low, high, _) = report.estimate((0, 0), row, "outliers, %");
        near(share, 100.0 * lost / 20.0, 1e-9);
        assert!(low < share && share < high, "{low} {share} {high}");
        assert_eq!(report.number((0, 0), row, "readings"), 20.0);
        let marked = report.number((0, 0), row, "marked");
        assert_eq!(marked + report.number((0, 0), row, "far"), lost);
    }
    // 16 readings, ± 10 around 10000: standard deviation with n − 1.
    let deviation = 10.0 * (16.0f64 / 15.0).sqrt();
    let filtered = report.estimate((0, 0), 0, "CV without outliers, %");
    near(filtered.0, 100.0 * deviation / 10_000.0, 1e-9);
    near(report.number((0, 0), 0, "mean"), 10_000.0, 1e-9);
    // All twenty: four zeros among sixteen.
    let (mean, spread) = (8000.0, (16.0 * 2000.0f64.powi(2) + 4.0 * 8000.0f64.powi(2)));
    let all = 100.0 * ((spread + 16.0 * 100.0) / 19.0).sqrt() / mean;
    near(report.number((0, 0), 0, "CV, %"), all, 1e-9);
    assert!(
        report
            .paragraphs(0)
            .contains("Fewer than three experiments")
    );
    assert!(
        report.paragraphs(0).contains("after less before: -10 ("),
        "{}",
        report.paragraphs(0)
    );
}

/// Three taxels, five loads each, at two test voltages; conductance = rest + 8.29e-6 · load^0.857.
fn responses(folder: &Folder) {
    folder.other_sensor("v2.toml", "v_test_volts = 0.4", "v_test_volts = 2.0");
    let mut table = "recording,frame,row,column,load_g,setting,experiment\n".to_owned();
    for (setting, sensor) in [("0.4 V", "sensor.toml"), ("2 V", "v2.toml")] {
        let mut frames = Vec::new();
        for (row, column) in [(0, 0), (1, 3), (3, 5)] {
            for load in [0.0, 25.0, 50.0, 100.0, 200.0] {
                let frame = frames.len();
                writeln!(
                    table,
                    "{sensor}.txt,{frame},{row},{column},{load},{setting},{row}"
                )
                .unwrap();
                frames.push(vec![(row, column, siemens(load))]);
            }
        }
        folder.scan(sensor, &format!("{sensor}.txt"), &frames);
    }
    folder.write("t.csv", &table);
}

#[test]
fn a_response_has_the_exponent_the_line_and_the_saturation_that_it_was_given() {
    let folder = Folder::new();
    responses(&folder);
    let experiment = |value: &str| {
        format!(
            "[[experiment]]\nkind = \"response\"\nname = \"{value}\"\ntrials = \"t.csv\"\nvalue = \"{value}\"\n\
             [experiment.settings]\n\"2 V\" = \"v2.toml\"\n"
        )
    };
    folder.plan(&(experiment("siemens") + &experiment("counts")));
    let report = folder.evaluated();
    let (exponent, low, high, experiments) = report.estimate((0, 0), 0, "exponent");
    near(exponent, 0.857, 1e-3);
    assert!(
        low > 0.85 && high < 0.86 && experiments == 3,
        "{low} {high}"
    );
    let points: Vec<(f64, f64)> = [0.0, 25.0, 50.0, 100.0, 200.0]
        .map(|load| (load, siemens(load)))
        .to_vec();
    let (slope, offset) = line(&points);
    near(report.number((0, 0), 0, "sensitivity") / slope, 1.0, 1e-3);
    near(report.number((0, 0), 0, "offset") / offset, 1.0, 1e-2);
    let off = points
        .iter()
        .map(|p| (p.1 - offset - slope * p.0).abs())
        .fold(0.0, f64::max);
    let percent = 100.0 * off / (slope * 200.0);
    near(report.number((0, 0), 0, "non-linearity, %"), percent, 0.02);
    // Each level, both settings: the conductance is the same whatever the voltage, where it can be read.
    for (row, (load, value)) in points.iter().chain(&points).enumerate() {
        let found = report.number((0, 1), row, "mean");
        assert_eq!(report.number((0, 1), row, "load, g"), *load);
        match row {
            9 => assert!(
                found < 0.8 * value,
                "a converter's end is a lower bound: {found}"
            ),
            _ => near(found, *value, 1e-7 + 1e-3 * value),
        }
    }
    // At 2 V and 2 kΩ the converter's 2.2 V are 0.55 mS: 100 g read 0.43 mS, 200 g would read 0.78.
    assert_eq!(report.cell((0, 0), 0, "saturates at, g"), &Value::Null);
    assert_eq!(report.number((0, 0), 1, "saturates at, g"), 200.0);
    assert_eq!(report.number((0, 1), 9, "saturated, %"), 100.0);
    let usable = report.cell((0, 0), 1, "usable, g").as_str().unwrap();
    assert!(usable.ends_with("to 100"), "{usable}");
    // Five times the voltage reads five times as much, below saturation.
    let ratio = report.number((1, 1), 8, "mean") / report.number((1, 1), 3, "mean");
    near(ratio, 5.0, 0.02);
}

#[test]
fn loads_of_a_gauge_that_is_read_all_the_time_are_not_listed_one_by_one() {
    let folder = Folder::new();
    let loads: Vec<f64> = (0..101).map(|i| 2.0 * f64::from(i)).collect();
    let mut table = "recording,frame,row,column,load_g\n".to_owned();
    for (frame, load) in loads.iter().enumerate() {
        writeln!(table, "r.txt,{frame},1,1,{load}").unwrap();
    }
    let frames: Vec<Pressed> = loads.iter().map(|&g| vec![(1, 1, siemens(g))]).collect();
    folder.scan("sensor.toml", "r.txt", &frames);
    folder.write("t.csv", &table);
    folder.plan(
        "[[experiment]]\nkind = \"response\"\nname = \"r\"\ntrials = \"t.csv\"\nvalue = \"siemens\"\n",
    );
    let report = folder.evaluated();
    near(report.number((0, 0), 0, "exponent"), 0.857, 1e-3);
    assert_eq!(
        report.0["sections"][0]["tables"].as_array().unwrap().len(),
        1
    );
    assert!(
        report
            .paragraphs(0)
            .contains("Too many different loads to list: all (101)")
    );
}

#[test]
fn loops_have_the_width_and_the_return_that_they_were_given() {
    let folder = Folder::new();
    let loads = [0.0, 100.0, 200.0, 100.0, 0.0];
    let values = [1e-4, 3e-4, 5e-4, 3.5e-4, 1.2e-4];
    let mut table = "recording,frame,row,column,load_g,experiment\n".to_owned();
    let mut frames = Vec::new();
    for turn in 0..3 {
        for (load, value) in loads.iter().zip(values) {
            writeln!(
                table,
                "loops.txt,{},2,{turn},{load},loop {turn}",
                frames.len()
            )
            .unwrap();
            frames.push(vec![(2, turn, value)]);
        }
    }
    folder.scan("sensor.toml", "loops.txt", &frames);
    folder.write("t.csv", &table);
    folder.plan("[[experiment]]\nkind = \"hysteresis\"\nname = \"h\"\ntrials = \"t.csv\"\n");
    let report = folder.evaluated();
    assert_eq!(report.number((0, 0), 0, "loops"), 3.0);
    // Range 4e-4 S: at 0 g 0.2e-4 between the ways, at 100 g 0.5e-4, at 200 g nothing.
    let (widest, low, high, loops) = report.estimate((0, 0), 0, "widest");
    near(widest, 12.5, 0.05);
    assert!(high - low < 0.1 && loops == 3);
    near(report.number((0, 0), 0, "zero return"), 5.0, 0.05);
    // Straight from 5 % to 12.5 % and to 0: at 51 loads the mean is 0.005 % more than the integral's 7.5 %.
    near(report.number((0, 0), 0, "mean"), 7.5, 0.1);
}

#[test]
fn holds_have_the_creep_that_they_were_given() {
    let folder = Folder::new();
    // One hold of 140 frames at 2 a second on each of three taxels: + 10 % with a time constant of 20 s.
    let value = |frame: usize| 5e-4 * (1.0 + 0.1 * (1.0 - (-(frame as f64 / 2.0) / 20.0).exp()));
    let mut table = "recording,row,column,load_g\n".to_owned();
    for column in 0..3 {
        let frames: Vec<Pressed> = (0..140).map(|i| vec![(1, column, value(i))]).collect();
        folder.scan("sensor.toml", &format!("hold{column}.txt"), &frames);
        writeln!(table, "hold{column}.txt,1,{column},100").unwrap();
    }
    folder.write("t.csv", &table);
    folder.plan(
        "frames_per_second = 2\n[[experiment]]\nkind = \"creep\"\nname = \"c\"\ntrials = \"t.csv\"\n",
    );
    let report = folder.evaluated();
    assert_eq!(report.number((0, 0), 0, "holds"), 3.0);
    assert_eq!(report.number((0, 0), 0, "mean length, s"), 69.5);
    let mean = |frames: std::ops::Range<usize>| {
        let count = frames.len() as f64;
        frames.map(value).sum::<f64>() / count
    };
    let (first, last) = (mean(0..14), mean(126..140));
    let (creep, low, high, _) = report.estimate((0, 0), 0, "creep, %");
    near(creep, 100.0 * (last - first) / first, 0.02);
    assert!(low > 0.9 * creep && high < 1.1 * creep);
    let half: Vec<(f64, f64)> = (70..140).map(|i| (i as f64 / 2.0, value(i))).collect();
    let drift = 100.0 * 3600.0 * line(&half).0 / mean(70..140);
    near(report.number((0, 0), 0, "drift, %/h"), drift, 0.02 * drift);
    // Amplitude and time constant in words, of one term: `10 (20 s)`.
    let words = report.table(0, 1)["rows"][0][2].as_str().unwrap();
    let numbers: Vec<f64> = words
        .split([' ', '(', ')'])
        .filter_map(|word| word.parse().ok())
        .collect();
    assert_eq!(numbers.len(), 2, "{words}");
    near(numbers[0], 10.0, 0.02);
    near(numbers[1], 20.0, 0.1);
}

#[test]
#[expect(
    clippy::too_many_lines,
    reason = "one run of the program, step by step"
)]
fn a_sweep_drops_as_the_circuit_does_and_not_when_compensated() {
    let folder = Folder::new();
    let mut plan = String::new();
    let mut drops = Vec::new();
    for along in ["row", "column"] {
        let most = if along == "row" { 5 } else { 3 };
        let mut table = "recording,frame,row,column,others,experiment\n".to_owned();
        let mut frames = Vec::new();
        for area in 0..3 {
            for others in (0..=most).rev() {
                let (row, column) = if along == "row" { (area, 0) } else { (0, area) };
                let frame = frames.len();
                writeln!(
                    table,
                    "{along}.txt,{frame},{row},{column},{others},area {area}"
                )
                .unwrap();
                let taxel = |i| {
                    let (r, c) = if along == "row" {
                        (row, i)
                    } else {
                        (i, column)
                    };
                    (r, c, 1e-3)
                };
                frames.push((0..=others).map(taxel).collect::<Pressed>());
            }
        }
        folder.scan("sensor.toml", &format!("{along}.txt"), &frames);
        folder.write(&format!("{along}.csv"), &table);
        writeln!(
            plan,
            "[[experiment]]\nkind = \"cross-talk\"\nname = \"{along}\"\ntrials = \"{along}.csv\"\nalong = \"{along}\""
        )
        .unwrap();
        // What the scan itself gives, without a converter: first frame all pressed, later one alone.
        folder.good(
            "simulate --sensor sensor.toml --conductance siemens.csv --unit volts -o volts.csv",
        );
        let volts = folder.numbers("volts.csv");
        drops.push(100.0 * (1.0 - volts[0] / volts[most * 24]));
    }
    folder.plan(&plan);
    let report = folder.evaluated();
    for (section, wanted) in drops.into_iter().enumerate() {
        let head = report.table(section, 0)["head"].as_array().unwrap();
        let at = |name: &str| head.iter().position(|h| h == name).unwrap();
        let row = &report.table(section, 0)["rows"][0];
        let measured = row[at("drop, %")]["value"].as_f64().unwrap();
        assert_eq!(row[at("drop, %")]["experiments"], 3);
        // Rows that are not sensed are open: taxels of a column do not know of each other.
        match section {
            0 => assert!(wanted > 0.5, "{wanted}"),
            _ => assert!(wanted < 0.05, "{wanted}"),
        }
        near(measured, wanted, 0.01);
        near(
            row[at("full circuit: drop, %")].as_f64().unwrap(),
            wanted,
            0.01,
        );
        near(row[at("taxel, Ω")].as_f64().unwrap(), 1000.0, 0.2);
        near(row[at("misfit, %")].as_f64().unwrap(), 0.0, 0.01);
        // Equation 6 knows nothing of switches: 5 others at an amplifier's gain of 1e5 are nearly nothing.
        let six = row[at("equation 6: drop, %")].as_f64().unwrap();
        assert!(six > 0.0 && six < 0.05, "{six}");
        near(
            report.number((section, 0), 0, "compensated: drop, %"),
            0.0,
            0.02,
        );
        let points = report.table(section, 1)["rows"].as_array().unwrap();
        assert_eq!(points.len(), if section == 0 { 6 } else { 4 });
        assert_eq!(points[0][2], 3.0);
    }
}

#[test]
fn the_same_plan_gives_the_same_bytes_and_another_seed_other_intervals() {
    let folder = Folder::new();
    responses(&folder);
    let plan = "[[experiment]]\nkind = \"response\"\nname = \"r\"\ntrials = \"t.csv\"\nvalue = \"counts\"\n\
                [experiment.settings]\n\"2 V\" = \"v2.toml\"\n";
    folder.plan(plan);
    let run = folder.good("evaluate plan.toml -o a.html");
    assert!(run.err.contains("wrote a.html"), "{run}");
    folder.good("report plan.toml -o b.html");
    folder.good("report plan.toml");
    let page = folder.read("a.html");
    assert!(page == folder.read("b.html") && page == folder.read("report.html"));
    assert_eq!(page.matches("<svg").count(), 2);
    // Sensor, program and every file with its fingerprint.
    for words in ["small", "taxel 0.", "t.csv", "plan.toml", "sensor.toml.txt"] {
        assert!(page.contains(words), "{words}");
    }
    folder.plan(&format!("seed = 2\n{plan}"));
    folder.good("report plan.toml -o c.html");
    assert_ne!(page, folder.read("c.html"));
    // Another confidence is told where it stands.
    folder.plan(&format!("confidence = 0.8\n{plan}"));
    let run = folder.good("evaluate plan.toml");
    assert!(run.out.contains("80 % intervals"), "{run}");
    assert!(!run.out.contains("95 %"), "{run}");
}
