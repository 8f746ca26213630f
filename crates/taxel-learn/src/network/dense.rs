//! Dense layers with ReLU between them, and their gradients.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel_linalg::{View, ViewMut};

use super::Real;

/// h₀ = x, h_{l+1} = max(0, h_l W_l + b_l), the last layer without the maximum (or with it, by `relu_last`).
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp<T: Real = f32> {
    widths: Vec<usize>,
    relu_last: bool,
    /// Per layer the weights (in × out, row-major), then the biases (out).
    parameters: Vec<T>,
}

/// What the forward pass of a batch leaves for the backward pass; also the memory of both.
#[derive(Debug, Clone, Default)]
pub struct Trace<T: Real = f32> {
    /// Outputs of every layer, batch × width.
    outputs: Vec<Vec<T>>,
    /// Gradient of the loss by the present layer's output, and by its input.
    upstream: Vec<T>,
    downstream: Vec<T>,
    batch: usize,
}

impl<T: Real> Trace<T> {
    /// Outputs of the last layer, batch × last width.
    pub fn output(&self) -> &[T] {
        self.outputs.last().expect("a network has layers")
    }

    /// Gradient of the loss by the inputs of the last backward pass, batch × first width.
    pub fn input_gradient(&self) -> &[T] {
        &self.downstream
    }
}

impl<T: Real> Mlp<T> {
    /// Uniform in ±√(6/(in + out)), weights and biases: scikit-learn's start for ReLU (Glorot and Bengio 2010).
    ///
    /// # Panics
    /// With fewer than two widths.
    pub fn drawn(widths: &[usize], relu_last: bool, seed: u64) -> Self {
        Self::new(widths, relu_last, &mut ChaCha8Rng::seed_from_u64(seed))
    }

    /// [`Mlp::drawn`] from a generator that others draw from as well.
    pub(crate) fn new(widths: &[usize], relu_last: bool, random: &mut impl Rng) -> Self {
        let mut network = Self::zeros(widths, relu_last);
        for layer in 0..network.layers() {
            let (fan_in, fan_out) = (widths[layer], widths[layer + 1]);
            let bound = (6.0 / (fan_in + fan_out) as f64).sqrt();
            let range = network.range(layer);
            for parameter in &mut network.parameters[range] {
                *parameter = T::of(bound * (2.0 * random.random::<f64>() - 1.0));
            }
        }
        network
    }

    /// All parameters zero.
    ///
    /// # Panics
    /// With fewer than two widths.
    pub fn zeros(widths: &[usize], relu_last: bool) -> Self {
        assert!(widths.len() >= 2, "a network has an input and an output");
        let count = widths.windows(2).map(|w| (w[0] + 1) * w[1]).sum();
        Self {
            widths: widths.to_vec(),
            relu_last,
            parameters: vec![T::default(); count],
        }
    }

    /// Widths from input to output.
    pub fn widths(&self) -> &[usize] {
        &self.widths
    }

    /// Whether the last layer has a ReLU as well.
    pub fn relu_last(&self) -> bool {
        self.relu_last
    }

    /// Number of layers.
    pub fn layers(&self) -> usize {
        self.widths.len() - 1
    }

    /// Every parameter: per layer the weights (in × out, row-major), then the biases.
    pub fn parameters(&self) -> &[T] {
        &self.parameters
    }

    /// Every parameter, to be changed.
    pub fn parameters_mut(&mut self) -> &mut [T] {
        &mut self.parameters
    }

    /// Weights (in × out, row-major) and biases of a layer.
    pub fn layer(&self, layer: usize) -> (&[T], &[T]) {
        self.parameters[self.range(layer)].split_at(self.widths[layer] * self.widths[layer + 1])
    }

    /// The same, to be changed.
    pub fn layer_mut(&mut self, layer: usize) -> (&mut [T], &mut [T]) {
        let range = self.range(layer);
        let weights = self.widths[layer] * self.widths[layer + 1];
        self.parameters[range].split_at_mut(weights)
    }

    /// Where each layer's weights are in the parameters: what L2 holds on to.
    pub fn weight_ranges(&self) -> Vec<std::ops::Range<usize>> {
        (0..self.layers())
            .map(|layer| {
                let start = self.range(layer).start;
                start..start + self.widths[layer] * self.widths[layer + 1]
            })
            .collect()
    }

    fn range(&self, layer: usize) -> std::ops::Range<usize> {
        let size = |l: usize| (self.widths[l] + 1) * self.widths[l + 1];
        let start: usize = (0..layer).map(size).sum();
        start..start + size(layer)
    }

    pub(super) fn has_relu(&self, layer: usize) -> bool {
        layer + 1 < self.layers() || self.relu_last
    }

    /// Outputs for a batch (n × first width); they are in the trace.
    pub fn forward(&self, inputs: &[T], trace: &mut Trace<T>) {
        self.start(inputs.len() / self.widths[0], trace);
        for layer in 0..self.layers() {
            let (done, rest) = trace.outputs.split_at_mut(layer);
            let input = done.last().map_or(inputs, Vec::as_slice);
            self.advance(layer, input, &mut rest[0]);
        }
    }

    fn start(&self, batch: usize, trace: &mut Trace<T>) {
        trace.batch = batch;
        trace.outputs.resize_with(self.layers(), Vec::new);
        for (output, width) in trace.outputs.iter_mut().zip(&self.widths[1..]) {
            output.resize(batch * width, T::default());
        }
    }

