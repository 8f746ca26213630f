//! What a picture looks like: its title, range, size, and axes.

use std::path::Path;
use std::str::FromStr;

use taxel_plot::{Extent, Format, Picture};

use super::super::positive::positive;
use crate::error::Error;

/// Pixels of a PNG per inch where nobody asks: two a point.
const DOTS_PER_INCH: u32 = 144;
/// The same of a movie, whose every pixel costs time and room.
const DOTS_OF_MOVIE: u32 = 96;
/// The largest number that an axis is drawn with.
const LARGEST: f64 = 1e300;
/// A range is at least this share of its larger end wide: numbers at its ends are not told apart in less.
const NARROWEST: f64 = 1e-9;

/// Options of the picture as a whole.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct Look {
    /// The line above the picture
    #[arg(long, value_name = "TEXT")]
    pub(super) title: Option<String>,
    /// Ends of the colours, or of the values' axis, in the unit drawn, so that pictures compare: 0..50
    #[arg(long, value_name = "LOW..HIGH", allow_hyphen_values = true)]
    pub(super) range: Option<ValueRange>,
    /// Size of the picture, which is laid out to fit: pixels of .png and .gif, points of .svg and .pdf
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<Size>,
    /// Pixels per inch; text keeps its size in points [default: 144 for .png, 96 for .gif]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(36..=2400))]
    dpi: Option<u32>,
    /// Axes of maps in millimetres from the first taxel's centre, by the sensor's pitch
    #[arg(long, conflicts_with_all = ["taxel", "row", "column"])]
    pub(super) mm: bool,
    /// How many times as fast as the recording a .gif is shown [default: 1]
    #[arg(long, value_name = "TIMES", value_parser = positive)]
    pub(super) speed: Option<f64>,
}

impl Look {
    /// The size asked for, in the unit of the format; a movie has none.
    pub(super) fn extent(
        &self,
        output: &Path,
        format: Option<Format>,
    ) -> Result<Option<Extent>, Error> {
        if let (Some(speed), true) = (self.speed, format.is_some()) {
            return Err(Error::Arguments {
                what: format!("--speed {speed}: {} does not move", output.display()),
                hint: "leave --speed out, or write .gif",
            });
        }
        let has_pixels = matches!(format, None | Some(Format::Png));
        if let (Some(dpi), false) = (self.dpi, has_pixels) {
            return Err(Error::Arguments {
                what: format!("--dpi {dpi}: {} has no pixels", output.display()),
                hint: "leave --dpi out, or write .png",
            });
        }
        let Some(Size { width, height }) = self.size else {
            return Ok(None);
        };
        let usual = format.map_or(DOTS_OF_MOVIE, |_| DOTS_PER_INCH);
        Ok(Some(if has_pixels {
            Extent::pixels(width, height, self.dpi.unwrap_or(usual).into())?
        } else {
            Extent::points(width, height)?
        }))
    }

    /// The picture with the pixels per inch asked for.
    pub(super) fn finished(&self, picture: Picture) -> Picture {
        match self.dpi {
            Some(dpi) => picture.dots_per_inch(dpi.into()),
            None => picture,
        }
    }

    /// The same for a picture of a movie.
    pub(super) fn moving(&self, picture: Picture) -> Picture {
        picture.dots_per_inch(self.dpi.unwrap_or(DOTS_OF_MOVIE).into())
    }
}

/// Both ends of what is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ValueRange {
    pub(super) low: f64,
    pub(super) high: f64,
}

/// What stands there is no range of values.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum NoRange {
    #[error("expected LOW..HIGH in the unit drawn, like 0..50 or -0.5..2")]
    Unread,
    #[error("the low end {low} is not below the high end {high}; expected LOW..HIGH, like 0..50")]
    NotRising { low: f64, high: f64 },
    #[error("from {low} to {high} is too narrow to be drawn; move the ends apart")]
    Narrow { low: f64, high: f64 },
    #[error("{end} is beyond what is drawn, -1e300 to 1e300")]
    Large { end: f64 },
}

impl FromStr for ValueRange {
    type Err = NoRange;

    fn from_str(text: &str) -> Result<Self, NoRange> {
        let (low, high) = text.split_once("..").ok_or(NoRange::Unread)?;
        let number = |text: &str| {
            let number = text.trim().parse::<f64>().map_err(|_| NoRange::Unread)?;
            Some(number).filter(|n| !n.is_nan()).ok_or(NoRange::Unread)
        };
        let (low, high) = (number(low)?, number(high)?);
        if let Some(end) = [low, high].into_iter().find(|end| end.abs() > LARGEST) {
            return Err(NoRange::Large { end });
        }
        let larger = low.abs().max(high.abs());
        if low >= high {
            Err(NoRange::NotRising { low, high })
        } else if high - low <= (NARROWEST * larger).max(1e-290) {
            Err(NoRange::Narrow { low, high })
        } else {
            Ok(Self { low, high })
        }
    }
}

