//! Counts to loads, frame after frame: screen, inverse, load law, tare, figures.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant, SystemTime};

use taxel::metric::FrameFigures;
use taxel::pipeline::Pipeline;
use taxel::screen::{Axis, LineFaultKind, LineFaults, LineScreen};
use taxel::solve::Raw;
use taxel::{Frame, Newtons, Sensor};
use taxel_learn::with_law;
use taxel_server::{BadLines, FrameMessage, Server};

use super::details::{Details, DetailsRequest};
use super::latest_queue::LatestQueue;
use super::recorder::{Recorder, SolvedFrame};
use super::status::SessionStatus;
use super::{FrameObserver, LiveFrame, SessionOptions, TimestampedFrame};
use crate::error::Error;
use crate::line_survey::FaultyLine;
use crate::methods::MethodName;

/// Frames that may wait for the engine.
pub(super) const QUEUE: usize = 4;
/// Frames that a tare is the mean of.
const TARE_FRAMES: u32 = 20;
/// Frames that lines are judged by, and the time between two of them.
const SURVEY_FRAMES: u32 = 100;
const SURVEY_EVERY: Duration = Duration::from_millis(50);
/// How long frames of before are on their way after a knob was turned.
const TURNED: Duration = Duration::from_millis(30);

/// What the engine is told.
pub(super) enum EngineCommand {
    Method(MethodName),
    Tare,
    Untare,
    /// The sensor has changed: a knob of a simulated one.
    Sensor(Box<Sensor>),
}

/// What a tare takes off, raw and compensated; and while it is being taken, how many frames are in it.
struct Tare {
    raw: Vec<f64>,
    loads: Vec<f64>,
    frames: u32,
    first: u64,
}

pub(super) struct Engine {
    sensor: Arc<Sensor>,
    file: PathBuf,
    method: MethodName,
    exact: Pipeline,
    raw: Pipeline,
    is_load: bool,
    tare: Option<Tare>,
    /// The one of the recording that is played.
    recorded_tare: Option<Arc<taxel_io::Tare>>,
    survey: LineScreen,
    surveyed: u32,
    survey_due: Instant,
    /// Lines that may be dead, and of which that was said.
    suspects: Vec<(Axis, usize)>,
    loads: Frame<Newtons>,
    status: Arc<SessionStatus>,
    recorder: Arc<Recorder>,
    details: Arc<Details>,
    commands: Receiver<EngineCommand>,
    observer: Option<FrameObserver>,
    /// Frames on their way were scanned before a knob was turned.
    blind_until: Option<Instant>,
}

impl Engine {
    pub(super) fn new(
        options: &SessionOptions,
        status: Arc<SessionStatus>,
        recorder: Arc<Recorder>,
        details: Arc<Details>,
        commands: Receiver<EngineCommand>,
        observer: Option<FrameObserver>,
    ) -> Result<Self, Error> {
        let (sensor, file) = (&options.sensor, &options.sensor_file);
        let [exact, raw] = pipelines(sensor, file, &options.method)?;
        status.set_method(exact_name(&exact, &options.method));
        Ok(Self {
            exact,
            raw,
            is_load: gives_loads(sensor, &options.method),
            tare: None,
            recorded_tare: None,
            survey: LineScreen::from_sensor(sensor),
            surveyed: 0,
            survey_due: Instant::now(),
            suspects: Vec::new(),
            loads: Frame::zeros(sensor.rows(), sensor.columns()),
            sensor: Arc::new(sensor.clone()),
            file: file.clone(),
            method: options.method.clone(),
            status,
            recorder,
            details,
            commands,
            observer,
            blind_until: None,
        })
    }

