//! A sensor and a recording of it, decided by a read-out and a seed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use taxel::sensor::{PerLine, Topology, preset};
use taxel::simulate::{Imperfections, Pattern, VirtualSensor};
use taxel::{Counts, Error, Frame};

/// Frames of a recording.
const FRAMES: usize = 40;

/// A virtual sensor and what presses on it.
pub struct Draw {
    pub name: String,
    pub real: VirtualSensor,
    pattern: Pattern,
}

impl Draw {
    /// Lines, bits, resistor, switches, V_t over full scale and pattern by the seed. Gains differ by 5 %, switches are alike.
    pub fn new(topology: Topology, seed: u64) -> Result<Self, Error> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut pick = |from: &[f64]| from[random.random_range(0..from.len())];
        let (rows, columns) = (
            pick(&[8.0, 16.0, 16.0, 32.0]),
            pick(&[8.0, 16.0, 16.0, 32.0]),
        );
        let (bits, ohms) = (pick(&[10.0, 12.0, 16.0]), pick(&[1000.0, 2000.0, 4700.0]));
        let (mux, scale) = (pick(&[4.0, 20.0, 70.0]), pick(&[0.7, 1.0, 1.0]));
        let names = ["fingers", "hand", "blobs", "random"];
        let name = names[pick(&[0.0, 1.0, 2.0, 3.0]) as usize];
        let parts = if topology.is_tia() {
            preset("mat-32x32-adg732")?
        } else {
            preset("mat-16x16-cd4067")?
        };
        let truth = parts.edited(|spec| {
            spec.readout.topology = topology;
            (spec.array.rows, spec.array.columns) = (rows as usize, columns as usize);
            spec.converter.bits = bits as u32;
            spec.converter.full_scale_volts = 3.3;
            // An amplifier is driven by as much as its resistor allows.
            let drive = if topology.is_tia() { 300.0 / ohms } else { 1.0 };
            spec.readout.v_test_volts = 3.3 * scale * drive;
            spec.readout.r_feedback_ohms = Some(ohms);
            spec.readout.r_pull_down_ohms = Some(ohms);
            spec.readout.r_mux_column_ohms = Some(PerLine::One(mux));
            spec.readout.r_mux_row_ohms = Some(PerLine::One(mux));
        })?;
        let mut imperfections = Imperfections::default();
        imperfections.gain_sd = 0.05;
        Ok(Self {
            name: format!(
                "{} {rows}x{columns} {bits} bits {ohms} ohms {mux} ohms {scale} {name} seed {seed}",
                topology.name()
            ),
            real: VirtualSensor::imperfect(&truth, &imperfections, seed)?,
            pattern: Pattern::named(name).expect("a known pattern"),
        })
    }

    /// A hand on the e-Cone, 64 × 128.
    #[allow(dead_code)]
    pub fn econe() -> Result<Self, Error> {
        Ok(Self {
            name: "econe 64x128 hand".to_owned(),
            real: VirtualSensor::new(&preset("econe")?, 101)?,
            pattern: Pattern::hand(),
        })
    }

    /// Frames spread over the pattern.
    pub fn frames(&self) -> Vec<Frame<Counts>> {
        let all = (0..FRAMES as u64).flat_map(|number| {
            let frame = 4 * number;
            self.real.recording(&self.pattern, frame..frame + 1)
        });
        all.map(|(_, scan)| scan.counts).collect()
    }
}
