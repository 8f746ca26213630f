//! How far numbers can be trusted: 95 % intervals of taxels and of what a frame amounts to, worked out beside the stream
//! while somebody looks.

mod judge;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use taxel::{Frame, Mark, Newtons, Sensor, Siemens};
use taxel_server::{Details as Message, FigureDetails, FrameMessage, TaxelDetails, Watched};

use self::judge::{Judge, TaxelErrors};
use super::latest_queue::LatestQueue;

/// How often they are worked out, and for how long after somebody asked.
const EVERY: Duration = Duration::from_millis(450);
const ASKED_FOR: Duration = Duration::from_secs(2);

/// A frame as viewers got it, its conductances, and the sensor that they are of.
pub(super) struct DetailsRequest {
    pub(super) siemens: Option<Frame<Siemens>>,
    /// As they are shown; `None` without a load law.
    pub(super) loads: Option<Frame<Newtons>>,
    /// Whether the inverse came to one answer.
    pub(super) is_answer: bool,
    pub(super) sensor: Arc<Sensor>,
    pub(super) shown: FrameMessage,
}

/// All of one frame: what is shown together was together.
struct Answer {
    siemens: Option<Frame<Siemens>>,
    frame: FrameMessage,
    errors: Option<TaxelErrors>,
    figures: Option<FigureDetails>,
}

struct Asked {
    last: Option<Instant>,
    /// Errors of taxels cost far more than those of figures: they are found for those who point at one.
    last_of_taxels: Option<Instant>,
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
                last_of_taxels: None,
                due: Instant::now(),
            }),
            file,
        }
    }

    /// Whether it is time for a request.
    pub(super) fn is_wanted(&self) -> bool {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        if !is_recent(asked.last) || now < asked.due {
            return false;
        }
        asked.due = now + EVERY;
        true
    }

    /// The next frame is one to tell of, however soon it comes: it may be the last for a long time, where a recording is held.
    pub(super) fn expect(&self) {
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        (asked.last, asked.due) = (Some(now), now);
    }

    pub(super) fn ask(&self, request: DetailsRequest) {
        self.questions.push(request);
    }

    pub(super) fn close(&self) {
        self.questions.close();
    }

    /// Answers questions until there are no more.
    pub(super) fn run(&self) {
        let mut known: Option<Judge> = None;
        while let Some(request) = self.questions.pop() {
            let mut judge = known
                .take()
                .filter(|judge| judge.is_of(&request))
                .unwrap_or_else(|| Judge::new(&request, &self.file));
            let asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
            let is_pointed_at = is_recent(asked.last_of_taxels);
            drop(asked);
            let found = Answer {
                errors: is_pointed_at.then(|| judge.taxels(&request)).flatten(),
                figures: judge.figures(&request),
                siemens: request.siemens,
                frame: request.shown,
            };
            known = Some(judge);
            let mut answer = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
            *answer = Some(found);
        }
    }

    /// The message `details`.
    pub(super) fn message(&self, watched: &Watched) -> Message {
        let now = Some(Instant::now());
        let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
        asked.last = now;
        if !watched.taxels.is_empty() {
            asked.last_of_taxels = now;
        }
        drop(asked);
        let answer = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(answer) = &*answer else {
            return Message::default();
        };
        let at = |&(row, column): &(usize, usize)| answer.taxel(row, column);
        let mut message = Message::new(watched.taxels.iter().filter_map(at).collect());
        if watched.figures {
            message.figures.clone_from(&answer.figures);
        }
        message
    }
}

fn is_recent(asked: Option<Instant>) -> bool {
    asked.is_some_and(|asked| asked.elapsed() < ASKED_FOR)
}

impl Answer {
    /// `None` where there is no such taxel.
    fn taxel(&self, row: usize, column: usize) -> Option<TaxelDetails> {
        let frame = &self.frame;
        if row >= frame.rows || column >= frame.columns {
            return None;
        }
        let at = row * frame.columns + column;
        let mut mark = frame.marks[at];
        let mut half = None;
        let mut noise_only = false;
        if let Some(errors) = &self.errors {
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
        details.siemens = self.siemens.as_ref().map(|siemens| siemens.values()[at]);
        details.half_width_95_newtons = half;
        details.noise_only = noise_only;
        Some(details)
    }
}

#[cfg(test)]
mod tests;