    /// Works until the queue is closed.
    pub(super) fn run(
        &mut self,
        incoming: &LatestQueue<TimestampedFrame>,
        server: Option<&Server>,
    ) {
        while let Some(arrived) = incoming.pop() {
            while let Ok(command) = self.commands.try_recv() {
                self.apply(command);
            }
            if self.blind_until.is_some_and(|until| Instant::now() < until) {
                continue;
            }
            let wanted = self.recorder.wants();
            let awaited = server.is_some_and(Server::is_awaited);
            self.look_at_lines(&arrived);
            self.take_recorded_tare(&arrived);
            let tares = self
                .tare
                .as_ref()
                .is_some_and(|tare| tare.frames < TARE_FRAMES);
            // Without viewers and without loads in the file nobody needs them; with viewers each frame keeps the
            // inverse warm for the next.
            if server.is_none() && !wanted.any() && self.observer.is_none() {
                continue;
            }
            let figures = self.solve(&arrived);
            self.show_observer(&arrived, &figures);
            if wanted.any() {
                let loads = wanted.loads.then_some(&self.loads);
                let solved = SolvedFrame {
                    loads: loads.cloned(),
                    figures,
                    sequence: arrived.frame.sequence,
                    at: arrived.at,
                };
                self.recorder.solved(solved, server.is_none());
            }
            self.status.set_total(
                self.is_load
                    .then(|| figures.total_force_newtons + self.tared_total()),
            );
            // A tare is the mean of raw loads, too.
            let message = (awaited || tares).then(|| self.message(&arrived, &figures));
            if let (Some(server), Some(message)) = (server, message) {
                if self.details.is_wanted() {
                    self.details.ask(DetailsRequest {
                        siemens: self.exact.result().siemens.cloned(),
                        loads: self.is_load.then(|| self.loads.clone()),
                        is_answer: self.exact.result().outcome.is_answer(),
                        sensor: self.sensor.clone(),
                        shown: message.clone(),
                    });
                }
                server.publish(message);
            }
            self.status.add_delay(arrived.at);
        }
    }

    /// Calls who wants every frame.
    fn show_observer(&mut self, arrived: &TimestampedFrame, figures: &FrameFigures) {
        let Some(observe) = &mut self.observer else {
            return;
        };
        let result = self.exact.result();
        observe(&LiveFrame {
            counts: &arrived.frame,
            siemens: result.siemens,
            loads: self.is_load.then_some(&self.loads),
            figures,
            is_answer: result.outcome.is_answer(),
            at: arrived.at,
        });
    }

    /// What the tare takes off in all.
    fn tared_total(&self) -> f64 {
        self.tare
            .as_ref()
            .map_or(0.0, |tare| tare.loads.iter().sum())
    }

    /// Fills `loads`: newtons, or siemens where there is no load law.
    fn solve(&mut self, arrived: &TimestampedFrame) -> FrameFigures {
        let result = self.exact.process(&arrived.frame);
        self.is_load &= result.loads.is_some();
        match (result.loads.filter(|_| self.is_load), result.siemens) {
            (Some(loads), _) => self.loads.clone_from(loads),
            (None, Some(siemens)) => {
                self.loads.copy_meta_from(siemens);
                self.loads.values_mut().copy_from_slice(siemens.values());
            }
            (None, None) => {}
        }
        if let Some(tare) = &mut self.tare {
            if tare.frames < TARE_FRAMES {
                add_mean(&mut tare.loads, self.loads.values(), tare.frames);
            }
            for (load, zero) in self.loads.values_mut().iter_mut().zip(&tare.loads) {
                *load -= zero;
            }
        }
        if self.is_load {
            FrameFigures::of(&self.loads, &self.sensor)
        } else {
            FrameFigures {
                outlier_share: taxel::metric::outlier_share(&self.loads),
                measured_share: taxel::metric::measured_share(&self.loads),
                ..FrameFigures::default()
            }
        }
    }

