//! Sensors, frames and an independent solver that the integration tests share.
#![allow(dead_code)]

pub mod tables;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::circuit::{Circuit, LineEnds, LinearCircuit};
use taxel::sensor::LineEnd;
use taxel::sensor::{
    Array, ConverterSpec, MaterialSpec, PerLine, PerTaxel, ReadoutSpec, Sensor, SensorSpec,
    SheetSpec, Topology,
};
use taxel::solve::{Method, method};
use taxel::{Frame, Siemens, Volts};

/// A sensor of any topology with equal switches.
pub fn sensor(
    topology: Topology,
    rows: usize,
    columns: usize,
    r_mux: f64,
    r_source: f64,
) -> Sensor {
    let tia = topology.is_tia();
    let mut array = Array::new(rows, columns);
    array.pitch_mm = [2.0, 2.0];
    array.taxel_area_mm2 = 5.0;
    let mut readout = ReadoutSpec::new(topology, if tia { 0.4 } else { 3.3 });
    readout.r_feedback_ohms = tia.then_some(2000.0);
    readout.open_loop_gain = tia.then_some(1e5);
    readout.r_mux_column_ohms = Some(PerLine::One(r_mux));
    readout.r_mux_row_ohms = Some(PerLine::One(r_mux));
    readout.r_source_ohms = r_source;
    readout.r_pull_down_ohms = (!tia).then_some(1000.0);
    let mut converter = ConverterSpec::new(16, if tia { 2.2 } else { 3.3 });
    converter.inverted = tia;
    let mut spec = SensorSpec::new(array, readout, converter);
    spec.name = "test".to_owned();
    Sensor::try_from(spec).expect("a valid test sensor")
}

/// A frame where `fraction` of the taxels is pressed to 500–3000 Ω, the rest at 1 µS.
pub fn pressed(rows: usize, columns: usize, fraction: f64, seed: u64) -> Frame<Siemens> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let values = (0..rows * columns)
        .map(|_| {
            if random.random::<f64>() < fraction {
                1.0 / random.random_range(500.0..3000.0)
            } else {
                1e-6
            }
        })
        .collect();
    Frame::new(rows, columns, values).expect("shape")
}

/// V_out of one taxel by a dense solve of the whole nodal matrix, node by node: no Schur complement, no
/// low-rank update, the follower as a source that is solved for. Also returns all node voltages.
pub fn nodal_volts(
    circuit: &LinearCircuit,
    g: &Frame<Siemens>,
    row: usize,
    column: usize,
) -> (f64, Vec<f64>) {
    let (rows, columns) = (g.rows(), g.columns());
    let ends = circuit.ends();
    // Among lines that float altogether the leak would be a resistor of its own; it stands for "open",
    // and is needed only where a line has nothing else.
    let row_total = |r: usize| (0..columns).map(|c| g.at(r, c)).sum::<f64>();
    let column_total = |c: usize| (0..rows).map(|r| g.at(r, c)).sum::<f64>();
    let isolated =
        (0..rows).any(|r| row_total(r) == 0.0) || (0..columns).any(|c| column_total(c) == 0.0);
    let leak = |end: f64| {
        if ends.is_floating() && !isolated {
            0.0
        } else {
            end
        }
    };
    let nodes = Nodes::new(circuit, rows, columns);
    let size = nodes.count;
    let mut matrix = vec![0.0; size * size];
    let mut sources = [vec![0.0; size], vec![0.0; size]];
    for node in 0..rows + columns {
        let selected = node == row || node == rows + column;
        let [all, to_v_test, to_follower] = node_ends(ends, node, selected);
        matrix[node * size + node] += if selected { all } else { leak(all) };
        sources[0][node] = to_v_test * ends.v_test_volts;
        sources[1][node] = to_follower;
    }
    for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let taxel = r * columns + c;
        let ends = [nodes.rows[taxel], nodes.columns[taxel]];
        join(&mut matrix, size, ends, g.at(r, c));
    }
    join_sheet(&mut matrix, circuit, &nodes, g);
    join_lines(&mut matrix, circuit, &nodes, [rows, columns]);
    let [driven, fed_back] = sources
        .map(|source| taxel_linalg::solve_symmetric(&matrix, &source).expect("positive definite"));
    // v = a + b · v_follower, v_follower = what is read of v_row.
    let rho = ends.volts_per_volt[row];
    let follower = rho * driven[row] / (1.0 - rho * fed_back[row]);
    let nodes: Vec<f64> = (driven.iter().zip(&fed_back))
        .map(|(driven, fed_back)| driven + follower * fed_back)
        .collect();
    (rho * nodes[row], nodes)
}

