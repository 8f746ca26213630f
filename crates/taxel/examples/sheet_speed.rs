//! Time of the exact inverse with a sheet against the same without: cold and warm, side by side.
//!
//! An accuracy, such as 1e-6, may be given, a share of the largest conductance; otherwise 1e-9.
//!
//! All run in turn, over and over; of each frame the shortest time counts, so that what else the machine does hardly does.
use std::time::Instant;
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::material::{LoadLaw, Sheet};
use taxel::sensor::preset;
use taxel::simulate::{Pattern, PatternKind};
use taxel::solve::{Exact, Method, Solver};
use taxel::{Frame, Siemens, Volts};

const FRAMES: u32 = 30;
const TURNS: usize = 60;
const STARTS: [&str; 2] = ["cold", "warm"];

/// One sheet, or none, and how it has done.
struct Contender {
    name: String,
    volts: Vec<Frame<Volts>>,
    solver: Box<dyn Solver>,
    /// Cold and warm: seconds of each frame, and the rounds of all.
    secs: [Vec<f64>; 2],
    rounds: [u32; 2],
}

impl Contender {
    fn new(
        circuit: &LinearCircuit,
        frames: &[Frame<Siemens>],
        sheet: Option<Sheet>,
        accuracy: f64,
    ) -> Self {
        let circuit = circuit.clone().with_sheet(sheet);
        Self {
            name: sheet.map_or("none".into(), |s| {
                let (kilo_ohms, alpha) = (s.resistance_ohms / 1e3, s.contact_factor);
                format!("{kilo_ohms} kΩ, α {alpha}")
            }),
            volts: frames.iter().map(|g| circuit.predict(g).unwrap()).collect(),
            solver: Exact::new(&circuit)
                .unwrap()
                .with_tolerance(accuracy)
                .solver(),
            secs: [
                vec![f64::INFINITY; frames.len()],
                vec![f64::INFINITY; frames.len()],
            ],
            rounds: [0; 2],
        }
    }

    /// All frames once.
    fn turn(&mut self, start: usize, out: &mut Frame<Siemens>) {
        self.rounds[start] = 0;
        for (volts, best) in self.volts.iter().zip(&mut self.secs[start]) {
            if start == 0 {
                self.solver.forget();
            }
            let began = Instant::now();
            let outcome = self.solver.solve_into(volts, out);
            *best = best.min(began.elapsed().as_secs_f64());
            assert!(outcome.stop.is_good());
            self.rounds[start] += outcome.iterations;
        }
    }

    fn millis(&self, start: usize) -> f64 {
        self.secs[start].iter().sum::<f64>() / f64::from(FRAMES) * 1e3
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let accuracy = std::env::args().nth(1);
    let accuracy = accuracy.map_or(Ok(1e-9), |word| word.parse())?;
    let sensor = preset("econe")?;
    let law = LoadLaw::from_sensor(&sensor)?;
    let circuit = LinearCircuit::from_sensor(&sensor)?;
    let sheets = [(40e3, 3.0), (20e3, 3.0), (12e3, 3.0), (8e3, 2.0)];
    let sheets = sheets.map(|(ohms, alpha)| Some(Sheet::new(ohms, alpha)));
    let blobs = PatternKind::Blobs { least: 5, most: 12 };
    let mut out = Frame::zeros(sensor.rows(), sensor.columns());
    for (name, pattern) in [("hand", Pattern::hand()), ("blobs", Pattern::new(blobs))] {
        let frames = (60..60 + FRAMES).map(|k| {
            let loads = pattern.loads(sensor.array(), 7, k.into());
            loads.map(|t, g| law.siemens_from_grams(t, g))
        });
        let frames: Vec<Frame<Siemens>> = frames.collect();
        let all = std::iter::once(None).chain(sheets);
        let mut all: Vec<_> = all
            .map(|sheet| Contender::new(&circuit, &frames, sheet, accuracy))
            .collect();
        for start in 0..STARTS.len() {
            for _ in 0..TURNS {
                all.iter_mut().for_each(|one| one.turn(start, &mut out));
            }
        }
        for one in &all {
            print!("{name:6} {:12}", one.name);
            for (start, word) in STARTS.into_iter().enumerate() {
                let (millis, rounds) = (
                    one.millis(start),
                    f64::from(one.rounds[start]) / f64::from(FRAMES),
                );
                let ratio = millis / all[0].millis(start);
                print!("  {word} {millis:.3} ms {rounds:4.1} rounds {ratio:.2} ×");
            }
            println!();
        }
    }
    Ok(())
}