    fn message(&mut self, arrived: &TimestampedFrame, figures: &FrameFigures) -> FrameMessage {
        let result = self.raw.process(&arrived.frame);
        let mut raw = match (result.loads.filter(|_| self.is_load), result.siemens) {
            (Some(loads), _) => loads.values().to_vec(),
            (None, siemens) => siemens.map_or_else(Vec::new, |siemens| siemens.values().to_vec()),
        };
        let mut done = false;
        if let Some(tare) = &mut self.tare {
            if tare.frames < TARE_FRAMES {
                add_mean(&mut tare.raw, &raw, tare.frames);
                tare.frames += 1;
                done = tare.frames == TARE_FRAMES;
            }
            for (load, zero) in raw.iter_mut().zip(&tare.raw) {
                *load -= zero;
            }
        }
        if done {
            self.tell_tare(arrived.frame.sequence);
        }
        let mut message = FrameMessage::default();
        message.rows = self.loads.rows();
        message.columns = self.loads.columns();
        message.is_load = self.is_load;
        message.is_tared = self.tare.is_some();
        message.is_raw = self.method == MethodName::Raw;
        message.sequence = arrived.frame.sequence;
        message.device_secs = arrived.frame.time_secs;
        message.at = Some(arrived.at);
        message.total_newtons = figures.total_force_newtons;
        message.grip_newtons = figures.grip.map(|grip| grip.newtons);
        message.peak_kilopascals = figures.peak_kilopascals;
        message.contact_area_mm2 = figures.contact_area_mm2;
        message.centre = figures.centre_mm.map(|mm| self.sensor.lines_from_mm(mm));
        message.outlier_share = figures.outlier_share;
        message.frames_per_second = self.status.frames_per_second();
        message.counts = arrived.frame.values().iter().map(|&v| v as u16).collect();
        message.raw = raw.iter().map(|&v| v as f32).collect();
        message.loads = self.loads.values().iter().map(|&v| v as f32).collect();
        message.marks = self.loads.marks().iter().map(|mark| mark.code()).collect();
        message
    }

    /// A tare is data: which frames it is the mean of, and what it takes off in all.
    fn tell_tare(&self, last: u64) {
        let Some(tare) = &self.tare else { return };
        self.recorder.tare(taxel_io::Tare {
            from_sequence: last + 1,
            at: SystemTime::now(),
            unit: self.unit().to_owned(),
            loads: tare.loads.clone(),
            raw: tare.raw.clone(),
        });
        let total: f64 = tare.loads.iter().sum();
        let unit = self.unit();
        self.recorder.event(
            "tare",
            &format!(
                "tare: the mean of {} frames from {} to {last}, {total:.4} {unit} in all",
                tare.frames, tare.first
            ),
        );
    }

