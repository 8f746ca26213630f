//! From read-out volts to counts and back, and the noise in between.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel_linalg::wide;

use crate::frame::{BLOCK, any_beyond, has_mark};
use crate::sensor::{ScanOrder, Sensor};
use crate::{Counts, Frame, Mark, Volts};

/// Standard deviation of what rounding to whole counts adds, counts: 1/√12.
pub const ROUNDING_COUNTS: f64 = 0.288_675_134_594_812_9;

/// The analogue-to-digital converter: gain, offset, inversion, carry-over, clipping, quantisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Converter {
    /// Volts per count; negative when counts grow as V_out falls.
    volts_per_count: f64,
    offset_volts: f64,
    max_count: f64,
    carry_over: f64,
    /// Largest count that the recorder writes as nothing.
    floor_count: Option<f64>,
    order: ScanOrder,
}

impl Converter {
    /// The converter of a sensor.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let spec = sensor.converter();
        let lsb = spec.full_scale_volts / sensor.max_count();
        Self {
            volts_per_count: if spec.inverted { -lsb } else { lsb },
            offset_volts: spec.offset_volts,
            max_count: sensor.max_count(),
            carry_over: spec.carry_over,
            floor_count: spec.floor_count,
            order: spec.scan_order,
        }
    }

    /// Size of one count, volts.
    pub fn lsb_volts(&self) -> f64 {
        self.volts_per_count.abs()
    }

    /// The largest count.
    pub fn max_count(&self) -> f64 {
        self.max_count
    }

    /// The count that a voltage is, neither rounded nor clipped, without the carry-over of the previous reading.
    pub fn count_from_volt(&self, volts: f64) -> f64 {
        volts / self.volts_per_count + self.offset_counts()
    }

    /// Counts from volts: carry-over of the previous reading, offset, inversion, clipping, rounding; 0 where the recorder
    /// writes nothing.
    pub fn counts_from_volts(&self, volts: &Frame<Volts>) -> Frame<Counts> {
        let mut counts = volts.map(|_, v| v / self.volts_per_count + self.offset_counts());
        if self.carry_over != 0.0 {
            let mut last = None;
            for at in scan(self.order, volts.rows(), volts.columns()) {
                let now = counts.values()[at];
                let kept = last.map_or(now, |last| {
                    (1.0 - self.carry_over) * now + self.carry_over * last
                });
                counts.values_mut()[at] = kept;
                last = Some(kept);
            }
        }
        for value in counts.values_mut() {
            // What noise leaves below nothing is nothing, without a sign.
            *value = value.round().clamp(0.0, self.max_count) + 0.0;
            if self.floor_count.is_some_and(|floor| *value <= floor) {
                *value = 0.0;
            }
        }
        counts
    }

    /// Volts from counts, into a frame that is already there; readings at the ceiling are marked
    /// [`Mark::Saturated`], those at or below what the recorder keeps [`Mark::BelowFloor`], other marks are taken over. Of a
    /// reading below the floor the volts are its bound: those of the largest count that is written as nothing.
    pub fn volts_from_counts_into(&self, counts: &Frame<Counts>, volts: &mut Frame<Volts>) {
        volts.copy_meta_from(counts);
        self.mark_volts(counts.values(), &mut volts.marks);
        let is_bound = |mark| mark == Mark::BelowFloor;
        if self.order == ScanOrder::RowByRow && !has_mark(&volts.marks, is_bound) {
            self.volts_in_order(counts.values(), &mut volts.values);
        } else {
            self.volts_out_of_order(counts, volts);
        }
    }

    /// Marks good readings that are beyond what is recorded.
    fn mark_volts(&self, counts: &[f64], marks: &mut [Mark]) {
        let floor = self.floor_count.unwrap_or(f64::NEG_INFINITY);
        let blocks = counts.chunks(BLOCK).zip(marks.chunks_mut(BLOCK));
        for (counts, marks) in blocks {
            if !any_beyond(counts, floor, self.max_count) {
                continue;
            }
            let good = marks.iter_mut().zip(counts);
            for (mark, count) in good.filter(|(mark, _)| **mark == Mark::Good) {
                *mark = if *count >= self.max_count {
                    Mark::Saturated
                } else if *count <= floor {
                    Mark::BelowFloor
                } else {
                    Mark::Good
                };
            }
        }
    }

    /// Where each reading keeps a part of the one beside it, and none is a bound: many at once.
    fn volts_in_order(&self, counts: &[f64], volts: &mut [f64]) {
        let offset = self.offset_counts();
        let per_count = self.volts_per_count;
        let read = move |count: f64| (count - offset) * per_count;
        let (part, whole) = (self.carry_over, 1.0 / (1.0 - self.carry_over));
        wide(
            #[inline(always)]
            || {
                for (volt, count) in volts.iter_mut().zip(counts) {
                    *volt = read(*count);
                }
                if part != 0.0 {
                    // kept_k = (1−m)·v_k + m·kept_{k−1}, so v_k needs the two neighbouring readings alone.
                    let pairs = counts[1..].iter().zip(counts);
                    for (volt, (count, last)) in volts[1..].iter_mut().zip(pairs) {
                        *volt = (read(*count) - part * read(*last)) * whole;
                    }
                }
            },
        );
    }

    fn volts_out_of_order(&self, counts: &Frame<Counts>, volts: &mut Frame<Volts>) {
        let offset = self.offset_counts();
        let readings = counts.values().iter().zip(&volts.marks);
        for (volt, (count, mark)) in volts.values.iter_mut().zip(readings) {
            let count = match (*mark, self.floor_count) {
                (Mark::BelowFloor, Some(floor)) => floor,
                _ => *count,
            };
            *volt = (count - offset) * self.volts_per_count;
        }
        if self.carry_over != 0.0 {
            let mut last = None;
            for at in scan(self.order, counts.rows(), counts.columns()) {
                let kept = volts.values[at];
                // Of a bound nothing was kept.
                if let Some(last) = last.filter(|_| volts.marks[at] != Mark::BelowFloor) {
                    volts.values[at] = (kept - self.carry_over * last) / (1.0 - self.carry_over);
                }
                last = Some(kept);
            }
        }
    }

    /// Volts from counts. Allocates; streams use [`Self::volts_from_counts_into`].
    pub fn volts_from_counts(&self, counts: &Frame<Counts>) -> Frame<Volts> {
        let mut volts = Frame::zeros(counts.rows(), counts.columns());
        self.volts_from_counts_into(counts, &mut volts);
        volts
    }

    fn offset_counts(&self) -> f64 {
        self.offset_volts / self.lsb_volts()
    }
}

