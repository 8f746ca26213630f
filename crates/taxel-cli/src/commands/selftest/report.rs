//! What the self-test found, for people and for scripts.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;
use taxel::Sensor;
use taxel::selftest::{Codes, Fault, Finding, Hum, Place, SelfTestResult};
use taxel::sensor::ScanOrder;

/// Findings of one kind on single taxels that are written out.
const NAMED: usize = 10;

/// All of it.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    sensor: String,
    rows: usize,
    columns: usize,
    /// Whether nothing was found.
    healthy: bool,
    empty_frames: u64,
    rubbed_frames: u64,
    baseline_counts: f64,
    noise_counts: f64,
    tested_share: f64,
    findings: Vec<Found>,
    /// The tests without a finding, and what they say.
    settling: Settling,
    hum: HumReport,
    codes: CodesReport,
    #[serde(skip)]
    taxels_affected: usize,
}

/// A finding.
#[derive(Debug, Serialize)]
struct Found {
    fault: &'static str,
    place: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    row: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    column: Option<usize>,
    taxels: usize,
    evidence: String,
    advice: String,
    #[serde(skip)]
    kind: Fault,
    #[serde(skip)]
    single: bool,
    #[serde(skip)]
    text: String,
}

#[derive(Debug, Serialize)]
struct Settling {
    /// `null` where it cannot be judged.
    share: Option<f64>,
    standard_error: Option<f64>,
    scan_order: Option<&'static str>,
    readings: u64,
}

#[derive(Debug, Serialize)]
struct HumReport {
    peaks: Vec<PeakReport>,
    /// Without a peak: an amplitude that would have been found, counts.
    below_counts: Option<f64>,
    not_judged: Option<String>,
}

#[derive(Debug, Serialize)]
struct PeakReport {
    mains_hz: f64,
    at_hz: f64,
    amplitude_counts: f64,
    chance: f64,
}

#[derive(Debug, Serialize)]
struct CodesReport {
    /// Codes between well-visited ones.
    judged: usize,
    not_judged: Option<String>,
}

impl Found {
    fn new(finding: &Finding) -> Self {
        let (row, column) = match finding.place {
            Place::Line { axis, index } | Place::Along { axis, index, .. } => on(axis, index),
            Place::Pair { axis, first } => on(axis, first),
            Place::Taxel { row, column } => (Some(row), Some(column)),
            Place::Array => (None, None),
        };
        Self {
            fault: finding.fault.word(),
            place: finding.place.to_string(),
            row,
            column,
            taxels: finding.taxels.len(),
            evidence: finding.evidence.clone(),
            advice: finding.advice.clone(),
            kind: finding.fault,
            single: matches!(finding.place, Place::Taxel { .. }),
            text: finding.to_string(),
        }
    }
}

fn on(axis: taxel::screen::Axis, index: usize) -> (Option<usize>, Option<usize>) {
    match axis {
        taxel::screen::Axis::Row => (Some(index), None),
        taxel::screen::Axis::Column => (None, Some(index)),
    }
}

impl Report {
    pub(super) fn new(sensor: &Sensor, result: &SelfTestResult) -> Self {
        let settling = result.settling;
        let (hum, codes) = (&result.hum, &result.codes);
        Self {
            sensor: sensor.name().to_owned(),
            rows: result.rows,
            columns: result.columns,
            healthy: result.is_good(),
            empty_frames: result.empty_frames,
            rubbed_frames: result.rubbed_frames,
            baseline_counts: result.baseline_counts,
            noise_counts: result.noise_counts,
            tested_share: result.tested_share,
            findings: result.findings.iter().map(Found::new).collect(),
            settling: Settling {
                share: settling.map(|s| s.share),
                standard_error: settling.map(|s| s.standard_error),
                scan_order: settling.map(|s| match s.order {
                    ScanOrder::RowByRow => "row-by-row",
                    ScanOrder::ColumnByColumn => "column-by-column",
                }),
                readings: settling.map_or(0, |s| s.readings),
            },
            hum: hum_report(hum),
            codes: CodesReport {
                judged: match codes {
                    Codes::Judged(_, judged) => *judged,
                    Codes::NotJudged(_) => 0,
                },
                not_judged: match codes {
                    Codes::Judged(..) => None,
                    Codes::NotJudged(why) => Some(why.clone()),
                },
            },
            taxels_affected: result.by_taxel().iter().flatten().count(),
        }
    }

