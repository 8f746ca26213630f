//! Frames in the unit to be drawn, without and with compensation.

use taxel::Frame;
use taxel_io::FrameSource;

use super::Job;
use crate::doubts::warn_of_suspects;
use crate::error::Error;
use crate::out::warn_unsolved;
use crate::progress::{Progress, Terminal};
use crate::recorded::Untared;
use taxel_app::chain::Chain;
use taxel_app::frames::{DisplayUnit, Input, open_shown, show};
use taxel_app::line_survey::Survey;
use taxel_app::methods::MethodName;
use taxel_app::units::InputUnit;

/// One frame to be drawn: as it was read, and with the cross-talk removed, where each is asked for.
pub(super) struct Stages<'a> {
    pub(super) raw: Option<&'a Frame<DisplayUnit>>,
    pub(super) compensated: Option<&'a Frame<DisplayUnit>>,
}

/// Which time frames are read: what there is to warn of is told once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pass {
    First,
    Again,
}

/// Shows every frame of the job's range to `see`; gives back how many there were.
pub(super) fn each(
    job: &Job<'_>,
    pass: Pass,
    see: impl FnMut(u64, Stages<'_>) -> Result<(), Error>,
) -> Result<u64, Error> {
    let (seen, read) = if job.args.values {
        each_value(job, see)?
    } else {
        each_count(job, pass, see)?
    };
    let range = job.range();
    if seen > 0 {
        return Ok(seen);
    }
    Err(taxel_app::Error::NoFrame {
        asked_by: if range.is_one() {
            "--frame"
        } else {
            "--frames"
        }
        .to_owned(),
        file: job.args.file.clone(),
        wanted: range.first,
        found: read,
    }
    .into())
}

/// How many frames were shown, and how many were read.
type Seen = (u64, u64);

fn each_value(
    job: &Job<'_>,
    mut see: impl FnMut(u64, Stages<'_>) -> Result<(), Error>,
) -> Result<Seen, Error> {
    let mut source = open_shown(&job.args.file, job.options)?;
    let mut frame = Frame::zeros(job.options.rows, job.options.columns);
    let range = job.range();
    let (mut seen, mut read) = (0, 0);
    let progress = Progress::new("reading");
    while range.end.is_none_or(|end| read < end) && source.next_into(&mut frame)? {
        if read >= range.first {
            if let Some(sensor) = &job.sensor {
                sensor.mark_absent(frame.marks_mut());
            }
            let stages = Stages {
                raw: None,
                compensated: Some(&frame),
            };
            see(read, stages)?;
            seen += 1;
        }
        read += 1;
        show(&source, &progress);
    }
    Ok((seen, read))
}

fn each_count(
    job: &Job<'_>,
    pass: Pass,
    mut see: impl FnMut(u64, Stages<'_>) -> Result<(), Error>,
) -> Result<Seen, Error> {
    let (Some(sensor), Some(unit)) = (&job.sensor, job.unit) else {
        unreachable!("a recording of counts has a sensor and a unit");
    };
    let name = &job.sensor_file;
    let mut input = Input::new(&job.args.file, InputUnit::Counts, sensor);
    input.options = job.options;
    let survey = Survey::of(&input, sensor, &Terminal, None)?;
    if pass == Pass::First {
        warn_of_suspects(&survey.faults);
    }
    let chain = |method: &MethodName| -> Result<Chain, Error> {
        let mut chain = Chain::new(sensor, name, method, unit)?;
        chain.set_lines(&survey.faults);
        Ok(chain)
    };
    let (wants_raw, wants_compensated) = job.stages();
    let mut raw = wants_raw.then(|| chain(&MethodName::Raw)).transpose()?;
    let mut best = wants_compensated
        .then(|| chain(&job.args.method))
        .transpose()?;
    let mut shown = [(); 2].map(|()| Frame::zeros(sensor.rows(), sensor.columns()));
    let range = job.range();
    let (mut seen, mut read) = (0, 0);
    let mut reading = input.open()?;
    let mut untared = Untared::new(job.args.no_tare);
    let progress = Progress::new("compensating");
    while range.end.is_none_or(|end| read < end) && reading.advance()? {
        if read >= range.first {
            for (i, (chain, shown)) in [&mut raw, &mut best]
                .into_iter()
                .zip(&mut shown)
                .enumerate()
            {
                let Some(chain) = chain else { continue };
                let outcome = chain.take(&reading)?;
                if let Some(outcome) = outcome.filter(|_| pass == Pass::First) {
                    warn_unsolved(read, &outcome);
                }
                chain.show_into(shown)?;
                if let Some(exported) = &job.exported {
                    let values = shown.values_mut().iter_mut();
                    values.for_each(|value| *value *= exported.per_siemens);
                }
                let raw = i == 0 || job.args.method == MethodName::Raw;
                untared.apply(reading.tare(), raw, chain.load_unit(), shown.values_mut());
            }
            let stages = Stages {
                raw: wants_raw.then_some(&shown[0]),
                compensated: wants_compensated.then_some(&shown[1]),
            };
            see(read, stages)?;
            seen += 1;
        }
        read += 1;
        reading.show(&progress);
    }
    Ok((seen, read))
}
