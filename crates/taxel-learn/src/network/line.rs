//! A network along straight lines of inputs, exactly: with ReLU it is piecewise linear there, so that the inputs
//! between two kinks share one pair of matrix products.

use super::Mlp;

/// Points on a line between which no unit switches.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// Its points: from, to (exclusive).
    points: (usize, usize),
    /// Row of its sums; the row after it holds their slopes, if the run has more than one point.
    row: usize,
}

impl Run {
    fn is_single(self) -> bool {
        self.points.1 - self.points.0 == 1
    }
}

/// Memory of [`Mlp::forward_along`].
#[derive(Debug, Clone, Default)]
pub struct LineScratch {
    runs: Vec<Run>,
    next: Vec<Run>,
    sums: Vec<f32>,
    inputs: Vec<f32>,
    cuts: Vec<bool>,
    outputs: Vec<f32>,
}

impl Mlp<f32> {
    /// Outputs (points × last width) at points (line, x), sorted by line and then by x. The first layer's sums there
    /// are `starts` (lines × second width, bias included) + x · `slope` (second width).
    pub fn forward_along<'a>(
        &self,
        starts: &[f32],
        slope: &[f32],
        points: &[(usize, f32)],
        memory: &'a mut LineScratch,
    ) -> &'a [f32] {
        memory.runs.clear();
        memory.sums.clear();
        let mut from = 0;
        for line in points.chunk_by(|a, b| a.0 == b.0) {
            let points = (from, from + line.len());
            from = points.1;
            let run = Run {
                points,
                row: memory.sums.len() / slope.len(),
            };
            memory.runs.push(run);
            let start = &starts[line[0].0 * slope.len()..][..slope.len()];
            if run.is_single() {
                let x = line[0].1;
                memory
                    .sums
                    .extend(start.iter().zip(slope).map(|(a, b)| a + x * b));
            } else {
                memory.sums.extend_from_slice(start);
                memory.sums.extend_from_slice(slope);
            }
        }
        for layer in 0..self.layers() {
            if layer > 0 {
                self.advance_runs(layer, memory);
            }
            if self.has_relu(layer) {
                memory.switch(self.widths()[layer + 1], points);
            }
        }
        let width = self.widths()[self.layers()];
        let last = if self.relu_last() {
            &memory.inputs
        } else {
            &memory.sums
        };
        memory.outputs.clear();
        for run in &memory.runs {
            let sums = &last[run.row * width..];
            for &(_, x) in &points[run.points.0..run.points.1] {
                let slope = if run.is_single() { 0.0 } else { x };
                let at = |unit| sums[unit] + slope * sums.get(width + unit).unwrap_or(&0.0);
                memory.outputs.extend((0..width).map(at));
            }
        }
        &memory.outputs
    }

    fn advance_runs(&self, layer: usize, memory: &mut LineScratch) {
        let (fan_in, fan_out) = (self.widths()[layer], self.widths()[layer + 1]);
        memory
            .sums
            .resize(memory.inputs.len() / fan_in * fan_out, 0.0);
        self.products(layer, &memory.inputs, &mut memory.sums);
        let biases = self.layer(layer).1;
        for run in &memory.runs {
            let sums = &mut memory.sums[run.row * fan_out..(run.row + 1) * fan_out];
            for (sum, bias) in sums.iter_mut().zip(biases) {
                *sum += bias;
            }
        }
    }
}

impl LineScratch {
    /// What the units let through, run by run; a run in which a unit switches becomes several.
    fn switch(&mut self, width: usize, points: &[(usize, f32)]) {
        self.next.clear();
        self.inputs.clear();
        for run in &self.runs {
            let sums = &self.sums[run.row * width..(run.row + 1) * width];
            if run.is_single() {
                self.next.push(Run {
                    points: run.points,
                    row: self.inputs.len() / width,
                });
                self.inputs.extend(sums.iter().map(|&sum| sum.max(0.0)));
                continue;
            }
            let slopes = &self.sums[(run.row + 1) * width..(run.row + 2) * width];
            let points = &points[run.points.0..run.points.1];
            find_cuts(sums, slopes, points, &mut self.cuts);
            let mut from = 0;
            for to in 1..=points.len() {
                if to < points.len() && !self.cuts[to] {
                    continue;
                }
                let part = Run {
                    points: (run.points.0 + from, run.points.0 + to),
                    row: self.inputs.len() / width,
                };
                self.next.push(part);
                let x = points[from].1;
                let lit = sums.iter().zip(slopes).map(|(a, b)| (a, b, a + x * b));
                if part.is_single() {
                    self.inputs.extend(lit.map(|(_, _, sum)| sum.max(0.0)));
                } else {
                    let gate = |value: &f32, sum: f32| if sum > 0.0 { *value } else { 0.0 };
                    self.inputs
                        .extend(lit.clone().map(|(a, _, sum)| gate(a, sum)));
                    self.inputs.extend(lit.map(|(_, b, sum)| gate(b, sum)));
                }
                from = to;
            }
        }
        std::mem::swap(&mut self.runs, &mut self.next);
    }
}

/// Marks the points before which a unit switches.
fn find_cuts(sums: &[f32], slopes: &[f32], points: &[(usize, f32)], cuts: &mut Vec<bool>) {
    cuts.clear();
    cuts.resize(points.len(), false);
    let (first, last) = (points[0].1, points[points.len() - 1].1);
    for (a, b) in sums.iter().zip(slopes) {
        let lit = a + first * b > 0.0;
        if lit != (a + last * b > 0.0) {
            cuts[points.partition_point(|&(_, x)| (a + x * b > 0.0) == lit)] = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::Trace;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_network_along_lines_is_the_network() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for relu_last in [false, true] {
            let network = Mlp::<f32>::new(&[4, 20, 30, 10, 2], relu_last, &mut random);
            let lines: Vec<[f32; 3]> = (0..7)
                .map(|_| [(); 3].map(|()| 2.0 * random.random::<f32>() - 1.0))
                .collect();
            let mut points: Vec<(usize, f32)> = Vec::new();
            for line in 0..7 {
                // One line without a point, one with one, others with many.
                let count = [0, 1, 2, 30, 9, 3, 1][line];
                points.extend((0..count).map(|_| (line, 8.0 * random.random::<f32>() - 4.0)));
            }
            points.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            let (weights, biases) = network.layer(0);
            let (slope, others) = weights.split_at(20);
            let mut starts = Vec::new();
            for line in &lines {
                let sum = |unit: usize| {
                    let products = (0..3).map(|i| line[i] * others[20 * i + unit]);
                    biases[unit] + products.sum::<f32>()
                };
                starts.extend((0..20).map(sum));
            }
            let mut memory = LineScratch::default();
            let found = network.forward_along(&starts, slope, &points, &mut memory);
            let inputs: Vec<f32> = points
                .iter()
                .flat_map(|&(line, x)| [x, lines[line][0], lines[line][1], lines[line][2]])
                .collect();
            let mut trace = Trace::default();
            network.forward(&inputs, &mut trace);
            assert_eq!(found.len(), trace.output().len());
            for (found, expected) in found.iter().zip(trace.output()) {
                assert!((found - expected).abs() < 1e-5, "{found} {expected}");
            }
        }
    }
}
