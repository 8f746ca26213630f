//! A sensor with known faults under a hand that rubs over it: only for tests. Everything follows from a seed.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::circuit::{Circuit, Converter, LinearCircuit, Noise, normal};
use crate::material::LoadLaw;
use crate::screen::Axis;
use crate::selftest::{SelfTest, SelfTestOptions, SelfTestResult, Unusable};
use crate::sensor::{PerLine, ScanOrder, preset};
use crate::simulate::{Imperfections, default_noise_counts, imperfect};
use crate::{Counts, Frame, Sensor};

mod far_parts;

use far_parts::FarParts;

/// What is broken. Everything empty: a sound sensor.
#[derive(Debug, Clone, Default)]
pub struct Broken {
    /// Lines without current.
    pub dead: Vec<(Axis, usize)>,
    /// Lines whose taxels from a position on carry no current.
    pub cut: Vec<(Axis, usize, usize)>,
    /// Lines with so many ohms more from a position on: as if each taxel beyond it were pressed alone.
    pub cracked: Vec<(Axis, usize, usize, f64)>,
    /// Lines without current in every third frame, by the seed.
    pub flickering: Vec<(Axis, usize)>,
    /// Lines whose readings are all at this share of the range.
    pub at: Vec<(Axis, usize, f64)>,
    /// A row and the next one that share their current.
    pub shorted_rows: Vec<usize>,
    /// Conductance of a taxel, siemens, whatever the load.
    pub siemens: Vec<(usize, f64)>,
    /// Taxels without current in every third frame.
    pub loose: Vec<usize>,
    /// Taxels that always read this count.
    pub stuck: Vec<(usize, f64)>,
    /// Taxels with this much noise on top, counts.
    pub noisy: Vec<(usize, f64)>,
    /// Share of the readings at either end, at random.
    pub stray_share: f64,
    /// Frequency, hertz, and amplitude, counts.
    pub hum: Option<(f64, f64)>,
    /// What the converter makes of a code.
    pub code: Option<fn(u64) -> u64>,
}

/// A sensor of `rows` × `columns` made of a preset, uneven by a tenth in switches and material.
pub fn sensor(name: &str, rows: usize, columns: usize, seed: u64) -> Sensor {
    let sensor = preset(name)
        .unwrap()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (rows, columns);
        })
        .unwrap();
    let uneven = Imperfections {
        mux_sd: 0.1,
        gain_sd: 0.1,
        ..Imperfections::default()
    };
    imperfect(&sensor, &uneven, seed).unwrap()
}

/// A sensor, its faults, and how it is recorded.
pub struct Bench {
    pub sensor: Sensor,
    pub broken: Broken,
    pub seed: u64,
    pub rate: Option<f64>,
    pub empty_frames: u64,
    pub rubbed_frames: u64,
}

impl Bench {
    pub fn new(sensor: Sensor, seed: u64) -> Self {
        Self {
            sensor,
            broken: Broken::default(),
            seed,
            rate: None,
            empty_frames: 100,
            rubbed_frames: 400,
        }
    }

    pub fn with(mut self, broken: Broken) -> Self {
        self.broken = broken;
        self
    }

    pub fn test(&self) -> Result<SelfTestResult, Unusable> {
        self.test_with(&SelfTestOptions::of(&self.sensor))
    }

    pub fn test_with(&self, options: &SelfTestOptions) -> Result<SelfTestResult, Unusable> {
        let test = self.begun(options);
        self.run(test.with_circuit(&self.as_its_owner_knows()))
    }

    fn begun(&self, options: &SelfTestOptions) -> SelfTest {
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        SelfTest::new(rows, columns, self.sensor.max_count(), options)
    }

    fn run(&self, mut test: SelfTest) -> Result<SelfTestResult, Unusable> {
        for frame in self.frames(false) {
            test.observe_empty(&frame)?;
        }
        for frame in self.frames(true) {
            test.observe_rubbed(&frame)?;
        }
        test.finish()
    }

    /// Switches all alike, and no material.
    fn as_its_owner_knows(&self) -> Sensor {
        let sensor = self.sensor.edited(|spec| {
            spec.material = None;
            let (rows, columns) = (spec.array.rows, spec.array.columns);
            let readout = &mut spec.readout;
            let alike = |list: &mut Option<PerLine>, lines| {
                *list = list.as_ref().map(|list| PerLine::One(list.mean(lines)));
            };
            alike(&mut readout.r_mux_column_ohms, columns);
            alike(&mut readout.r_mux_row_ohms, rows);
        });
        sensor.unwrap()
    }

