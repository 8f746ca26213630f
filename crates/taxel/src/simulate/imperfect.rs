//! What differs between a parts list and a sensor built from it.

use rand_chacha::ChaCha8Rng;

use super::{Purpose, ReadingFaults, generator};
use crate::circuit::normal;
use crate::material::DynamicLaw;
use crate::sensor::{
    AxisSpec, DynamicSpec, EndTo, MaterialSpec, PerLine, PerTaxel, SensorSpec, SheetSpec,
};
use crate::{Error, Sensor};

/// Load at which taxels that differ in exponent alone respond alike, grams.
const PIVOT_LOAD_G: f64 = 100.0;

/// How a real sensor differs from its nominal numbers; what is drawn is log-normal unless said otherwise.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Imperfections {
    /// Relative standard deviation of the switch resistances, line by line. 0.1 is typical.
    pub mux_sd: f64,
    /// Relative standard deviation of what lines resist along their length, line by line, where they do.
    pub line_sd: f64,
    /// Relative standard deviation of the material's gain, taxel by taxel.
    pub gain_sd: f64,
    /// Standard deviation of the exponent, taxel by taxel (normal, no less than half of the nominal one). Taxels that
    /// differ in it alone respond alike at 100 g.
    pub exponent_sd: f64,
    /// The feedback or pull-down resistor's relative deviation: 0.005 is half a percent more.
    pub resistor_deviation: f64,
    /// The amplifier's true open-loop gain at the scan rate, where it is not the nominal one.
    pub open_loop_gain: Option<f64>,
    /// Load at which the material has lost half of its response, grams.
    pub saturation_load_g: Option<f64>,
    /// Mechanical spread, as in sensor.toml.
    pub spread: Option<[f64; 3]>,
    /// One continuous sheet over all taxels, as in sensor.toml.
    pub sheet: Option<SheetSpec>,
    /// Creep and hysteresis, as in sensor.toml.
    pub dynamic: Option<DynamicSpec>,
    /// The converter's offset, volts.
    pub offset_volts: f64,
    /// Share of its predecessor in the scan that a reading keeps, 0 to below 0.5.
    pub carry_over: f64,
    /// How many rows say nothing.
    pub dead_rows: usize,
    /// How many columns say nothing.
    pub dead_columns: usize,
    /// How many rows come and go.
    pub flickering_rows: usize,
    /// How many columns come and go.
    pub flickering_columns: usize,
    /// Stuck readings, and how often flickering lines are out.
    pub faults: ReadingFaults,
}

impl Imperfections {
    /// An array as it comes from the bench: every switch, line that resists and taxel differs by a tenth, the amplifier is slow, a
    /// reading in 500 is stuck, one row is dead and one column flickers. All of it is within the circuit's model.
    pub fn uneven() -> Self {
        Self {
            mux_sd: 0.1,
            line_sd: 0.1,
            gain_sd: 0.1,
            resistor_deviation: 0.005,
            open_loop_gain: Some(5000.0),
            dead_rows: 1,
            flickering_columns: 1,
            faults: ReadingFaults {
                stuck_share: 0.002,
                ..ReadingFaults::default()
            },
            ..Self::default()
        }
    }

    /// What the circuit's equations do not know: loads that spread to the neighbours, an exponent for each taxel,
    /// a material that saturates, an offset, readings that keep a little of their predecessor; and the uneven switches
    /// and gains of [`Self::uneven`], without its broken lines.
    pub fn beyond_the_circuit() -> Self {
        Self {
            exponent_sd: 0.02,
            saturation_load_g: Some(2500.0),
            spread: Some([0.05, 0.05, 0.01]),
            offset_volts: 0.002,
            carry_over: 0.003,
            dead_rows: 0,
            flickering_columns: 0,
            faults: ReadingFaults::default(),
            ..Self::uneven()
        }
    }

    /// The same, and one continuous sheet: 12 kΩ between neighbours in series with three times their contacts.
    pub fn under_a_sheet() -> Self {
        Self {
            sheet: Some(SheetSpec::new(12e3, 3.0)),
            ..Self::beyond_the_circuit()
        }
    }

    /// A material that remembers, and nothing else: 3 % of creep a decade from 0.8 to 80 s, and 6 % of hysteresis.
    pub fn creeping() -> Self {
        let law = DynamicLaw {
            lags: [0.8, 8.0, 80.0].map(|secs| (0.03, secs)).to_vec(),
            plays: [5.0, 15.0, 40.0].map(|grams| (0.02, grams)).to_vec(),
            period_secs: 1.0,
        };
        Self {
            dynamic: Some(law.to_spec()),
            ..Self::default()
        }
    }
}

/// Draws a true sensor from what its owner knows: one switch resistance per line, one gain and exponent per taxel,
/// and broken lines, which the truth's `screen` names. What `imperfections` does not touch stays.
///
/// # Errors
/// A number outside its physical range.
pub fn imperfect(
    nominal: &Sensor,
    imperfections: &Imperfections,
    seed: u64,
) -> Result<Sensor, Error> {
    nominal.edited(|truth| draw(truth, imperfections, seed))
}

