//! What acts, and for how long.

use super::{is_usable, same_shape};
use crate::{Error, Frame, Newtons};

/// The integral of a quantity over time, by the trapezoidal rule, sample by sample: ∫ y dt ≈ Σ ½ (y_k + y_k−1)(t_k −
/// t_k−1). Unit: that of the quantity times a second.
///
/// Of [`super::total_force_newtons`] it is the force–time integral (N·s); of [`super::peak_pressure`], taken frame by
/// frame, the pressure–time integral (kPa·s) as pressure platforms report it.
///
/// Source: Melai et al., *Gait & Posture* 34:379 (2011), who set the customary pressure–time integral (under the
/// peak-pressure curve) against force–time integral per contact area; Brady et al., *Gait & Posture* 111:92 (2024).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TimeIntegral {
    sum: f64,
    last: Option<(f64, f64)>,
}

impl TimeIntegral {
    /// Adds the next sample. A time that is not later than the one before adds nothing and starts anew from here.
    pub fn add(&mut self, time_secs: f64, value: f64) {
        if let Some((time, before)) = self.last.filter(|(time, _)| time_secs > *time) {
            self.sum += 0.5 * (value + before) * (time_secs - time);
        }
        self.last = Some((time_secs, value));
    }

    /// The integral so far.
    pub fn value(&self) -> f64 {
        self.sum
    }
}

/// The integral of samples `(time in seconds, value)`: see [`TimeIntegral`].
pub fn time_integral(samples: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let mut integral = TimeIntegral::default();
    for (time_secs, value) in samples {
        integral.add(time_secs, value);
    }
    integral.value()
}

/// Force–time integral of every taxel, N·s. State of constant size.
///
/// Divided by the taxel's area it is the taxel's pressure–time integral ([`TaxelIntegrals::highest_kilopascal_secs`]):
/// never more than the integral under the peak-pressure curve, because the peak wanders.
/// A taxel that does not count in a frame adds nothing for the two intervals beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct TaxelIntegrals {
    newton_secs: Frame<Newtons>,
    last: Frame<Newtons>,
    last_time_secs: Option<f64>,
}

impl TaxelIntegrals {
    /// For frames of this shape.
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            newton_secs: Frame::zeros(rows, columns),
            last: Frame::zeros(rows, columns),
            last_time_secs: None,
        }
    }

    /// Adds the next frame, taken at `time_secs`.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn add(&mut self, time_secs: f64, frame: &Frame<Newtons>) -> Result<(), Error> {
        same_shape("frame to integrate", &self.last, frame)?;
        if let Some(time) = self.last_time_secs.filter(|time| time_secs > *time) {
            let half = 0.5 * (time_secs - time);
            for (i, sum) in self.newton_secs.values_mut().iter_mut().enumerate() {
                if is_usable(frame.marks()[i]) && is_usable(self.last.marks()[i]) {
                    *sum += half * (frame.values()[i] + self.last.values()[i]);
                }
            }
        }
        self.last.values_mut().copy_from_slice(frame.values());
        self.last.marks_mut().copy_from_slice(frame.marks());
        self.last_time_secs = Some(time_secs);
        Ok(())
    }

    /// The integrals, N·s, row by row.
    pub fn newton_secs(&self) -> &[f64] {
        self.newton_secs.values()
    }

    /// The highest pressure–time integral of a single taxel, kPa·s.
    pub fn highest_kilopascal_secs(&self, taxel_area_mm2: f64) -> f64 {
        let highest = self.newton_secs().iter().copied().fold(0.0, f64::max);
        super::kilopascals_from_newtons(highest, taxel_area_mm2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mark;

    #[test]
    fn a_ramp_integrates_to_half_its_rectangle() {
        assert_eq!(time_integral([(0.0, 0.0), (1.0, 2.0), (2.0, 4.0)]), 4.0);
        // Uneven steps: 1·(1+3)/2 + 0.5·(3+1)/2
        assert_eq!(time_integral([(0.0, 1.0), (1.0, 3.0), (1.5, 1.0)]), 3.0);
        assert_eq!(time_integral([]), 0.0);
    }

    #[test]
    fn time_that_runs_backwards_adds_nothing() {
        assert_eq!(
            time_integral([(5.0, 1.0), (6.0, 1.0), (0.0, 1.0), (1.0, 1.0)]),
            2.0
        );
    }

    #[test]
    fn each_taxel_is_integrated_and_lost_readings_are_left_out() {
        let mut sums = TaxelIntegrals::new(1, 2);
        let mut frame = Frame::<Newtons>::new(1, 2, vec![1.0, 2.0]).unwrap();
        sums.add(0.0, &frame).unwrap();
        sums.add(0.5, &frame).unwrap();
        assert_eq!(sums.newton_secs(), [0.5, 1.0]);
        frame.marks_mut()[1] = Mark::Flickering;
        sums.add(1.0, &frame).unwrap();
        assert_eq!(sums.newton_secs(), [1.0, 1.0]);
        frame.marks_mut()[1] = Mark::Good;
        sums.add(1.5, &frame).unwrap();
        assert_eq!(sums.newton_secs(), [1.5, 1.0]);
        // 1.5 N·s on 5 mm²
        assert!((sums.highest_kilopascal_secs(5.0) - 300.0).abs() < 1e-9);
        assert!(sums.add(2.0, &Frame::zeros(2, 2)).is_err());
    }
}