    /// The findings, as `fault at place`, in alphabetical order.
    pub fn found(&self) -> Vec<String> {
        words(&self.test().unwrap())
    }

    /// The same of one who knows the shape of the array alone, and that its lines are left open.
    pub fn found_without_circuit(&self) -> Vec<String> {
        let test = self.begun(&SelfTestOptions::of(&self.sensor));
        words(&self.run(test).unwrap())
    }

    /// The frames of the empty or of the rubbed recording.
    pub fn frames(&self, rubbed: bool) -> impl Iterator<Item = Frame<Counts>> {
        let count = if rubbed {
            self.rubbed_frames
        } else {
            self.empty_frames
        };
        let law = LoadLaw::from_sensor(&self.sensor).unwrap();
        let circuit = LinearCircuit::from_sensor(&self.sensor).unwrap();
        let is_open = self.sensor.readout().has_open_columns();
        let apart = is_open.then(|| FarParts::new(&self.sensor, &self.broken));
        let converter = Converter::from_sensor(&self.sensor);
        let bits = self.sensor.converter().bits;
        let noise = Noise {
            standard_deviation_volts: default_noise_counts(bits) * converter.lsb_volts(),
        };
        let mut random = ChaCha8Rng::seed_from_u64(2 * self.seed + u64::from(rubbed));
        (0..count).map(move |k| {
            let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
            let share = rubbed.then(|| k as f64 / count as f64);
            let loads = self.hand(share, &mut random);
            let siemens = loads.iter().enumerate();
            let siemens = siemens.map(|(taxel, &g)| law.siemens_from_grams(taxel, g));
            let mut siemens = Frame::new(rows, columns, siemens.collect()).unwrap();
            self.break_taxels(siemens.values_mut(), &mut random);
            self.tie_rows(siemens.values_mut());
            let mut volts = match &apart {
                Some(apart) => apart.read(&siemens),
                None => circuit.predict(&siemens).unwrap(),
            };
            self.repeat_rows(volts.values_mut());
            self.add_hum(volts.values_mut(), k, &converter);
            noise.add(&mut volts, &mut random);
            let mut counts = converter.counts_from_volts(&volts);
            self.break_readings(counts.values_mut(), &mut random);
            counts.sequence = k;
            counts.time_secs = self.rate.map(|rate| k as f64 / rate);
            counts
        })
    }

    /// A palm and four fingers, grams on every taxel, on a path along which they pass over all of the array; `share` says
    /// how far along. Nothing of no share.
    fn hand(&self, share: Option<f64>, random: &mut ChaCha8Rng) -> Vec<f64> {
        let (rows, columns) = (self.sensor.rows() as f64, self.sensor.columns() as f64);
        let mut loads = vec![0.0; self.sensor.rows() * self.sensor.columns()];
        let Some(share) = share else { return loads };
        let strokes = 6.0;
        let stroke = (share * strokes).floor();
        let along = share * strokes - stroke;
        let along = if stroke % 2.0 == 0.0 {
            along
        } else {
            1.0 - along
        };
        let jitter = |random: &mut ChaCha8Rng| random.random_range(-0.5..0.5);
        let centre = [
            (stroke + 0.5) / strokes * rows + jitter(random),
            (-0.05 + 1.1 * along) * columns + jitter(random),
        ];
        let size = 0.16 * rows.min(columns) + 1.2;
        let mut pads = vec![([0.0, 0.0], [1.1, 0.9], 1.0)];
        for finger in 0..4 {
            let across = 0.55 * (f64::from(finger) - 1.5);
            pads.push(([across, 1.5], [0.24, 0.7], 0.6));
        }
        let strength = 250.0 * random.random_range(0.7..1.3);
        for (taxel, load) in loads.iter_mut().enumerate() {
            let at = [taxel as f64 / columns, taxel as f64 % columns];
            let at = [at[0].floor() + 0.5, at[1] + 0.5];
            for &(offset, half, height) in &pads {
                let away: f64 = (0..2)
                    .map(|i| ((at[i] - centre[i]) / size - offset[i]) / half[i])
                    .map(|d| d * d)
                    .sum();
                if away < 1.0 {
                    *load = load.max(strength * height * (1.0 - away).powf(0.7));
                }
            }
        }
        loads
    }