    /// The line above the picture.
    pub(super) fn title(&self) -> String {
        let name = match self.sensor.as_str() {
            "" => "self-test".to_owned(),
            name => format!("{name}, self-test"),
        };
        match self.findings.len() {
            0 => format!("{name}: nothing found"),
            1 => format!("{name}: 1 finding"),
            found => format!("{name}: {found} findings"),
        }
    }

    fn has(&self, kind: Fault) -> bool {
        self.findings.iter().any(|found| found.kind == kind)
    }

    /// One line for each test of the whole read-out that found nothing, or could not.
    fn others(&self) -> Vec<String> {
        let mut lines = Vec::new();
        match (self.settling.share, self.settling.standard_error) {
            (Some(share), Some(error)) if !self.has(Fault::Settling) => lines.push(format!(
                "settling: a reading keeps {:.2} ± {:.2} % of the one before",
                100.0 * share,
                100.0 * error
            )),
            (None, _) => lines.push(
                "settling: cannot be judged; press the last taxels of some lines while the first of the next are free"
                    .to_owned(),
            ),
            _ => {}
        }
        match (&self.hum.not_judged, self.hum.below_counts) {
            (Some(why), _) => lines.push(format!("mains hum: cannot be judged: {why}")),
            (None, Some(counts)) => {
                lines.push(format!("mains hum: none of {counts:.2} counts or more"));
            }
            _ => {}
        }
        match &self.codes.not_judged {
            Some(why) => lines.push(format!("converter codes: cannot be judged: {why}")),
            None if !self.has(Fault::Codes) => lines.push(format!(
                "converter codes: all of the {} that could be judged occur",
                self.codes.judged
            )),
            None => {}
        }
        lines
    }
}

const UNTIMED: &str =
    "the empty recording has no times; --frames-per-second says how many frames a second";

fn hum_report(hum: &Hum) -> HumReport {
    let mut report = HumReport {
        peaks: Vec::new(),
        below_counts: None,
        not_judged: None,
    };
    match hum {
        Hum::Found(peaks) => {
            let peaks = peaks.iter().map(|peak| PeakReport {
                mains_hz: peak.mains_hz,
                at_hz: peak.at_hz,
                amplitude_counts: peak.amplitude_counts,
                chance: peak.chance,
            });
            report.peaks = peaks.collect();
        }
        Hum::Below(counts) => report.below_counts = Some(*counts),
        Hum::Untimed => report.not_judged = Some(UNTIMED.to_owned()),
        Hum::NotJudged(why) => report.not_judged = Some(why.clone()),
    }
    report
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} rows x {} columns, {} frames empty, {} rubbed",
            self.rows, self.columns, self.empty_frames, self.rubbed_frames
        )?;
        writeln!(
            f,
            "baseline {:.1} counts, noise {:.2} counts; {:.1} % of the taxels tested",
            self.baseline_counts,
            self.noise_counts,
            100.0 * self.tested_share
        )?;
        if self.healthy {
            writeln!(f, "healthy: nothing to solder")?;
        } else {
            writeln!(
                f,
                "{} found, on {} of {} taxels beside what concerns all; what to do, the most taxels first:",
                self.findings.len(),
                self.taxels_affected,
                self.rows * self.columns
            )?;
        }
        let mut named: BTreeMap<Fault, usize> = BTreeMap::new();
        for found in &self.findings {
            let count = named.entry(found.kind).or_default();
            *count += 1;
            if !found.single || *count <= NAMED {
                writeln!(f, "  {}", found.text)?;
            }
        }
        for (kind, count) in named {
            let single = self.findings.iter().any(|f| f.kind == kind && f.single);
            if single && count > NAMED {
                let more = count - NAMED;
                writeln!(
                    f,
                    "  … and {more} more taxels {}; --json has all",
                    kind.words()
                )?;
            }
        }
        for line in self.others() {
            writeln!(f, "{line}")?;
        }
        Ok(())
    }
}
