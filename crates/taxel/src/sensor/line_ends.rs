//! A read-out as a table: what driven and sensed lines end in, selected and not. The named read-outs are presets of it.

mod check;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::spec::{PerLine, ReadoutSpec, Topology};
pub(super) use check::check;

/// Where an end of a line leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum EndTo {
    /// The test voltage V_t.
    VTest,
    /// Ground.
    Ground,
    /// The virtual ground of an inverting amplifier with `r_feedback_ohms`; of sensed lines.
    Amplifier,
    /// A follower of the voltage that is read; of unselected lines.
    Follower,
    /// Nowhere.
    Open,
}

impl EndTo {
    /// All of them.
    pub const ALL: [EndTo; 5] = [
        EndTo::VTest,
        EndTo::Ground,
        EndTo::Amplifier,
        EndTo::Follower,
        EndTo::Open,
    ];

    /// Its word in sensor.toml.
    pub fn name(self) -> &'static str {
        match self {
            EndTo::VTest => "v_test",
            EndTo::Ground => "ground",
            EndTo::Amplifier => "amplifier",
            EndTo::Follower => "follower",
            EndTo::Open => "open",
        }
    }
}

/// What is read of the selected sensed line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Reads {
    /// Its voltage: over the resistor behind its switch, or the line's own where none is behind one.
    Voltage,
    /// The current into its amplifier.
    Current,
}

/// One end of every line of an axis, in one state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EndSpec {
    /// Where it leads to.
    pub to: EndTo,
    /// Its resistance, ohms; infinite where a line has none. Behind a switch, what is there besides the switch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ohms: Option<PerLine>,
    /// Whether it stands behind the line's switch, `r_mux_column_ohms` or `r_mux_row_ohms`, which a calibration can find.
    #[serde(default, skip_serializing_if = "is_false")]
    pub switched: bool,
}

fn is_false(value: &bool) -> bool {
    !value
}

impl EndSpec {
    /// An end of its own, the same at every line or one by one.
    pub fn fixed(to: EndTo, ohms: PerLine) -> Self {
        Self {
            to,
            ohms: Some(ohms),
            switched: false,
        }
    }

    /// An end behind the line's switch, with nothing else in the way.
    pub fn switched(to: EndTo) -> Self {
        Self {
            to,
            ohms: None,
            switched: true,
        }
    }

    /// Its own resistance at line `i`, without a switch.
    pub fn ohms_at(&self, i: usize) -> f64 {
        self.ohms.as_ref().map_or(0.0, |ohms| ohms.at(i))
    }
}

/// The ends of the lines of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AxisSpec {
    /// Of the selected line.
    #[serde(serialize_with = "write_ends", deserialize_with = "read_ends")]
    pub selected: Vec<EndSpec>,
    /// Of every other line; none: open.
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        serialize_with = "write_ends",
        deserialize_with = "read_ends"
    )]
    pub unselected: Vec<EndSpec>,
}

impl AxisSpec {
    /// These ends.
    pub fn new(selected: Vec<EndSpec>, unselected: Vec<EndSpec>) -> Self {
        Self {
            selected,
            unselected,
        }
    }

    /// Whether any end stands behind a switch.
    pub fn is_switched(&self) -> bool {
        self.all().any(|end| end.switched)
    }

    /// Whether lines that are not selected are left open.
    pub fn is_open(&self) -> bool {
        self.unselected.iter().all(|end| end.to == EndTo::Open)
    }

    fn all(&self) -> impl Iterator<Item = &EndSpec> {
        self.selected.iter().chain(&self.unselected)
    }
}

/// One end is a table, several are a list of tables.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneOrMany {
    One(EndSpec),
    Many(Vec<EndSpec>),
}

fn read_ends<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<EndSpec>, D::Error> {
    Ok(match OneOrMany::deserialize(from)? {
        OneOrMany::One(end) => vec![end],
        OneOrMany::Many(ends) => ends,
    })
}

fn write_ends<S: Serializer>(ends: &[EndSpec], to: S) -> Result<S::Ok, S::Error> {
    match ends {
        [end] => end.serialize(to),
        ends => ends.serialize(to),
    }
}

