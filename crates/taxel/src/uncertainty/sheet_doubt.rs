//! What the law of a sheet may be wrong by: two numbers tell how neighbours conduct to each other, and no film keeps to them.

use super::set_passive;
use crate::circuit::{Circuit, NotPassive, OperatingPoint, SensorCircuit};
use crate::{Error, Sensor};

/// The same circuit under a sheet that conducts more by one standard error of its law.
pub(super) struct SheetDoubt {
    more: Box<dyn OperatingPoint>,
    here: Vec<f64>,
    /// What every reading is off by, volts.
    changes: Vec<f64>,
}

impl SheetDoubt {
    /// None where there is no sheet, or nothing is said of how well its law is known.
    pub(super) fn new(sensor: &Sensor) -> Result<Option<Self>, Error> {
        let share = sensor.uncertainty().and_then(|told| told.sheet_share);
        let sheet = sensor.material().and_then(|material| material.sheet);
        let (Some(share), Some(_)) = (share, sheet) else {
            return Ok(None);
        };
        let more = sensor.edited(|spec| {
            let sheet = spec.material.as_mut().and_then(|m| m.sheet.as_mut());
            let sheet = sheet.expect("there is one");
            *sheet = sheet.more_by_its_law(share);
        })?;
        let nothing = || vec![0.0; sensor.rows() * sensor.columns()];
        Ok(Some(Self {
            more: SensorCircuit::from_sensor(&more)?.operating_point(),
            here: nothing(),
            changes: nothing(),
        }))
    }

    /// What readings would be off by at the conductances that `point` stands at, volts; 0 where a reading is no part of the
    /// system.
    pub(super) fn look_at(
        &mut self,
        point: &dyn OperatingPoint,
        siemens: &[f64],
        is_known: &[bool],
    ) -> Result<&[f64], NotPassive> {
        set_passive(&mut *self.more, siemens)?;
        point.predict_into(&mut self.here);
        self.more.predict_into(&mut self.changes);
        let each = self.changes.iter_mut().zip(&self.here).zip(is_known);
        for ((change, here), known) in each {
            *change = if *known { 0.0 } else { *change - here };
        }
        Ok(&self.changes)
    }

    /// What a sum is off by whose readings add to it by `influence` a volt each, of the frame that was looked at last.
    pub(super) fn of_sum(&self, influence: &[f64]) -> f64 {
        let each = self.changes.iter().zip(influence);
        each.map(|(change, influence)| change * influence)
            .sum::<f64>()
            .abs()
    }
}

#[cfg(test)]
mod tests {
    use crate::circuit::{Circuit, SensorCircuit};
    use crate::frame::newtons_from_grams;
    use crate::material::LoadLaw;
    use crate::sensor::{SheetSpec, UncertaintySpec, preset};
    use crate::solve::default_method;
    use crate::uncertainty::{FigureErrors, StandardErrors};
    use crate::{Frame, Grams, Newtons, Sensor};

    const SHARE: f64 = 0.02;

    /// Under a film whose law is off by so much.
    fn under_sheet(share: f64) -> Sensor {
        let told = UncertaintySpec {
            model_share: 0.0,
            model_floor_g: 0.0,
            fit_share: 0.0,
            factor_95: 1.96,
            presses: 100,
            frame_share: None,
            frame_floor_g: None,
            spread_error: None,
            sheet_share: Some(SHARE),
            material_factor: None,
        };
        let edited = preset("econe").unwrap().edited(|spec| {
            (spec.array.rows, spec.array.columns) = (12, 14);
            spec.array.geometry = None;
            let material = spec.material.as_mut().unwrap();
            let sheet = SheetSpec::new(12e3, 3.0);
            material.sheet = Some(sheet.more_by_its_law(share));
            spec.uncertainty = Some(told);
        });
        edited.unwrap()
    }

    /// A contact with an edge, and a press that stands alone.
    fn grams(taxel: usize) -> f64 {
        match (taxel / 14, taxel % 14) {
            (3..=7, 4..=9) => 60.0 + 3.0 * taxel as f64,
            (10, 1) => 300.0,
            _ => 0.0,
        }
    }

    #[test]
    fn loads_and_their_sum_are_off_by_what_it_says_where_the_law_is() {
        let (sensor, real) = (under_sheet(0.0), under_sheet(SHARE));
        let law = LoadLaw::from_sensor(&sensor).unwrap();
        let siemens = Frame::<Grams>::zeros(12, 14)
            .map(|taxel, _: f64| law.siemens_from_grams(taxel, grams(taxel)));
        let volts = SensorCircuit::from_sensor(&real).unwrap();
        let volts = volts.predict(&siemens).unwrap();
        let solved = default_method(&sensor).unwrap().solve(&volts);
        assert!(solved.outcome.is_answer());
        let loads: Vec<f64> = (solved.frame.values().iter().enumerate())
            .map(|(t, &g)| newtons_from_grams(law.grams_from_siemens(t, g)))
            .collect();
        let off = |t: usize| loads[t] - newtons_from_grams(grams(t));
        let mut errors = StandardErrors::new(&sensor, None).unwrap();
        let mut marks = vec![crate::Mark::Good; 168];
        let found = errors.of_loads(&solved.frame, &loads, true, &mut marks);
        found.unwrap();
        let most = (0..168).map(|t| off(t).abs()).fold(0.0, f64::max);
        for (t, says) in errors.parts().model.values().iter().enumerate() {
            assert!(
                (says - off(t).abs()).abs() < 0.03 * most,
                "{t}: {says}, {}",
                off(t)
            );
        }
        let sum: f64 = (0..168).map(off).sum();
        let frame = Frame::<Newtons>::new(12, 14, loads.clone()).unwrap();
        let figures = FigureErrors::new(&sensor, None)
            .unwrap()
            .of(&solved.frame, &frame, true);
        let says = figures.total_force_newtons.model;
        assert!((says / sum.abs() - 1.0).abs() < 0.03, "{says} {sum}");
    }
}
