//! Time of the exact inverse with a sheet against the same without: cold and warm, side by side.
use std::time::Instant;
use taxel::circuit::{Circuit, LinearCircuit};
use taxel::material::{LoadLaw, Sheet};
use taxel::sensor::preset;
use taxel::simulate::{Pattern, PatternKind};
use taxel::solve::{Exact, Method};
use taxel::{Frame, Siemens};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sensor = preset("econe")?;
    let law = LoadLaw::from_sensor(&sensor)?;
    for (name, pattern) in [
        ("hand", Pattern::hand()),
        (
            "blobs",
            Pattern::new(PatternKind::Blobs { least: 5, most: 12 }),
        ),
    ] {
        let frames: Vec<Frame<Siemens>> = (60..90)
            .map(|k| {
                let loads = pattern.loads(sensor.array(), 7, k);
                loads.map(|t, g| law.siemens_from_grams(t, g))
            })
            .collect();
        for sheet in [
            None,
            Some(Sheet::new(40e3, 3.0)),
            Some(Sheet::new(20e3, 3.0)),
            Some(Sheet::new(12e3, 3.0)),
            Some(Sheet::new(8e3, 2.0)),
        ] {
            let circuit = LinearCircuit::from_sensor(&sensor)?.with_sheet(sheet);
            let volts: Vec<_> = frames.iter().map(|g| circuit.predict(g).unwrap()).collect();
            let method = Exact::new(&circuit).unwrap();
            let mut solver = method.solver();
            let mut out = Frame::zeros(64, 128);
            let mut row = Vec::new();
            for warm in [false, true] {
                let mut best = f64::INFINITY;
                let mut rounds = 0;
                for _ in 0..15 {
                    let start = Instant::now();
                    rounds = 0;
                    for v in &volts {
                        if !warm {
                            solver.forget();
                        }
                        let o = solver.solve_into(v, &mut out);
                        assert!(o.stop.is_good());
                        rounds += o.iterations;
                    }
                    best = best.min(start.elapsed().as_secs_f64() / volts.len() as f64);
                }
                row.push((best * 1e3, rounds as f64 / 30.0));
            }
            println!(
                "{name:6} {sheet:?}: cold {:.3} ms {:.1} rounds, warm {:.3} ms {:.1} rounds",
                row[0].0, row[0].1, row[1].0, row[1].1
            );
        }
    }
    Ok(())
}
