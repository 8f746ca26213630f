//! What the paper says, and where it contradicts itself.

use taxel_view::cells;
use taxel_view::report::{Cell, Section, Table, number};

use super::{TITLE, cell};

/// The paper's numbers beside those of the simulated e-Cone. Sections stand in the order of the plan.
pub(super) fn beside(sections: &[Section], learnt_from: usize) -> Section {
    let [repeatability, response, row, column, presses, hand, ..] = sections else {
        return Section::default();
    };
    let mut table = Table::new(
        "Intervals are 95 %, over experiments",
        &["what", "where", "the paper", "simulated"],
    );
    let mut line = |what: &str, place: &str, said: &str, found: Cell| {
        table.push(cells![what, place, said, found.to_string()]);
    };
    let outliers = "outliers, %";
    line(
        "outliers before the repair, %",
        "Table IV",
        "22",
        cell(repeatability, outliers, 0),
    );
    line(
        "outliers after it, %",
        "Table IV",
        "5",
        cell(repeatability, outliers, 1),
    );
    line(
        "response is a straight line: R²",
        "Fig. 24",
        "a straight line",
        cell(response, "R²", 0),
    );
    line(
        "non-linearity, %",
        "Fig. 24",
        "not given",
        cell(response, "non-linearity, %", 0),
    );
    line(
        "saturates with a wrong R_k at, g",
        "Fig. 25",
        "more than 100",
        cell(response, "saturates at, g", 1),
    );
    line(
        "smallest load with V_test = 10 mV, g",
        "section V.C",
        "ghosts from noise",
        cell(response, "smallest, g", 2),
    );
    line(
        "drop with 9 others in the row, %",
        "Fig. 28",
        "a slight drop",
        cell(row, "drop, %", 0),
    );
    line(
        "of which equation 6 explains, %",
        "Fig. 29",
        "all",
        cell(row, "equation 6: drop, %", 0),
    );
    line(
        "and the full circuit, %",
        "",
        "",
        cell(row, "full circuit: drop, %", 0),
    );
    line(
        "drop with R_v = 1 kΩ, %",
        "Fig. 31",
        "steeper",
        cell(row, "drop, %", 1),
    );
    line(
        "in the column with R_v, %",
        "Fig. 31",
        "more than anticipated",
        cell(column, "drop, %", 1),
    );
    line(
        "in the column without, %",
        "section V.C",
        "not considered",
        cell(column, "drop, %", 0),
    );
    let mean = "mean absolute";
    for (what, section) in [("presses", presses), ("hands", hand)] {
        let is_papers = what == "presses";
        let mut error = |of: &str, said: &str, row: usize| {
            let words = format!("error on {what}, {of}, g");
            line(&words, "section VI.B", said, cell(section, mean, row));
        };
        error("load law alone", "not given", 0);
        error(
            "the paper's network",
            if is_papers { "about 10" } else { "not given" },
            1,
        );
        error("exact inverse", "not done", 2);
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
