//! What to measure with a multimeter where frames leave several read-outs.

use super::report::Measurement;
use crate::sensor::Topology;

/// What a line that is not selected hangs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Columns {
    Grounded,
    Open,
    Follow,
}

fn columns(topology: Topology) -> Columns {
    match topology {
        Topology::DividerFloating | Topology::DividerPulledRows => Columns::Open,
        Topology::DividerVoltageFeedback => Columns::Follow,
        _ => Columns::Grounded,
    }
}

fn differ<T: PartialEq>(left: &[Topology], of: impl Fn(Topology) -> T) -> bool {
    left.iter().any(|&topology| of(topology) != of(left[0]))
}

/// The measurements that part these read-outs.
pub(super) fn measure(left: &[Topology]) -> Vec<Measurement> {
    let mut all = Vec::new();
    if left.len() < 2 {
        return all;
    }
    let has = |wanted| left.iter().any(|&topology| columns(topology) == wanted);
    if has(Columns::Open) && (has(Columns::Grounded) || has(Columns::Follow)) {
        all.push(Measurement {
            measure: "resistance between a column that is not selected and ground, board powered, scan stopped, mat unplugged",
            means: vec![
                "near the switch's on-resistance (1 to 200 ohms): grounded columns",
                "open (above 1 Mohm): floating columns",
            ],
        });
    }
    if has(Columns::Follow) && has(Columns::Grounded) {
        all.push(Measurement {
            measure: "voltage of a column that is not selected, scan stopped on a taxel that is pressed hard",
            means: vec![
                "0 V: grounded columns",
                "that of the sensed row: voltage feedback",
            ],
        });
    }
    if differ(left, Topology::is_tia) {
        all.push(Measurement {
            measure: "voltage of the sensed row (before any amplifier) to ground, scan stopped on a taxel, while it is pressed harder and harder",
            means: vec![
                "stays within some millivolts: an amplifier holds it (tia-...)",
                "rises with the load: a pull-down resistor (divider-...)",
            ],
        });
    }
    let pulled = |topology| topology == Topology::DividerPulledRows;
    if differ(left, pulled) {
        all.push(Measurement {
            measure: "resistance between a row that is not being read and ground, board powered, scan stopped, mat unplugged",
            means: vec![
                "some kilohms, as at the row that is read: every row keeps its pull-down",
                "open (above 1 Mohm), or next to nothing: rows are switched",
            ],
        });
    }
    let zero = |topology| topology == Topology::TiaZeroPotential;
    if differ(left, zero) {
        all.push(Measurement {
            measure: "voltage of a row that is not being read, scan stopped on a column, a taxel of both pressed hard",
            means: vec![
                "within some millivolts of 0 V: every row has its amplifier (tia-zero-potential)",
                "a good part of V_t: the row is open",
            ],
        });
    }
    all
}
