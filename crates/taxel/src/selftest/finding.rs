//! What can be wrong, where, and what to do about it.

use std::fmt;

use crate::screen::Axis;

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Fault {
    /// All readings of a line at the most conductive end: it touches the supply, or the line it is measured against.
    LineAtSupply,
    /// A line exactly at the least conductive end, without the noise that an open one shows: it touches ground.
    LineAtGround,
    /// A line never answers.
    LineOpen,
    /// A line answers up to a place, and never beyond it.
    LineBroken,
    /// A line answers clearly less from a place on, or the farther the less, than the lines beside it.
    LineResists,
    /// A line at an edge never answered; it has only one neighbour to vouch for it.
    LineSilent,
    /// Two neighbouring lines read the same.
    LinesShorted,
    /// A line comes and goes.
    LineFlickering,
    /// Most taxels of a line are noisy.
    LineNoisy,
    /// A taxel conducts without a load.
    TaxelShorted,
    /// A taxel never changes, or is too often at an end of the converter.
    TaxelStuck,
    /// A taxel never answers although its surroundings do.
    TaxelOpen,
    /// A taxel comes and goes.
    TaxelFlickering,
    /// A taxel is noisier than the others.
    TaxelNoisy,
    /// Single readings at an end of the converter, on no taxel in particular.
    StrayReadings,
    /// A reading keeps a share of the one before.
    Settling,
    /// The readings swing with the mains.
    Hum,
    /// The converter never gives some codes.
    Codes,
    /// Taxels that were not pressed in the rubbed recording.
    NotPressed,
}

impl Fault {
    /// Every fault, in the order in which they go before one another.
    pub const ALL: [Fault; 19] = [
        Fault::LineAtSupply,
        Fault::LineAtGround,
        Fault::LineOpen,
        Fault::LineBroken,
        Fault::LineResists,
        Fault::LineSilent,
        Fault::LinesShorted,
        Fault::LineFlickering,
        Fault::LineNoisy,
        Fault::TaxelShorted,
        Fault::TaxelStuck,
        Fault::TaxelOpen,
        Fault::TaxelFlickering,
        Fault::TaxelNoisy,
        Fault::StrayReadings,
        Fault::Settling,
        Fault::Hum,
        Fault::Codes,
        Fault::NotPressed,
    ];

    /// The word for it, for scripts.
    pub fn word(self) -> &'static str {
        match self {
            Fault::LineAtSupply => "line-at-supply",
            Fault::LineAtGround => "line-at-ground",
            Fault::LineOpen => "line-open",
            Fault::LineBroken => "line-broken",
            Fault::LineResists => "line-resists",
            Fault::LineSilent => "line-silent",
            Fault::LinesShorted => "lines-shorted",
            Fault::LineFlickering => "line-flickering",
            Fault::LineNoisy => "line-noisy",
            Fault::TaxelShorted => "taxel-shorted",
            Fault::TaxelStuck => "taxel-stuck",
            Fault::TaxelOpen => "taxel-open",
            Fault::TaxelFlickering => "taxel-flickering",
            Fault::TaxelNoisy => "taxel-noisy",
            Fault::StrayReadings => "stray-readings",
            Fault::Settling => "settling",
            Fault::Hum => "hum",
            Fault::Codes => "codes",
            Fault::NotPressed => "not-pressed",
        }
    }

    /// The same for people, as it follows the place.
    pub fn words(self) -> &'static str {
        match self {
            Fault::LineAtSupply => "shorted to the supply",
            Fault::LineAtGround => "shorted to ground",
            Fault::LineOpen | Fault::TaxelOpen => "open",
            Fault::LineBroken => "broken",
            Fault::LineResists => "resists",
            Fault::LineSilent => "silent",
            Fault::LinesShorted => "shorted together",
            Fault::LineFlickering | Fault::TaxelFlickering => "flickering",
            Fault::LineNoisy | Fault::TaxelNoisy => "noisy",
            Fault::TaxelShorted => "shorted",
            Fault::TaxelStuck => "stuck",
            Fault::StrayReadings => "stray readings",
            Fault::Settling => "settling time too short",
            Fault::Hum => "mains hum",
            Fault::Codes => "codes that never occur",
            Fault::NotPressed => "not pressed",
        }
    }
}

