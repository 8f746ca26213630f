//! What the exact method keeps between frames.

use super::super::lines::LiveLines;
use super::shares::Shares;
use super::sideways::Sideways;
use crate::material::Sheet;

/// What is kept of a frame for the next one, and room to work in.
pub(crate) struct SolverState {
    pub(super) live: LiveLines,
    /// Which of the live rows carry current, in this frame and in the one before.
    pub(super) strong: Vec<bool>,
    pub(super) strong_before: Vec<bool>,
    /// The rows that carry current.
    places: Vec<usize>,
    pub(super) warm: bool,
    /// The conductances in memory are those of the frame that the start is from.
    pub(super) follows: bool,
    /// Whether a converter has rounded the readings.
    pub(super) is_rounded: bool,
    pub(super) volts: Vec<f64>,
    pub(super) siemens: Vec<f64>,
    pub(super) share: Vec<f64>,
    /// 1/g_c of the live columns.
    pub(super) column_ohms: Vec<f64>,
    pub(super) along_rows: Vec<f64>,
    /// P_rr of the rows that carry current, ohms.
    pub(super) p: Vec<f64>,
    pub(super) half: Shares<f32>,
    pub(super) full: Shares<f64>,
    /// Of a continuous sheet.
    pub(super) sideways: Option<Sideways>,
}

/// What a frame leaves for the next solve of the same frame by another circuit, without the room to work in.
#[derive(Debug, Clone, Default)]
pub(crate) struct Start {
    live: LiveLines,
    strong: Vec<bool>,
    point: Vec<f32>,
    /// Couplings of a sheet, of rows and of columns.
    couplings: [Vec<f64>; 2],
}

impl SolverState {
    /// Takes a start in the place of its own, which is then in `start`: many frames take turns in one state's memory, that stays
    /// in the processor's cache. Whether the start is one is for `is_known`.
    pub(crate) fn exchange(&mut self, start: &mut Start, is_known: bool) {
        std::mem::swap(&mut self.live, &mut start.live);
        std::mem::swap(&mut self.strong_before, &mut start.strong);
        std::mem::swap(&mut self.half.point, &mut start.point);
        (self.warm, self.follows) = (is_known, false);
        if !is_known {
            self.strong_before.clear();
            self.keep_couplings(start);
            return;
        }
        self.reshape_sideways();
        let m = self.strong_before.iter().filter(|&&strong| strong).count();
        self.resize(m, self.live.columns.len());
        self.keep_couplings(start);
    }

    /// Exchanges couplings; those of a start without a sheet are none.
    fn keep_couplings(&mut self, start: &mut Start) {
        let Some(sideways) = &mut self.sideways else {
            return;
        };
        let now = [&mut sideways.now.small, &mut sideways.now.large];
        for (own, kept) in now.into_iter().zip(&mut start.couplings) {
            if self.warm && own.len() != kept.len() {
                continue;
            }
            std::mem::swap(own, kept);
        }
    }

    /// Makes the next solve start cold.
    pub(crate) fn forget(&mut self) {
        self.warm = false;
    }

    pub(super) fn new(rows: usize, columns: usize) -> Self {
        Self {
            live: LiveLines::default(),
            strong: Vec::with_capacity(rows),
            strong_before: Vec::with_capacity(rows),
            places: Vec::with_capacity(rows),
            warm: false,
            follows: false,
            is_rounded: false,
            volts: vec![0.0; rows * columns],
            siemens: vec![0.0; rows * columns],
            share: vec![0.0; rows],
            column_ohms: vec![0.0; columns],
            along_rows: vec![0.0; rows],
            p: vec![0.0; rows],
            half: Shares::new(rows, columns),
            full: Shares::new(rows, columns),
            sideways: None,
        }
    }

    /// Takes a sheet, or its absence. True when it had none before, or has none now.
    pub(super) fn takes(&mut self, sheet: Option<Sheet>) -> bool {
        match (&mut self.sideways, sheet) {
            (Some(sideways), Some(sheet)) => sideways.now.sheet = sheet,
            (None, None) => {}
            (sideways, sheet) => {
                *sideways = sheet.map(Sideways::new);
                return true;
            }
        }
        false
    }

    /// Makes room for the rows that carry current, keeping what is known of those that go on doing so. Allocates nothing.
    pub(super) fn reshape(&mut self, n: usize) {
        let count = |rows: &[bool]| rows.iter().filter(|&&strong| strong).count();
        let (m, before) = (count(&self.strong), count(&self.strong_before));
        self.warm &= self.strong.len() == self.strong_before.len();
        self.warm = self.warm
            && self
                .half
                .carry_over(&self.strong_before, &self.strong, [before, m], n);
        self.follows = false;
        self.strong_before.clone_from(&self.strong);
        self.reshape_sideways();
        self.resize(m, n);
    }

    fn reshape_sideways(&mut self) {
        if let Some(sideways) = &mut self.sideways {
            let rows = self.live.rows.iter().zip(&self.strong_before);
            self.places.clear();
            self.places
                .extend(rows.filter(|row| *row.1).map(|row| *row.0));
            sideways.reshape(&self.places, &self.live.columns);
        }
    }

    fn resize(&mut self, m: usize, n: usize) {
        self.p.resize(m, 0.0);
        self.half.resize(m, n);
        self.full.resize(m, n);
    }

    /// Begins with the frame before as the start, or with nothing.
    pub(super) fn begin(&mut self, is_cold: bool) {
        if is_cold {
            self.half.forget();
            if let Some(sideways) = &mut self.sideways {
                sideways.forget();
            }
        } else {
            self.half.mixing.resume();
        }
    }

    /// G from the unknowns, in single precision or not: the largest conductance and the largest change of one; nothing where a row's
    /// denominator is not positive.
    pub(super) fn conductances(&mut self, is_single: bool, is_first: bool) -> Option<(f64, f64)> {
        let sideways = self.sideways.as_mut();
        if is_single {
            self.half.conductances(&self.p, sideways, is_first)
        } else {
            self.full.conductances(&self.p, sideways, is_first)
        }
    }

    /// Takes back what mixing made of the last step. False where it made nothing.
    pub(super) fn retreat(&mut self, is_single: bool) -> bool {
        if is_single {
            self.half.retreat()
        } else {
            self.full.retreat()
        }
    }

    /// Goes `part` of the way to the next unknowns.
    pub(super) fn advance(&mut self, is_single: bool, part: f64) {
        let sideways = self.sideways.as_ref();
        if is_single {
            self.half.advance(sideways, part);
        } else {
            self.full.advance(sideways, part);
        }
    }

    /// The answer in double precision, and what the next frame starts from.
    pub(super) fn finish(&mut self, is_single: bool) {
        if is_single {
            let sideways = self.sideways.as_mut();
            self.full.finish(&self.half, &self.p, sideways);
            self.half.keep_conductances(&self.full);
        } else {
            self.half.keep(&self.full);
        }
    }
}
