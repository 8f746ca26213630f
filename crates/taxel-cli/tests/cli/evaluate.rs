//! `taxel evaluate` and `taxel report`: constructed recordings whose figures are known, and everything that a plan can get
//! wrong.

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
    for (setting, lost) in [("before", 4), ("after", 1)] {
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
    for (row, lost) in [(0, 4.0), (1, 1.0)] {
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
        report.paragraphs(0).contains("after less before: -15 ("),
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
    // One hold of 60 frames at 2 a second on each of three taxels: + 10 % with a time constant of 5 s.
    let value = |frame: usize| 5e-4 * (1.0 + 0.1 * (1.0 - (-(frame as f64 / 2.0) / 5.0).exp()));
    let mut table = "recording,row,column,load_g\n".to_owned();
    for column in 0..3 {
        let frames: Vec<Pressed> = (0..60).map(|i| vec![(1, column, value(i))]).collect();
        folder.scan("sensor.toml", &format!("hold{column}.txt"), &frames);
        writeln!(table, "hold{column}.txt,1,{column},100").unwrap();
    }
    folder.write("t.csv", &table);
    folder.plan(
        "frames_per_second = 2\n[[experiment]]\nkind = \"creep\"\nname = \"c\"\ntrials = \"t.csv\"\n",
    );
    let report = folder.evaluated();
    assert_eq!(report.number((0, 0), 0, "holds"), 3.0);
    assert_eq!(report.number((0, 0), 0, "mean length, s"), 29.5);
    let mean = |frames: std::ops::Range<usize>| {
        let count = frames.len() as f64;
        frames.map(value).sum::<f64>() / count
    };
    let (first, last) = (mean(0..6), mean(54..60));
    let (creep, low, high, _) = report.estimate((0, 0), 0, "creep, %");
    near(creep, 100.0 * (last - first) / first, 0.02);
    assert!(low > 0.9 * creep && high < 1.1 * creep);
    let half: Vec<(f64, f64)> = (30..60).map(|i| (i as f64 / 2.0, value(i))).collect();
    let drift = 100.0 * 3600.0 * line(&half).0 / mean(30..60);
    near(report.number((0, 0), 0, "drift, %/h"), drift, 0.02 * drift);
    // Amplitude and time constant in words: `10.0 (5.0 s)`; time constants lie 11 % apart.
    let words = report.table(0, 1)["rows"][0][2].as_str().unwrap();
    let numbers: Vec<f64> = words
        .split([' ', '(', ')'])
        .filter_map(|word| word.parse().ok())
        .collect();
    // What the nearest time constant leaves may be given to a second, small one.
    let amplitudes: f64 = numbers.iter().step_by(2).sum();
    near(amplitudes, 10.0, 0.1);
    assert!(numbers[0] > 0.95 * amplitudes, "{words}");
    near(numbers[1], 5.0, 0.5);
}

#[test]
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

/// Six frames of three loads each in one row and one more, with their places and totals; the loads as values too.
fn presses(folder: &Folder) {
    let mut table = "recording,frame,row,column,load_g,total_g,x_mm,y_mm\n".to_owned();
    let (mut frames, mut truth) = (Vec::new(), Vec::new());
    for frame in 0..6usize {
        let scale = 40.0 * (frame + 1) as f64;
        let loads: [(usize, usize, f64); 4] = [
            (1, 1, scale),
            (1, 3, 2.0 * scale),
            (1, 4, scale),
            (3, 3, scale),
        ];
        let total: f64 = loads.iter().map(|l| l.2).sum();
        let centre = |of: &dyn Fn(&(usize, usize, f64)) -> f64| {
            2.0 * loads.iter().map(|l| of(l) * l.2).sum::<f64>() / total
        };
        let (x, y) = (centre(&|l| l.1 as f64), centre(&|l| l.0 as f64));
        writeln!(
            table,
            "presses.txt,{frame},1,3,{},{total},{x},{y}",
            2.0 * scale
        )
        .unwrap();
        frames.push(loads.map(|(r, c, load)| (r, c, siemens(load))).to_vec());
        truth.push(loads.to_vec());
    }
    folder.scan("sensor.toml", "presses.txt", &frames);
    folder.write("t.csv", &table);
    folder.write("truth.csv", &conductances(&truth, 0.0));
}

#[test]
fn the_exact_inverse_has_no_error_and_the_raw_reading_has_one() {
    let folder = Folder::new();
    presses(&folder);
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"presses\"\ntrials = \"t.csv\"\nranges_g = [0, 300]\n\
         [[experiment]]\nkind = \"accuracy\"\nname = \"frames\"\nrecording = \"presses.txt\"\n\
         truth_g = \"truth.csv\"\nframes_per_experiment = 2\nranges_g = [0, 300]\n",
    );
    let report = folder.evaluated();
    // Taxel, by load, total, place.
    for (table, tolerance) in [(0, 0.02), (2, 0.1)] {
        let (bias, low, high, experiments) = report.estimate((0, table), 1, "bias");
        assert_eq!(experiments, 6);
        assert!(low <= bias && bias <= high);
        for column in ["mean absolute", "root mean square", "95th percentile"] {
            near(report.number((0, table), 1, column), 0.0, tolerance);
        }
        let raw = report.estimate((0, table), 0, "bias");
        assert!(raw.2 < -1.0, "{raw:?}");
    }
    near(report.number((0, 3), 1, "mean"), 0.0, 1e-3);
    assert!(report.number((0, 3), 0, "mean") > 2e-3);
    let names: Vec<&str> = report.table(0, 1)["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row[0].as_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "raw, 0 to 300 g",
            "raw, from 300 g",
            "auto, 0 to 300 g",
            "auto, from 300 g"
        ]
    );
    // Loads of 80, 160, 240 g; 320, 400, 480 g.
    assert_eq!(report.number((0, 1), 0, "readings"), 3.0);
    assert!(report.number((0, 1), 0, "bias") > report.number((0, 1), 1, "bias"));
    // Whole frames: four loaded taxels in six frames, of which two are one experiment.
    assert_eq!(report.number((1, 0), 1, "readings"), 24.0);
    let (error, _, _, experiments) = report.estimate((1, 0), 1, "mean absolute");
    assert_eq!(experiments, 3);
    near(error, 0.0, 0.02);
    near(report.number((1, 2), 1, "mean absolute"), 0.0, 0.1);
    near(report.number((1, 3), 1, "mean"), 0.0, 1e-3);
    near(report.number((1, 4), 1, "largest ghost, g"), 0.0, 0.05);
    near(report.number((1, 4), 1, "cross-talk index"), 0.0, 1e-4);
    let head = report.table(1, 4)["head"].as_array().unwrap();
    assert_eq!(head.len(), 3);
}