fn draw(truth: &mut SensorSpec, imperfections: &Imperfections, seed: u64) {
    let (rows, columns) = (truth.array.rows, truth.array.columns);
    // One stream each, so that turning one imperfection on leaves the others as they were.
    let stream = |number| generator(seed, Purpose::Sensor, number);
    let readout = &mut truth.readout;
    let (switches, lines) = (imperfections.mux_sd, imperfections.line_sd);
    for (list, count, sd, number) in [
        (&mut readout.r_mux_column_ohms, columns, switches, 0),
        (&mut readout.r_mux_row_ohms, rows, switches, 1),
        (&mut readout.r_line_column_ohms, columns, lines, 6),
        (&mut readout.r_line_row_ohms, rows, lines, 7),
    ] {
        vary_lines(list, count, sd, &mut stream(number));
    }
    for ohms in [&mut readout.r_feedback_ohms, &mut readout.r_pull_down_ohms]
        .into_iter()
        .flatten()
    {
        *ohms *= 1.0 + imperfections.resistor_deviation;
    }
    if let Some(sensed) = &mut readout.sensed {
        vary_pull_downs(sensed, 1.0 + imperfections.resistor_deviation);
    }
    if imperfections.open_loop_gain.is_some() && readout.has_amplifier() {
        readout.open_loop_gain = imperfections.open_loop_gain;
    }
    truth.converter.offset_volts += imperfections.offset_volts;
    if imperfections.carry_over > 0.0 {
        truth.converter.carry_over = imperfections.carry_over;
    }
    if let Some(material) = &mut truth.material {
        let shape = [rows, columns];
        vary_material(
            material,
            shape,
            imperfections,
            [&mut stream(2), &mut stream(3)],
        );
    }
    let screen = &mut truth.screen;
    break_lines(
        [&mut screen.dead_rows, &mut screen.flickering_rows],
        [imperfections.dead_rows, imperfections.flickering_rows],
        rows,
        &mut stream(4),
    );
    break_lines(
        [&mut screen.dead_columns, &mut screen.flickering_columns],
        [imperfections.dead_columns, imperfections.flickering_columns],
        columns,
        &mut stream(5),
    );
}

fn vary_lines(ohms: &mut Option<PerLine>, lines: usize, sd: f64, random: &mut ChaCha8Rng) {
    if let Some(nominal) = ohms.as_ref().filter(|_| sd > 0.0) {
        let drawn = (0..lines).map(|line| nominal.at(line) * (sd * normal(random)).exp());
        *ohms = Some(PerLine::Each(drawn.collect()));
    }
}

/// The same resistors of a table.
fn vary_pull_downs(sensed: &mut AxisSpec, factor: f64) {
    let ends = sensed.selected.iter_mut().chain(&mut sensed.unselected);
    for end in ends.filter(|end| end.to == EndTo::Ground) {
        match &mut end.ohms {
            Some(PerLine::One(ohms)) => *ohms *= factor,
            Some(PerLine::Each(list)) => list.iter_mut().for_each(|ohms| *ohms *= factor),
            None => {}
        }
    }
}

fn vary_material(
    material: &mut MaterialSpec,
    shape: [usize; 2],
    imperfections: &Imperfections,
    [of_gain, of_exponent]: [&mut ChaCha8Rng; 2],
) {
    if imperfections.saturation_load_g.is_some() {
        material.saturation_load_g = imperfections.saturation_load_g;
    }
    if imperfections.spread.is_some() {
        material.spread = imperfections.spread;
    }
    if imperfections.sheet.is_some() {
        material.sheet = imperfections.sheet;
    }
    if imperfections.dynamic.is_some() {
        material.dynamic.clone_from(&imperfections.dynamic);
    }
    if imperfections.gain_sd == 0.0 && imperfections.exponent_sd == 0.0 {
        return;
    }
    let gain = material.gain.clone().unwrap_or(PerTaxel::One(1.0));
    let (Some(mut gain), Some(mut exponent)) =
        (every(&gain, shape), every(&material.exponent, shape))
    else {
        return;
    };
    for (gain, exponent) in gain.iter_mut().zip(&mut exponent) {
        let nominal = *exponent;
        let drawn = nominal + imperfections.exponent_sd * normal(of_exponent);
        *exponent = drawn.max(0.5 * nominal);
        *gain *= (imperfections.gain_sd * normal(of_gain)).exp();
        *gain *= PIVOT_LOAD_G.powf(nominal - *exponent);
    }
    let lines = |values: &[f64]| values.chunks(shape[1]).map(<[f64]>::to_vec).collect();
    material.gain = Some(PerTaxel::Each(lines(&gain)));
    if imperfections.exponent_sd > 0.0 {
        material.exponent = PerTaxel::Each(lines(&exponent));
    }
}

/// One value per taxel, row by row; none when they are still in a file.
fn every(values: &PerTaxel, [rows, columns]: [usize; 2]) -> Option<Vec<f64>> {
    match values {
        PerTaxel::One(value) => Some(vec![*value; rows * columns]),
        PerTaxel::Each(lines) => Some(lines.concat()),
        PerTaxel::File(_) => None,
    }
}

