//! From what was counted to the list of findings: one for every line or taxel, the gravest that explains it.

use super::along::SeenAlong;
use super::finding::advice;
use super::quiet::median;
use super::{
    CodeFault, Codes, Fault, Finding, Hum, Place, Rubbed, SelfTest, SelfTestResult, Settling,
};
use crate::screen::{Axis, LineFaultKind, LineFaults};
use crate::sensor::ScanOrder;

/// Share of a line's taxels that make a line of them.
const LINE_SHARE: f64 = 0.8;
/// Share of the taxels beside a line at an edge that must have been reached before its silence counts.
const BESIDE_SHARE: f64 = 0.8;
/// Median absolute deviations above the median silence of all lines that gaps in a hand do not reach.
const GAP_SPREADS: f64 = 9.0;
/// Counts of noise that an open line shows and a grounded one does not.
const VISIBLE_NOISE: f64 = 2.0;

/// Findings so far, and which taxels they explain.
pub(super) struct Classifier<'a> {
    pub(super) test: &'a SelfTest,
    pub(super) rubbed: &'a Rubbed,
    pub(super) seen: SeenAlong,
    pub(super) findings: Vec<Finding>,
    explained: Vec<bool>,
}

pub(super) fn classify(test: &SelfTest, rubbed: &Rubbed) -> SelfTestResult {
    let taxels = test.rows * test.columns;
    let mut found = Classifier {
        test,
        rubbed,
        seen: SeenAlong::default(),
        findings: Vec::new(),
        explained: (0..taxels)
            .map(|taxel| rubbed.response.is_absent(taxel))
            .collect(),
    };
    let faults = rubbed.lines.finish();
    found.lines_at_an_end();
    found.shorted_taxels();
    found.along_lines();
    found.open_lines(&faults);
    found.shorted_lines(&faults);
    found.flickering_lines(&faults);
    found.silent_edges();
    found.taxels();
    found.stray_readings();
    let settling = rubbed.carry_over.finish();
    let hum = test.hum.finish(taxels, &test.options);
    let codes = test.codes.finish(&test.options);
    found.settling(settling);
    found.hum(&hum);
    found.codes(&codes);
    let tested_share = found.not_pressed();
    let mut findings = found.findings;
    let order = |f: &Finding| (std::cmp::Reverse(f.taxels.len()), f.fault);
    findings.sort_by_key(order);
    SelfTestResult {
        findings,
        rows: test.rows,
        columns: test.columns,
        absent: test.options.screen.absent.clone(),
        empty_frames: test.empty_frames,
        rubbed_frames: rubbed.response.frames,
        baseline_counts: rubbed.unloaded.typical_counts,
        noise_counts: rubbed.unloaded.typical_noise,
        tested_share,
        settling,
        hum,
        codes,
    }
}

