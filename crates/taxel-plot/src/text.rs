//! How wide a text will be, and where to break it.

/// Advance widths of U+0020 to U+007E in the shipped font, in thousandths of the type size.
const ADVANCES: [u16; 95] = [
    281, 278, 403, 631, 638, 812, 639, 222, 362, 362, 500, 659, 280, 460, 276, 357, 625, 464, 605,
    636, 642, 608, 624, 571, 616, 624, 276, 280, 659, 659, 659, 507, 936, 676, 651, 727, 719, 598,
    587, 743, 740, 264, 543, 652, 562, 889, 753, 761, 635, 761, 639, 638, 642, 741, 676, 949, 642,
    665, 625, 362, 357, 362, 469, 452, 497, 564, 621, 558, 621, 582, 361, 609, 591, 237, 237, 544,
    237, 869, 585, 597, 609, 609, 372, 523, 364, 581, 557, 812, 540, 557, 541, 362, 327, 362, 659,
];
/// The same for every other character.
const OTHER_ADVANCE: u16 = 660;

/// Width of `text` at type size `size`; never less than it is drawn with in the shipped font, but for rare letters.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let thousandths: u64 = text.chars().map(|c| u64::from(advance(c))).sum();
    thousandths as f64 * size / 1000.0
}

fn advance(character: char) -> u16 {
    (character as usize)
        .checked_sub(0x20)
        .and_then(|i| ADVANCES.get(i))
        .copied()
        .unwrap_or(OTHER_ADVANCE)
}

/// The widest of `labels`.
pub(crate) fn widest(labels: &[String], size: f64) -> f64 {
    labels
        .iter()
        .map(|label| width(label, size))
        .fold(0.0, f64::max)
}

/// `text` in lines no wider than `limit`: broken between words, and within a word that is wider alone.
pub(crate) fn wrap(text: &str, size: f64, limit: f64) -> Vec<String> {
    wrap_by(text, limit, &|text| width(text, size))
}

/// The same with another measure of a text's width.
pub(crate) fn wrap_by(text: &str, limit: f64, width: &dyn Fn(&str) -> f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let joined = if line.is_empty() {
                word.to_owned()
            } else {
                format!("{line} {word}")
            };
            if width(&joined) <= limit {
                line = joined;
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            line = break_word(word, limit, width, &mut lines);
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines
}

/// Pushes what of `word` fills whole lines, and gives back the rest.
fn break_word(
    word: &str,
    limit: f64,
    width: &dyn Fn(&str) -> f64,
    lines: &mut Vec<String>,
) -> String {
    let mut rest = String::new();
    for character in word.chars() {
        rest.push(character);
        if width(&rest) > limit && rest.chars().count() > 1 {
            rest.pop();
            lines.push(std::mem::replace(&mut rest, character.to_string()));
        }
    }
    rest
}

/// `text` cut with an ellipsis so that it is no wider than `limit`.
pub(crate) fn shorten(text: &str, size: f64, limit: f64) -> String {
    if width(text, size) <= limit {
        return text.to_owned();
    }
    let mut kept = String::new();
    for character in text.chars() {
        kept.push(character);
        if width(&kept, size) + width("...", size) > limit {
            kept.pop();
            break;
        }
    }
    kept.truncate(kept.trim_end().len());
    kept + "…"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_no_wider_than_the_limit() {
        let text =
            "before cross-talk was removed, a-very-long-file-name-without-any-blank.txt and more";
        let lines = wrap(text, 10.0, 90.0);
        assert!(lines.len() > 3);
        assert!(lines.iter().all(|line| width(line, 10.0) <= 90.0));
        let letters = |s: &str| s.chars().filter(|c| !c.is_whitespace()).collect::<String>();
        assert_eq!(letters(&lines.concat()), letters(text));
    }

    #[test]
    fn a_text_that_fits_stays_as_it_is() {
        assert_eq!(wrap("frame 12", 10.0, 90.0), ["frame 12"]);
        assert_eq!(shorten("frame 12", 10.0, 90.0), "frame 12");
        assert!(shorten("frame 12 of many", 10.0, 50.0).ends_with('…'));
        assert!(wrap("", 10.0, 90.0).is_empty());
    }
}
