//! The message `hello`: what a viewer must know first.

use serde::Serialize;
use taxel::Mark;
use taxel::metric::is_usable;
use taxel::sensor::{Handle, Region, RegionSpec};

use super::PROTOCOL;

/// What a viewer must know first. A page that gets one starts afresh.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Hello {
    /// Version of the messages, [`PROTOCOL`].
    pub protocol: u32,
    /// Name and version of the program.
    pub program: String,
    /// What is shown.
    pub sensor: SensorFacts,
    /// Where it comes from.
    pub source: SourceFacts,
    /// The methods that a viewer may choose from, by name.
    pub methods: Vec<String>,
    /// Whether viewers may record.
    pub can_record: bool,
    /// What a viewer may change of a simulated source.
    pub sliders: Vec<Slider>,
    /// The file that is played, if it is one.
    pub file: Option<FileFacts>,
    /// What the codes of marks mean, in the order of the codes.
    pub marks: Vec<MarkMeaning>,
}

impl Hello {
    /// A source without methods, recordings, sliders or a file, with the marks of this library.
    pub fn new(program: impl Into<String>, sensor: SensorFacts, source: SourceFacts) -> Self {
        Self {
            protocol: PROTOCOL,
            program: program.into(),
            sensor,
            source,
            methods: Vec::new(),
            can_record: false,
            sliders: Vec::new(),
            file: None,
            marks: mark_meanings(),
        }
    }
}

/// The sensor, as far as a viewer needs it.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct SensorFacts {
    /// What people call it.
    pub name: String,
    /// Sensed lines.
    pub rows: usize,
    /// Driven lines.
    pub columns: usize,
    /// Between rows and between columns, mm.
    pub pitch_mm: [f64; 2],
    /// Area that the load of one taxel acts on, mm²; on a cone, of a taxel of the widest ring.
    pub taxel_area_mm2: f64,
    /// Area of its cell, from line to line both ways, mm².
    pub cell_area_mm2: f64,
    /// Resolution of the converter.
    pub bits: u32,
    /// Its largest count.
    pub max_count: f64,
    /// Loads are newtons; else conductances in siemens.
    pub has_load_law: bool,
    /// When it was calibrated and last checked, in words; nothing where it was not.
    pub calibration: Option<String>,
    /// Of another program's recording: what has to be known of its numbers; nothing where they are read here.
    pub exported: Option<ExportedFacts>,
    /// Where the taxels lie, row by row, x to the right and y down in mm; nothing where they lie at the crossings of their
    /// lines. A crossing without a taxel has none.
    pub positions_mm: Option<Vec<Option<[f64; 2]>>>,
    /// Named parts of it.
    pub regions: Vec<RegionFacts>,
    /// The handle that the array is wrapped around; nothing where it is flat.
    pub handle: Option<HandleFacts>,
}

/// A named part of an array.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct RegionFacts {
    /// What people call it.
    pub name: String,
    /// Boxes that hold its taxels and no others: first row, last row, first column, last column, ends included. Of one that moves
    /// over a recording, those of all frames together.
    pub boxes: Vec<[usize; 4]>,
    /// Where it lies in which frames; none where it lies still in all.
    pub windows: Vec<RegionWindow>,
}

/// Where a region lies in some frames of a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RegionWindow {
    /// The first and the last of them, from 0.
    pub frames: [u64; 2],
    /// Boxes as of the region.
    pub boxes: Vec<[usize; 4]>,
}

impl RegionFacts {
    /// What is told of a region of an array with so many columns.
    pub fn new(region: &Region, columns: usize) -> Self {
        let boxes = |taxels: &[usize]| RegionSpec::of_taxels("", taxels, columns).boxes;
        let window = |(frames, taxels): ([u64; 2], &[usize])| RegionWindow {
            frames,
            boxes: boxes(taxels),
        };
        Self {
            name: region.name().to_owned(),
            boxes: boxes(region.taxels()),
            windows: region.windows().map(window).collect(),
        }
    }
}

