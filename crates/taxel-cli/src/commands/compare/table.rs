//! The contest as a table, a file, and a figure.

use std::fmt;
use std::path::Path;

use serde::Serialize;
use taxel_learn::Split;
use taxel_learn::benchmark::{Bin, Errors, Scores};
use taxel_plot::{Format, Line, Series};

use super::Args;
use super::candidates::Candidate;
use crate::error::Error;
use crate::out;
use taxel_app::training_set::TrainingSet;

/// One way from counts to loads.
#[derive(Debug, Serialize)]
struct Entry {
    name: String,
    learnt_from: usize,
    presses: Option<Errors>,
    taxels: Option<Errors>,
    largest_ghost_g: Option<f64>,
    mean_ghost_g: Option<f64>,
    milliseconds_a_frame: Option<f64>,
    by_load: Vec<Bin>,
    by_rest_of_row: Vec<Bin>,
    note: String,
}

/// All of them.
#[derive(Debug, Serialize)]
pub(super) struct Table {
    sources: Vec<String>,
    known_presses: usize,
    judged_presses: usize,
    judged_frames: usize,
    entries: Vec<Entry>,
}

impl Table {
    pub(super) fn new(
        args: &Args,
        training_set: &TrainingSet,
        split: &Split,
        frames: usize,
    ) -> Self {
        let names = training_set
            .sources
            .iter()
            .map(|source| source.name.clone());
        let recordings = args.recordings.iter().map(|r| r.display().to_string());
        Self {
            sources: names.chain(recordings).collect(),
            known_presses: split.train.len() + split.check.len(),
            judged_presses: split.test.len(),
            judged_frames: frames,
            entries: Vec::new(),
        }
    }

    /// Whether a candidate of that name learnt from as many presses already.
    pub(super) fn has(&self, candidate: &Candidate) -> bool {
        let same = |e: &Entry| (&e.name, e.learnt_from) == (&candidate.name, candidate.learnt_from);
        self.entries.iter().any(same)
    }

    pub(super) fn add(&mut self, candidate: &Candidate, scores: &Scores) {
        let ghosts = scores.ghosts_g();
        self.entries.push(Entry {
            name: candidate.name.clone(),
            learnt_from: candidate.learnt_from,
            presses: scores.of_presses(),
            taxels: scores.of_taxels(),
            largest_ghost_g: ghosts.map(|g| g.0),
            mean_ghost_g: ghosts.map(|g| g.1),
            milliseconds_a_frame: scores.milliseconds(),
            by_load: scores.by_load(),
            by_rest_of_row: scores.by_rest(),
            note: candidate.note.clone(),
        });
    }

