//! What counts to grams cost beside the inverse alone, on a stream of an e-Cone: as it is shipped, and with all that a calibration
//! may find: a gain and an exponent for every taxel, a bend, spread, creep and hysteresis, memory of the scan, an offset.
//!
//! All run in turn, over and over; of each frame the shortest time counts, so that what else the machine does hardly does.
use std::time::Instant;
use taxel::circuit::Converter;
use taxel::material::{DynamicLaw, HysteresisState, LoadLaw, Spread};
use taxel::pipeline::Pipeline;
use taxel::screen::FrameScreen;
use taxel::sensor::{Bend, PerTaxel, preset};
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::solve::default_method;
use taxel::{Counts, Error, Frame, Sensor, Siemens, Volts};

const FRAMES: u64 = 30;

fn calibrated(sensor: &Sensor) -> Result<Sensor, Error> {
    let each = |middle: f64, step: f64| {
        let of = |row: usize, column: usize| {
            middle + step * ((37 * row + 101 * column) % 21) as f64 - 10.0 * step
        };
        let line = |row| (0..sensor.columns()).map(|c| of(row, c)).collect();
        PerTaxel::Each((0..sensor.rows()).map(line).collect())
    };
    let dynamic = DynamicLaw {
        lags: vec![(0.08, 0.8), (0.07, 8.0), (0.07, 80.0)],
        plays: vec![(0.07, 5.0), (0.07, 15.0), (0.07, 40.0)],
        period_secs: 0.01,
    };
    sensor.edited(|spec| {
        spec.converter.carry_over = 0.002;
        spec.converter.offset_volts = 0.0005;
        spec.converter.noise_counts = Some(3.0);
        let material = spec.material.as_mut().expect("the preset has one");
        material.gain = Some(each(1.0, 0.02));
        material.exponent = each(0.857, 0.003);
        material.spread = Some([0.03, 0.025, 0.004]);
        material.bend = Some(Bend::new(
            vec![1.0, 2.5, 4.0, 5.0, 6.5],
            vec![-0.02, 0.01, 0.03, -0.01, -0.06],
        ));
        material.dynamic = Some(dynamic.to_spec());
    })
}

/// What is timed, and the shortest time of each frame.
struct Timed<'a> {
    name: &'static str,
    run: Box<dyn FnMut(usize) + 'a>,
    secs: Vec<f64>,
}

impl<'a> Timed<'a> {
    fn new(name: &'static str, run: impl FnMut(usize) + 'a) -> Self {
        Self {
            name,
            run: Box::new(run),
            secs: vec![f64::INFINITY; FRAMES as usize],
        }
    }

    fn turn(&mut self) {
        for (frame, best) in self.secs.iter_mut().enumerate() {
            let began = Instant::now();
            (self.run)(frame);
            *best = best.min(began.elapsed().as_secs_f64());
        }
    }

    fn micros(&self) -> f64 {
        self.secs.iter().sum::<f64>() / self.secs.len() as f64 * 1e6
    }
}

/// A stream as it goes through: counts, volts, conductances, acting loads.
struct Stream {
    counts: Vec<Frame<Counts>>,
    volts: Vec<Frame<Volts>>,
    siemens: Vec<Frame<Siemens>>,
    grams: Vec<Vec<f64>>,
}

impl Stream {
    fn new(sensor: &Sensor, law: &LoadLaw) -> Result<Self, Error> {
        let real = VirtualSensor::new(sensor, 1)?;
        let counts: Vec<_> = (60..60 + FRAMES)
            .map(|t| {
                let loads = Pattern::hand().loads(sensor.array(), 1, t);
                real.read(&loads, t).counts
            })
            .collect();
        let mut pipeline = Pipeline::new(sensor, default_method(sensor)?)?;
        let (mut volts, mut siemens, mut grams) = (Vec::new(), Vec::new(), Vec::new());
        for counts in &counts {
            let result = pipeline.process(counts);
            volts.push(result.volts.clone());
            siemens.extend(result.siemens.cloned());
            let mut acting = vec![0.0; counts.values().len()];
            law.grams_of_frame(siemens[siemens.len() - 1].values(), &mut acting);
            grams.push(acting);
        }
        Ok(Self {
            counts,
            volts,
            siemens,
            grams,
        })
    }
}

fn parts<'a>(
    sensor: &Sensor,
    stream: &'a Stream,
    law: &'a LoadLaw,
) -> Result<Vec<Timed<'a>>, Error> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let (mut counts, mut volts) = (Frame::zeros(rows, columns), Frame::zeros(rows, columns));
    let mut out = Frame::zeros(rows, columns);
    let mut loads = vec![0.0; rows * columns];
    let mut solver = default_method(sensor)?.solver();
    solver.set_rounded(true);
    let mut pipeline = Pipeline::new(sensor, default_method(sensor)?)?;
    let mut screen = FrameScreen::from_sensor(sensor);
    let converter = Converter::from_sensor(sensor);
    let mut timed = vec![
        Timed::new("inverse", move |k| {
            solver.solve_into(&stream.volts[k], &mut out);
        }),
        Timed::new("counts to grams", move |k| {
            pipeline.process(&stream.counts[k]);
        }),
        Timed::new("screen", move |k| {
            counts.clone_from(&stream.counts[k]);
            screen.mark(&mut counts).expect("of its shape");
        }),
        Timed::new("volts", move |k| {
            converter.volts_from_counts_into(&stream.counts[k], &mut volts);
        }),
        Timed::new("law", move |k| {
            law.grams_of_frame(stream.siemens[k].values(), &mut loads);
        }),
    ];
    let material = sensor.material().expect("the preset has one");
    if let Some(dynamic) = &material.dynamic {
        let mut state = HysteresisState::new(&DynamicLaw::from_spec(dynamic), rows * columns);
        let mut grams = vec![0.0; rows * columns];
        timed.push(Timed::new("creep", move |k| {
            grams.copy_from_slice(&stream.grams[k]);
            state.loads_from_acting(None, &mut grams, |_| false);
        }));
    }
    if let Some(spread) = material.spread.map(Spread::new) {
        let (mut loads, mut work) = (
            vec![0.0; rows * columns],
            vec![0.0; Spread::room(rows * columns, columns)],
        );
        timed.push(Timed::new("spread", move |k| {
            spread.undo(columns, &[], &stream.grams[k], &mut loads, &mut work);
        }));
    }
    Ok(timed)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let turns = std::env::args().nth(1);
    let turns = turns.map_or(Ok(60), |word| word.parse())?;
    let shipped = preset("econe")?;
    let all = calibrated(&shipped)?;
    for (name, sensor) in [("as shipped", shipped), ("calibrated", all)] {
        let law = LoadLaw::from_sensor(&sensor)?;
        let stream = Stream::new(&sensor, &law)?;
        let mut timed = parts(&sensor, &stream, &law)?;
        for _ in 0..turns {
            timed.iter_mut().for_each(Timed::turn);
        }
        let inverse = timed[0].micros();
        for one in &timed {
            let micros = one.micros();
            println!(
                "{name}  {:16} {micros:6.1} µs  {:.2} × the inverse",
                one.name,
                micros / inverse
            );
        }
    }
    Ok(())
}
