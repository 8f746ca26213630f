//! What taxels of lines that are out may conduct, where lines are left open.
//!
//! A line may be out because it is broken off where it is read or driven: then it hangs in the air, and what stands on it still
//! joins the lines that cross it, which raises all other readings. Or its taxels are gone with it, as the inverse has it. No frame
//! tells the two apart. What the first would add to the readings is found for taxels that conduct as those around them do.

use super::known::read_around;
use super::set_passive;
use crate::circuit::OperatingPoint;
use crate::{Frame, Mark, Siemens};

/// Patterns by which taxels of a line are off from what stands for them, each half up and half down: together they tell what
/// each of them does by itself, as far as their number goes.
const PATTERNS: usize = 8;

/// Finds by how much readings would differ.
pub(super) struct Detached {
    filled: Vec<f64>,
    /// What those around a taxel whose line is out differ by, siemens.
    apart: Vec<f64>,
    without: Vec<f64>,
    direction: Vec<f64>,
    moves: Vec<Vec<f64>>,
    /// Whether the frame looked at last moves anything.
    has_moves: bool,
}

/// Whether a taxel's line is out.
fn is_out(mark: Mark) -> bool {
    matches!(mark, Mark::Open | Mark::Flickering)
}

impl Detached {
    pub(super) fn new(taxels: usize) -> Self {
        let none = || vec![0.0; taxels];
        Self {
            filled: none(),
            apart: none(),
            without: none(),
            direction: none(),
            moves: vec![none(); 1 + PATTERNS],
            has_moves: false,
        }
    }

    /// Volts that readings of the frame looked at last would be off by: where all taxels of lines that are out conduct as those
    /// around them do, and where each is off from that by as much as these are from one another. Each is one standard error that has
    /// nothing to do with the others. Nothing where no line is out, or nothing stands around it.
    pub(super) fn moves(&self) -> &[Vec<f64>] {
        if self.has_moves { &self.moves } else { &[] }
    }

    /// Looks at a frame. `point` stands at its conductances, before and afterwards.
    pub(super) fn look_at(&mut self, point: &mut dyn OperatingPoint, siemens: &Frame<Siemens>) {
        self.has_moves = false;
        let marks = siemens.marks();
        let mut any = false;
        for (taxel, filled) in self.filled.iter_mut().enumerate() {
            (*filled, self.apart[taxel]) = (siemens.values()[taxel], 0.0);
            if is_out(marks[taxel]) {
                (*filled, self.apart[taxel]) = around(siemens, marks, taxel);
                any |= *filled > 0.0;
            }
        }
        if !any {
            return;
        }
        point.predict_into(&mut self.without);
        let is_passive = set_passive(point, &self.filled).is_ok();
        if is_passive {
            self.find_moves(point);
        }
        // It stood here before.
        let stands = set_passive(point, siemens.values()).is_ok();
        self.has_moves = is_passive && stands;
    }

    fn find_moves(&mut self, point: &mut dyn OperatingPoint) {
        let (whole, patterns) = self.moves.split_at_mut(1);
        point.predict_into(&mut whole[0]);
        for (moved, without) in whole[0].iter_mut().zip(&self.without) {
            *moved -= without;
        }
        for (pattern, moved) in patterns.iter_mut().enumerate() {
            let mut place = 0;
            for (direction, apart) in self.direction.iter_mut().zip(&self.apart) {
                *direction = 0.0;
                if *apart > 0.0 {
                    // Walsh's functions: no two of them are alike along a line.
                    let is_down = (place & (2 * pattern + 1)).count_ones() % 2 == 1;
                    let size = apart / (PATTERNS as f64).sqrt();
                    *direction = if is_down { -size } else { size };
                    place += 1;
                }
            }
            point.jvp_into(&self.direction, moved);
        }
    }
}

/// Mean and standard deviation of the conductances around a taxel that were read.
fn around(siemens: &Frame<Siemens>, marks: &[Mark], taxel: usize) -> (f64, f64) {
    let each = || read_around(siemens, marks, taxel).map(|value| value.max(0.0));
    let count = each().count().max(1) as f64;
    let mean = each().sum::<f64>() / count;
    let square = each().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}
