//! Regions of a recording that nobody has drawn: the parts of a hand, else its contacts.

use taxel::segment::{ContactOptions, contacts, hand};
use taxel::sensor::RegionSpec;

use super::{Measured, Settings};
use crate::error::Error;
use crate::reporter::Reporter;

/// Contacts that are named at most, the heaviest: more are a texture.
const MAX_CONTACTS: usize = 16;

/// In the mean of all frames a contact is pressed above this share of what counts as touched: it may be there in a tenth of them.
const PRESSED_SHARE: f64 = 0.1;

impl Measured<'_> {
    /// The regions of the mean of all frames with an answer: palm, thumb and fingers where four fingers lie side by side around a
    /// handle, else its contacts, the heaviest first.
    ///
    /// # Errors
    /// As [`Measured::measure`]; a recording in which nobody presses.
    pub fn find_regions(
        &self,
        settings: &Settings,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<RegionSpec>, Error> {
        let survey = self.survey(settings, reporter)?;
        let (map, _) = self.mean_loads(settings, None, &survey, reporter, is_stopped)?;
        let mut found = contacts(&map, self.sensor, &ContactOptions::default());
        let is_pressed = |newtons: f64| newtons > PRESSED_SHARE * settings.touched_newtons;
        found.retain(|contact| is_pressed(contact.highest_newtons));
        if let Some(parts) = hand(&found, self.sensor) {
            return Ok(parts);
        }
        found.truncate(MAX_CONTACTS);
        if found.is_empty() {
            return Err(Error::Request {
                what: format!("{}: no region is pressed", self.recording.display()),
                hint: "regions can be drawn in a file: a [[region]] each, with `name`, and `boxes` or `outline`",
            });
        }
        let columns = self.sensor.columns();
        let named = found.iter().enumerate().map(|(at, contact)| {
            RegionSpec::of_taxels(format!("contact {}", at + 1), &contact.taxels, columns)
        });
        Ok(named.collect())
    }
}