/// What a read-out is made of, whether it was named or written as a table.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadoutTable {
    /// What is read.
    pub reads: Reads,
    /// The columns.
    pub driven: AxisSpec,
    /// The rows.
    pub sensed: AxisSpec,
}

impl ReadoutTable {
    /// The table of a read-out that was checked.
    pub(super) fn of(said: &ReadoutSpec) -> Self {
        let switched = EndSpec::switched;
        let ground = || vec![switched(EndTo::Ground)];
        let pull_down = || EndSpec {
            ohms: said.r_pull_down_ohms.map(PerLine::One),
            ..switched(EndTo::Ground)
        };
        let amplifier = || vec![switched(EndTo::Amplifier)];
        let (sensed, unselected) = match said.topology {
            Topology::LineEnds => {
                let none = || AxisSpec::new(Vec::new(), Vec::new());
                return Self {
                    reads: said.reads.unwrap_or(Reads::Voltage),
                    driven: said.driven.clone().unwrap_or_else(none),
                    sensed: said.sensed.clone().unwrap_or_else(none),
                };
            }
            Topology::TiaGroundedColumns => (AxisSpec::new(amplifier(), Vec::new()), ground()),
            Topology::TiaZeroPotential => (AxisSpec::new(amplifier(), amplifier()), ground()),
            Topology::DividerPulledRows => (
                AxisSpec::new(vec![pull_down()], vec![pull_down()]),
                Vec::new(),
            ),
            divider => {
                let sensed = AxisSpec::new(vec![pull_down()], Vec::new());
                let columns = match divider {
                    Topology::DividerFloating => Vec::new(),
                    Topology::DividerVoltageFeedback => vec![switched(EndTo::Follower)],
                    _ => ground(),
                };
                (sensed, columns)
            }
        };
        Self {
            reads: if said.topology.is_tia() {
                Reads::Current
            } else {
                Reads::Voltage
            },
            driven: AxisSpec::new(vec![switched(EndTo::VTest)], unselected),
            sensed,
        }
    }

    /// From the selected sensed line to ground by every way but through switches, ohms: the mean over the rows.
    pub(super) fn pull_down_ohms(&self, rows: usize) -> f64 {
        (0..rows).map(|r| self.pull_down_ohms_at(r)).sum::<f64>() / rows.max(1) as f64
    }

    /// The same of one row.
    pub(crate) fn pull_down_ohms_at(&self, row: usize) -> f64 {
        let ends = self.sensed.selected.iter();
        let ends = ends.filter(|end| end.to == EndTo::Ground);
        1.0 / ends.map(|end| 1.0 / end.ohms_at(row)).sum::<f64>()
    }
}

impl std::fmt::Display for ReadoutTable {
    /// `columns v_test 45 Ω, else ground 30 Ω; rows ground 1000 Ω, else the same`.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        for (i, (name, axis)) in [("columns", &self.driven), ("rows", &self.sensed)]
            .into_iter()
            .enumerate()
        {
            let before = if i == 0 { "" } else { "; " };
            write!(f, "{before}{name} ")?;
            write_words(f, &axis.selected)?;
            if axis.is_open() {
                write!(f, ", else open")?;
            } else if axis.selected == axis.unselected {
                write!(f, ", else the same")?;
            } else {
                write!(f, ", else ")?;
                write_words(f, &axis.unselected)?;
            }
        }
        Ok(())
    }
}

fn write_words(f: &mut std::fmt::Formatter, ends: &[EndSpec]) -> std::fmt::Result {
    for (i, end) in ends.iter().enumerate() {
        let before = if i == 0 { "" } else { " and " };
        let switch = if end.switched {
            " behind the switch"
        } else {
            ""
        };
        write!(f, "{before}{}{switch}", end.to.name())?;
        match &end.ohms {
            Some(PerLine::One(ohms)) => write!(f, " {ohms} Ω")?,
            Some(PerLine::Each(ohms)) => {
                let finite = || ohms.iter().copied().filter(|ohms| ohms.is_finite());
                let least = finite().fold(f64::INFINITY, f64::min);
                let most = finite().fold(0.0, f64::max);
                write!(f, " {least} to {most} Ω")?;
            }
            None => {}
        }
    }
    Ok(())
}
