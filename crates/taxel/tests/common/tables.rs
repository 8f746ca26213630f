//! Read-outs that are written as tables of line ends.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::sensor::{Sensor, preset};

/// A sensor of so many lines, `bits` and this `[readout]`.
pub fn sensor_of(rows: usize, columns: usize, bits: u32, readout: &str) -> Sensor {
    let text = format!(
        "format = 1\n[array]\nrows = {rows}\ncolumns = {columns}\n{readout}\n[converter]\nbits = {bits}\nfull_scale_volts = 5.0\n"
    );
    Sensor::from_toml(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Mats that people solder: a name and the `[readout]`.
pub const MATS: [(&str, &str); 5] = [
    (
        "pull-downs on every row, columns open behind diodes",
        "[readout]\ntopology = \"line-ends\"\nreads = \"voltage\"\nv_test_volts = 4.7\n\
         driven.selected = { to = \"v_test\", ohms = 100.0 }\n\
         sensed.selected = { to = \"ground\", ohms = 2200.0 }\n\
         sensed.unselected = { to = \"ground\", ohms = 2200.0 }\n",
    ),
    (
        "columns driven low by a shift register",
        "[readout]\ntopology = \"line-ends\"\nreads = \"voltage\"\nv_test_volts = 5.0\n\
         driven.selected = { to = \"v_test\", ohms = 45.0 }\n\
         driven.unselected = { to = \"ground\", ohms = 30.0 }\n\
         sensed.selected = { to = \"ground\", ohms = 1000.0 }\n\
         sensed.unselected = { to = \"ground\", ohms = 1000.0 }\n",
    ),
    (
        "a weak pull-down on every row beside the one behind the switch",
        "[readout]\ntopology = \"line-ends\"\nreads = \"voltage\"\nv_test_volts = 5.0\n\
         r_mux_column_ohms = 70.0\nr_mux_row_ohms = 70.0\n\
         driven.selected = { to = \"v_test\", switched = true }\n\
         sensed.selected = [{ to = \"ground\", ohms = 10000.0 }, { to = \"ground\", ohms = 1000.0, switched = true }]\n\
         sensed.unselected = { to = \"ground\", ohms = 10000.0 }\n",
    ),
    (
        "rows and columns guarded by a follower through resistors",
        "[readout]\ntopology = \"line-ends\"\nreads = \"voltage\"\nv_test_volts = 5.0\n\
         r_mux_column_ohms = 70.0\nr_mux_row_ohms = 70.0\n\
         driven.selected = { to = \"v_test\", switched = true }\n\
         driven.unselected = { to = \"follower\", switched = true }\n\
         sensed.selected = { to = \"ground\", ohms = 1000.0, switched = true }\n\
         sensed.unselected = [{ to = \"follower\", ohms = 330.0 }, { to = \"ground\", ohms = 100000.0 }]\n",
    ),
    (
        "a virtual ground, every row held at ground through a resistor",
        "[readout]\ntopology = \"line-ends\"\nreads = \"current\"\nv_test_volts = 0.8\n\
         r_feedback_ohms = 2000.0\nr_mux_column_ohms = 70.0\nr_mux_row_ohms = 70.0\n\
         driven.selected = { to = \"v_test\", switched = true }\n\
         driven.unselected = { to = \"ground\", switched = true }\n\
         sensed.selected = [{ to = \"ground\", ohms = 1000.0 }, { to = \"amplifier\", switched = true }]\n\
         sensed.unselected = { to = \"ground\", ohms = 1000.0 }\n",
    ),
];

/// The home-made mat of 16 x 16 with a read-out of its own.
pub fn mat(readout: &str) -> Sensor {
    let plain = preset("mat-16x16-cd4067").unwrap();
    let own = sensor_of(16, 16, 10, readout);
    plain
        .edited(|spec| {
            spec.readout = own.spec().readout.clone();
            spec.converter.inverted = own.readout().has_amplifier();
        })
        .unwrap()
}

/// Any table: ends drawn for every line, among them lines that have none.
pub fn any_table(rows: usize, columns: usize, seed: u64) -> Sensor {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x7ab1e);
    let mut list = |lines: usize, least: f64, gaps: bool| {
        let one = |_| {
            if gaps && random.random_bool(0.3) {
                "inf".to_owned()
            } else {
                format!("{:.3}", least * 10f64.powf(random.random_range(0.0..2.0)))
            }
        };
        (0..lines).map(one).collect::<Vec<_>>().join(", ")
    };
    let current = seed.is_multiple_of(3);
    let drive = list(columns, 5.0, false);
    let mut ends = |lines: usize, places: &[&str], from: u64| {
        let taken = places.iter().enumerate();
        let taken = taken.filter(|(i, _)| (seed >> (from + *i as u64)) & 1 == 1);
        taken
            .map(|(_, to)| format!("{{ to = \"{to}\", ohms = [{}] }}", list(lines, 20.0, true)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let places: &[&str] = if current {
        &["ground", "v_test"]
    } else {
        &["ground", "v_test", "follower"]
    };
    let (column, row) = (ends(columns, places, 8), ends(rows, places, 12));
    let also = ends(rows, &["ground", "v_test"], 16);
    let read = if current {
        "{ to = \"amplifier\", switched = true }".to_owned()
    } else {
        format!(
            "{{ to = \"ground\", switched = {}, ohms = [{}] }}",
            seed & 128 == 0,
            list(rows, 100.0, false)
        )
    };
    let reads = if current { "current" } else { "voltage" };
    let readout = format!(
        "[readout]\ntopology = \"line-ends\"\nreads = \"{reads}\"\nv_test_volts = 3.3\nr_feedback_ohms = 2000.0\n\
         r_mux_row_ohms = 70.0\n\
         driven.selected = [{{ to = \"v_test\", ohms = [{drive}] }}]\ndriven.unselected = [{column}]\n\
         sensed.selected = [{read}, {also}]\nsensed.unselected = [{row}]\n"
    );
    sensor_of(rows, columns, 16, &readout.replace(", ]\n", "]\n"))
}
