//! Every key of a sensor file known, with the nearest known one where it is not.

use super::{DiodePlace, EndTo, Rings, Shape, Topology};
use crate::Error;

/// Characters of a line that an error quotes.
const MAX_QUOTE: usize = 200;

const TABLES: [(&str, &[&str]); 22] = [
    (
        "",
        &[
            "format",
            "name",
            "array",
            "readout",
            "converter",
            "material",
            "uncertainty",
            "check",
            "screen",
            "provenance",
            "exported",
            "region",
        ],
    ),
    (
        "exported",
        &[
            "program",
            "unit",
            "unit_per_count",
            "threshold",
            "taxel_areas_mm2",
            "header",
        ],
    ),
    ("region", &["name", "boxes", "outline", "confidence"]),
    (
        "array",
        &[
            "rows",
            "columns",
            "pitch_mm",
            "taxel_area_mm2",
            "labels",
            "population",
            "positions",
            "geometry",
        ],
    ),
    (
        "array.geometry",
        &[
            "shape",
            "rings",
            "diameter_mm",
            "diameters_mm",
            "height_mm",
            "seam_gap_mm",
        ],
    ),
    (
        "readout",
        &[
            "topology",
            "v_test_volts",
            "r_feedback_ohms",
            "open_loop_gain",
            "r_mux_column_ohms",
            "r_mux_row_ohms",
            "r_source_ohms",
            "r_line_row_ohms",
            "r_line_column_ohms",
            "row_end",
            "column_end",
            "r_pull_down_ohms",
            "reads",
            "driven",
            "sensed",
            "diode",
        ],
    ),
    (
        "readout.diode",
        &[
            "place",
            "part",
            "saturation_amperes",
            "emission",
            "temperature_celsius",
        ],
    ),
    ("readout.driven", &["selected", "unselected"]),
    ("readout.sensed", &["selected", "unselected"]),
    ("readout.driven.selected", &["to", "ohms", "switched"]),
    ("readout.driven.unselected", &["to", "ohms", "switched"]),
    ("readout.sensed.selected", &["to", "ohms", "switched"]),
    ("readout.sensed.unselected", &["to", "ohms", "switched"]),
    (
        "converter",
        &[
            "bits",
            "full_scale_volts",
            "inverted",
            "offset_volts",
            "noise_counts",
            "memory",
            "floor_count",
            "scan_order",
        ],
    ),
    (
        "material",
        &[
            "g_zero_siemens",
            "factor",
            "exponent",
            "gain",
            "saturation_load_g",
            "bend",
            "spread",
            "sheet",
            "dynamic",
        ],
    ),
    ("material.sheet", &["resistance_ohms", "contact_factor"]),
    ("material.bend", &["ln_load_g", "ln_siemens"]),
    (
        "material.dynamic",
        &[
            "lag_weight",
            "lag_secs",
            "play_weight",
            "play_g",
            "period_secs",
        ],
    ),
    (
        "uncertainty",
        &[
            "model_share",
            "model_floor_g",
            "fit_share",
            "factor_95",
            "presses",
            "frame_share",
            "frame_floor_g",
            "spread_error",
            "sheet_share",
            "material_factor",
        ],
    ),
    (
        "check",
        &[
            "scale",
            "conductance_scale",
            "scale_standard_error",
            "offset_g",
            "presses",
            "date",
            "verdict",
            "calibrated",
        ],
    ),
    (
        "screen",
        &[
            "dead_rows",
            "dead_columns",
            "flickering_rows",
            "flickering_columns",
            "low_counts",
            "high_counts",
            "repair",
            "ceiling_is_load",
        ],
    ),
    (
        "provenance",
        &[
            "program",
            "date",
            "data",
            "presses",
            "cross_validated_error_g",
            "cross_validation",
            "standard_errors",
            "held",
            "findings",
        ],
    ),
];

