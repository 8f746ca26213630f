//! The currents of every reading: a taxel's own, and the two beside it.

use super::Paths;
use super::grounded::Grounded;
use super::whole::Whole;
use crate::circuit::diode::branch::{Branch, Current};

/// Of every taxel while its lines are selected, row by row.
pub(crate) struct Currents {
    scheme: Scheme,
    /// i, amperes.
    pub(crate) own: Vec<f64>,
    /// v_r, volts, at the row's end.
    pub(crate) row_volts: Vec<f64>,
    /// V_c, volts, at the column's end.
    pub(crate) column_volts: Vec<f64>,
}

enum Scheme {
    Grounded(Box<Grounded>),
    Whole(Box<Whole>),
}

/// What flows beside a taxel's own current.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Beside {
    /// X or D, and its derivative by the line's potential.
    pub(crate) amperes: f64,
    pub(super) siemens: f64,
    /// What it adds to the voltage over the taxel along lines that resist, beyond what the taxel's own current drops there.
    pub(crate) volts: f64,
}

/// Rounds in which the row's leak and its potential are brought together.
const ROUNDS: usize = 20;

impl Currents {
    pub(crate) fn new(paths: &Paths) -> Self {
        if paths.is_grounded() {
            Self::by(paths, Scheme::Grounded(Box::new(Grounded::new(paths))))
        } else {
            Self::by_all_lines(paths)
        }
    }

    /// By Newton's method on all lines at once, whatever their ends are.
    pub(crate) fn by_all_lines(paths: &Paths) -> Self {
        Self::by(paths, Scheme::Whole(Box::new(Whole::new(paths))))
    }

    fn by(paths: &Paths, scheme: Scheme) -> Self {
        let none = || vec![0.0; paths.rows * paths.columns];
        Self {
            scheme,
            own: none(),
            row_volts: none(),
            column_volts: none(),
        }
    }

    /// Finds what flows beside the taxels' own currents. Nothing flows through conductances below 0, which are noise.
    /// `is_read`: for the inverse, which knows the readings.
    pub(crate) fn set(&mut self, paths: &Paths, siemens: &[f64], is_read: bool) {
        match &mut self.scheme {
            Scheme::Grounded(grounded) => grounded.set(paths, siemens, is_read),
            Scheme::Whole(whole) => whole.set(paths, siemens),
        }
    }

    /// X of a taxel, where its row is at a potential and it carries a current.
    #[inline]
    pub(crate) fn left(&self, paths: &Paths, taxel: usize, volts: f64, amperes: f64) -> Beside {
        match &self.scheme {
            Scheme::Grounded(grounded) => grounded.left(paths, taxel, volts, amperes),
            Scheme::Whole(whole) => Beside {
                amperes: whole.left[taxel],
                ..Beside::default()
            },
        }
    }

    /// The driven column's end without a taxel's own current: where it stands, volts, and what is in the way, ohms. What others
    /// draw goes with its potential, a little.
    #[inline]
    pub(crate) fn source(&self, paths: &Paths, taxel: usize) -> (f64, f64) {
        let column = taxel % paths.columns;
        let (u, g_cs) = (paths.drives[column], paths.ends.column_selected[column]);
        let drawn = self.drawn(paths, taxel, u);
        let ohms = 1.0 / (g_cs + drawn.siemens);
        (u - ohms * drawn.amperes, ohms)
    }

    /// D of a taxel, where its column is at a potential.
    #[inline]
    fn drawn(&self, paths: &Paths, taxel: usize, volts: f64) -> Current {
        match &self.scheme {
            Scheme::Grounded(grounded) => grounded.drawn(taxel, taxel % paths.columns, volts),
            Scheme::Whole(whole) => Current {
                amperes: whole.drawn[taxel],
                siemens: 0.0,
            },
        }
    }

    /// The taxels' own currents, and where their lines stand. The network must be set.
    pub(crate) fn solve_own(&mut self, paths: &Paths, siemens: &[f64]) {
        for (taxel, &g) in siemens.iter().enumerate() {
            let column = taxel % paths.columns;
            let (own, row_volts, column_volts) = match &self.scheme {
                Scheme::Grounded(grounded) if paths.rows_alike => {
                    let (v_column, floats) = grounded.alike(taxel, column);
                    let (i, v_row) = self.own(paths, taxel, g, (v_column, 0.0), floats);
                    (i, v_row, v_column)
                }
                _ => self.selected(paths, taxel, g),
            };
            self.own[taxel] = own;
            self.row_volts[taxel] = row_volts;
            self.column_volts[taxel] = column_volts;
        }
    }

    /// A taxel whose reading moves its column: what others draw goes with the column's potential.
    fn selected(&self, paths: &Paths, taxel: usize, g: f64) -> (f64, f64, f64) {
        let (source, ohms) = self.source(paths, taxel);
        let (i, v_row) = self.own(paths, taxel, g, (source, ohms), 0.0);
        (i, v_row, source - ohms * i)
    }

    /// Current and row potential of a taxel behind a source: the end of the row and what leaves it are linear about the last
    /// potential, so that each round is one current through one diode.
    fn own(
        &self,
        paths: &Paths,
        taxel: usize,
        g: f64,
        (source_volts, source_ohms): (f64, f64),
        start: f64,
    ) -> (f64, f64) {
        let junction = &paths.junction;
        let g_end = paths.ends.row_selected[taxel / paths.columns];
        let (mut v, mut i) = (if start.is_finite() { start } else { 0.0 }, 0.0);
        for _ in 0..ROUNDS {
            let left = self.left(paths, taxel, v, i);
            let end = g_end + left.siemens;
            let lift = (left.amperes - left.siemens * v) / end;
            i = if g == 0.0 {
                0.0
            } else {
                let ohms = 1.0 / g.abs() + paths.along(taxel) + source_ohms + 1.0 / end;
                let through = Branch::new(junction, 1.0 / ohms);
                through
                    .at(junction, source_volts + left.volts + lift)
                    .amperes
                    .copysign(g)
            };
            let next = i / end - lift;
            let moved = (next - v).abs();
            v = next;
            if moved <= 1e-15 * source_volts.abs() {
                break;
            }
        }
        (i, v)
    }
}
