use taxel::pipeline::Pipeline;
use taxel::sensor::{preset, Population};
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::{solve, Mark, frame::grams_from_newtons};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let name = &args[1];
    let floor_share: f64 = args[2].parse().unwrap();
    let frames: u64 = args[3].parse().unwrap();
    for seed in [1u64, 2, 3] {
        let base = preset(name).unwrap();
        let (rows, columns) = (base.rows(), base.columns());
        // an insole: an ellipse and a third empty
        let there = |r: usize, c: usize| {
            let y = (r as f64 + 0.5) / rows as f64 * 2.0 - 1.0;
            let x = (c as f64 + 0.5) / columns as f64 * 2.0 - 1.0;
            let half = 0.75 - 0.35 * (1.8 * y + 0.4).cos().powi(2) * if y.abs() < 0.6 {1.0} else {0.2};
            x.abs() < half && (r * 7 + c * 3 + seed as usize) % 11 != 0
        };
        let mask: Vec<Vec<f64>> = (0..rows).map(|r| (0..columns).map(|c| f64::from(u8::from(there(r, c)))).collect()).collect();
        let masked = base.edited(|s| s.array.population = Some(Population::Each(mask.clone()))).unwrap();
        let floor = (floor_share * base.max_count()).round();
        let floored = if floor_share > 0.0 { masked.edited(|s| s.converter.floor_count = Some(floor)).unwrap() } else { masked.clone() };
        let truth = VirtualSensor::new(&floored, seed).unwrap();
        let zero = masked.edited(|s| s.material = s.material.take().map(|mut m| { m.g_zero_siemens = 0.0; m })).unwrap();
        let _ = zero;
        let variants = [("no mask", base.clone()), ("mask", masked.clone()), ("mask+floor", floored.clone()), ("floor alone", floored.edited(|s| s.array.population=None).unwrap())];
        for (what, sensor) in variants {
            let mut pipeline = Pipeline::new(&sensor, solve::method("newton", &sensor).unwrap()).unwrap();
            let (mut sum, mut n, mut bad, mut it, mut below, mut all, mut ntax) = (0.0, 0, 0, 0, 0, 0.0, 0);
            let mut total = (0.0, 0.0);
            for frame in 0..frames {
                let loads = Pattern::hand().loads(truth.sensor().array(), seed, 80 + frame * 7);
                let counts = truth.read(&loads, frame).counts;
                let result = pipeline.process(&counts);
                it += result.outcome.iterations;
                if !result.outcome.is_answer() { bad += 1; continue; }
                let got = result.newtons().unwrap();
                below += got.count(Mark::BelowFloor);
                for (t, &load) in loads.values().iter().enumerate() {
                    if truth.sensor().is_absent(t) { continue; }
                    let e = (grams_from_newtons(got.values()[t]) - load).abs();
                    all += e; ntax += 1;
                    if load > 0.0 { sum += e; n += 1; total.0 += load; total.1 += grams_from_newtons(got.values()[t]); }
                }
            }
            println!("{name} seed {seed} floor {floor} {what}: loaded MAE {:.3} g (n {n}, mean load {:.0}), all MAE {:.3}, total {:+.1}%, bad {bad}/{frames}, rounds {:.1}, below {:.1}%", sum / n as f64, total.0 / n as f64, all / ntax as f64, 100.0*(total.1/total.0-1.0), it as f64 / frames as f64, 100.0*below as f64/ntax.max(1) as f64);
        }
    }
}