/// Lists of fixed length: table, key, both, numbers, what they are.
const LISTS: [(&str, &str, &str, usize, &str); 3] = [
    (
        "array",
        "pitch_mm",
        "array.pitch_mm",
        2,
        "the distance between rows, and that between columns",
    ),
    (
        "array.geometry",
        "diameters_mm",
        "array.geometry.diameters_mm",
        2,
        "the diameter at the first ring, and that at the last",
    ),
    (
        "material",
        "spread",
        "material.spread",
        3,
        "along the column, along the row, diagonal",
    ),
];

/// A hint that names the nearest of `known`, and all of them.
pub(super) fn nearest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> String {
    let all: Vec<&str> = known.collect();
    let best = all
        .iter()
        .map(|name| (strsim::jaro_winkler(word, name), *name))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((score, name)) if score > 0.75 => {
            format!("did you mean `{name}`? (known: {})", all.join(", "))
        }
        _ => format!("known: {}", all.join(", ")),
    }
}

/// What is wrong and where; of a line that nobody could read, only the first part.
pub(super) fn not_toml(error: &toml::de::Error) -> Error {
    let words = error.to_string();
    let cut = |line: &str| match line.char_indices().nth(MAX_QUOTE) {
        Some((end, _)) => format!("{} …", &line[..end]),
        None => line.to_owned(),
    };
    let lines: Vec<String> = words.trim_end().lines().map(cut).collect();
    let hint = if words.contains("missing field") {
        "\nhint: this table needs that key; docs/formats.md says what each means, with its unit"
    } else {
        ""
    };
    Error::Toml {
        message: lines.join("\n") + hint,
    }
}

/// Refuses a key that nobody reads, a topology that is none, and words of line ends that are none.
pub(super) fn check(text: &str) -> Result<(), Error> {
    let root: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| not_toml(&error))?;
    table_keys(text, "", &root)?;
    for (table, key, path, expected, meaning) in LISTS {
        let mut names = table.split('.');
        let first = names.next().and_then(|name| root.get(name));
        let table = names.fold(first, |table, name| table?.get(name));
        let list = table.and_then(|table| table.get(key));
        if let Some(list) = list.and_then(|list| list.as_array())
            && list.len() != expected
        {
            return Err(Error::Numbers {
                key: path,
                found: list.len(),
                expected,
                meaning,
            });
        }
    }
    if let Some(geometry) = root.get("array").and_then(|array| array.get("geometry")) {
        body(geometry)?;
    }
    match root.get("readout").and_then(|readout| readout.as_table()) {
        Some(readout) => read_out(readout),
        None => Ok(()),
    }
}

/// The words of a body that an array lies on.
fn body(geometry: &toml::Value) -> Result<(), Error> {
    let shapes = Shape::ALL.map(Shape::name);
    let rings = Rings::ALL.map(Rings::name);
    for (key, known) in [("shape", &shapes[..]), ("rings", &rings)] {
        let found = geometry.get(key).and_then(|value| value.as_str());
        if let Some(found) = found.filter(|found| !known.contains(found)) {
            return Err(Error::Geometry {
                key,
                problem: format!("is `{found}`, which is none of its words"),
                hint: nearest(found, known.iter().copied()),
            });
        }
    }
    Ok(())
}

