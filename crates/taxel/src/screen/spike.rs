//! Spikes over time: a taxel that jumps for one frame and comes back.

use super::{Level, ScreenOptions, TimeSpikes, check_shape};
use crate::{Counts, Error, Frame};

/// Finds readings that stand out from the frame before and the frame after, in a stream at a steady rate. State
/// of constant size: the two last frames.
///
/// A spike is only known one frame later, so what is found belongs to the frame *before* the one
/// just observed.
#[derive(Debug, Clone)]
pub struct TimeSpikeScreen {
    rows: usize,
    columns: usize,
    rule: TimeSpikes,
    before: Vec<f64>,
    middle: Vec<f64>,
    seen: u64,
}

impl TimeSpikeScreen {
    /// For frames of this shape. Uses `options.time_spikes`, or its defaults where that is `None`.
    pub fn new(rows: usize, columns: usize, options: &ScreenOptions) -> Self {
        Self {
            rows,
            columns,
            rule: options.time_spikes.unwrap_or_default(),
            before: vec![0.0; rows * columns],
            middle: vec![0.0; rows * columns],
            seen: 0,
        }
    }

    /// Takes the next frame in and writes the taxels (row · columns + column) that were spikes in the frame
    /// before it into `spiked` (cleared first; its capacity is reused). Empty for the first two frames and while
    /// the noise is unknown.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn observe(
        &mut self,
        frame: &Frame<Counts>,
        level: Option<Level>,
        spiked: &mut Vec<usize>,
    ) -> Result<(), Error> {
        check_shape("frame to screen", self.rows, self.columns, frame)?;
        spiked.clear();
        if let Some(level) = level.filter(|_| self.seen >= 2) {
            let triples = self.before.iter().zip(&self.middle).zip(frame.values());
            let found = triples
                .enumerate()
                .filter(|(_, ((a, x), b))| is_spike(**a, **x, **b, level, &self.rule));
            spiked.extend(found.map(|(i, _)| i));
        }
        std::mem::swap(&mut self.before, &mut self.middle);
        self.middle.copy_from_slice(frame.values());
        self.seen += 1;
        Ok(())
    }
}

fn is_spike(a: f64, x: f64, b: f64, level: Level, rule: &TimeSpikes) -> bool {
    let same_side = (x - a) * (x - b) > 0.0;
    let jump = (x - a).abs().min((x - b).abs());
    let height = (a.max(b) - level.baseline_counts).max(0.0);
    same_side
        && jump > rule.sigmas * level.noise_counts + rule.share * height
        && (a - b).abs() < jump / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: Level = Level {
        baseline_counts: 25.0,
        noise_counts: 3.0,
    };

    fn found(readings: &[f64]) -> Vec<usize> {
        let mut screen = TimeSpikeScreen::new(1, 2, &ScreenOptions::default());
        let mut spiked = Vec::new();
        let mut at = Vec::new();
        for (t, &reading) in readings.iter().enumerate() {
            let frame = Frame::new(1, 2, vec![reading, 25.0]).unwrap();
            screen.observe(&frame, Some(LEVEL), &mut spiked).unwrap();
            assert!(spiked.iter().all(|&i| i == 0));
            at.extend(spiked.iter().map(|_| t - 1));
        }
        at
    }

    #[test]
    fn one_frame_up_or_down_and_back_is_a_spike() {
        assert_eq!(found(&[25.0, 26.0, 900.0, 24.0, 25.0]), [2]);
        assert_eq!(found(&[5000.0, 5010.0, 30.0, 5020.0, 5000.0]), [2]);
    }

    #[test]
    fn presses_ramps_and_noise_are_not() {
        assert!(found(&[25.0, 25.0, 5000.0, 5000.0, 5000.0, 25.0, 25.0]).is_empty());
        assert!(found(&[25.0, 500.0, 1000.0, 1500.0, 1000.0, 500.0]).is_empty());
        assert!(found(&[25.0, 34.0, 22.0, 30.0, 19.0]).is_empty());
        assert!(found(&[8000.0, 8900.0, 8000.0, 9000.0]).is_empty());
    }

    #[test]
    fn a_frame_of_another_shape_is_refused() {
        let mut screen = TimeSpikeScreen::new(2, 2, &ScreenOptions::default());
        let error = screen.observe(&Frame::zeros(2, 3), None, &mut Vec::new());
        assert!(matches!(error, Err(Error::Shape { .. })));
    }
}
