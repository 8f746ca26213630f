//! Whether a fit that even loads took no part in reads them as what they weigh.

use super::evidence::Evidence;
use super::least_squares::median;
use crate::frame::newtons_from_grams;
use crate::pipeline::Pipeline;
use crate::solve::default_method;
use crate::{Error, Mark, Sensor};

/// Even loads that are read off by more than this share on average speak against a fit. Taxels that differ make less of it, since their mean
/// counts; so does what a weight is usually stated to.
const OFF: f64 = 0.05;

/// What must be said of a fit that reads even loads otherwise than what they weigh; nothing where there are none.
pub(super) fn doubt(sensor: &Sensor, evidence: &Evidence) -> Option<String> {
    let shares = shares(sensor, evidence).ok()?;
    let off = (!shares.is_empty()).then(|| median(&shares) - 1.0)?;
    (off.abs() > OFF).then(|| {
        format!(
            "even loads, which took no part in this fit, are read {:.0} % too {} by it, and where much is loaded at once its totals may be as far off: something of the circuit is missing (a continuous sheet beside lines that resist?), or the weights of the even loads are wrong",
            100.0 * off.abs(),
            if off > 0.0 { "heavy" } else { "light" },
        )
    })
}

/// What each even load is read as, on average over its taxels, of what it weighs.
fn shares(sensor: &Sensor, evidence: &Evidence) -> Result<Vec<f64>, Error> {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor)?)?;
    let mut shares = Vec::new();
    for level in &evidence.levels {
        pipeline.begin_anew();
        let result = pipeline.process(&level.counts);
        if !result.outcome.stop.is_good() {
            continue;
        }
        let loads = result.newtons()?;
        let taxels = loads.values().iter().zip(loads.marks());
        let good = taxels.filter(|(_, mark)| **mark == Mark::Good);
        let (sum, count) = good.fold((0.0, 0), |(sum, count), (load, _)| (sum + load, count + 1));
        if count > 0 {
            shares.push(sum / f64::from(count) / newtons_from_grams(level.load_g));
        }
    }
    Ok(shares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;
    use crate::simulate::{VirtualSensor, labelled_presses, uniform_levels};

    #[test]
    fn even_loads_that_are_read_otherwise_than_they_weigh_are_told() {
        for name in ["mat-32x32-adg732", "mat-16x16-cd4067"] {
            let sensor = preset(name).unwrap();
            let real = VirtualSensor::new(&sensor, 1).unwrap();
            let mut data = labelled_presses(&real, 10);
            data.uniform = uniform_levels(&real, &[50.0, 150.0, 300.0], 1);
            let evidence = Evidence::new(&sensor, &data).unwrap();
            assert_eq!(doubt(&sensor, &evidence), None);
            for (weighs, words) in [(1.1, "9 % too light"), (0.9, "11 % too heavy")] {
                let mut stated = data.clone();
                for (_, load_g) in &mut stated.uniform {
                    *load_g *= weighs;
                }
                let evidence = Evidence::new(&sensor, &stated).unwrap();
                let found = doubt(&sensor, &evidence).expect("a doubt");
                assert!(found.contains(words), "{name}: {found}");
            }
        }
    }
}