/// Numbers that another program has found.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ExportedFacts {
    /// What is done to them and what is not, in words.
    pub words: String,
    /// Their unit, where they are no loads.
    pub unit: Option<String>,
    /// How much of that unit a siemens of the frames stands for; 1 where they are loads.
    pub per_siemens: f64,
}

impl ExportedFacts {
    /// Loads, as other programs have found them.
    pub fn new(words: impl Into<String>) -> Self {
        Self {
            words: words.into(),
            unit: None,
            per_siemens: 1.0,
        }
    }
}

/// A cylinder or a cone that an array is wrapped around: enough to draw it, and to say what it is gripped with.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HandleFacts {
    /// Which lines run round it, `rows` or `columns`; the others run along it.
    pub rings: &'static str,
    /// Of each line that runs along it, radians, ascending from 0 to below 2π.
    pub angles: Vec<f64>,
    /// Of each ring, mm.
    pub radii_mm: Vec<f64>,
    /// Of each ring above the first one, along the axis, mm.
    pub heights_mm: Vec<f64>,
    /// Of each ring: the areas of its taxels as a share of those of the widest.
    pub narrowness: Vec<f64>,
    /// Angle between surface and axis, radians: positive where the body narrows from the first ring to the last.
    pub slope: f64,
    /// Whether the last line along it is a neighbour of the first.
    pub closes: bool,
}

impl HandleFacts {
    /// What is told of a handle.
    pub fn new(handle: &Handle) -> Self {
        let rise = handle.step_mm * handle.slope.cos();
        Self {
            rings: handle.rings.name(),
            angles: handle.angles.clone(),
            radii_mm: handle.radii_mm.clone(),
            heights_mm: (0..handle.radii_mm.len())
                .map(|ring| rise * ring as f64)
                .collect(),
            narrowness: (0..handle.radii_mm.len())
                .map(|ring| handle.narrowness(ring))
                .collect(),
            slope: handle.slope,
            closes: handle.closes(),
        }
    }
}

impl SensorFacts {
    /// An array of this shape, with a pitch of 1 mm and nothing else known.
    pub fn new(name: impl Into<String>, rows: usize, columns: usize) -> Self {
        Self {
            name: name.into(),
            rows,
            columns,
            pitch_mm: [1.0; 2],
            taxel_area_mm2: 1.0,
            cell_area_mm2: 1.0,
            ..Self::default()
        }
    }
}

/// Where frames come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct SourceFacts {
    /// As it was given.
    pub address: String,
    /// What it is.
    #[serde(rename = "type")]
    pub kind: SourceKind,
}

impl SourceFacts {
    /// A source of this kind at this address.
    pub fn new(address: impl Into<String>, kind: SourceKind) -> Self {
        let address = address.into();
        Self { address, kind }
    }
}

/// What a source is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SourceKind {
    /// A sensor.
    Device,
    /// A simulated one.
    Sim,
    /// A recording.
    File,
}

/// The recording that is played.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct FileFacts {
    /// Frames in it.
    pub frames: u64,
    /// How long it is, s.
    pub duration_secs: f64,
}

impl FileFacts {
    /// A recording of so many frames, so long.
    pub fn new(frames: u64, duration_secs: f64) -> Self {
        Self {
            frames,
            duration_secs,
        }
    }
}

/// Something that a viewer may change of a simulated source.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Slider {
    /// Its name in requests.
    pub key: String,
    /// Its name for people.
    pub label: String,
    /// The unit of its value; empty for none.
    pub unit: String,
    /// Where it stands; of a switch 0 or 1.
    pub value: f64,
    /// How it is moved.
    #[serde(flatten)]
    pub kind: SliderKind,
}

impl Slider {
    /// A slider without a unit.
    pub fn new(
        key: impl Into<String>,
        label: impl Into<String>,
        kind: SliderKind,
        value: f64,
    ) -> Self {
        Self {
            key: key.into(),
            label: label.into(),
            unit: String::new(),
            value,
            kind,
        }
    }
}

