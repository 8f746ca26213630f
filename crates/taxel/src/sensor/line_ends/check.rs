//! Tables of line ends that no board can be: each is refused in words.

use super::{AxisSpec, EndSpec, EndTo, Reads};
use crate::Error;
use crate::sensor::spec::{PerLine, ReadoutSpec, SensorSpec, Topology};

/// The largest resistance that still is one, ohms; what is more is an open line, written `inf`.
const MAX_OHMS: f64 = 1e10;
const MIN_OHMS: f64 = 1e-3;

fn refuse(key: &str, problem: impl Into<String>, hint: &str) -> Error {
    Error::LineEnds {
        key: key.to_owned(),
        problem: problem.into(),
        hint: hint.to_owned(),
    }
}

/// Refuses them, and parts of a table where the topology is a named one.
pub(in super::super) fn check(sensor: &SensorSpec) -> Result<(), Error> {
    let readout = &sensor.readout;
    if readout.topology != Topology::LineEnds {
        return no_table(readout);
    }
    if readout.r_pull_down_ohms.is_some() {
        return Err(refuse(
            "readout.r_pull_down_ohms",
            "stands beside a table of line ends, which says it itself",
            "write it as `ohms` of an end to ground under [readout.sensed]",
        ));
    }
    let needs = |key, hint: &str| Error::MissingKey {
        key,
        hint: hint.to_owned(),
    };
    let reads = readout.reads.ok_or_else(|| {
        needs(
            "readout.reads",
            "\"voltage\" of the selected sensed line, or \"current\" into its amplifier",
        )
    })?;
    let driven = readout.driven.as_ref().ok_or_else(|| {
        let hint = "topology `line-ends` is a table: [readout.driven.selected] and [readout.driven.unselected] say what columns end in";
        needs("readout.driven", hint)
    })?;
    let sensed = readout.sensed.as_ref().ok_or_else(|| {
        let hint = "topology `line-ends` is a table: [readout.sensed.selected] and [readout.sensed.unselected] say what rows end in";
        needs("readout.sensed", hint)
    })?;
    numbers(sensor, driven, sensed)?;
    check_driven(driven, sensor.array.columns)?;
    check_sensed(sensed, sensor.array.rows, reads)?;
    followers(reads, driven, sensed)
}

/// A named topology has its ends already.
fn no_table(readout: &ReadoutSpec) -> Result<(), Error> {
    let written = [
        ("readout.driven", readout.driven.is_some()),
        ("readout.sensed", readout.sensed.is_some()),
        ("readout.reads", readout.reads.is_some()),
    ];
    match written.iter().find(|(_, is_there)| *is_there) {
        Some((key, _)) => Err(refuse(
            key,
            format!(
                "stands beside topology `{}`, which says how lines end already",
                readout.topology.name()
            ),
            "write topology = \"line-ends\" for a table of your own, or leave the table out",
        )),
        None => Ok(()),
    }
}

/// Resistances, and one number for all lines or one a line.
fn numbers(sensor: &SensorSpec, driven: &AxisSpec, sensed: &AxisSpec) -> Result<(), Error> {
    for (key, ends, lines, unit, unit_one) in [
        (
            KEYS[0],
            &driven.selected,
            sensor.array.columns,
            "columns",
            "column",
        ),
        (
            KEYS[1],
            &driven.unselected,
            sensor.array.columns,
            "columns",
            "column",
        ),
        (KEYS[2], &sensed.selected, sensor.array.rows, "rows", "row"),
        (
            KEYS[3],
            &sensed.unselected,
            sensor.array.rows,
            "rows",
            "row",
        ),
    ] {
        for end in ends {
            if let Some(PerLine::Each(values)) = &end.ohms
                && values.len() != lines
            {
                return Err(Error::ListLength {
                    key,
                    found: values.len(),
                    expected: lines,
                    unit,
                    unit_one,
                });
            }
            end_numbers(key, end)?;
        }
        if ends.iter().filter(|end| end.switched).count() > 1 {
            return Err(refuse(
                key,
                "has two ends behind one switch",
                "a switch leads to one place: write `switched = true` at one of them, and the other's own `ohms`",
            ));
        }
    }
    Ok(())
}

const KEYS: [&str; 4] = [
    "readout.driven.selected",
    "readout.driven.unselected",
    "readout.sensed.selected",
    "readout.sensed.unselected",
];

