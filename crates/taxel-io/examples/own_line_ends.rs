//! A read-out that is none of the five: columns behind diodes (open when not driven), every row with a pull-down of
//! its own, selected or not. The line ends are given by hand; scan, inverse and standard errors are those of the
//! library. Writes the conductances and prints a line per frame. [real-mats.md] tells what comes out of a real mat.
//!
//! `cargo run --release -p taxel-io --example own_line_ends -- SENSOR.toml RECORDING.txt G.csv`
//!
//! [real-mats.md]: https://github.com/taxel/taxel/blob/main/docs/real-mats.md

use taxel::circuit::{Circuit, Converter, LineEnds, LinearCircuit};
use taxel::sensor::{Sensor, Topology};
use taxel::solve::{Method, Newton};
use taxel::stats::median;
use taxel::uncertainty::{Uncertainty, standard_errors_by};
use taxel::{Frame, Volts};
use taxel_io::{ReadOptions, ValuesWriter, open_counts};

/// Standard deviation of rounding to whole counts.
const ROUNDING: f64 = 0.289;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut names = std::env::args().skip(1);
    let (Some(file), Some(recording), Some(output)) = (names.next(), names.next(), names.next())
    else {
        return Err("usage: own_line_ends SENSOR.toml RECORDING.txt G.csv".into());
    };
    let sensor = Sensor::from_toml(&std::fs::read_to_string(file)?)?;
    let given = LineEnds::from_sensor(&sensor)?;
    let ends = LineEnds {
        topology: Topology::DividerGroundedColumns,
        column_unselected: vec![1e-9; sensor.columns()],
        row_unselected: given.row_selected.clone(),
        ..given
    };
    let circuit = LinearCircuit::new(ends);
    let method = Newton::new(circuit.clone());
    let mut solver = method.solver();
    let mut point = circuit.operating_point();
    let converter = Converter::from_sensor(&sensor);
    let mut volts = Frame::<Volts>::zeros(sensor.rows(), sensor.columns());
    let mut siemens = volts.map(|_, _| 0.0);
    println!("frame  stop        residual  median G (S)  negative  error > value");
    let mut source = open_counts(recording, ReadOptions::of(&sensor))?;
    let mut counts = Frame::zeros(sensor.rows(), sensor.columns());
    let mut writer = ValuesWriter::create(&output)?;
    while source.next_into(&mut counts)? {
        converter.volts_from_counts_into(&counts, &mut volts);
        let outcome = solver.solve_into(&volts, &mut siemens);
        let sigma = ROUNDING * converter.lsb_volts();
        let dense = Uncertainty::Dense;
        let errors = standard_errors_by(dense, &mut *point, siemens.values(), sigma)?;
        writer.write(&siemens)?;
        let share = |of: &dyn Fn(f64, f64) -> bool| {
            let pairs = siemens.values().iter().zip(&errors);
            pairs.filter(|(g, e)| of(**g, **e)).count() as f64 / errors.len() as f64
        };
        println!(
            "{:5}  {:10.10}  {:8.1e}  {:12.2e}  {:6.1} %  {:11.1} %",
            counts.sequence,
            format!("{:?}", outcome.stop),
            outcome.residual,
            median(siemens.values().iter().copied()).unwrap_or(f64::NAN),
            100.0 * share(&|g, _| g < 0.0),
            100.0 * share(&|g, e| e > g.abs())
        );
    }
    writer.commit()?;
    Ok(())
}