    fn unit(&self) -> &'static str {
        if self.is_load { "N" } else { "S" }
    }

    /// Nothing is taken off any more.
    fn untare(&mut self) {
        if self.tare.take().is_some() {
            let from = self.loads.sequence + 1;
            let undone = taxel_io::Tare::undone(from, SystemTime::now());
            self.recorder.tare(undone);
            self.recorder.event("tare", "tare cleared");
        }
        self.status.set_tare(false);
    }

    /// Of a recording: what was taken off when it was made is taken off when it is played.
    fn take_recorded_tare(&mut self, arrived: &TimestampedFrame) {
        let Some(recorded) = &arrived.tare else {
            return;
        };
        if *recorded == self.recorded_tare {
            return;
        }
        self.recorded_tare.clone_from(recorded);
        let taxels = self.loads.values().len();
        let fits =
            |tare: &&Arc<taxel_io::Tare>| tare.loads.len() == taxels && tare.unit == self.unit();
        self.tare = recorded.as_ref().filter(fits).map(|tare| Tare {
            raw: if tare.raw.len() == taxels {
                tare.raw.clone()
            } else {
                vec![0.0; taxels]
            },
            loads: tare.loads.clone(),
            frames: TARE_FRAMES,
            first: tare.from_sequence,
        });
        self.status.set_tare(self.tare.is_some());
    }

    /// Looks for faulty lines in frames now and then.
    fn look_at_lines(&mut self, arrived: &TimestampedFrame) {
        let now = Instant::now();
        if now < self.survey_due || self.survey.observe(&arrived.frame).is_err() {
            return;
        }
        self.survey_due = now + SURVEY_EVERY;
        self.surveyed += 1;
        if self.surveyed < SURVEY_FRAMES {
            return;
        }
        let faults = self.survey.finish().with_declared(self.sensor.screen());
        self.survey = LineScreen::from_sensor(&self.sensor);
        self.surveyed = 0;
        self.exact.set_lines(&faults);
        self.raw.set_lines(&faults);
        self.status.set_bad_lines(bad_lines(&faults));
        self.tell_of_suspects(&faults);
    }

    /// Says once of each line that may be dead that it may: what stands on it is in no sum, and no mark tells.
    fn tell_of_suspects(&mut self, faults: &LineFaults) {
        for fault in faults.suspects() {
            let line = (fault.axis, fault.index);
            if !self.suspects.contains(&line) {
                self.suspects.push(line);
                let words = FaultyLine::new(fault, false).text;
                self.status.note(&words);
                self.status.tell(format!("warning: {words}"));
            }
        }
    }

    fn apply(&mut self, command: EngineCommand) {
        match command {
            EngineCommand::Tare => {
                let taxels = self.loads.values().len();
                self.tare = Some(Tare {
                    raw: vec![0.0; taxels],
                    loads: vec![0.0; taxels],
                    frames: 0,
                    first: self.loads.sequence + 1,
                });
                self.status.set_tare(true);
            }
            EngineCommand::Untare => self.untare(),
            EngineCommand::Method(method) => self.rebuild(self.sensor.clone(), method),
            EngineCommand::Sensor(sensor) => {
                self.rebuild(Arc::new(*sensor), self.method.clone());
                self.blind_until = Some(Instant::now() + TURNED);
            }
        }
    }

    /// Another sensor or method; where they do not go together, all stays as it was.
    fn rebuild(&mut self, sensor: Arc<Sensor>, method: MethodName) {
        if let Ok([exact, raw]) = pipelines(&sensor, &self.file, &method) {
            self.status.set_method(exact_name(&exact, &method));
            (self.exact, self.raw) = (exact, raw);
            if method != self.method {
                // Zero by one method is not zero by another.
                self.untare();
            }
            self.is_load = gives_loads(&sensor, &method);
            (self.sensor, self.method) = (sensor, method);
            self.survey = LineScreen::from_sensor(&self.sensor);
            self.surveyed = 0;
        }
    }
}

/// By a load law, or by a model, which needs none.
pub(super) fn gives_loads(sensor: &Sensor, method: &MethodName) -> bool {
    sensor.material().is_some() || method.is_model()
}

pub(super) fn exact_name(pipeline: &Pipeline, method: &MethodName) -> String {
    match method {
        MethodName::Auto => pipeline.method_name().to_owned(),
        other => other.to_string(),
    }
}

fn pipelines(
    sensor: &Sensor,
    file: &std::path::Path,
    name: &MethodName,
) -> Result<[Pipeline; 2], Error> {
    let raw = Box::new(Raw::from_sensor(sensor));
    Ok([
        name.pipeline(sensor, file)?,
        if name.is_model() {
            // Raw readings stand beside loads: without a law of the sensor's own, as if 1 uS were a gram.
            Pipeline::new(&with_law(sensor.clone()), raw)?
        } else {
            Pipeline::new(sensor, raw)?
        },
    ])
}

fn bad_lines(faults: &LineFaults) -> BadLines {
    let mut lines = BadLines::default();
    for fault in &faults.faults {
        let of_axis = match (fault.axis, fault.kind == LineFaultKind::Suspect) {
            (Axis::Row, false) => &mut lines.rows,
            (Axis::Column, false) => &mut lines.columns,
            (Axis::Row, true) => &mut lines.suspect_rows,
            (Axis::Column, true) => &mut lines.suspect_columns,
        };
        of_axis.push(fault.index);
        if let LineFaultKind::Shorted { with } = fault.kind {
            of_axis.push(with);
        }
    }
    for lines in [&mut lines.rows, &mut lines.columns] {
        lines.sort_unstable();
        lines.dedup();
    }
    lines
}

/// The mean of `frames` + 1 frames from that of `frames`.
fn add_mean(mean: &mut [f64], values: &[f64], frames: u32) {
    for (mean, value) in mean.iter_mut().zip(values) {
        *mean += (value - *mean) / f64::from(frames + 1);
    }
}
