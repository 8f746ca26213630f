//! What stands before the platforms: words of who and when, and the forces of both feet over time.

use super::super::cells::number_of;
use super::super::text_file::TextFile;
use super::{FORMAT, is_platform, unit_ms};
use crate::error::Error;

/// Frames of forces before those of the platform at most: they are held while the file is read.
const MAX_FORCES: usize = 1 << 20;
/// Words of the left foot's column, and of the right one's, in languages met and others.
#[rustfmt::skip]
const FEET: [[&str; 12]; 2] = [
    ["li", "links", "linke", "linker", "left", "l", "gauche", "izquierda", "izq", "sinistra", "sx", "esquerda"],
    ["re", "rechts", "rechte", "rechter", "right", "r", "droite", "derecha", "der", "destra", "dx", "direita"],
];

/// What stands before the platform: words, and the sum of both feet's forces by milliseconds.
pub(super) fn read_forces(text: &mut TextFile) -> Result<(String, Vec<(f64, f64)>), Error> {
    let (mut header, mut forces) = (Vec::new(), Vec::new());
    let mut force_columns: Vec<usize> = Vec::new();
    let mut unit = 1.0;
    while text.advance()? {
        let words = text.words();
        let line = words.trim();
        if is_platform(text.line()) {
            return Ok((header.join("\n"), forces));
        }
        // Names with a comma may stand between quotes.
        let cells: Vec<&str> = words
            .split('\t')
            .map(|cell| cell.trim().trim_matches('"'))
            .collect();
        if !force_columns.is_empty()
            && let Some(time) = number_of(cells[0])
        {
            let each = force_columns.iter().map(|&at| number_of(cells.get(at)?));
            // A step that it has given to neither foot counts as none.
            let each = each.map(|force| force.filter(|newtons| *newtons > 0.0));
            if let Some(newtons) = each.sum::<Option<f64>>()
                && forces.len() < MAX_FORCES
            {
                forces.push((time * unit, newtons));
            }
            continue;
        }
        if let Some(own) = unit_ms(cells[0]).filter(|_| cells.len() > 2) {
            unit = own;
            force_columns = feet(text, &cells)?;
        }
        header.push(line.to_owned());
    }
    let hint = "only exports with the raw data of the platform hold frames";
    Err(text.wrong(FORMAT, "a line `Platform {`", hint))
}

/// The two columns of the feet's forces: those in newtons whose names say a side, each of one foot, or the only two that are of no
/// part of something, as of a butterfly.
fn feet(text: &TextFile, names: &[&str]) -> Result<Vec<usize>, Error> {
    let is_force = |name: &str| name.ends_with(",N") && !name.contains('.');
    let columns: Vec<usize> = (0..names.len()).filter(|&at| is_force(names[at])).collect();
    let of = |words: &[&str]| -> Vec<usize> {
        let own = columns.iter().copied();
        own.filter(|&at| {
            let name = names[at].to_lowercase();
            let mut parts = name.split(|c: char| !c.is_alphanumeric());
            parts.any(|part| words.contains(&part))
        })
        .collect()
    };
    if let ([left], [right]) = (&of(&FEET[0])[..], &of(&FEET[1])[..])
        && left != right
    {
        return Ok(vec![*left, *right]);
    }
    match columns.len() {
        0 | 2 => Ok(columns),
        found => {
            let found = format!("{found} columns in newtons");
            let hint = "which of them are the feet's forces is not told by their names; rename them to `Left,N` and `Right,N`";
            let expected = "one of the left and one of the right foot";
            Err(text.wrong_at(0, FORMAT, found, expected, hint))
        }
    }
}