    /// output = input · weights of a layer, without its biases.
    pub(super) fn products(&self, layer: usize, input: &[T], output: &mut [T]) {
        let (fan_in, fan_out) = (self.widths[layer], self.widths[layer + 1]);
        let batch = input.len() / fan_in;
        T::product(
            ViewMut::new(output, batch, fan_out),
            View::new(input, batch, fan_in),
            View::new(self.layer(layer).0, fan_in, fan_out),
        );
    }

    fn advance(&self, layer: usize, input: &[T], output: &mut [T]) {
        self.products(layer, input, output);
        let biases = self.layer(layer).1;
        if self.has_relu(layer) {
            add_and_relu(output, biases)
        } else {
            add(output, biases)
        }
    }

    /// Adds the gradient of a loss to `gradient` (as long as the parameters), given its gradient by the outputs
    /// of the batch that the trace is of. The gradient by the inputs is left in the trace when asked for.
    pub fn backward(
        &self,
        inputs: &[T],
        by_output: &[T],
        trace: &mut Trace<T>,
        gradient: &mut [T],
        with_inputs: bool,
    ) {
        let batch = trace.batch;
        trace.upstream.clear();
        trace.upstream.extend_from_slice(by_output);
        for layer in (0..self.layers()).rev() {
            let (fan_in, fan_out) = (self.widths[layer], self.widths[layer + 1]);
            if self.has_relu(layer) {
                gate(&mut trace.upstream, &trace.outputs[layer]);
            }
            let input = match layer {
                0 => inputs,
                _ => &trace.outputs[layer - 1],
            };
            let (by_weights, by_biases) =
                gradient[self.range(layer)].split_at_mut(fan_in * fan_out);
            let upstream = View::new(trace.upstream.as_slice(), batch, fan_out);
            T::add_product(
                ViewMut::new(by_weights, fan_in, fan_out),
                View::new(input, batch, fan_in).transpose(),
                upstream,
                T::of(1.0),
            );
            for row in trace.upstream.chunks_exact(fan_out) {
                for (sum, value) in by_biases.iter_mut().zip(row) {
                    *sum += *value;
                }
            }
            if layer > 0 || with_inputs {
                trace.downstream.resize(batch * fan_in, T::default());
                T::product(
                    ViewMut::new(&mut trace.downstream, batch, fan_in),
                    upstream,
                    View::new(self.layer(layer).0, fan_in, fan_out).transpose(),
                );
                if layer > 0 {
                    std::mem::swap(&mut trace.upstream, &mut trace.downstream);
                }
            }
        }
    }
}

/// Adds the biases to every row, and keeps what is above zero.
fn add_and_relu<T: Real>(rows: &mut [T], biases: &[T]) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for row in rows.chunks_exact_mut(biases.len()) {
                for (value, bias) in row.iter_mut().zip(biases) {
                    let sum = *value + *bias;
                    *value = if sum > T::default() {
                        sum
                    } else {
                        T::default()
                    };
                }
            }
        },
    );
}

/// Adds the biases to every row.
fn add<T: Real>(rows: &mut [T], biases: &[T]) {
    for row in rows.chunks_exact_mut(biases.len()) {
        for (value, bias) in row.iter_mut().zip(biases) {
            *value += *bias;
        }
    }
}

/// Lets a gradient through where the ReLU did.
fn gate<T: Real>(gradient: &mut [T], outputs: &[T]) {
    for (gradient, output) in gradient.iter_mut().zip(outputs) {
        *gradient = if *output > T::default() {
            *gradient
        } else {
            T::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(network: &Mlp<f64>, inputs: &[f64], trace: &mut Trace<f64>) -> f64 {
        network.forward(inputs, trace);
        trace.output().iter().map(|y| y.sin()).sum()
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        for relu_last in [false, true] {
            let mut random = ChaCha8Rng::seed_from_u64(11);
            let mut network = Mlp::<f64>::new(&[5, 7, 6, 3], relu_last, &mut random);
            let mut inputs: Vec<f64> = (0..4 * 5).map(|_| random.random::<f64>() - 0.5).collect();
            let mut trace = Trace::default();
            loss(&network, &inputs, &mut trace);
            let by_output: Vec<f64> = trace.output().iter().map(|y| y.cos()).collect();
            let mut gradient = vec![0.0; network.parameters().len()];
            network.backward(&inputs, &by_output, &mut trace, &mut gradient, true);
            let by_input = trace.input_gradient().to_vec();
            let step = 1e-6;
            for (i, found) in gradient.iter().enumerate() {
                let kept = network.parameters()[i];
                network.parameters_mut()[i] = kept + step;
                let above = loss(&network, &inputs, &mut trace);
                network.parameters_mut()[i] = kept - step;
                let below = loss(&network, &inputs, &mut trace);
                network.parameters_mut()[i] = kept;
                let difference = (above - below) / (2.0 * step);
                assert!((difference - found).abs() < 1e-7, "parameter {i}");
            }
            for (i, found) in by_input.iter().enumerate() {
                let kept = inputs[i];
                inputs[i] = kept + step;
                let above = loss(&network, &inputs, &mut trace);
                inputs[i] = kept - step;
                let below = loss(&network, &inputs, &mut trace);
                inputs[i] = kept;
                let difference = (above - below) / (2.0 * step);
                assert!((difference - found).abs() < 1e-7, "input {i}");
            }
        }
    }
}