/// Adds lines that are sound so far to the lists of dead and flickering ones, as long as there are any.
fn break_lines(
    mut lists: [&mut Vec<usize>; 2],
    counts: [usize; 2],
    lines: usize,
    random: &mut ChaCha8Rng,
) {
    let mut sound: Vec<usize> = (0..lines)
        .filter(|line| lists.iter().all(|list| !list.contains(line)))
        .collect();
    for (list, count) in lists.iter_mut().zip(counts) {
        for _ in 0..count.min(sound.len()) {
            list.push(sound.swap_remove(super::below(random, sound.len())));
        }
        list.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    fn relative_sd(values: impl Iterator<Item = f64>) -> f64 {
        let logs: Vec<f64> = values.map(f64::ln).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        (logs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / logs.len() as f64).sqrt()
    }

    #[test]
    fn without_imperfections_the_truth_is_what_the_owner_knows() {
        let nominal = preset("econe").unwrap();
        assert_eq!(
            imperfect(&nominal, &Imperfections::default(), 1).unwrap(),
            nominal
        );
    }

    #[test]
    fn what_is_drawn_has_the_spread_asked_for_and_passes_every_check() {
        let nominal = preset("econe").unwrap();
        for imperfections in [
            Imperfections::uneven(),
            Imperfections::beyond_the_circuit(),
            Imperfections::under_a_sheet(),
        ] {
            let truth = imperfect(&nominal, &imperfections, 2).unwrap();
            assert_eq!(truth, imperfect(&nominal, &imperfections, 2).unwrap());
            assert_ne!(truth, imperfect(&nominal, &imperfections, 3).unwrap());
            let Some(PerLine::Each(columns)) = truth.readout().r_mux_column_ohms.clone() else {
                panic!("one resistance per column");
            };
            let sd = relative_sd(columns.into_iter());
            assert!((sd / 0.1 - 1.0).abs() < 0.2, "{sd}");
            let r_k = truth.readout().r_feedback_ohms().unwrap();
            assert!((r_k - 2010.0).abs() < 1e-9);
            let gain = &truth.material().unwrap().gain;
            // Exponents pivot about 100 g: ln 100 times their deviation is in the gain, too.
            let wanted = 0.1f64.hypot(imperfections.exponent_sd * PIVOT_LOAD_G.ln());
            let sd = relative_sd(gain.iter().copied());
            assert!((sd / wanted - 1.0).abs() < 0.05, "{sd}");
            let sheet = &truth.spec().material.as_ref().unwrap().sheet;
            assert_eq!(*sheet, imperfections.sheet);
        }
    }

    #[test]
    fn one_more_imperfection_leaves_the_others_as_they_were() {
        let nominal = preset("econe").unwrap();
        let truth = imperfect(&nominal, &Imperfections::uneven(), 2).unwrap();
        let spread = Imperfections {
            spread: Some([0.05, 0.05, 0.01]),
            dead_columns: 2,
            ..Imperfections::uneven()
        };
        let also = imperfect(&nominal, &spread, 2).unwrap();
        assert_eq!(truth.readout(), also.readout());
        let gain = |sensor: &Sensor| sensor.material().unwrap().gain.clone();
        assert_eq!(gain(&truth), gain(&also));
        assert_eq!(truth.screen().dead_rows, also.screen().dead_rows);
        assert_eq!(also.screen().dead_columns.len(), 2);
    }

    #[test]
    fn a_sheet_changes_no_other_number_and_what_a_pressed_mat_reads() {
        let nominal = preset("mat-16x16-cd4067").unwrap();
        let cut = Imperfections::beyond_the_circuit();
        let [whole, cut] = [Imperfections::under_a_sheet(), cut]
            .map(|imperfections| imperfect(&nominal, &imperfections, 2).unwrap());
        let taken_out = whole
            .edited(|spec| spec.material.as_mut().unwrap().sheet = None)
            .unwrap();
        assert_eq!(taken_out, cut);
        let read = |truth: &Sensor, load: f64| {
            let sensor = super::super::VirtualSensor::new(truth, 2).unwrap();
            let counts = sensor.read(&crate::Frame::filled(16, 16, load), 0).counts;
            counts.values().iter().sum::<f64>() / 256.0
        };
        let more = read(&whole, 300.0) - read(&cut, 300.0);
        assert!(more.abs() > 1.0, "{more}");
    }

    #[test]
    fn more_broken_lines_than_there_are_break_them_all_once() {
        let nominal = preset("mat-16x16-cd4067").unwrap();
        let all = Imperfections {
            dead_rows: 10,
            flickering_rows: 99,
            ..Imperfections::default()
        };
        let screen = imperfect(&nominal, &all, 1).unwrap().screen().clone();
        let mut rows = [screen.dead_rows, screen.flickering_rows].concat();
        rows.sort_unstable();
        assert_eq!(rows, (0..16).collect::<Vec<_>>());
    }
}