    /// One line a candidate, everything in it.
    pub(super) fn write_csv(&self, file: &Path) -> Result<(), Error> {
        let mut text = String::from(
            "method,learnt_from,press_count,press_mae_g,press_mae_standard_error_g,press_rmse_g,press_p95_g,\
             taxel_count,taxel_mae_g,taxel_rmse_g,taxel_p95_g,largest_ghost_g,mean_ghost_g,ms_a_frame",
        );
        if let Some(first) = self.entries.first() {
            for bin in &first.by_load {
                text += &format!(",mae_load_{}_to_{}_g", bin.from_g, bin.to_g);
            }
            for bin in &first.by_rest_of_row {
                text += &format!(",mae_rest_of_row_{}_to_{}_g", bin.from_g, bin.to_g);
            }
        }
        text.push('\n');
        for entry in &self.entries {
            let name = entry.name.replace(',', ";");
            let mut cells = vec![name, entry.learnt_from.to_string()];
            let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.6}"));
            let p = entry.presses.as_ref();
            cells.push(p.map_or(String::new(), |e| e.count.to_string()));
            cells.push(number(p.map(|e| e.mean_absolute_g)));
            cells.push(number(p.and_then(|e| e.standard_error_g)));
            cells.push(number(p.map(|e| e.root_mean_square_g)));
            cells.push(number(p.map(|e| e.p95_g)));
            let t = entry.taxels.as_ref();
            cells.push(t.map_or(String::new(), |e| e.count.to_string()));
            cells.push(number(t.map(|e| e.mean_absolute_g)));
            cells.push(number(t.map(|e| e.root_mean_square_g)));
            cells.push(number(t.map(|e| e.p95_g)));
            cells.push(number(entry.largest_ghost_g));
            cells.push(number(entry.mean_ghost_g));
            cells.push(number(entry.milliseconds_a_frame));
            let bins = entry.by_load.iter().chain(&entry.by_rest_of_row);
            cells.extend(bins.map(|bin| number(bin.mean_absolute_g)));
            text += &cells.join(",");
            text.push('\n');
        }
        out::file(file, text.as_bytes())
    }

    /// Error against load, one line a candidate; against the number of presses, where there are several. Logarithms,
    /// since candidates differ by orders of magnitude.
    pub(super) fn draw(&self, file: &Path) -> Result<(), Error> {
        let format = Format::from_extension(file)?;
        let mut sizes: Vec<usize> = self.entries.iter().map(|e| e.learnt_from).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let mut names: Vec<&String> = Vec::new();
        for entry in &self.entries {
            if !names.contains(&&entry.name) {
                names.push(&entry.name);
            }
        }
        let series = if names.len() < self.entries.len() {
            self.learning_curve(&sizes, &names)?
        } else {
            self.by_load()?
        };
        let Some(series) = series else {
            return Ok(());
        };
        let picture = series
            .quantity("mean absolute error")
            .unit("log10 g")
            .caption(match self.judged_frames {
                0 => format!("On {} held-out presses.", self.judged_presses),
                n => format!("On loaded taxels of {n} frames."),
            })
            .picture()?;
        out::file(file, &picture.render(format)?)
    }

    fn by_load(&self) -> Result<Option<Series>, Error> {
        // The middle of every bin; the last has no end.
        let middle = |bin: &Bin| {
            if bin.to_g.is_finite() {
                0.5 * (bin.from_g + bin.to_g)
            } else {
                1.25 * bin.from_g
            }
        };
        let Some(first) = self.entries.first() else {
            return Ok(None);
        };
        let x: Vec<f64> = first.by_load.iter().map(middle).collect();
        let lines = self
            .entries
            .iter()
            .map(|entry| {
                let values = entry
                    .by_load
                    .iter()
                    .map(|bin| logarithm(bin.mean_absolute_g));
                Line::new(&entry.name, values.collect())
            })
            .collect();
        Ok(Some(
            Series::new("load (g)", x, lines)?.title("Error against load"),
        ))
    }

    fn learning_curve(&self, sizes: &[usize], names: &[&String]) -> Result<Option<Series>, Error> {
        let error = |entry: &Entry| {
            let found = entry.taxels.as_ref().or(entry.presses.as_ref());
            logarithm(found.map(|e| e.mean_absolute_g))
        };
        let lines = names
            .iter()
            .map(|name| {
                let at = |&size: &usize| {
                    // Who could not learn from more stays as good.
                    self.entries
                        .iter()
                        .filter(|e| &&e.name == name && e.learnt_from <= size)
                        .max_by_key(|e| e.learnt_from)
                        .map_or(f64::NAN, error)
                };
                Line::new(name.as_str(), sizes.iter().map(at).collect())
            })
            .collect();
        let x = sizes.iter().map(|&n| (n as f64).log10()).collect();
        Ok(Some(
            Series::new("presses learnt from (log10)", x, lines)?.title("Learning curve"),
        ))
    }
}

/// log10 of an error, grams; not below a milligram.
fn logarithm(error_g: Option<f64>) -> f64 {
    error_g.map_or(f64::NAN, |error| error.max(1e-3).log10())
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(
            f,
            "up to {} presses to learn from; judged on {} held-out presses (those with frames: every way) and {} frames; errors in grams",
            self.known_presses, self.judged_presses, self.judged_frames
        )?;
        writeln!(
            f,
            "{:<28}{:>38} |{:>30} |{:>20}",
            "", "held-out presses", "loaded taxels of frames", "ghost"
        )?;
        writeln!(
            f,
            "{:<22}{:>6}{:>20}{:>9}{:>9} |{:>12}{:>9}{:>9} |{:>10}{:>10}{:>10}",
            "",
            "learnt",
            "mean absolute",
            "rms",
            "95 %",
            "mean abs.",
            "rms",
            "95 %",
            "largest",
            "mean",
            "ms/frame"
        )?;
        let number = |value: Option<f64>| value.map_or("–".to_owned(), |v| format!("{v:.3}"));
        for entry in &self.entries {
            let p = entry.presses.as_ref();
            let t = entry.taxels.as_ref();
            let mean = match p {
                Some(e) => format!(
                    "{:.3} ± {:.3}",
                    e.mean_absolute_g,
                    e.standard_error_g.unwrap_or(0.0)
                ),
                None => "–".to_owned(),
            };
            writeln!(
                f,
                "{:<22}{:>6}{:>20}{:>9}{:>9} |{:>12}{:>9}{:>9} |{:>10}{:>10}{:>10}",
                entry.name,
                entry.learnt_from,
                mean,
                number(p.map(|e| e.root_mean_square_g)),
                number(p.map(|e| e.p95_g)),
                number(t.map(|e| e.mean_absolute_g)),
                number(t.map(|e| e.root_mean_square_g)),
                number(t.map(|e| e.p95_g)),
                number(entry.largest_ghost_g),
                number(entry.mean_ghost_g),
                number(entry.milliseconds_a_frame),
            )?;
        }
        for entry in self.entries.iter().filter(|e| !e.note.is_empty()) {
            writeln!(f, "{}: {}", entry.name, entry.note)?;
        }
        Ok(())
    }
}