#[test]
fn a_table_may_mix_lines_about_taxels_and_about_the_whole() {
    let folder = Folder::new();
    presses(&folder);
    folder.write(
        "t.csv",
        "recording,frame,row,column,load_g,total_g\npresses.txt,0,1,3,80,\npresses.txt,1,,,,400\n",
    );
    folder.plan("[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\n");
    let report = folder.evaluated();
    near(report.number((0, 0), 1, "mean absolute"), 0.0, 0.02);
    near(report.number((0, 1), 1, "mean absolute"), 0.0, 0.1);
    assert_eq!(report.number((0, 0), 1, "readings"), 1.0);
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

#[test]
fn frames_that_cannot_be_read_are_left_out_and_told() {
    let folder = Folder::new();
    let frames: Vec<Pressed> = (0..4)
        .map(|i| vec![(1, 2, 1e-4 * f64::from(i + 1))])
        .collect();
    folder.scan("sensor.toml", "whole.txt", &frames);
    let whole = folder.read("whole.txt");
    let mut lines: Vec<&str> = whole.lines().collect();
    lines[4] = "24,x,24,24,24,24,";
    folder.write("hurt.txt", &lines.join("\n"));
    folder.write(
        "t.csv",
        "recording,frame,row,column,load_g\nhurt.txt,0,1,2,10\nhurt.txt,2,1,2,30\nhurt.txt,3,1,2,40\n",
    );
    folder.plan(
        "[[experiment]]\nkind = \"response\"\nname = \"r\"\ntrials = \"t.csv\"\nvalue = \"siemens\"\n",
    );
    let run = folder.taxel("evaluate plan.toml --json");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("frame 1 left out"), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert!(report.paragraphs(0).contains("1 frames could not be read"));
    // The others keep their numbers.
    for (row, wanted) in [(0, 1e-4), (1, 3e-4), (2, 4e-4)] {
        near(report.number((0, 1), row, "mean"), wanted, 1e-7);
    }
    // The loads of the frame that is missing are passed over too.
    let truth: Vec<Pressed> = (0..4)
        .map(|i| {
            vec![(
                1,
                2,
                ((1e-4 * f64::from(i + 1) - REST) / 8.29e-6).powf(1.0 / 0.857),
            )]
        })
        .collect();
    folder.write("truth.csv", &conductances(&truth, 0.0));
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"hurt.txt\"\ntruth_g = \"truth.csv\"\n",
    );
    let run = folder.taxel("evaluate plan.toml --json");
    assert_eq!(run.code, Some(3), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert_eq!(report.number((0, 0), 1, "readings"), 3.0);
    near(report.number((0, 0), 1, "95th percentile"), 0.0, 0.05);
}

#[test]
fn frames_that_no_conductances_explain_are_told() {
    let folder = Folder::new();
    folder.scan(
        "sensor.toml",
        "r.txt",
        &[(0..24).map(|i| (i / 6, i % 6, 1e-3)).collect()],
    );
    folder.other_sensor(
        "sensor.toml",
        "r_mux_row_ohms = 10.0",
        "r_mux_row_ohms = 2000.0",
    );
    folder.write("t.csv", "recording,row,column\nr.txt,1,1\n");
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"r\"\ntrials = \"t.csv\"\n");
    // Counts are what they are.
    folder.good("evaluate plan.toml");
    let plan = folder.read("plan.toml");
    folder.write("plan.toml", &(plan + "value = \"siemens\"\n"));
    let run = folder.taxel("evaluate plan.toml");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        run.out
            .contains("1 frames could not be read, or no conductances explain"),
        "{run}"
    );
}

