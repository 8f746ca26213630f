//! What finds the intervals of a sensor's frames.

use std::path::Path;
use std::sync::Arc;

use taxel::uncertainty::FigureErrors;
use taxel::{Frame, Mark, Sensor};
use taxel_server::FigureDetails;

use super::DetailsRequest;
use crate::frames::DisplayUnit;
use crate::standard_error::StandardErrors;
use crate::units::Unit;

/// Half-widths of 95 % intervals, and the marks that they leave.
pub(super) struct TaxelErrors {
    pub(super) half: Frame<DisplayUnit>,
    pub(super) marks: Vec<Mark>,
    pub(super) noise_only: bool,
}

/// Of one sensor, in the unit that its frames are shown in.
pub(super) struct Judge {
    sensor: Arc<Sensor>,
    is_load: bool,
    taxels: Option<StandardErrors>,
    figures: Option<FigureErrors>,
}

impl Judge {
    /// For frames like this one, of a sensor that comes from `file`.
    pub(super) fn new(request: &DetailsRequest, file: &Path) -> Self {
        let sensor = request.sensor.clone();
        let is_load = request.loads.is_some();
        let unit = if is_load {
            Unit::Newtons
        } else {
            Unit::Siemens
        };
        Self {
            is_load,
            taxels: StandardErrors::new(&sensor, file, unit, None).ok(),
            figures: FigureErrors::new(&sensor, None).ok(),
            sensor,
        }
    }

    /// Whether it is one for this frame.
    pub(super) fn is_of(&self, request: &DetailsRequest) -> bool {
        Arc::ptr_eq(&self.sensor, &request.sensor) && self.is_load == request.loads.is_some()
    }

    pub(super) fn taxels(&mut self, request: &DetailsRequest) -> Option<TaxelErrors> {
        let errors = self.taxels.as_mut()?;
        let siemens = request.siemens.as_ref()?;
        // What fit and model leave goes with the load that is shown.
        let loads = &request.shown.loads;
        let mut shown = siemens.map(|taxel, _| f64::from(loads[taxel]));
        errors.of(siemens, request.is_answer, &mut shown).ok()?;
        let mut half = Frame::zeros(siemens.rows(), siemens.columns());
        errors.half_widths_into(&mut half);
        Some(TaxelErrors {
            half,
            marks: shown.marks().to_vec(),
            noise_only: !errors.knows_more_than_noise(),
        })
    }

    /// Of total force and contact area; `None` where frames are no loads.
    pub(super) fn figures(&mut self, request: &DetailsRequest) -> Option<FigureDetails> {
        let loads = request.loads.as_ref()?;
        let shown = &request.shown;
        let mut details = FigureDetails::default();
        details.sequence = shown.sequence;
        details.total_newtons = shown.total_newtons;
        details.contact_area_mm2 = shown.contact_area_mm2;
        // An interval by the noise of readings would promise what cross-talk does not keep.
        let siemens = request.siemens.as_ref().filter(|_| !shown.is_raw);
        if let Some((errors, siemens)) = self.figures.as_mut().zip(siemens) {
            let found = errors.of(siemens, loads, request.is_answer);
            let half = |width: f64| Some(width).filter(|width| width.is_finite());
            details.total_half_width_95_newtons = half(found.total_force_newtons.half_width_95);
            details.contact_area_half_width_95_mm2 = half(found.contact_area_mm2.half_width_95);
            details.noise_only = !errors.knows_more_than_noise();
        }
        if details.total_half_width_95_newtons.is_none() {
            why_unbounded(request).clone_into(&mut details.why_unbounded);
        }
        Some(details)
    }
}

fn why_unbounded(request: &DetailsRequest) -> &'static str {
    let has = |mark| {
        let marks = request.loads.as_ref().map(Frame::marks);
        marks.is_some_and(|marks| marks.contains(&mark))
    };
    if request.shown.is_raw {
        "by the method raw cross-talk is in it, which nothing bounds"
    } else if request.siemens.is_none() {
        "a model tells loads, but not how far to trust them"
    } else if !request.is_answer {
        "the readings of this frame have no single answer"
    } else if has(Mark::Saturated) {
        "a taxel is at the converter's ceiling"
    } else {
        "the readings of this frame do not bound it"
    }
}
