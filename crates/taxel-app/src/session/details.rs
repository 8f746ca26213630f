//! How far a taxel's load can be trusted: 95 % intervals, worked out beside the stream while somebody looks.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use taxel::{Frame, Mark, Sensor, Siemens};
use taxel_server::{Details as Message, FrameMessage, TaxelDetails};

use super::latest_queue::LatestQueue;
use crate::frames::DisplayUnit;
use crate::standard_error::StandardErrors;
use crate::units::Unit;

/// How often they are worked out, and for how long after somebody asked.
const EVERY: Duration = Duration::from_millis(450);
const ASKED_FOR: Duration = Duration::from_secs(2);

/// A frame as viewers got it, its conductances, and the sensor that they are of.
pub(super) struct DetailsRequest {
    pub(super) siemens: Option<Frame<Siemens>>,
    /// Whether the inverse came to one answer.
    pub(super) is_answer: bool,
    pub(super) sensor: Arc<Sensor>,
    pub(super) is_load: bool,
    pub(super) shown: FrameMessage,
}

/// All of one frame: what is shown together was together.
struct Answer {
    siemens: Option<Frame<Siemens>>,
    frame: FrameMessage,
    errors: Option<Errors>,
}

/// Half-widths of 95 % intervals, and the marks that they leave.
struct Errors {
    half: Frame<DisplayUnit>,
    marks: Vec<Mark>,
    noise_only: bool,
}

struct Asked {
    last: Option<Instant>,
    due: Instant,
}

/// Questions from the engine, answers for viewers.
pub(super) struct Details {
    questions: LatestQueue<DetailsRequest>,
    answer: Mutex<Option<Answer>>,
    asked: Mutex<Asked>,
    file: PathBuf,
}

impl Details {
    pub(super) fn new(file: PathBuf) -> Self {
        Self {
            questions: LatestQueue::new(1),
            answer: Mutex::new(None),
            asked: Mutex::new(Asked {
                last: None,
                due: Instant::now(),
            }),
            file,
        }
    }

    /// Whether it is time for a request.
    pub(super) fn is_wanted(&self) -> bool {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let looks = asked.last.is_some_and(|last| now - last < ASKED_FOR);
        if !looks || now < asked.due {
            return false;
        }
        asked.due = now + EVERY;
        true
    }

    pub(super) fn ask(&self, request: DetailsRequest) {
        self.questions.push(request);
    }

    pub(super) fn close(&self) {
        self.questions.close();
    }

    /// Answers questions until there are no more.
    pub(super) fn run(&self) {
        let mut known: Option<(Arc<Sensor>, Option<StandardErrors>)> = None;
        while let Some(request) = self.questions.pop() {
            let same = known
                .as_ref()
                .is_some_and(|(sensor, _)| Arc::ptr_eq(sensor, &request.sensor));
            if !same {
                let unit = if request.is_load {
                    Unit::Newtons
                } else {
                    Unit::Siemens
                };
                let errors = StandardErrors::new(&request.sensor, &self.file, unit, None).ok();
                known = Some((request.sensor.clone(), errors));
            }
            let Some((_, errors)) = &mut known else {
                continue;
            };
            let siemens = request.siemens;
            let errors = errors.as_mut().zip(siemens.as_ref());
            let errors = errors.and_then(|(errors, siemens)| {
                // What fit and model leave goes with the load that is shown.
                let loads = &request.shown.loads;
                let mut shown = siemens.map(|taxel, _| f64::from(loads[taxel]));
                errors.of(siemens, request.is_answer, &mut shown).ok()?;
                let mut half = Frame::zeros(siemens.rows(), siemens.columns());
                errors.half_widths_into(&mut half);
                Some(Errors {
                    half,
                    marks: shown.marks().to_vec(),
                    noise_only: !errors.knows_more_than_noise(),
                })
            });
            let mut answer = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
            *answer = Some(Answer {
                siemens,
                frame: request.shown,
                errors,
            });
        }
    }

    /// The message `details`.
    pub(super) fn message(&self, taxels: &[(usize, usize)]) -> Message {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        asked.last = Some(Instant::now());
        drop(asked);
        let answer = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        let found: Vec<_> = taxels
            .iter()
            .filter_map(|&(row, column)| {
                let answer = answer.as_ref()?;
                let frame = &answer.frame;
                if row >= frame.rows || column >= frame.columns {
                    return None;
                }
                let at = row * frame.columns + column;
                let mut mark = frame.marks[at];
                let mut half = None;
                let mut noise_only = false;
                if let Some(errors) = &answer.errors {
                    // More uncertain than it is large: that is said, and the error is none that could be shown.
                    if mark == Mark::Good.code() && errors.marks[at] == Mark::Unresolved {
                        mark = Mark::Unresolved.code();
                    }
                    let is_measured = [Mark::Good, Mark::Unfamiliar]
                        .map(Mark::code)
                        .contains(&mark);
                    half = Some(errors.half.values()[at]).filter(|_| is_measured);
                    noise_only = errors.noise_only;
                }
                let mut details = TaxelDetails::at(row, column);
                details.sequence = frame.sequence;
                details.load = frame.loads[at];
                details.raw = frame.raw[at];
                details.counts = frame.counts[at];
                details.mark = mark;
                details.siemens = answer.siemens.as_ref().map(|siemens| siemens.values()[at]);
                details.half_width_95_newtons = half;
                details.noise_only = noise_only;
                Some(details)
            })
            .collect();
        Message::new(found)
    }
}