/// A plan of a loop that nobody has recorded yet.
fn unmade() -> Folder {
    let folder = Folder::new();
    folder.write(
        "t.csv",
        "recording,row,column,load_g,experiment\n9.mcap,1,1,0,a\nsub/10.mcap,1,1,100,a\n8.mcap,1,1,50,a\n7.mcap,1,1,0,a\n",
    );
    folder.plan(
        "live_frames = 3\n[[experiment]]\nkind = \"hysteresis\"\nname = \"one loop\"\ntrials = \"t.csv\"\nvalue = \"counts\"\n",
    );
    folder
}

const LIVE: &str = "evaluate plan.toml --live sim:sensor.toml?hand --json";
const MADE: [&str; 4] = ["9.mcap", "sub/10.mcap", "8.mcap", "7.mcap"];

#[test]
fn recordings_are_made_in_the_order_of_the_table_and_kept() {
    let folder = unmade();
    let run = folder.taxel_with(LIVE, "\n\n\n\n");
    assert_eq!(run.code, Some(0), "{run}");
    let told: Vec<&str> = run.err.lines().filter(|l| l.starts_with('[')).collect();
    assert_eq!(
        told,
        [
            "[1/4] one loop: take everything off, then Enter",
            "[2/4] one loop: press row 1, column 1 with 100 g, then Enter",
            "[3/4] one loop: press row 1, column 1 with 50 g, then Enter",
            "[4/4] one loop: take everything off, then Enter",
        ]
    );
    assert!(run.err.contains("4 recordings made"), "{run}");
    let report = Report(serde_json::from_str(&run.out).unwrap());
    assert_eq!(report.number((0, 0), 0, "loops"), 1.0);
    let bytes = || MADE.map(|name| std::fs::read(folder.path(name)).unwrap());
    let before = bytes();
    for name in MADE {
        folder.good(&format!("convert {name} -o {name}.txt"));
        assert!(folder.numbers(&format!("{name}.txt")).len() >= 3 * 24);
    }
    // Nothing is made twice, and nobody is asked.
    let again = folder.taxel_with(LIVE, "");
    assert_eq!(again.code, Some(0), "{again}");
    assert!(again.err.starts_with("0 recordings made"), "{again}");
    assert_eq!(again.out, run.out);
    assert!(before == bytes());
}