/// What a line conducts to anywhere, to V_t and to the follower; rows first.
fn node_ends(ends: &LineEnds, node: usize, selected: bool) -> [f64; 3] {
    let (from, follow) = (&ends.to_v_test, &ends.to_follower);
    let rows = ends.row_selected.len();
    let lists = match (node < rows, selected) {
        (true, true) => [&ends.row_selected, &from.row_selected, &follow.row_selected],
        (true, false) => [
            &ends.row_unselected,
            &from.row_unselected,
            &follow.row_unselected,
        ],
        (false, true) => [
            &ends.column_selected,
            &from.column_selected,
            &follow.column_selected,
        ],
        (false, false) => [
            &ends.column_unselected,
            &from.column_unselected,
            &follow.column_unselected,
        ],
    };
    let line = if node < rows { node } else { node - rows };
    lists.map(|list| list[line])
}

/// The node of each taxel's row and of its column. The ends of the lines come first, rows before columns; a line without
/// resistance is its end.
struct Nodes {
    rows: Vec<usize>,
    columns: Vec<usize>,
    count: usize,
}

impl Nodes {
    fn new(circuit: &LinearCircuit, rows: usize, columns: usize) -> Self {
        let mut nodes = Self {
            rows: Vec::new(),
            columns: Vec::new(),
            count: rows + columns,
        };
        let place = |end: LineEnd, lines: usize| match end {
            LineEnd::First => 0,
            LineEnd::Last => lines - 1,
        };
        for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let mut new = |end: usize, is_new: bool| {
                nodes.count += usize::from(is_new);
                if is_new { nodes.count - 1 } else { end }
            };
            let (along_row, along_column) = match circuit.lines() {
                None => (false, false),
                Some(lines) => (
                    lines.row_ohms()[r] > 0.0 && c != place(lines.ends().0, columns),
                    lines.column_ohms()[c] > 0.0 && r != place(lines.ends().1, rows),
                ),
            };
            let row = new(r, along_row);
            let column = new(rows + c, along_column);
            nodes.rows.push(row);
            nodes.columns.push(column);
        }
        nodes
    }
}

/// What a continuous sheet conducts between the nodes of neighbours.
fn join_sheet(matrix: &mut [f64], circuit: &LinearCircuit, nodes: &Nodes, g: &Frame<Siemens>) {
    let Some(sheet) = circuit.sheet() else {
        return;
    };
    let (rows, columns) = (g.rows(), g.columns());
    let mut flow = |of: [usize; 2], a: f64, b: f64| {
        if a > 0.0 && b > 0.0 {
            let ohms = sheet.resistance_ohms + sheet.contact_factor * (1.0 / a + 1.0 / b);
            join(matrix, nodes.count, of, 1.0 / ohms);
        }
    };
    for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let at = r * columns + c;
        if r + 1 < rows {
            let of = [nodes.rows[at], nodes.rows[at + columns]];
            flow(of, g.at(r, c), g.at(r + 1, c));
        }
        if c + 1 < columns {
            let of = [nodes.columns[at], nodes.columns[at + 1]];
            flow(of, g.at(r, c), g.at(r, c + 1));
        }
    }
}

