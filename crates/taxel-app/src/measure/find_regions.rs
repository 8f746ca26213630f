//! Regions of a recording that nobody has drawn: the parts of a hand, else its contacts.

use taxel::metric::is_usable;
use taxel::segment::{ContactOptions, contacts, hand};
use taxel::sensor::RegionSpec;
use taxel::{Frame, Mark, Newtons};

use super::{Measured, Settings};
use crate::conversion::Conversion;
use crate::error::Error;
use crate::line_survey::Survey;
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
        let map = self.mean_loads(settings, reporter, is_stopped)?;
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

    /// Mean load of every taxel, newtons; where it was never read, it is marked as in the last frame.
    fn mean_loads(
        &self,
        settings: &Settings,
        reporter: &dyn Reporter,
        is_stopped: &(dyn Fn() -> bool + Sync),
    ) -> Result<Frame<Newtons>, Error> {
        let input = self.input(settings);
        if !input.can_be_read_twice() {
            return Err(Error::Request {
                what: format!("{} can be read once only", self.recording.display()),
                hint: "regions are found in a first pass over all frames: keep the recording in a file",
            });
        }
        let no_figures = Measured {
            regions: &[],
            ..*self
        };
        let mut request = no_figures.request(settings, is_stopped, false);
        request.figures = None;
        request.check()?;
        let survey = Survey::of(&input, self.sensor, reporter, settings.threads)?;
        let conversion = Conversion::new(request, &survey)?;
        let mut reading = input.open()?;
        let stage = reporter.stage("looking for regions");
        let mut mean = Frame::<Newtons>::zeros(self.sensor.rows(), self.sensor.columns());
        mean.marks_mut().fill(Mark::Absent);
        let mut counts = vec![0u32; mean.values().len()];
        conversion.run(&mut reading, &*stage, |frame| {
            let each = frame.shown.values().iter().zip(frame.shown.marks());
            for (taxel, (load, mark)) in each.enumerate().filter(|_| frame.is_answer()) {
                if is_usable(*mark) {
                    mean.values_mut()[taxel] += load;
                    mean.marks_mut()[taxel] = Mark::Good;
                    counts[taxel] += 1;
                }
            }
            Ok(())
        })?;
        for (sum, count) in mean.values_mut().iter_mut().zip(&counts) {
            *sum /= f64::from(*count).max(1.0);
        }
        Ok(mean)
    }
}