    fn line(&self, axis: Axis, index: usize) -> Vec<usize> {
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        match axis {
            Axis::Row => (0..columns).map(|c| index * columns + c).collect(),
            Axis::Column => (0..rows).map(|r| r * columns + index).collect(),
        }
    }

    fn break_taxels(&self, siemens: &mut [f64], random: &mut ChaCha8Rng) {
        let broken = &self.broken;
        for &(taxel, value) in &broken.siemens {
            siemens[taxel] = value;
        }
        let mut out = || random.random::<f64>() < 1.0 / 3.0;
        for &taxel in &broken.loose {
            if out() {
                siemens[taxel] = 0.0;
            }
        }
        if self.sensor.readout().has_open_columns() {
            // [`FarParts`] has what lies beyond.
            return self.break_lines(siemens, out);
        }
        for &(axis, index, from) in &broken.cut {
            for &taxel in &self.line(axis, index)[from..] {
                siemens[taxel] = 0.0;
            }
        }
        for &(axis, index, from, ohms) in &broken.cracked {
            for &taxel in &self.line(axis, index)[from..] {
                siemens[taxel] /= 1.0 + ohms * siemens[taxel];
            }
        }
        self.break_lines(siemens, out);
    }

    fn break_lines(&self, siemens: &mut [f64], mut out: impl FnMut() -> bool) {
        let broken = &self.broken;
        let mut lines = broken.dead.clone();
        lines.extend(broken.flickering.iter().copied().filter(|_| out()));
        for (axis, index) in lines {
            for taxel in self.line(axis, index) {
                siemens[taxel] = 0.0;
            }
        }
    }

    fn shorted_taxels(&self) -> impl Iterator<Item = (usize, usize)> {
        let rows = self.broken.shorted_rows.iter();
        rows.flat_map(|&row| {
            let (one, other) = (self.line(Axis::Row, row), self.line(Axis::Row, row + 1));
            one.into_iter().zip(other)
        })
    }

    /// Two rows that are one line: it has the conductances of both.
    fn tie_rows(&self, siemens: &mut [f64]) {
        for (a, b) in self.shorted_taxels() {
            (siemens[a], siemens[b]) = (siemens[a] + siemens[b], 0.0);
        }
    }

    /// Whichever of the two is selected, it is read.
    fn repeat_rows(&self, volts: &mut [f64]) {
        for (a, b) in self.shorted_taxels() {
            volts[b] = volts[a];
        }
    }

    fn add_hum(&self, volts: &mut [f64], frame: u64, converter: &Converter) {
        let (Some((hertz, counts)), Some(rate)) = (self.broken.hum, self.rate) else {
            return;
        };
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        let taxels = volts.len() as f64;
        for (taxel, volt) in volts.iter_mut().enumerate() {
            let index = match self.sensor.converter().scan_order {
                ScanOrder::RowByRow => taxel,
                ScanOrder::ColumnByColumn => taxel % columns * rows + taxel / columns,
            };
            let secs = (frame as f64 + index as f64 / taxels) / rate;
            *volt += counts * converter.lsb_volts() * (TAU * hertz * secs).sin();
        }
    }

    fn break_readings(&self, counts: &mut [f64], random: &mut ChaCha8Rng) {
        let (broken, most) = (&self.broken, self.sensor.max_count());
        for &(taxel, noise) in &broken.noisy {
            counts[taxel] = (counts[taxel] + noise * normal(random))
                .round()
                .clamp(0.0, most);
        }
        for &(taxel, value) in &broken.stuck {
            counts[taxel] = value;
        }
        for &(axis, index, share) in &broken.at {
            for taxel in self.line(axis, index) {
                counts[taxel] = (share * most).round();
            }
        }
        if broken.stray_share > 0.0 {
            for count in counts.iter_mut() {
                let (stray, high): (f64, bool) = (random.random(), random.random());
                if stray < broken.stray_share {
                    *count = if high { most } else { 0.0 };
                }
            }
        }
        if let Some(code) = broken.code {
            for count in counts {
                *count = code(*count as u64) as f64;
            }
        }
    }
}

fn words(result: &SelfTestResult) -> Vec<String> {
    let findings = result.findings.iter();
    let mut found: Vec<String> = findings
        .map(|f| format!("{} at {}", f.fault.word(), f.place))
        .collect();
    found.sort();
    found
}
