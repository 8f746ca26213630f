//! Regions of a recording that nobody has drawn: the parts of a hand or of feet, else its contacts.

use std::path::Path;

use taxel::segment::{
    ContactOptions, Segmenter, Window, WindowOptions, Windows, feet, joined_contacts, joined_hand,
};
use taxel::sensor::RegionSpec;
use taxel::{Frame, Newtons};

use super::mean::Mean;
use super::{Measured, Settings};
use crate::error::Error;
use crate::reporter::{Reporter, Silent};

/// Contacts that are named at most, the heaviest: more are a texture.
const MAX_CONTACTS: usize = 16;

/// In the mean of all frames a contact is pressed above this share of what counts as touched: it may be there in a tenth of them.
const PRESSED_SHARE: f64 = 0.1;

/// Whether a word stands in place of a file of regions, so that they are to be found: `auto`, and `phalanges` for fingers cut at
/// their joints, which the answer tells. `None` of a file.
pub fn finds_regions(word: &Path) -> Option<bool> {
    match word.to_str() {
        Some("auto") => Some(false),
        Some("phalanges") => Some(true),
        _ => None,
    }
}

/// What was found in a recording.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FoundRegions {
    /// What it was taken for.
    pub kind: FoundKind,
    /// Its regions; one that moves is there once for each window of time.
    pub regions: Vec<RegionSpec>,
    /// Windows of time in each of which it lies still.
    pub windows: usize,
}

/// What a recording is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum FoundKind {
    /// A hand, gripping.
    Hand,
    /// Feet.
    Feet,
    /// Contacts of something.
    Contacts,
}

impl Measured<'_> {
    /// The regions of a recording, by the frames with an answer: palm, thumb and fingers where four fingers lie side by side; heel,
    /// midfoot, forefoot and toes of feet on a flat sensor; else its contacts, the heaviest first. What moves is found in each
    /// window of time in which it lies still, and keeps its names.
    ///
    /// # Errors
    /// As [`Measured::measure`]; a recording in which nobody presses.
    pub fn find_regions(
        &self,
        settings: &Settings,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<FoundRegions, Error> {
        self.find(settings, reporter, is_stopped, true)
    }

    /// The same of a recording in which a hand presses: no part of it is one of a foot.
    ///
    /// # Errors
    /// As [`Self::find_regions`].
    pub(crate) fn find_regions_of_hand(&self, settings: &Settings) -> Result<FoundRegions, Error> {
        self.find(settings, &Silent, &|| false, false)
    }

    fn find(
        &self,
        settings: &Settings,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
        may_be_feet: bool,
    ) -> Result<FoundRegions, Error> {
        let survey = self.survey(settings, reporter)?;
        let segmenter = Segmenter::new(self.sensor);
        let mut windows = Windows::new(segmenter.clone(), WindowOptions::default());
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        let mut mean = Mean::new(rows, columns);
        let mut loads = Frame::<Newtons>::zeros(rows, columns);
        self.look_at_loads(settings, &survey, reporter, is_stopped, |frame, _| {
            loads.values_mut().copy_from_slice(frame.shown.values());
            loads.marks_mut().copy_from_slice(frame.shown.marks());
            windows.add(frame.sequence(), &loads, frame.is_answer());
            if frame.is_answer() {
                mean.add(frame);
            }
        })?;
        let (mean, _) = mean.finish();
        let mean = may_be_feet.then_some(&mean);
        let found = found(&windows.finish(), mean, &segmenter, settings);
        if found.regions.is_empty() {
            return Err(Error::Request {
                what: format!("{}: no region is pressed", self.recording.display()),
                hint: "regions can be drawn in a file: a [[region]] each, with `name`, and `boxes` or `outline`",
            });
        }
        Ok(found)
    }
}

fn found(
    windows: &[Window],
    of_feet: Option<&Frame<Newtons>>,
    segmenter: &Segmenter,
    settings: &Settings,
) -> FoundRegions {
    let least_newtons = PRESSED_SHARE * settings.touched_newtons;
    let of = |kind, regions, windows| FoundRegions {
        kind,
        regions,
        windows,
    };
    if let Some(hand) = joined_hand(windows, segmenter, least_newtons, settings.phalanges) {
        return of(FoundKind::Hand, hand, windows.len());
    }
    let pressed = of_feet.filter(|mean| mean.values().iter().any(|load| *load > least_newtons));
    let parts = pressed.and_then(|mean| feet(mean, segmenter, &ContactOptions::default()));
    if let Some(parts) = parts {
        let columns = segmenter.sensor().columns();
        let regions = parts.iter().map(|part| part.region(columns)).collect();
        return of(FoundKind::Feet, regions, 1);
    }
    let contacts = joined_contacts(windows, segmenter, least_newtons, MAX_CONTACTS);
    of(FoundKind::Contacts, contacts, windows.len())
}
