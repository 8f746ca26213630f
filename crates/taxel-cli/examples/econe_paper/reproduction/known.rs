//! What the paper says, and where it contradicts itself.

use taxel_plot::cells;
use taxel_plot::report::{Section, Table, number};

use super::{TITLE, cell};

/// A number of the paper: what, where, how it says it; and where ours stands: section (in the order of the plan), column
/// and row of its first table.
type Known = (
    &'static str,
    &'static str,
    &'static str,
    usize,
    &'static str,
    usize,
);

#[rustfmt::skip]
const KNOWN: [Known; 18] = [
    ("outliers before the repair, %", "Table IV", "22", 0, "outliers, %", 0),
    ("outliers after it, %", "Table IV", "5", 0, "outliers, %", 1),
    ("response is a straight line: R²", "Fig. 24", "a straight line", 1, "R²", 0),
    ("non-linearity, %", "Fig. 24", "not given", 1, "non-linearity, %", 0),
    ("saturates with a wrong R_k at, g", "Fig. 25", "more than 100", 1, "saturates at, g", 1),
    ("smallest load with V_test = 10 mV, g", "section V.C", "ghosts from noise", 1, "smallest, g", 2),
    ("drop with 9 others in the row, %", "Fig. 28", "a slight drop", 2, "drop, %", 0),
    ("of which equation 6 explains, %", "Fig. 29", "all", 2, "equation 6: drop, %", 0),
    ("and the full circuit, %", "", "", 2, "full circuit: drop, %", 0),
    ("drop with R_v = 1 kΩ, %", "Fig. 31", "steeper", 2, "drop, %", 1),
    ("in the column with R_v, %", "Fig. 31", "more than anticipated", 3, "drop, %", 1),
    ("in the column without, %", "section V.C", "not considered", 3, "drop, %", 0),
    ("error on presses, load law alone, g", "section VI.B", "not given", 4, "mean absolute", 0),
    ("error on presses, the paper's network, g", "section VI.B", "about 10", 4, "mean absolute", 1),
    ("error on presses, exact inverse, g", "section VI.B", "not done", 4, "mean absolute", 2),
    ("error on hands, load law alone, g", "section VI.B", "not given", 5, "mean absolute", 0),
    ("error on hands, the paper's network, g", "section VI.B", "not given", 5, "mean absolute", 1),
    ("error on hands, exact inverse, g", "section VI.B", "not done", 5, "mean absolute", 2),
];

/// The paper's numbers beside those of the simulated e-Cone.
pub(super) fn next_to(sections: &[Section], learnt_from: usize) -> Section {
    let mut table = Table::new(
        "Intervals are 95 %, over experiments",
        &["what", "where", "the paper", "simulated"],
    );
    for (what, place, said, section, column, row) in KNOWN {
        let found = cell(&sections[section], column, row);
        table.push(cells![what, place, said, found.to_string()]);
    }
    Section {
        title: "The paper's numbers beside ours".to_owned(),
        paragraphs: vec![
            format!(
                "{TITLE}: 64 × 128 taxels, 10 Ω switches, 16 bits, 3 counts of noise, and tips that are set down with a tenth of a taxel of misalignment. Real materials also creep, and differ from taxel to taxel; nothing here says how much."
            ),
            format!(
                "The network is the paper's (160, 480, 240), trained with {} simulated presses, split by press before rows are shuffled; the paper shuffles first, so that copies of one press stand on both sides of its split.",
                number(learnt_from as f64)
            ),
        ],
        tables: vec![table],
        figures: Vec::new(),
    }
}

/// Where the paper's numbers cannot be right.
pub(super) fn corrections() -> Section {
    let mut table = Table::new("", &["where", "as printed", "should be"]);
    let mut line =
        |place: &str, printed: &str, right: &str| table.push(cells![place, printed, right]);
    line(
        "equations 4 to 6",
        "a sum over n without an end",
        "over the N other pressed taxels of the row",
    );
    line(
        "equation 6 with Table V",
        "explains Fig. 28",
        "predicts 0.04 % at N = 20",
    );
    line("equation 7", "1/(1 + 1000) = 0.0009", "0.000999");
    line(
        "Table III, 8 mm²",
        "0.465 MPa",
        "3.64 N / 8 mm² = 0.455 MPa",
    );
    line(
        "Table VI",
        "a reading of 65820",
        "at most 65535 with 16 bits",
    );
    line(
        "Algorithm 1",
        "pressed where the count is ≤ 300",
        "where it is above a threshold (350 in its program)",
    );
    line(
        "the split",
        "rows are shuffled before",
        "split by press, then shuffle",
    );
    Section {
        title: "Where the paper's own numbers disagree".to_owned(),
        paragraphs: Vec::new(),
        tables: vec![table],
        figures: Vec::new(),
    }
}