/// How many values a range leaves out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beyond {
    range: ValueRange,
    count: u64,
    below: u64,
    above: u64,
    least: f64,
    most: f64,
}

impl Beyond {
    pub(super) fn new(range: ValueRange) -> Self {
        Self {
            range,
            count: 0,
            below: 0,
            above: 0,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
        }
    }

    /// Counts what can be drawn of `values`.
    pub(super) fn count(&mut self, values: impl IntoIterator<Item = f64>) {
        for value in values.into_iter().filter(|value| value.is_finite()) {
            self.count += 1;
            self.below += u64::from(value < self.range.low);
            self.above += u64::from(value > self.range.high);
            self.least = self.least.min(value);
            self.most = self.most.max(value);
        }
    }

    /// For the caption: how many values are drawn at an end though they lie beyond it.
    pub(super) fn told(&self, unit: &str) -> Option<String> {
        let Self {
            range,
            count,
            below,
            above,
            least,
            most,
        } = *self;
        let part = |many: u64, word: &str, name: &str, end: f64| {
            (many > 0).then(|| format!("{many} {word} ({name} {})", short(end)))
        };
        let parts = [
            part(below, "below", "least", least),
            part(above, "above", "most", most),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| {
            format!(
                "of {count} values {} the range {} to {} {unit}",
                parts.join(" and "),
                short(range.low),
                short(range.high),
            )
            .trim_end()
            .to_owned()
        })
    }
}

/// A number to four figures, without zeros at its end.
fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let before = if size >= 1.0 {
        size.log10().floor() as i32
    } else {
        0
    };
    let decimals = usize::try_from(3 - before).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Width and height, as they are typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Size {
    width: u32,
    height: u32,
}

/// What stands there is no size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected WIDTHxHEIGHT, both at least 1, like 1200x800")]
struct NoSize;

impl FromStr for Size {
    type Err = NoSize;

    fn from_str(text: &str) -> Result<Self, NoSize> {
        let (width, height) = text.split_once(['x', 'X', '×']).ok_or(NoSize)?;
        let number = |text: &str| {
            let number = text.trim().parse::<u32>().map_err(|_| NoSize)?;
            Some(number).filter(|&n| n > 0).ok_or(NoSize)
        };
        Ok(Self {
            width: number(width)?,
            height: number(height)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_values_are_read_and_must_rise() {
        let range = |low, high| Ok(ValueRange { low, high });
        assert_eq!("0..50".parse(), range(0.0, 50.0));
        assert_eq!("-0.5..2.5e-6".parse(), range(-0.5, 2.5e-6));
        assert_eq!("1...5".parse::<ValueRange>().ok(), None);
        for unread in ["", "5", "a..b", "NaN..1", "0..", "..4"] {
            assert_eq!(
                unread.parse::<ValueRange>(),
                Err(NoRange::Unread),
                "{unread}"
            );
        }
        let (low, high) = (50.0, 50.0);
        let falling = Err(NoRange::NotRising { low, high });
        assert_eq!("50..50".parse::<ValueRange>(), falling);
        let text = "1..1.0000000001".parse::<ValueRange>().unwrap_err();
        assert!(text.to_string().contains("1 to 1.0000000001"), "{text}");
        let end = f64::INFINITY;
        assert_eq!("0..inf".parse::<ValueRange>(), Err(NoRange::Large { end }));
    }

    #[test]
    fn sizes_have_two_numbers() {
        let size = Size {
            width: 1200,
            height: 80,
        };
        assert_eq!("1200x80".parse(), Ok(size));
        for wrong in [
            "",
            "1200",
            "0x80",
            "1200x",
            "-1x5",
            "1.5x2",
            "5x99999999999",
        ] {
            assert_eq!(wrong.parse::<Size>(), Err(NoSize), "{wrong}");
        }
    }

    #[test]
    fn values_beyond_a_range_are_counted_and_blank_ones_are_not() {
        let range = ValueRange {
            low: 0.0,
            high: 50.0,
        };
        let mut beyond = Beyond::new(range);
        beyond.count([0.0, 50.0, 12.0, f64::NAN]);
        assert_eq!(beyond.told("g"), None);
        beyond.count([-1.25, 73.456, 99.0, f64::INFINITY]);
        let told = "of 6 values 1 below (least -1.25) and 2 above (most 99) the range 0 to 50 g";
        assert_eq!(beyond.told("g").as_deref(), Some(told));
    }

    #[test]
    fn numbers_have_four_figures() {
        let shown = [0.0, 123456.0, 1234.56, 73.456, 0.5, -2.5e-6].map(short);
        assert_eq!(shown, ["0", "123456", "1235", "73.46", "0.5", "-2.500e-6"]);
    }
}