#[test]
fn what_was_recorded_before_nobody_pressed_enter_is_kept() {
    let folder = unmade();
    let run = folder.taxel_with(LIVE, "\n\n");
    insta::assert_snapshot!(without_frames(&run.err), @r"
    4 recordings to make; Enter begins one, Ctrl-C ends: what was recorded is kept
    [1/4] one loop: take everything off, then Enter
    [2/4] one loop: press row 1, column 1 with 100 g, then Enter
    [3/4] one loop: press row 1, column 1 with 50 g, then Enter
    error: nobody can press Enter: standard input has ended
    hint: run it in a terminal; what was recorded is kept, and a next run goes on from there
    ");
    assert_eq!(run.code, Some(2), "{run}");
    assert_eq!(
        MADE.map(|name| folder.exists(name)),
        [true, true, false, false]
    );
    assert!(!folder.names().iter().any(|name| name.contains("partial")));
    let bytes = std::fs::read(folder.path("9.mcap")).unwrap();
    let run = folder.taxel_with(LIVE, "\n\n");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(run.err.contains("2 recordings made"), "{run}");
    assert!(bytes == std::fs::read(folder.path("9.mcap")).unwrap());
}

/// Messages without how many frames a fast source gave.
fn without_frames(err: &str) -> String {
    let lines = err.lines().filter(|line| !line.contains(" frames in "));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_frame_that_a_trial_asks_for_is_recorded() {
    let folder = unmade();
    folder.write(
        "t.csv",
        "recording,frame,total_g,x_mm,y_mm\na.mcap,7,100,3,4.5\n",
    );
    folder.plan(
        "live_frames = 2\n[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\n",
    );
    let run = folder.taxel_with(LIVE, "\n");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.err
            .contains("[1/1] a: press at x 3 mm, y 4.5 mm, 100 g in all, then Enter"),
        "{run}"
    );
}

#[test]
fn what_cannot_be_measured_live_is_refused() {
    let folder = unmade();
    for (address, says) in [
        ("file:r.mcap", "is a recording, not a live sensor"),
        ("stdin:", "both the sensor and the Enter key"),
        ("nonsense", "is no address"),
    ] {
        let run = folder.taxel(&format!("evaluate plan.toml --live {address}"));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains(says), "{run}");
    }
    folder.write("t.csv", "recording,row,column,load_g\nr.npy,1,1,0\n");
    let run = folder.taxel(LIVE);
    assert_eq!(run.code, Some(2), "{run}");
    assert!(
        run.err
            .contains("r.npy does not exist, and what is measured is recorded as .mcap"),
        "{run}"
    );
}