/// Where something is wrong. Rows and columns count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// A line.
    Line {
        /// Row or column.
        axis: Axis,
        /// Which.
        index: usize,
    },
    /// A line between two of its taxels.
    Along {
        /// Row or column.
        axis: Axis,
        /// Which.
        index: usize,
        /// The last taxel before the place, counted along the line.
        after: usize,
        /// The first beyond it.
        before: usize,
    },
    /// A line and the next one.
    Pair {
        /// Rows or columns.
        axis: Axis,
        /// The first of the two.
        first: usize,
    },
    /// A taxel.
    Taxel {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// The whole array, or its read-out.
    Array,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line { axis, index } => write!(f, "{axis} {index}"),
            Place::Along {
                axis,
                index,
                after,
                before,
            } => {
                let (least, most) = (after.min(before), after.max(before));
                let crossing = axis.other();
                write!(f, "{axis} {index}, between {crossing}s {least} and {most}")
            }
            Place::Pair { axis, first } => write!(f, "{axis}s {first} and {}", first + 1),
            Place::Taxel { row, column } => write!(f, "taxel at row {row}, column {column}"),
            Place::Array => f.write_str("array"),
        }
    }
}

/// One thing that is wrong, with the evidence for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What.
    pub fault: Fault,
    /// Where.
    pub place: Place,
    /// The taxels affected, row · columns + column, ascending; all of them for faults of the whole read-out.
    pub taxels: Vec<usize>,
    /// What was seen, in numbers.
    pub evidence: String,
    /// What to do.
    pub advice: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            fault,
            place,
            evidence,
            advice,
            ..
        } = self;
        write!(f, "{place}: {} – {advice} ({evidence})", fault.words())
    }
}

/// What to do about a fault at a place.
pub(super) fn advice(fault: Fault, place: Place) -> String {
    let line = match place {
        Place::Line { axis, index } | Place::Along { axis, index, .. } => {
            format!("{axis} line {index}")
        }
        Place::Pair { axis, first } => format!("{axis} lines {first} and {}", first + 1),
        Place::Taxel { row, column } => format!("row {row} and column {column}"),
        Place::Array => String::new(),
    };
    match fault {
        Fault::LineAtSupply => {
            format!("look for a bridge from {line} to the supply or to a driven line")
        }
        Fault::LineAtGround => format!("look for a bridge from {line} to ground, then for a break"),
        Fault::LineOpen => format!("check the joint of {line} at the connector, then its switch"),
        Fault::LineBroken => format!("look for a break in {line} there, and bridge it"),
        Fault::LineResists => {
            format!("look for a crack, a thin stretch or a poor joint in {line}; measure along it with a multimeter")
        }
        Fault::LineSilent => format!(
            "press it and test again; if it stays silent, check the joint of {line} at the connector"
        ),
        Fault::LinesShorted => {
            format!("look for a solder bridge or a stray strand between {line}, from the connector on")
        }
        Fault::LineFlickering => {
            format!("solder the joint of {line} again, or clean its contact at the connector")
        }
        Fault::LineNoisy => format!("check the joint of {line}, and its distance from clocks and mains"),
        Fault::TaxelShorted => format!("separate the crossing of {line}: the lines touch through the material"),
        Fault::TaxelStuck => {
            format!("look at the crossing of {line}; if it moves with the scan, suspect the converter")
        }
        Fault::TaxelOpen => format!("look for a gap in the material, or glue, at the crossing of {line}"),
        Fault::TaxelFlickering => format!("press the crossing of {line} together: its contact comes and goes"),
        Fault::TaxelNoisy => format!("look at the contact at the crossing of {line}"),
        Fault::StrayReadings => "reseat the connectors, then check the converter's wiring and supply".to_owned(),
        Fault::Settling => {
            "wait longer after switching a line, before the conversion; or give `memory` in the sensor file".to_owned()
        }
        Fault::Hum => "ground the supply and the shield, and keep the lines away from mains cables".to_owned(),
        Fault::Codes => "check the converter's data lines and its resolution in the sensor file".to_owned(),
        Fault::NotPressed => "rub over them and test again: nothing is known about them".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_differ_and_the_list_is_in_order() {
        let mut words: Vec<&str> = Fault::ALL.iter().map(|fault| fault.word()).collect();
        assert!(Fault::ALL.is_sorted());
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), Fault::ALL.len());
    }

    #[test]
    fn a_finding_says_where_what_why_and_what_to_do() {
        let place = Place::Line {
            axis: Axis::Row,
            index: 11,
        };
        let finding = Finding {
            fault: Fault::LineOpen,
            place,
            taxels: vec![],
            evidence: "64 taxels never responded".to_owned(),
            advice: advice(Fault::LineOpen, place),
        };
        assert_eq!(
            finding.to_string(),
            "row 11: open – check the joint of row line 11 at the connector, then its switch \
             (64 taxels never responded)"
        );
    }
}