/// How a slider is moved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SliderKind {
    /// Along a range.
    Range {
        /// Its lower end.
        min: f64,
        /// Its upper end.
        max: f64,
        /// Between two places.
        step: f64,
        /// Equal ways are equal ratios.
        logarithmic: bool,
    },
    /// On or off.
    Switch,
}

impl SliderKind {
    /// The values that it can have.
    pub fn range(self) -> std::ops::RangeInclusive<f64> {
        match self {
            SliderKind::Range { min, max, .. } => min..=max,
            SliderKind::Switch => 0.0..=1.0,
        }
    }
}

/// What a mark means to who looks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct MarkMeaning {
    /// Its word.
    pub word: &'static str,
    /// A sentence.
    pub text: &'static str,
    /// How much it takes away from the value.
    pub severity: Severity,
    /// The taxel counts in totals.
    pub counts: bool,
    /// Its value may set the scale of colours.
    pub scales: bool,
}

/// How much a mark takes away from a value; a number on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Severity {
    /// Nothing.
    None = 0,
    /// The value is none of the taxel's own, or is uncertain.
    Doubtful = 1,
    /// The value is not to be trusted.
    Bad = 2,
}

impl Serialize for Severity {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(*self as u8)
    }
}

/// By code: how severe, whether it sets the scale, and a sentence.
const MEANINGS: [(Severity, bool, &str); Mark::ALL.len()] = [
    (Severity::None, true, "Nothing is known against it."),
    (
        Severity::Bad,
        false,
        "On a line that is dead: the frame says nothing about it.",
    ),
    (
        Severity::Bad,
        true,
        "At the converter's ceiling: the value is a lower bound.",
    ),
    (Severity::Bad, false, "Stuck at an end of the converter."),
    (
        Severity::Bad,
        false,
        "A spike against its neighbours or over time.",
    ),
    (Severity::Bad, false, "On a line that comes and goes."),
    (
        Severity::Bad,
        false,
        "On lines that read alike because they are shorted together.",
    ),
    (
        Severity::Doubtful,
        true,
        "Not measured: the median of its neighbours.",
    ),
    (
        Severity::Doubtful,
        true,
        "The cross-talk cannot be undone: its standard error exceeds its value.",
    ),
    (
        Severity::Doubtful,
        true,
        "A network's estimate from an input unlike those it was trained with.",
    ),
    (Severity::None, false, "There is no taxel at this crossing."),
    (
        Severity::Doubtful,
        true,
        "Below what the recorder keeps: taken to be unloaded, and may be loaded by as much as reads that little.",
    ),
];

/// What every mark means, in the order of their codes.
pub fn mark_meanings() -> Vec<MarkMeaning> {
    let meaning = |(mark, (severity, scales, text)): (Mark, _)| MarkMeaning {
        word: mark.word(),
        text,
        severity,
        counts: is_usable(mark),
        scales,
    };
    Mark::ALL.into_iter().zip(MEANINGS).map(meaning).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_marks_is_in_the_order_of_their_codes() {
        let meanings = mark_meanings();
        for (code, mark) in Mark::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(mark.code()), code);
            assert_eq!(meanings[code].word, mark.word());
        }
        let bad = meanings.iter().filter(|m| m.severity == Severity::Bad);
        let bad: Vec<_> = bad.map(|meaning| meaning.word).collect();
        let lost = [
            "open",
            "saturated",
            "stuck",
            "spike",
            "flickering",
            "shorted",
        ];
        assert_eq!(bad, lost);
        let silent = meanings.iter().filter(|m| !m.scales).count();
        assert_eq!(silent, 6);
    }

    #[test]
    fn a_slider_says_its_kind_beside_its_name() {
        let mut slider = Slider::new("dead_row", "Dead row", SliderKind::Switch, 1.0);
        slider.unit = "x".to_owned();
        assert_eq!(
            serde_json::to_value(&slider).unwrap(),
            serde_json::json!({ "key": "dead_row", "label": "Dead row", "unit": "x", "value": 1.0, "type": "switch" })
        );
        assert!(!SliderKind::Switch.range().contains(&1.5));
    }
}