/// The words of a read-out.
fn read_out(readout: &toml::Table) -> Result<(), Error> {
    let known = || {
        let all = Topology::ALL.iter().chain(&[Topology::LineEnds]);
        all.map(|known| known.name())
    };
    if let Some(found) = readout.get("topology").and_then(|word| word.as_str())
        && !known().any(|name| name == found)
    {
        return Err(Error::UnknownTopology {
            found: found.to_owned(),
            hint: nearest(found, known()),
        });
    }
    let word = |key: String, value: Option<&toml::Value>, known: &[&str]| match value
        .and_then(|value| value.as_str())
    {
        Some(found) if !known.contains(&found) => Err(Error::LineEnds {
            key,
            problem: format!("is `{found}`, which is none of its words"),
            hint: nearest(found, known.iter().copied()),
        }),
        _ => Ok(()),
    };
    word(
        "readout.reads".to_owned(),
        readout.get("reads"),
        &["voltage", "current"],
    )?;
    for end in ["row_end", "column_end"] {
        word(
            format!("readout.{end}"),
            readout.get(end),
            &["first", "last"],
        )?;
    }
    let diode = readout.get("diode").and_then(|diode| diode.get("place"));
    let diode_places = DiodePlace::ALL.map(DiodePlace::name);
    word("readout.diode.place".to_owned(), diode, &diode_places)?;
    let places = EndTo::ALL.map(EndTo::name);
    for (axis, state) in AXES {
        let ends = readout.get(axis).and_then(|axis| axis.get(state));
        let ends = ends.map_or(&[][..], |ends| {
            ends.as_array()
                .map_or_else(|| std::slice::from_ref(ends), Vec::as_slice)
        });
        for end in ends {
            word(format!("readout.{axis}.{state}.to"), end.get("to"), &places)?;
        }
    }
    Ok(())
}

const AXES: [(&str, &str); 4] = [
    ("driven", "selected"),
    ("driven", "unselected"),
    ("sensed", "selected"),
    ("sensed", "unselected"),
];

fn table_keys(text: &str, name: &str, table: &toml::Table) -> Result<(), Error> {
    let Some((_, known)) = TABLES.iter().find(|(known, _)| *known == name) else {
        return Ok(());
    };
    for (key, value) in table {
        if !known.contains(&key.as_str()) {
            return Err(Error::UnknownKey {
                table: match name {
                    "" => "the top level".to_owned(),
                    name => format!("[{name}]"),
                },
                key: key.clone(),
                line: line_of(text, name, key),
                hint: nearest(key, known.iter().copied()),
            });
        }
        let path = if name.is_empty() {
            key.clone()
        } else {
            format!("{name}.{key}")
        };
        // A list of tables is looked through as each of them.
        let several = value.as_array().map_or(&[][..], Vec::as_slice);
        for inner in std::iter::once(value).chain(several) {
            if let Some(inner) = inner.as_table() {
                table_keys(text, &path, inner)?;
            }
        }
    }
    Ok(())
}

/// The line, from 1, on which a key of a table stands: below the table's own header, or dotted from above. Of a table that
/// is written inline its own line.
fn line_of(text: &str, table: &str, key: &str) -> usize {
    let plain = |path: &str| path.replace(['"', '\'', ' '], "");
    let joined = |table: &str, key: &str| {
        if table.is_empty() {
            key.to_owned()
        } else {
            format!("{table}.{key}")
        }
    };
    let wanted = joined(table, key);
    let (mut header, mut inline) = (String::new(), None);
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        let path = if line.starts_with('[') {
            header = plain(line.trim_start_matches('[').split(']').next().unwrap_or(""));
            header.clone()
        } else if let Some((left, _)) = line.split_once('=') {
            joined(&header, &plain(left))
        } else {
            continue;
        };
        if path == wanted || path.starts_with(&format!("{wanted}.")) {
            return i + 1;
        }
        if path == table && !line.starts_with('[') {
            inline = Some(i + 1);
        }
    }
    inline.unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_found_in_its_own_table() {
        let text =
            "name = \"a\"\n[array]\nrows = 4\n[screen]\nrows = 3\n[material.bend]\nknots = [1]\n";
        assert_eq!(line_of(text, "array", "rows"), 3);
        assert_eq!(line_of(text, "screen", "rows"), 5);
        assert_eq!(line_of(text, "", "name"), 1);
        assert_eq!(line_of(text, "material", "bend"), 6);
        assert_eq!(line_of(text, "material.bend", "knots"), 7);
        let dotted = "name = \"a\"\narray . rows = 4\nscreen = { rows = 3 }\n";
        assert_eq!(line_of(dotted, "array", "rows"), 2);
        assert_eq!(line_of(dotted, "screen", "rows"), 3);
    }
}
