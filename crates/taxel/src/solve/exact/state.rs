//! What the exact method keeps between frames: the small matrix S of the rows that carry current.

use super::super::anderson::Anderson;
use super::super::lines::LiveLines;
use super::super::network::Network;
use super::super::root::Root;
use super::MIXING_DEPTH;
use super::single::Single;

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
    /// The frame before was too much for the fast iteration.
    pub(super) slow: bool,
    pub(super) volts: Vec<f64>,
    pub(super) siemens: Vec<f64>,
    pub(super) share: Vec<f64>,
    /// 1/g_c of the live columns.
    pub(super) column_ohms: Vec<f64>,
    pub(super) along_rows: Vec<f64>,
    pub(super) network: Network,
    pub(super) single: Single,
    /// What makes the previous frame's S have this one's P_rr, on either side.
    pub(super) stretch: Vec<f64>,
    /// The lower triangle of S, row by row, without a sheet's couplings; then these, of rows and columns.
    pub(super) packed: Vec<f64>,
    pub(super) image: Vec<f64>,
    pub(super) triangle: Vec<f64>,
    pub(super) diagonal: Vec<f64>,
    pub(super) mixing: Anderson,
    pub(super) root: Root,
}

/// What a frame leaves for the next solve of the same frame by another circuit, without the room to work in.
#[derive(Debug, Default)]
pub(crate) struct Start {
    live: LiveLines,
    strong: Vec<bool>,
    p: Vec<f64>,
    packed: Vec<f64>,
}

impl SolverState {
    /// Takes a start in the place of its own, which is then in `start`: many frames take turns in one state's memory, that stays
    /// in the processor's cache. Whether the start is one is for `is_known`.
    pub(crate) fn exchange(&mut self, start: &mut Start, is_known: bool) {
        std::mem::swap(&mut self.live, &mut start.live);
        std::mem::swap(&mut self.strong_before, &mut start.strong);
        std::mem::swap(&mut self.network.p, &mut start.p);
        std::mem::swap(&mut self.packed, &mut start.packed);
        (self.warm, self.slow, self.follows) = (is_known, false, false);
        self.mixing.restart();
        if is_known {
            if let Some(sideways) = &mut self.network.sideways {
                sideways.reshape_to(&self.live, &self.strong_before, &mut self.places);
            }
            self.resize(self.network.p.len(), self.live.columns.len());
        } else {
            self.strong_before.clear();
        }
    }

    /// Makes the next solve start cold.
    pub(crate) fn forget(&mut self) {
        self.warm = false;
    }

    pub(super) fn new(rows: usize, columns: usize) -> Self {
        let packed = rows * (rows + 1) / 2 + rows + columns;
        Self {
            live: LiveLines::default(),
            strong: Vec::with_capacity(rows),
            strong_before: Vec::with_capacity(rows),
            places: Vec::with_capacity(rows),
            warm: false,
            follows: false,
            is_rounded: false,
            slow: false,
            volts: vec![0.0; rows * columns],
            siemens: vec![0.0; rows * columns],
            share: vec![0.0; rows],
            column_ohms: vec![0.0; columns],
            along_rows: vec![0.0; rows],
            network: Network::new(rows, columns),
            single: Single::new(rows, columns),
            stretch: vec![1.0; rows],
            packed: vec![0.0; packed],
            image: vec![0.0; packed],
            triangle: vec![0.0; rows * rows],
            diagonal: vec![0.0; rows],
            mixing: Anderson::new(MIXING_DEPTH, packed),
            root: Root::new(rows, columns),
        }
    }

    /// Makes room for the rows that carry current, keeping what is known of S. Allocates nothing.
    pub(super) fn reshape(&mut self, n: usize) {
        let m = self.strong.iter().filter(|&&strong| strong).count();
        if let Some(sideways) = &mut self.network.sideways {
            sideways.reshape_to(&self.live, &self.strong, &mut self.places);
        }
        let packed = m * (m + 1) / 2 + self.network.couplings();
        if self.warm && self.strong.len() == self.strong_before.len() {
            self.carry_over(packed);
        } else {
            self.warm = false;
            self.packed.resize(packed, 0.0);
        }
        self.strong_before.clone_from(&self.strong);
        self.resize(m, n);
    }

    fn resize(&mut self, m: usize, n: usize) {
        let packed = m * (m + 1) / 2 + self.network.couplings();
        // Without what is known of couplings, they are 0.
        self.packed.resize(packed, 0.0);
        self.image.resize(packed, 0.0);
        self.network.resize(m, n);
        self.single.resize(m, n);
        self.triangle.resize(m * m, 0.0);
        self.diagonal.resize(m, 0.0);
        self.mixing.resize(packed);
        self.root.resize(m, n);
    }

    /// Makes the network's S the start of the fast iteration.
    pub(super) fn take_s(&mut self) {
        let m = self.network.m;
        pack(&self.network.s, &mut self.packed, m);
        if let Some(sideways) = &self.network.sideways {
            let (rows, columns) = (&sideways.now.small, &sideways.now.large);
            // S is packed without what the sheet adds.
            for (i, coupling) in rows.iter().enumerate() {
                self.packed[(i + 1) * (i + 2) / 2 + i] += coupling;
            }
            let tail = self.packed[m * (m + 1) / 2..].iter_mut();
            for (kept, coupling) in tail.zip(rows.iter().chain(columns)) {
                *kept = *coupling;
            }
        }
        self.stretch.fill(1.0);
        self.mixing.restart();
        (self.warm, self.follows) = (true, false);
    }

    /// S of the rows that go on carrying current; 0 for the others.
    fn carry_over(&mut self, packed: usize) {
        self.image.clear();
        self.image.resize(packed, 0.0);
        let (mut i, mut i_before) = (0, 0);
        for (strong, before) in self.strong.iter().zip(&self.strong_before) {
            if *strong {
                let (mut at, mut from) = (i * (i + 1) / 2, i_before * (i_before + 1) / 2);
                let columns = self.strong.iter().zip(&self.strong_before);
                for (strong, known) in columns {
                    if at == (i + 1) * (i + 2) / 2 {
                        break;
                    }
                    if *strong {
                        let both = *before && *known;
                        self.image[at] = if both { self.packed[from] } else { 0.0 };
                        at += 1;
                    }
                    from += usize::from(*known);
                }
            }
            i += usize::from(*strong);
            i_before += usize::from(*before);
        }
        std::mem::swap(&mut self.image, &mut self.packed);
    }
}

fn pack(full: &[f64], packed: &mut [f64], m: usize) {
    let mut at = 0;
    for i in 0..m {
        packed[at..=at + i].copy_from_slice(&full[i * m..=i * m + i]);
        at += i + 1;
    }
}

/// The full matrix of a packed lower triangle, in the numbers that `of` makes of its own.
pub(super) fn unpack<T: Copy>(packed: &[f64], full: &mut [T], m: usize, of: impl Fn(f64) -> T) {
    let mut at = 0;
    for i in 0..m {
        for j in 0..=i {
            let value = of(packed[at]);
            full[i * m + j] = value;
            full[j * m + i] = value;
            at += 1;
        }
    }
}
