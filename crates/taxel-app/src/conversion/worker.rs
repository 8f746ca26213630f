//! What one thread does with a frame.

use taxel::screen::LineFaults;
use taxel::uncertainty::NoiseBias;

use super::frame::{Block, Converted, Read};
use super::{FiguresWanted, Request};
use crate::chain::Chain;
use crate::error::Error;
use crate::figures::Figures;
use crate::in_order::Work;
use crate::methods::MethodName;
use crate::standard_error::{Part, StandardErrors};
use crate::tare;

/// A thread's own pipeline.
pub(super) struct Worker {
    pub(super) chain: Chain,
    errors: Option<StandardErrors>,
    figures: Option<Figures>,
    bias: Option<NoiseBias>,
}

fn chain(request: &Request, faults: &LineFaults) -> Result<Chain, Error> {
    let mut chain = Chain::new(
        request.sensor,
        request.sensor_file,
        request.method,
        request.unit,
    )?;
    if let Some(repair) = request.repair {
        chain.set_repair(repair);
    }
    chain.set_lines(faults);
    Ok(chain)
}

impl Worker {
    pub(super) fn new(request: &Request, faults: &LineFaults) -> Result<Self, Error> {
        let Request {
            sensor,
            sensor_file,
            unit,
            ..
        } = *request;
        let chain = chain(request, faults)?;
        let level = faults.level;
        let errors = request
            .errors
            .any()
            .then(|| StandardErrors::new(sensor, sensor_file, unit, level));
        let figures = request.figures.map(|wanted| match wanted {
            // Nothing tells how far to trust what another program has found.
            _ if sensor.exported().is_some() => Ok(Figures::without_errors(sensor, unit)),
            FiguresWanted::Values => Ok(Figures::without_errors(sensor, unit)),
            FiguresWanted::WithErrors => Figures::new(sensor, sensor_file, unit, level),
        });
        let figures = figures.transpose()?.map(|figures| {
            let figures = figures.touched_above(request.touched_newtons);
            figures.with_regions(request.regions)
        });
        let bias = if figures.is_some() && request.method.inverts() {
            // One of its own: what goes through it is no frame of the recording.
            let own = self::chain(request, faults)?.into_pipeline();
            NoiseBias::new(sensor, own, level)
        } else {
            None
        };
        Ok(Self {
            bias,
            chain,
            errors: errors.transpose()?,
            figures,
        })
    }

    pub(super) fn noise_counts(&self) -> Option<f64> {
        self.errors.as_ref().map(|errors| errors.noise_counts)
    }

    fn convert(&mut self, frame: &mut Converted, request: &Request) -> Result<(), Error> {
        if frame.is_first {
            self.chain.begin_anew();
            self.bias.iter_mut().for_each(NoiseBias::begin_anew);
        }
        frame.outcome = match &frame.read {
            Read::Counts(counts) => self.chain.take_screened(counts),
            Read::Volts(volts) => self.chain.take_volts(volts),
            Read::Siemens(siemens) => {
                self.chain.take_siemens(siemens)?;
                None
            }
        };
        self.chain.show_into(&mut frame.shown)?;
        self.find_errors(frame)?;
        if let Some(tare) = frame.tare.as_ref().filter(|_| !request.no_tare) {
            let raw = *request.method == MethodName::Raw;
            let loads = frame.shown.values_mut();
            if let Some(zeros) = tare::zeros(tare, raw, request.unit, loads.len()) {
                tare::take_off(zeros, self.chain.load_unit(), loads);
            }
        }
        if let Some(zeros) = request.zeros {
            tare::take_off(zeros, self.chain.load_unit(), frame.shown.values_mut());
        }
        self.find_figures(frame);
        Ok(())
    }

    fn find_figures(&mut self, frame: &mut Converted) {
        frame.figures = None;
        let (Some(figures), Some(loads)) = (&mut self.figures, self.chain.loads()) else {
            return;
        };
        if let Some(bias) = &mut self.bias {
            let has_volts = frame.is_answer() && !matches!(frame.read, Read::Siemens(_));
            let volts = has_volts.then(|| self.chain.volts());
            let found = volts.and_then(|volts| bias.of(volts, loads));
            figures.set_bias(found);
            // For whoever finds the errors of this frame later.
            frame.bias = found.filter(|_| frame.siemens.is_some()).cloned();
        }
        let siemens = self.chain.siemens();
        let mut row = figures.of(siemens, loads, &frame.shown, frame.is_answer());
        row.frame = frame.sequence();
        frame.figures = Some(row);
        figures.regions_into(&mut frame.regions);
        if let (Some(out), Some(siemens)) = (&mut frame.siemens, siemens) {
            out.copy_meta_from(siemens);
            out.values_mut().copy_from_slice(siemens.values());
        }
    }

    /// How far to trust the numbers, before any tare: readings were uncertain by as much.
    fn find_errors(&mut self, frame: &mut Converted) -> Result<(), Error> {
        let (Some(errors), Some(siemens)) = (&mut self.errors, self.chain.siemens()) else {
            return Ok(());
        };
        let is_answer = frame.is_answer();
        let found = errors.of(siemens, is_answer, &mut frame.shown)?;
        if let Some(out) = &mut frame.errors.standard_errors {
            out.copy_meta_from(found);
            out.values_mut().copy_from_slice(found.values());
        }
        if let Some(out) = &mut frame.errors.half_widths {
            errors.half_widths_into(out);
        }
        for (part, out) in Part::ALL.into_iter().zip(&mut frame.errors.parts) {
            errors.part_into(part, out);
        }
        Ok(())
    }
}

/// The work on a block, by any thread.
pub(super) struct Converting<'a> {
    pub(super) request: &'a Request<'a>,
}

impl Work<Block> for Converting<'_> {
    type Worker = Worker;

    fn work(&self, worker: &mut Worker, block: &mut Block) {
        for frame in block.converted_mut() {
            frame.failed = if (self.request.is_stopped)() {
                Some(Error::Stopped)
            } else {
                worker.convert(frame, self.request).err()
            };
        }
    }
}
