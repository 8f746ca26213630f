//! The files that `compensate` writes: numbers, marks, standard errors.

use std::path::{Path, PathBuf};

use taxel::{Frame, Sensor};
use taxel_record::npy::Element;

use super::Args;
use crate::error::Error;
use crate::frames::{FrameWriter, Shown};
use crate::out;

/// What is written, frame by frame; nothing appears under its name before `commit`.
pub(super) struct Outputs {
    numbers: FrameWriter<Shown>,
    marks: Option<FrameWriter<Shown>>,
    errors: Option<FrameWriter<Shown>>,
    codes: Frame<Shown>,
}

impl Outputs {
    pub(super) fn create(args: &Args, sensor: &Sensor, frames: Option<u64>) -> Result<Self, Error> {
        let shape = (sensor.rows(), sensor.columns());
        let create = |file: &Path, element| FrameWriter::create(file, shape, element, frames);
        let numbers = args.output.as_deref().unwrap_or(Path::new("-"));
        let marks = marks_file(args);
        Ok(Self {
            numbers: create(numbers, Element::F8)?,
            marks: marks.map(|file| create(&file, Element::U1)).transpose()?,
            errors: match &args.standard_error {
                Some(file) => Some(create(file, Element::F8)?),
                None => None,
            },
            codes: Frame::zeros(shape.0, shape.1),
        })
    }

    pub(super) fn write(&mut self, shown: &Frame<Shown>) -> Result<(), Error> {
        self.numbers.write(shown)?;
        if let Some(marks) = &mut self.marks {
            let codes = self.codes.values_mut().iter_mut();
            for (code, mark) in codes.zip(shown.marks()) {
                *code = mark.code().into();
            }
            marks.write(&self.codes)?;
        }
        Ok(())
    }

    pub(super) fn write_errors(&mut self, errors: &Frame<Shown>) -> Result<(), Error> {
        match &mut self.errors {
            Some(writer) => writer.write(errors),
            None => Ok(()),
        }
    }

    pub(super) fn commit(self) -> Result<(), Error> {
        for writer in [self.marks, self.errors].into_iter().flatten() {
            writer.commit()?;
        }
        self.numbers.commit()
    }
}

/// Where the marks go: where the user says, else beside the numbers.
pub(super) fn marks_file(args: &Args) -> Option<PathBuf> {
    let beside = || {
        let output = args.output.as_ref()?;
        let is_file = !out::is_stdout(output) && !output.starts_with("/dev");
        is_file.then(|| output.with_extension("marks.csv"))
    };
    args.marks.clone().or_else(beside)
}