/// The taxels of a frame, row-major indices in the order they are read.
pub(crate) fn scan(order: ScanOrder, rows: usize, columns: usize) -> impl Iterator<Item = usize> {
    (0..rows * columns).map(move |k| match order {
        ScanOrder::RowByRow => k,
        ScanOrder::ColumnByColumn => k % rows * columns + k / rows,
    })
}

/// White noise of the read-out, volts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation, volts.
    pub standard_deviation_volts: f64,
}

impl Noise {
    /// Draws of it, decided by the seed.
    pub fn draws(self, seed: u64) -> NoiseDraws {
        NoiseDraws {
            noise: self,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Adds one draw to every taxel; the generator, seeded by the caller, decides it.
    pub(crate) fn add(&self, volts: &mut Frame<Volts>, random: &mut ChaCha8Rng) {
        for value in volts.values_mut() {
            *value += self.standard_deviation_volts * normal(random);
        }
    }
}

/// Draws of [`Noise`], one after the other: the same seed gives the same ones.
#[derive(Debug, Clone)]
pub struct NoiseDraws {
    noise: Noise,
    random: ChaCha8Rng,
}

impl NoiseDraws {
    /// Adds one draw to every taxel.
    pub fn add(&mut self, volts: &mut Frame<Volts>) {
        self.noise.add(volts, &mut self.random);
    }
}

/// A standard normal number (Box and Muller 1958).
pub(crate) fn normal(random: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (2.0 * std::f64::consts::PI * v).cos()
}