#[test]
fn plans_that_make_no_sense_are_refused_with_words() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.fails("evaluate nowhere.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open nowhere.toml: No such file or directory (os error 2)
    hint: docs/evaluate.md has an example of a plan
    ");
    let good = "[[experiment]]\nkind = \"creep\"\nname = \"x\"\ntrials = \"t.csv\"\n";
    let plan = |text: &str| {
        folder.write("plan.toml", text);
        folder.fails("evaluate plan.toml")
    };
    let head = "format = 1\nsensor = \"sensor.toml\"\n";
    insta::assert_snapshot!(plan(&format!("{head}sead = 3\n{good}")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: TOML parse error at line 3, column 1
      |
    3 | sead = 3
      | ^^^^
    unknown field `sead`, expected one of `format`, `title`, `sensor`, `seed`, `resamples`, `confidence`, `frames_per_second`, `live_frames`, `experiment`
    hint: docs/evaluate.md has every key of a plan
    ");
    insta::assert_snapshot!(plan(&format!("{head}{}", good.replace("creep", "crosstalk"))), @r#"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: TOML parse error at line 4, column 8
      |
    4 | kind = "crosstalk"
      |        ^^^^^^^^^^^
    unknown variant `crosstalk`, expected one of `repeatability`, `response`, `hysteresis`, `creep`, `cross-talk`, `accuracy`
    hint: docs/evaluate.md has every key of a plan
    "#);
    insta::assert_snapshot!(plan(&format!("{head}{}", good.replace("[[experiment]]", "[experiment]"))), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: TOML parse error at line 3, column 1
      |
    3 | [experiment]
      | ^^^^^^^^^^^^
    invalid type: map, expected a sequence
    write [[experiment]], with two brackets: there may be more than one
    hint: docs/evaluate.md has every key of a plan
    ");
    for (text, says) in [
        (String::new(), "missing field `format`"),
        (
            format!("format = 2\nsensor = \"sensor.toml\"\n{good}"),
            "format = 2, but this program knows format 1",
        ),
        (
            format!("{head}experiment = []\n"),
            "no experiment: each begins with [[experiment]]",
        ),
        (head.to_owned(), "missing field `experiment`"),
        (
            format!("{head}{}", good.replace("name = \"x\"", "")),
            "missing field `name`",
        ),
        (
            format!("{head}{}", good.replace("\"x\"", "\" \"")),
            "no name",
        ),
        (
            format!("{head}{}", good.replace("trials", "trial")),
            "unknown field `trial`",
        ),
        (
            format!("{head}{}", good.replace("trials = \"t.csv\"", "")),
            "no trials",
        ),
        (
            format!("{head}{good}recording = \"r.npy\"\n"),
            "both trials and recording",
        ),
        (
            format!(
                "{head}{}",
                good.replace("trials = \"t.csv\"", "recording = \"r\"\ntruth_g = \"t\"")
            ),
            "creep needs trials",
        ),
        (
            format!(
                "{head}{}",
                good.replace("creep", "accuracy")
                    .replace("trials", "recording")
            ),
            "recording and truth_g go together",
        ),
        (
            format!("{head}confidence = 95\n{good}"),
            "confidence = 95, expected 0.5 to below 1",
        ),
        (
            format!("{head}resamples = 5\n{good}"),
            "resamples = 5, expected 100",
        ),
        (
            format!("{head}frames_per_second = 0\n{good}"),
            "frames_per_second = 0, expected a number above 0",
        ),
        (
            format!("{head}live_frames = 0\n{good}"),
            "live_frames = 0, expected 1 or more",
        ),
        (
            format!("{head}{good}along = \"column\"\n"),
            "along means nothing to creep",
        ),
        (
            format!("{head}{good}value = \"newtons\"\n"),
            "unknown variant `newtons`",
        ),
        (
            format!("{head}{good}ranges_g = [1, 0]\n"),
            "ranges_g means nothing to creep",
        ),
        (
            format!(
                "{head}{}ranges_g = [1, 0]\n",
                good.replace("creep", "accuracy")
            ),
            "ranges_g = [1.0, 0.0] must ascend",
        ),
        (
            format!(
                "{head}{}value = \"grams\"\n",
                good.replace("creep", "accuracy")
            ),
            "value means nothing to accuracy",
        ),
        (
            format!("{head}{good}frames_per_experiment = 2\n"),
            "frames_per_experiment means nothing to creep",
        ),
        (
            format!("format = 1\nsensor = \"nosensor.toml\"\n{good}"),
            "cannot open nosensor.toml",
        ),
        (format!("{head}{good}"), "cannot open t.csv"),
    ] {
        let run = plan(&text);
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.err.contains(says), "{says}\n{run}");
    }
    let none = folder.fails("evaluate");
    assert_eq!(none.code, Some(2));
    for name in ["report.docx", "report"] {
        let run = folder.fails(&format!("evaluate plan.toml -o {name}"));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(
            run.err
                .contains("is no report's name\nhint: it ends in .html or .pdf"),
            "{run}"
        );
        assert_eq!(
            folder.fails(&format!("report plan.toml -o {name}")).code,
            Some(2)
        );
    }
}

#[test]
fn tables_that_do_not_fit_their_kind_are_refused_with_their_place() {
    let folder = Folder::new();
    let frames: Vec<Pressed> = (0..12).map(|_| vec![(1, 1, 1e-3)]).collect();
    folder.scan("sensor.toml", "r.txt", &frames);
    let trial = |kind: &str, table: &str| {
        folder.plan(&format!(
            "[[experiment]]\nkind = \"{kind}\"\nname = \"x\"\ntrials = \"t.csv\"\n"
        ));
        folder.write("t.csv", table);
        folder.fails("evaluate plan.toml")
    };
    insta::assert_snapshot!(trial("response", "recording,row,column\nr.txt,1,1\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: t.csv, line 2: response needs load_g in every line
    hint: docs/evaluate.md says which columns each kind needs
    ");
    insta::assert_snapshot!(trial("response", "recording,row,column,load_g\nr.txt,1,1,5\nr.txt,4,1,5\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: taxel outside the array at t.csv, line 3, column 7: `4,1` is row 4, column 1, but the array has 4 rows x 6 columns, counted from 0
    hint: check the label, `labels` under [array] in the sensor file, and which sensor this is
    ");
    insta::assert_snapshot!(trial("hysteresis", "recording,row,column,load_g\nr.txt,1,1,5\nr.txt,1,1,7\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: t.csv, setting all: hysteresis needs a loop (lines with one word under experiment) whose load grows and falls over two loads or more, found 24 readings that are not it
    ");
    for (kind, table, says) in [
        (
            "repeatability",
            "recording\nr.txt\n",
            "line 2: repeatability needs row and column, or taxel",
        ),
        (
            "hysteresis",
            "recording,row,column\nr.txt,1,1\n",
            "hysteresis needs load_g",
        ),
        (
            "creep",
            "recording,load_g\nr.txt,1\n",
            "creep needs row and column, or taxel",
        ),
        (
            "cross-talk",
            "recording,row,column\nr.txt,1,1\n",
            "cross-talk needs others",
        ),
        (
            "cross-talk",
            "recording,row,column,others\nr.txt,1,1,1\nr.txt,1,1,6\n",
            "line 3: 6 others pressed, but a row has 6 taxels",
        ),
        (
            "cross-talk",
            "recording,row,column,others\nr.txt,1,1,2\n",
            "cross-talk needs readings with two numbers of others",
        ),
        (
            "accuracy",
            "recording,row,column\nr.txt,1,1\n",
            "accuracy needs taxel and load_g, or total_g, or x_mm and y_mm",
        ),
        ("accuracy", "recording,total_g,x_mm\nr.txt,1,1\n", "y_mm"),
        (
            "accuracy",
            "recording,total_g,x_mm,y_mm\nr.txt,1,1,\n",
            "x_mm and y_mm go together",
        ),
        (
            "accuracy",
            "recording,x_mm,y_mm\nr.txt,-1,1\n",
            "places count from the centre of the taxel",
        ),
        ("response", "row,column,load_g\n1,1,1\n", "recording"),
        ("response", "recording,row,load_g\nr.txt,1,1\n", "column"),
        (
            "response",
            "recording,row,column,load\nr.txt,1,1,1\n",
            "did you mean `load_g`?",
        ),
        (
            "response",
            "recording,row,column,load_g\nr.txt,1,1,heavy\n",
            "must be a finite number",
        ),
        (
            "response",
            "recording,row,column,load_g\nnowhere.txt,1,1,1\n",
            "cannot open nowhere.txt",
        ),
        (
            "response",
            "recording,frame,row,column,load_g\nr.txt,12,1,1,1\n",
            "line 2: frame 12 of r.txt, but it has 12 frames",
        ),
        (
            "response",
            "recording,row,column,load_g\nr.txt,1,1,1\n",
            "response needs readings under two loads or more",
        ),
        (
            "creep",
            "recording,row,column\nr.txt,1,1\n",
            "r.txt: no times, but experiment 'x' is about time",
        ),
        (
            "response",
            "recording,row,column,load_g\n",
            "no trial in t.csv",
        ),
    ] {
        let run = trial(kind, table);
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.err.contains(says), "{says}\n{run}");
    }
}

#[test]
fn settings_that_no_trial_has_are_refused() {
    let folder = Folder::new();
    responses(&folder);
    folder.plan(
        "[[experiment]]\nkind = \"response\"\nname = \"r\"\ntrials = \"t.csv\"\n[experiment.settings]\n\"2V\" = \"v2.toml\"\n",
    );
    insta::assert_snapshot!(folder.fails("evaluate plan.toml"), @r#"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: experiment 'r': settings has '2V', but t.csv has {"0.4 V", "2 V"}
    hint: docs/evaluate.md has every key of a plan
    "#);
}

#[test]
fn loads_need_a_load_law_and_truths() {
    let folder = Folder::new();
    presses(&folder);
    let without = SENSOR.split("[material]").next().unwrap();
    folder.write("plain.toml", without);
    folder.plan("[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\nsensor = \"plain.toml\"\n");
    let run = folder.fails("evaluate plan.toml");
    assert!(
        run.err
            .contains("has no [material]\nhint: run `taxel calibrate`"),
        "{run}"
    );
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"a\"\ntrials = \"t.csv\"\nvalue = \"grams\"\nsensor = \"plain.toml\"\n");
    assert!(
        folder
            .fails("evaluate plan.toml")
            .err
            .contains("has no [material]")
    );
    let fewer: Vec<Pressed> = vec![vec![(1, 1, 5.0)]; 5];
    folder.write("truth.csv", &conductances(&fewer, 0.0));
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"presses.txt\"\ntruth_g = \"truth.csv\"\n",
    );
    insta::assert_snapshot!(folder.fails("evaluate plan.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: truth.csv: 5 frames of known loads, but presses.txt has more
    hint: one frame of loads for each frame of counts
    ");
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"presses.txt\"\ntruth_g = \"truth.csv\"\nmethods = [\"rwa\"]\n",
    );
    let run = folder.fails("evaluate plan.toml");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("no method `rwa`"), "{run}");
}

/// Loads over time on half of the taxels, none on the others, and what a material with one lag makes of them.
fn series(folder: &Folder, weight: f64, tau_secs: f64, period: f64) {
    let frames = 160;
    let mut scanned: Vec<Pressed> = vec![Vec::new(); frames];
    let mut loads: Vec<Pressed> = vec![Vec::new(); frames];
    for taxel in 0..12usize {
        let (row, column) = (taxel / 3, 2 * (taxel % 3) + taxel / 3 % 2);
        let load = |frame: usize| match (frame + 7 * taxel) % 60 {
            _ if frame < 5 => 0.0,
            part if part < 35 => 60.0 + 15.0 * taxel as f64 + (part as f64),
            _ => 0.0,
        };
        // What lags behind: τ·ds/dt = F − s, the load straight between frames, in small steps.
        let mut lag = 0.0;
        for frame in 0..frames {
            if frame > 0 {
                let (from, to) = (load(frame - 1), load(frame));
                let steps = 1000;
                for step in 0..steps {
                    let at = from + (to - from) * (f64::from(step) + 0.5) / f64::from(steps);
                    let keep = (-period / f64::from(steps) / tau_secs).exp();
                    lag = keep * lag + (1.0 - keep) * at;
                }
            }
            let acting = load(frame) + weight * lag;
            scanned[frame].push((row, column, siemens(acting)));
            loads[frame].push((row, column, load(frame)));
        }
    }
    folder.scan("sensor.toml", "series.txt", &scanned);
    folder.write("loads.csv", &conductances(&loads, 0.0));
    let without = SENSOR.split("[material]").next().unwrap();
    folder.write("parts.toml", without);
}

#[test]
fn a_series_gives_the_creep_that_it_was_given() {
    let folder = Folder::new();
    series(&folder, 0.2, 3.0, 0.25);
    let calibrate = "calibrate --sensor parts.toml --series series.txt --loads loads.csv --period 0.25 --lags 1 --plays 0 -o c.toml";
    let run = folder.good(&format!("{calibrate} --json --static-output static.toml"));
    let report: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(report["frames"], 160);
    assert_eq!(report["taxels_fitted"], 12);
    let parameters = report["parameters"].as_array().unwrap();
    let found = |name: &str| {
        let one = parameters.iter().find(|p| p["name"] == name);
        one.unwrap_or_else(|| panic!("{parameters:?}"))["value"]
            .as_f64()
            .unwrap()
    };
    near(found("lag weight 1"), 0.2, 0.01);
    near(found("lag, s 1"), 3.0, 0.15);
    near(found("exponent"), 0.857, 0.005);
    // With what it found, the loads of the series come back; with the best law without memory they do not.
    folder.plan("");
    let plan = |sensor: &str| {
        folder.write(
            "plan.toml",
            &format!(
                "format = 1\nsensor = \"{sensor}\"\nframes_per_second = 4\nresamples = 100\n\
                 [[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"series.txt\"\n\
                 truth_g = \"loads.csv\"\nframes_per_experiment = 40\nmethods = [\"auto\"]\n"
            ),
        );
        folder.evaluated().number((0, 0), 0, "mean absolute")
    };
    let (with, without) = (plan("c.toml"), plan("static.toml"));
    assert!(with < 0.3, "{with}");
    assert!(without > 10.0 * with, "{without} {with}");
    let text = folder.good(calibrate);
    assert!(
        text.out.contains("160 frames, 39.8 s, 12 taxels fitted"),
        "{text}"
    );
}

#[test]
fn series_that_cannot_be_used_are_refused() {
    let folder = Folder::new();
    series(&folder, 0.2, 3.0, 0.25);
    let calibrate = "calibrate --sensor parts.toml --series series.txt -o c.toml";
    let no_period = folder.fails(&format!("{calibrate} --loads loads.csv"));
    insta::assert_snapshot!(no_period, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: series.txt tells no times, and creep is about time
    hint: --period takes the seconds between two frames
    ");
    let no_loads = folder.fails(&format!("{calibrate} --period 0.25"));
    assert_eq!(no_loads.code, Some(2));
    assert!(no_loads.err.contains("--loads <FILE>"), "{no_loads}");
    let text = folder.read("loads.csv");
    let some: Vec<&str> = text.lines().take(4 * 100).collect();
    folder.write("short.csv", &(some.join("\n") + "\n"));
    let shorter = folder.fails(&format!("{calibrate} --loads short.csv --period 0.25"));
    insta::assert_snapshot!(shorter, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: series.txt: the series has 160 frames, 100 frames of loads and 160 times, needs as many of each and 50 or more
    hint: one frame of known loads for each frame of counts
    ");
    for period in ["0", "-1"] {
        let run = folder.fails(&format!("{calibrate} --loads loads.csv --period={period}"));
        assert!(
            run.err.contains("period") || run.err.contains("time"),
            "{run}"
        );
    }
    assert!(!folder.exists("c.toml"));
}