fn end_numbers(key: &str, end: &EndSpec) -> Result<(), Error> {
    let is_open = end.to == EndTo::Open;
    if is_open && (end.ohms.is_some() || end.switched) {
        return Err(refuse(
            key,
            "is open and has a resistance",
            "an open line leads nowhere: leave `ohms` and `switched` out",
        ));
    }
    if !is_open && end.ohms.is_none() && !end.switched {
        return Err(refuse(
            key,
            format!("leads to `{}` without any resistance", end.to.name()),
            "give `ohms` (an output pin has 20 to 100, a wire 0.1), or `switched = true` where it stands behind the line's switch",
        ));
    }
    let values = match &end.ohms {
        Some(PerLine::One(value)) => std::slice::from_ref(value),
        Some(PerLine::Each(values)) => values,
        None => &[],
    };
    let is_list = matches!(end.ohms, Some(PerLine::Each(_)));
    let good =
        |ohms: f64| (MIN_OHMS..=MAX_OHMS).contains(&ohms) || (is_list && ohms == f64::INFINITY);
    match values.iter().position(|&ohms| !good(ohms)) {
        Some(i) => Err(Error::OutOfRange {
            key: if is_list {
                format!("{key}.ohms[{i}]")
            } else {
                format!("{key}.ohms")
            },
            found: values[i],
            expected: "0.001 to 1e10",
            hint: "a resistor, in ohms; in a list, `inf` for a line that has none; for lines that all have none leave the end out",
        }),
        None => Ok(()),
    }
}

/// The first line without an end that any of `to` is, if there is one.
fn line_without(ends: &[EndSpec], lines: usize, to: &[EndTo]) -> Option<usize> {
    let holds = |line: usize| {
        let mut ends = ends.iter().filter(|end| to.contains(&end.to));
        ends.any(|end| end.ohms_at(line).is_finite())
    };
    (0..lines).find(|&line| !holds(line))
}

fn check_driven(driven: &AxisSpec, columns: usize) -> Result<(), Error> {
    if let Some(column) = line_without(&driven.selected, columns, &[EndTo::VTest]) {
        return Err(refuse(
            KEYS[0],
            format!("never leads to V_t at column {column}: nothing drives the taxels there"),
            "one end of the selected driven line must be `to = \"v_test\"`; where it is pulled low against rows held high, write the circuit upside down and record 2^bits - 1 less each count",
        ));
    }
    if driven.all().any(|end| end.to == EndTo::Amplifier) {
        return Err(refuse(
            "readout.driven",
            "leads to an amplifier",
            "amplifiers read sensed lines; a driven line leads to `v_test`, `ground`, `follower` or `open`",
        ));
    }
    Ok(())
}

fn check_sensed(sensed: &AxisSpec, rows: usize, reads: Reads) -> Result<(), Error> {
    let amplified = |ends: &[EndSpec]| ends.iter().any(|end| end.to == EndTo::Amplifier);
    match reads {
        Reads::Current => {
            if let Some(row) = line_without(&sensed.selected, rows, &[EndTo::Amplifier]) {
                return Err(refuse(
                    KEYS[2],
                    format!("has no virtual ground at row {row}, so that no current can be read"),
                    "one end of the selected sensed line must be `to = \"amplifier\"`, or write reads = \"voltage\"",
                ));
            }
        }
        Reads::Voltage => {
            if amplified(&sensed.selected) || amplified(&sensed.unselected) {
                return Err(refuse(
                    "readout.sensed",
                    "leads to an amplifier, but a voltage is read",
                    "write reads = \"current\" and r_feedback_ohms, or `to = \"ground\"`",
                ));
            }
            if let Some(row) = line_without(&sensed.selected, rows, &[EndTo::Ground]) {
                return Err(refuse(
                    KEYS[2],
                    format!(
                        "has no end to ground at row {row}: it would sit at V_t whatever is pressed"
                    ),
                    "a voltage is read over a pull-down: `to = \"ground\"` with its `ohms`",
                ));
            }
            if let Some(end) = sensed.selected.iter().find(|end| end.switched)
                && end.to == EndTo::Ground
                && end.ohms.is_none()
            {
                return Err(refuse(
                    KEYS[2],
                    "leads to ground behind its switch without a resistor, over which a voltage could be read",
                    "give the pull-down behind the switch as `ohms`; a switch that only leads to the converter draws nothing: leave it out",
                ));
            }
        }
    }
    if amplified(&sensed.selected)
        && sensed
            .selected
            .iter()
            .filter(|end| end.to == EndTo::Amplifier)
            .count()
            > 1
    {
        return Err(refuse(
            KEYS[2],
            "leads to two amplifiers",
            "one is read: leave the other out",
        ));
    }
    Ok(())
}

/// Followers repeat a voltage that is read, for lines that are not.
fn followers(reads: Reads, driven: &AxisSpec, sensed: &AxisSpec) -> Result<(), Error> {
    for (key, ends) in [(KEYS[0], &driven.selected), (KEYS[2], &sensed.selected)] {
        if ends.iter().any(|end| end.to == EndTo::Follower) {
            return Err(refuse(
                key,
                "leads to the follower",
                "the follower repeats the selected sensed line: only lines that are not selected can hang on it",
            ));
        }
    }
    let follows = |axis: &AxisSpec| axis.unselected.iter().any(|end| end.to == EndTo::Follower);
    if reads == Reads::Current && (follows(driven) || follows(sensed)) {
        return Err(refuse(
            "readout.reads",
            "is \"current\", and lines follow the voltage that is read: there is none but the amplifier's ground",
            "write `to = \"ground\"` in place of `to = \"follower\"`, or reads = \"voltage\"",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