/// What lines conduct from taxel to taxel.
fn join_lines(
    matrix: &mut [f64],
    circuit: &LinearCircuit,
    nodes: &Nodes,
    [rows, columns]: [usize; 2],
) {
    let Some(lines) = circuit.lines() else {
        return;
    };
    for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let (at, along_row, along_column) =
            (r * columns + c, lines.row_ohms()[r], lines.column_ohms()[c]);
        if c + 1 < columns && along_row > 0.0 {
            let of = [nodes.rows[at], nodes.rows[at + 1]];
            join(matrix, nodes.count, of, 1.0 / along_row);
        }
        if r + 1 < rows && along_column > 0.0 {
            let of = [nodes.columns[at], nodes.columns[at + columns]];
            join(matrix, nodes.count, of, 1.0 / along_column);
        }
    }
}

/// A conductance between two nodes.
fn join(matrix: &mut [f64], size: usize, [a, b]: [usize; 2], siemens: f64) {
    matrix[a * size + a] += siemens;
    matrix[b * size + b] += siemens;
    matrix[a * size + b] -= siemens;
    matrix[b * size + a] -= siemens;
}

/// The same sensor under a continuous sheet, or under a cut one.
pub fn under_sheet(sensor: &Sensor, sheet: Option<(f64, f64)>) -> Sensor {
    let material = sheet.map(|(ohms, contact)| {
        let mut material = MaterialSpec::new(1e-5, PerTaxel::One(0.85));
        material.sheet = Some(SheetSpec::new(ohms, contact));
        material
    });
    sensor
        .edited(|spec| spec.material = material)
        .expect("a valid sheet")
}

/// Largest absolute value.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| most.max(v.abs()))
}

/// Largest absolute difference.
pub fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// Shapes that every property of the inverse is tried on: one taxel, one line, either side longer, square.
pub const SHAPES: [(usize, usize); 6] = [(1, 1), (1, 6), (6, 1), (12, 5), (5, 12), (8, 8)];

/// The methods that invert a topology (without a source resistor), by name.
pub fn methods(topology: Topology) -> &'static [&'static str] {
    match topology {
        Topology::TiaGroundedColumns => &["exact", "newton"],
        _ => &["newton"],
    }
}

/// A sensor and a method that inverts its scan.
pub struct Inversion {
    /// For messages.
    pub label: String,
    /// The sensor.
    pub sensor: Sensor,
    /// Its circuit.
    pub circuit: LinearCircuit,
    /// The method.
    pub method: Box<dyn Method>,
}

/// The method called `name` for a sensor of equal switches.
pub fn inversion(
    name: &str,
    topology: Topology,
    (rows, columns): (usize, usize),
    r_mux: f64,
    r_source: f64,
) -> Inversion {
    let sensor = sensor(topology, rows, columns, r_mux, r_source);
    Inversion {
        label: format!(
            "{name}, {} {rows}x{columns}, {r_mux} Ohm, source {r_source} Ohm",
            topology.name()
        ),
        circuit: LinearCircuit::from_sensor(&sensor).expect("switches are known"),
        method: method(name, &sensor).expect("the method fits"),
        sensor,
    }
}

/// The one list: every topology, shape and method.
pub fn inversions(r_mux: f64) -> Vec<Inversion> {
    let mut list = Vec::new();
    for topology in Topology::ALL {
        for shape in SHAPES {
            for name in methods(topology) {
                list.push(inversion(name, topology, shape, r_mux, 0.0));
            }
        }
    }
    list
}

/// Largest error over the largest conductance.
pub fn relative_error(found: &Frame<Siemens>, truth: &Frame<Siemens>) -> f64 {
    farthest(found.values(), truth.values()) / largest(truth.values())
}

/// Scans of a slowly changing press: from frame to frame every taxel changes by up to 1 %.
pub fn stream(circuit: &LinearCircuit, first: &Frame<Siemens>, frames: usize) -> Vec<Frame<Volts>> {
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let mut siemens = first.clone();
    (0..frames)
        .map(|_| {
            let volts = circuit.predict(&siemens).expect("passive");
            for g in siemens.values_mut() {
                *g *= 1.0 + random.random_range(-0.01..0.01);
            }
            volts
        })
        .collect()
}