impl Classifier<'_> {
    pub(super) fn line(&self, axis: Axis, index: usize) -> Vec<usize> {
        self.rubbed.response.line(axis, index).collect()
    }

    pub(super) fn is_explained(&self, axis: Axis, index: usize) -> bool {
        let line = self.line(axis, index);
        let known = line.iter().filter(|&&taxel| self.explained[taxel]).count();
        known as f64 >= LINE_SHARE * line.len() as f64 || self.is_known_along(axis, index)
    }

    /// Adds a finding; its taxels are explained from here on, unless it is about the whole read-out.
    pub(super) fn add(&mut self, fault: Fault, place: Place, taxels: Vec<usize>, evidence: String) {
        if place != Place::Array {
            for &taxel in &taxels {
                self.explained[taxel] = true;
            }
        }
        self.findings.push(Finding {
            fault,
            place,
            taxels,
            evidence,
            advice: advice(fault, place),
        });
    }

    fn add_line(&mut self, fault: Fault, axis: Axis, index: usize, evidence: String) {
        let taxels = self.line(axis, index);
        self.add(fault, Place::Line { axis, index }, taxels, evidence);
    }

    fn lines_at_an_end(&mut self) {
        let share = self.test.options.line_end_share;
        for axis in Axis::BOTH {
            for index in self.rubbed.response.lines(axis) {
                let taxels = self.line(axis, index).into_iter();
                let at_end = self.test.ends.line_share(taxels, true, share);
                if at_end >= self.test.options.screen.line_share {
                    let evidence = format!(
                        "{:.0} % of its taxels read {:.0} with and without a load",
                        100.0 * at_end,
                        self.test.max_count
                    );
                    self.add_line(Fault::LineAtSupply, axis, index, evidence);
                }
            }
        }
    }

    /// Shorted taxels; all that is masked because of them is explained.
    fn shorted_taxels(&mut self) {
        let (unloaded, most) = (&self.rubbed.unloaded, self.test.max_count);
        for (taxel, &usual) in unloaded.counts.iter().enumerate() {
            if self.explained[taxel] || usual < self.test.options.shorted_share * most {
                continue;
            }
            let place = self.place(taxel);
            let evidence = format!(
                "reads {usual:.0} of {most:.0} without a load; of its row and column nothing else can be told until then"
            );
            self.add(Fault::TaxelShorted, place, vec![taxel], evidence);
        }
        for (explained, masked) in self.explained.iter_mut().zip(&unloaded.masked) {
            *explained |= masked;
        }
    }

    fn place(&self, taxel: usize) -> Place {
        Place::Taxel {
            row: taxel / self.test.columns,
            column: taxel % self.test.columns,
        }
    }

    fn open_lines(&mut self, faults: &LineFaults) {
        for axis in Axis::BOTH {
            for index in self.rubbed.response.lines(axis) {
                let dead = faults.faults.iter().any(|fault| {
                    (fault.axis, fault.index, fault.kind) == (axis, index, LineFaultKind::Dead)
                        // No gap in a hand makes a line fall.
                        && (fault.has_fallen
                            || self.silence(axis, index) >= self.test.options.screen.line_share)
                });
                let response = &self.rubbed.response;
                let open = dead || response.is_open(axis, index, &self.test.options);
                if !open || self.is_explained(axis, index) {
                    continue;
                }
                let taxels = self.line(axis, index);
                let grounded = self
                    .test
                    .ends
                    .line_share(taxels.iter().copied(), false, 0.99);
                // Converted noise is half cut off at 0: an open input of that noise is above it in every other frame.
                let noise = self.rubbed.unloaded.typical_noise;
                let at_ground = grounded >= LINE_SHARE && noise >= VISIBLE_NOISE;
                let silent = taxels.iter().filter(|&&t| response.loaded[t] == 0).count();
                let mut own: Vec<f64> = taxels
                    .iter()
                    .map(|&t| self.rubbed.unloaded.counts[t])
                    .collect();
                let evidence = format!(
                    "{silent} of {} taxels never responded; unloaded they read {:.0}, the array {:.0}",
                    taxels.len(),
                    median(&mut own),
                    self.rubbed.unloaded.typical_counts
                );
                let fault = if at_ground {
                    Fault::LineAtGround
                } else {
                    Fault::LineOpen
                };
                self.add_line(fault, axis, index, evidence);
            }
        }
    }

    fn shorted_lines(&mut self, faults: &LineFaults) {
        for fault in &faults.faults {
            let LineFaultKind::Shorted { with } = fault.kind else {
                continue;
            };
            let (axis, first) = (fault.axis, fault.index);
            if self.is_explained(axis, first) && self.is_explained(axis, with) {
                continue;
            }
            let mut taxels = self.line(axis, first);
            taxels.extend(self.line(axis, with));
            taxels.sort_unstable();
            let evidence = format!(
                "alike in {:.1} % of {} loaded readings; the typical pair of {axis}s in {:.1} %",
                100.0 * fault.faulty as f64 / fault.tested.max(1) as f64,
                fault.tested,
                100.0 * fault.next_to
            );
            self.add(
                Fault::LinesShorted,
                Place::Pair { axis, first },
                taxels,
                evidence,
            );
        }
    }

    fn flickering_lines(&mut self, faults: &LineFaults) {
        for axis in Axis::BOTH {
            let usual = self.usual_silence(axis);
            for fault in faults.faults.iter().filter(|fault| fault.axis == axis) {
                let flickers = fault.kind == LineFaultKind::Flickering;
                if flickers
                    && !self.is_explained(axis, fault.index)
                    && (fault.has_fallen || self.silence(axis, fault.index) > usual)
                {
                    let evidence =
                        format!("out in {} of {} rubbed frames", fault.faulty, fault.tested);
                    self.add_line(Fault::LineFlickering, axis, fault.index, evidence);
                }
            }
        }
    }

    fn silence(&self, axis: Axis, index: usize) -> f64 {
        self.rubbed
            .response
            .silent_share(axis, index, &self.test.options)
    }

    /// The silence that gaps in a hand can make on any line of an axis: the median of all lines, and its spread.
    fn usual_silence(&self, axis: Axis) -> f64 {
        let lines = self.rubbed.response.lines(axis).into_iter();
        let mut shares: Vec<f64> = lines.map(|i| self.silence(axis, i)).collect();
        let middle = median(&mut shares);
        for share in &mut shares {
            *share = (*share - middle).abs();
        }
        middle + (GAP_SPREADS * median(&mut shares)).max(self.test.options.flicker_share)
    }

    /// Lines at the edge that never answered, while the next one did along nearly all of its length.
    fn silent_edges(&mut self) {
        for axis in Axis::BOTH {
            let lines = self.rubbed.response.lines(axis);
            let count = lines.len();
            if count < 2 {
                continue;
            }
            for (edge, inner) in [(lines[0], lines[1]), (lines[count - 1], lines[count - 2])] {
                let response = &self.rubbed.response;
                let reached = response.reached(axis, inner);
                if response.never_loaded(axis, edge)
                    && reached >= BESIDE_SHARE
                    && !self.is_explained(axis, edge)
                {
                    let evidence = format!(
                        "no taxel of it ever responded; {:.0} % of {axis} {inner} did",
                        100.0 * reached
                    );
                    self.add_line(Fault::LineSilent, axis, edge, evidence);
                }
            }
        }
    }

    /// Single taxels, and lines of them.
    fn taxels(&mut self) {
        let mut found: Vec<Option<(Fault, String)>> = (0..self.explained.len())
            .map(|taxel| {
                (!self.explained[taxel])
                    .then(|| self.fault_of(taxel))
                    .flatten()
            })
            .collect();
        for axis in Axis::BOTH {
            for index in self.rubbed.response.lines(axis) {
                let line = self.line(axis, index);
                let noisy = |t: &&usize| matches!(&found[**t], Some((Fault::TaxelNoisy, _)));
                let count = line.iter().filter(noisy).count();
                if count as f64 >= LINE_SHARE * line.len() as f64 {
                    for &taxel in &line {
                        found[taxel] = None;
                    }
                    let mut noise: Vec<f64> = line
                        .iter()
                        .map(|&t| self.rubbed.unloaded.noise[t])
                        .collect();
                    let evidence = format!(
                        "{count} of {} taxels, median noise {:.1} counts; the array {:.1}",
                        line.len(),
                        median(&mut noise),
                        self.rubbed.unloaded.typical_noise
                    );
                    self.add_line(Fault::LineNoisy, axis, index, evidence);
                }
            }
        }
        for (taxel, found) in found.into_iter().enumerate() {
            if let Some((fault, evidence)) = found {
                let place = self.place(taxel);
                self.add(fault, place, vec![taxel], evidence);
            }
        }
    }

    fn fault_of(&self, taxel: usize) -> Option<(Fault, String)> {
        let (unloaded, options) = (&self.rubbed.unloaded, &self.test.options);
        let usual = unloaded.counts[taxel];
        let tally = &self.test.ends.taxels[taxel];
        let answers = self.rubbed.response.around[taxel];
        let supported = answers.supported >= options.supported_frames;
        let away = (usual - unloaded.typical_counts).abs();
        let would_show = unloaded.typical_noise >= 1.0 || away > unloaded.loaded[taxel];
        if tally.is_constant() && would_show {
            let evidence = format!("{usual:.0} in all {} frames", self.test.ends.frames);
            return Some((Fault::TaxelStuck, evidence));
        }
        let given = answers.given_share();
        if supported && given <= options.screen.silent_share {
            let evidence = format!(
                "reads {:.0} % of what is around it, in {} frames in which all of that was loaded",
                100.0 * given,
                answers.supported
            );
            return Some((Fault::TaxelOpen, evidence));
        }
        // Before what silence tells: noise about a low baseline is silent in half of the frames.
        if unloaded.is_noisy(taxel, options) {
            let (noise, typical) = (unloaded.noise[taxel], unloaded.typical_noise);
            let evidence = format!("noise {noise:.1} counts; the array {typical:.1}");
            return Some((Fault::TaxelNoisy, evidence));
        }
        let close = self.rubbed.response.close[taxel];
        let often = close.silent >= options.flicker_frames;
        if often && close.silent_share() >= options.flicker_share {
            let evidence = format!(
                "silent in {} of {} frames in which all around it was loaded, and not in the others",
                close.silent, close.supported
            );
            return Some((Fault::TaxelFlickering, evidence));
        }
        let frames = self.rubbed.response.frames;
        let share = f64::from(tally.stuck) / frames.max(1) as f64;
        if tally.stuck >= options.stuck_readings && share >= options.stuck_share {
            let evidence = format!(
                "at an end of the converter without a reason in {} of {frames} rubbed frames",
                tally.stuck
            );
            // A contact that opens falls to the lower end and comes back.
            let falls = 2 * tally.low >= tally.stuck && share < options.open_share;
            let fault = if falls {
                Fault::TaxelFlickering
            } else {
                Fault::TaxelStuck
            };
            return Some((fault, evidence));
        }
        None
    }

    fn whole(&self) -> Vec<usize> {
        let response = &self.rubbed.response;
        (0..self.explained.len())
            .filter(|&t| !response.is_absent(t))
            .collect()
    }

    /// Readings at an end that no finding explains.
    fn stray_readings(&mut self) {
        let unexplained = |taxel: &usize| !self.explained[*taxel];
        let taxels: Vec<usize> = self.whole().into_iter().filter(unexplained).collect();
        let stuck: u64 = taxels
            .iter()
            .map(|&t| u64::from(self.test.ends.taxels[t].stuck))
            .sum();
        let readings = taxels.len() as u64 * self.rubbed.response.frames;
        let share = stuck as f64 / readings.max(1) as f64;
        if share >= self.test.options.stray_share && stuck >= 20 {
            let evidence = format!(
                "{stuck} of {readings} rubbed readings ({:.2} %) stand at an end of the converter without a reason",
                100.0 * share
            );
            self.add(Fault::StrayReadings, Place::Array, taxels, evidence);
        }
    }

    fn settling(&mut self, settling: Option<Settling>) {
        let options = &self.test.options;
        let Some(settling) = settling else { return };
        let clear = settling.share > options.settling_sigmas * settling.standard_error;
        if !clear || settling.share < options.settling_share {
            return;
        }
        let along = match settling.order {
            ScanOrder::RowByRow => "row by row",
            ScanOrder::ColumnByColumn => "column by column",
        };
        let evidence = format!(
            "a reading keeps {:.2} ± {:.2} % of the one before, scanned {along}",
            100.0 * settling.share,
            100.0 * settling.standard_error
        );
        self.add(Fault::Settling, Place::Array, self.whole(), evidence);
    }

    fn hum(&mut self, hum: &Hum) {
        let Hum::Found(peaks) = hum else { return };
        let said: Vec<String> = peaks
            .iter()
            .map(|peak| {
                format!(
                    "{:.2} counts at {:.2} Hz ({} Hz mains frequency)",
                    peak.amplitude_counts, peak.at_hz, peak.mains_hz
                )
            })
            .collect();
        let evidence = format!("amplitude {}", said.join(", "));
        self.add(Fault::Hum, Place::Array, self.whole(), evidence);
    }

    fn codes(&mut self, codes: &Codes) {
        let Codes::Judged(faults, _) = codes else {
            return;
        };
        for fault in faults {
            let evidence = match fault {
                CodeFault::StuckBit { bit, set } => {
                    format!("bit {bit} is always {}", u8::from(*set))
                }
                CodeFault::Steps { step } => format!("codes come in steps of {step}"),
                CodeFault::Missing {
                    codes,
                    first,
                    judged,
                } => {
                    let first: Vec<String> = first.iter().map(u64::to_string).collect();
                    let more = if *codes > first.len() { ", …" } else { "" };
                    format!("{codes} of {judged} codes: {}{more}", first.join(", "))
                }
                CodeFault::Odd {
                    share,
                    standard_error,
                } => format!(
                    "{:.1} ± {:.1} % of neighbouring codes are odd ones",
                    100.0 * share,
                    100.0 * standard_error
                ),
            };
            self.add(Fault::Codes, Place::Array, self.whole(), evidence);
        }
    }

    /// Taxels about which nothing is known. Gives the share about which something is.
    fn not_pressed(&mut self) -> f64 {
        let options = &self.test.options;
        let response = &self.rubbed.response;
        let unknown = |taxel: &usize| {
            !self.explained[*taxel]
                && response.loaded[*taxel] == 0
                && response.around[*taxel].supported < options.supported_frames
        };
        let all = self.whole().len();
        let taxels: Vec<usize> = self.whole().into_iter().filter(unknown).collect();
        let share = taxels.len() as f64 / all.max(1) as f64;
        if share > options.untested_share {
            let evidence = format!(
                "{} of {} taxels ({:.0} %) never responded, nor did their surroundings",
                taxels.len(),
                all,
                100.0 * share
            );
            self.add(Fault::NotPressed, Place::Array, taxels, evidence);
        }
        1.0 - share
    }
}
