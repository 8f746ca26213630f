//! The keys of a header: those that were met in exports, and what they are called in other languages.

use super::super::header::Pairs;

/// Keys that were met, in small letters.
const KEYS: [&str; 32] = [
    "data_type",
    "version",
    "hardware",
    "map_version",
    "hw_type",
    "versapogofsx",
    "filename",
    "sensor_type",
    "rows",
    "cols",
    "row_spacing",
    "col_spacing",
    "sensel_area",
    "noise_threshold",
    "seconds_per_frame",
    "micro_second",
    "time",
    "scale_factor",
    "exponent",
    "saturation_pressure",
    "calibration_info",
    "calibration_point_1",
    "calibration_point_2",
    "calibration_mode_1",
    "calibration_mode_2",
    "sensitivity",
    "map_index",
    "submap",
    "comments",
    "start_frame",
    "end_frame",
    "units",
];
/// The same of keys that only say how a picture is turned.
const TURNED: [&str; 2] = ["mirror_row", "mirror_col"];
/// The keys that a frame is understood by, in other languages.
const OTHERS: [(&str, &[&str]); 7] = [
    (
        "rows",
        &[
            "zeilen", "reihen", "lignes", "filas", "righe", "linhas", "rijen",
        ],
    ),
    (
        "cols",
        &[
            "columns", "spalten", "colonnes", "columnas", "colonne", "colunas", "kolommen",
        ],
    ),
    (
        "units",
        &[
            "einheit",
            "einheiten",
            "unité",
            "unités",
            "unite",
            "unites",
            "unidad",
            "unidades",
            "unità",
            "unita",
            "unidade",
            "eenheid",
            "eenheden",
        ],
    ),
    ("row_spacing", &["zeilenabstand", "reihenabstand"]),
    ("col_spacing", &["spaltenabstand"]),
    ("sensel_area", &["sensorfläche", "sensorflaeche"]),
    ("seconds_per_frame", &["sekunden_pro_bild"]),
];

/// Whether a word, in small letters, is a key that was met.
pub(in super::super) fn is_known(word: &str) -> bool {
    KEYS.contains(&word) || TURNED.contains(&word)
}

/// Whether a word is a key, in capitals, that was met.
pub(in super::super) fn is_key(word: &str) -> bool {
    let is_part = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
    word.chars().all(is_part) && is_known(&word.to_lowercase())
}

/// Gives keys of other languages their English names.
pub(super) fn translate(pairs: &mut Pairs) {
    for (key, others) in OTHERS {
        others.iter().for_each(|other| pairs.rename(other, key));
    }
}
