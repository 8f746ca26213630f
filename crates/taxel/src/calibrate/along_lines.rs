//! Do the lines resist along their length, beside all else that a search finds? Asked where noise does not explain the presses, by a
//! search of its own, whose unloaded taxels tell lines together with switches; kept where held-out presses are nearer for it.

use super::choose::Search;
use super::fit::Score;
use super::least_squares::{normal_equations, solve};
use super::model::{Model, Unknown};
use super::outcome::LINES;
use super::presses::has_exact_inverse;
use super::{MAX_LEVELLED_TAXELS, MAX_SEARCHED_TAXELS, with_error};
use crate::sensor::PerLine;
use crate::{Error, Sensor, stats};
use taxel_linalg::dot;

/// What lines are taken to resist from one taxel to the next at first, ohms: switches and lines stand for each other, so that a search
/// from one start ends far off as often as not.
const STARTS_OHMS: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
/// So many of them are followed to the end; one alone where two come to the same lines but for this share.
const MOST_STARTS: usize = 3;
const SAME: f64 = 0.15;
/// Where circuit and law alone make less of rows and of columns, they are taken for lines that do not resist, ohms.
const LEAST_OHMS: f64 = 0.1;
/// Presses that are less far off than so many times what noise and this share of a load make of them are worth no search of its own:
/// it takes several times as long as the first.
const WORTH_A_LOOK: f64 = 0.5;
const SHARE: f64 = 0.02;
/// From here on the report warns where nobody looked.
const WORTH_A_WARNING: f64 = 1.0;
/// Where they are farther off than this, a calibration without lines is worth little, and minutes are well spent on looking.
const WORTH_MINUTES: f64 = 2.5;
/// Terms of a square law of row and column.
const PLACE_TERMS: usize = 6;
/// From this ratio on it tells something: chance alone makes as much of 90 presses or more once in 400. Mats of 24 and 32 lines a side
/// whose lines resist 0.5 or 2 Ohm a pitch: 6 to 16, but for one of 1.7; whose lines do not: up to 2.6.
const TELLING: f64 = 4.0;
/// Held-out presses must be nearer by so many standard errors.
const BETTER: f64 = 2.0;

impl<'a> Search<'a> {
    /// The search itself, or one whose lines resist, where held-out presses are clearly nearer to their labels by that.
    pub(super) fn or_with_lines(
        mut self,
        sensor: &Sensor,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Self {
        let readout = sensor.readout();
        let is_told = readout.r_line_row_ohms.is_some() || readout.r_line_column_ohms.is_some();
        let taxels = sensor.rows() * sensor.columns();
        if is_told || with_lines(sensor, 1.0).is_err() {
            return self;
        }
        let slow = taxels > MAX_SEARCHED_TAXELS || !has_exact_inverse(sensor, &self.options);
        let off = self.beyond_noise();
        if !self.options.line_resistance && off >= WORTH_A_LOOK && self.are_off_alike() {
            let text = "not looked for: presses are off alike wherever they lie, as where taxels differ that no uniform load tells (--line-resistance looks all the same)";
            self.note(LINES, false, text.to_owned());
            return self;
        }
        let is_too_slow = slow && (off < WORTH_MINUTES || taxels > MAX_LEVELLED_TAXELS);
        if is_too_slow && !self.options.line_resistance {
            let why = "not looked for beside other effects: it would take minutes, and is done where it is asked for (--line-resistance)";
            self.note(LINES, false, why.to_owned());
            if off >= WORTH_A_WARNING {
                self.doubts.push(format!(
                    "presses are {off:.1} times as far off as noise and {:.0} % of a load make them, and whether lines resist along their length was {why}",
                    100.0 * self.usual_share()
                ));
            }
            return self;
        }
        if !self.options.line_resistance && off < WORTH_A_LOOK {
            let text = format!(
                "looked for, not found: without it presses are only {off:.1} times as far off as noise and {:.0} % of a load make them",
                100.0 * self.usual_share()
            );
            self.note(LINES, false, text);
            return self;
        }
        progress("resistance along the lines", 0.65);
        match self.with_lines(sensor, progress) {
            Ok(with) => with,
            Err(why) => {
                self.note(LINES, false, format!("looked for, not found: {why}"));
                self
            }
        }
    }

    /// What labels err by at least, a share of a load.
    fn usual_share(&self) -> f64 {
        SHARE.max(self.options.label_share)
    }

    /// How many times as far off presses usually are as noise and a small share of their loads make them.
    fn beyond_noise(&mut self) -> f64 {
        let says = self.score().map(|score| score.says_g.clone());
        let says: Vec<Option<f64>> = says.unwrap_or_default().into_iter().map(Some).collect();
        let presses = self.readings(&says);
        let share = self.usual_share();
        let off = presses.iter().map(|press| {
            let usual = press.noise_g.hypot(share * press.load_g);
            (press.says_g - press.load_g).abs() / usual
        });
        stats::median(off).unwrap_or(0.0)
    }

    /// Whether what presses are off by has nothing to do with where they lie. Only asked where no uniform load tells how taxels differ:
    /// that hides what lines do, and a search for it takes minutes.
    fn are_off_alike(&mut self) -> bool {
        let evidence = self.evaluator.evidence;
        evidence.levels.is_empty() && self.told_by_place().is_some_and(|ratio| ratio < TELLING)
    }

    /// How much more the place of a press tells of how far it is off than chance does: the F statistic of a square law of its row and
    /// column. Lines that resist make presses far from their ends read less than near ones.
    fn told_by_place(&mut self) -> Option<f64> {
        let says = self.score().map(|score| score.says_g.clone());
        let says: Vec<Option<f64>> = says?.into_iter().map(Some).collect();
        let share = self.usual_share();
        let presses = self.readings(&says);
        let (evidence, sensor) = (self.evaluator.evidence, &self.model.sensor);
        let place = |at: usize, count: usize| 2.0 * at as f64 / (count.max(2) - 1) as f64 - 1.0;
        let terms = presses.iter().map(|press| {
            let label = &evidence.presses[press.press];
            let x = place(label.row, sensor.rows());
            let y = place(label.column, sensor.columns());
            let scale = press.load_g / press.noise_g.hypot(share * press.load_g);
            [1.0, x, y, x * x, y * y, x * y].map(|term| scale * term)
        });
        let terms: Vec<[f64; PLACE_TERMS]> = terms.collect();
        let off = presses.iter().map(|press| {
            let usual = press.noise_g.hypot(share * press.load_g);
            (press.says_g - press.load_g) / usual
        });
        let off: Vec<f64> = off.collect();
        // One press far off the others must not decide.
        let limit = 3.0 * 1.4826 * stats::median(off.iter().map(|off| off.abs()))?;
        let off: Vec<f64> = off.iter().map(|off| off.clamp(-limit, limit)).collect();
        let left = off.len().checked_sub(PLACE_TERMS + 1)?;
        let squares = |count: usize| -> Option<f64> {
            let rows: Vec<&[f64]> = terms.iter().map(|terms| &terms[..count]).collect();
            let (normal, right) = normal_equations(&rows, &off, &vec![1.0; off.len()]);
            let step = solve(&normal, &right, 0.0)?;
            let rest = rows
                .iter()
                .zip(&off)
                .map(|(row, off)| off + dot(row, &step));
            Some(rest.map(|rest| rest * rest).sum())
        };
        let (without, with) = (squares(1)?, squares(PLACE_TERMS)?);
        let more = (PLACE_TERMS - 1) as f64;
        Some((without - with) / more / (with / left as f64))
    }

    /// A search whose lines resist, or why there is none worth having.
    fn with_lines(
        &self,
        sensor: &Sensor,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<Self, String> {
        let starts = self.best_starts(sensor)?;
        let mut best: Option<(f64, Self)> = None;
        for (_, mut with) in starts {
            let ran = with.finish_with_lines(progress);
            let error_g = with.error_g();
            if ran.is_ok() && best.as_ref().is_none_or(|(least, _)| error_g < *least) {
                best = Some((error_g, with));
            }
        }
        let (_, mut with) = best.ok_or("a fit with it ends nowhere")?;
        let (gain, errors) = match (self.score(), with.score()) {
            (Some(own), Some(with)) => own.error_above(with),
            _ => return Err("no held-out press could be judged".to_owned()),
        };
        let presses =
            format!("held-out presses gain {gain:.3} g by it ({errors:.1} standard errors)");
        if errors <= BETTER {
            return Err(presses);
        }
        let text = format!("{}; {presses}", with.line_words());
        with.note(LINES, true, text);
        Ok(with)
    }

    /// Circuit and law alone from the starts that held-out presses are nearest by, and how far off these are, grams.
    fn best_starts(&self, sensor: &Sensor) -> Result<Vec<(f64, Self)>, String> {
        let (evidence, executor) = (self.evaluator.evidence, self.evaluator.executor);
        let mut starts: Vec<(f64, Self)> = Vec::new();
        let mut most = MOST_STARTS;
        for ohms in STARTS_OHMS {
            let begun = with_lines(sensor, ohms).and_then(|from| {
                let mut search = Search::begin(&from, evidence, &self.options, executor, true)?;
                Ok((search.begin_with_circuit(&mut |_, _| ())?, search))
            });
            let Ok((error_g, search)) = begun else {
                continue;
            };
            let mut others = starts.iter();
            let agree = others.any(|(_, other)| have_same_lines(&other.model, &search.model));
            starts.push((error_g, search));
            if agree {
                most = 1;
                break;
            }
        }
        starts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        starts.truncate(most);
        let (_, nearest) = starts.first().ok_or("a frame has no solution with it")?;
        let (column, row) = nearest.model.mean_line_ohms();
        if column.max(row) < LEAST_OHMS {
            return Err(format!(
                "rows would resist {row:.2} Ohm from one taxel to the next, columns {column:.2} Ohm"
            ));
        }
        Ok(starts)
    }

    /// Everything together, begun with each line as it was found, and with all of a side alike: the nearer to held-out
    /// presses of the two, or what was there before, where that was nearer.
    pub(super) fn polish_with_lines(
        &mut self,
        progress: &mut dyn FnMut(&str, f64),
    ) -> Result<(), Error> {
        let begun = self.before();
        let mut from = |search: &mut Self, alike: bool| -> Result<f64, Error> {
            search.go_back_to(&begun);
            if alike {
                search.model.make_lines_alike();
            }
            search.polish(progress)?;
            Ok(search.error_g())
        };
        let begun_g = self.error_g();
        // On small arrays the second is the nearer nearly always, on large ones the first: it is left for the end, and not done twice.
        let taxels = self.model.sensor.rows() * self.model.sensor.columns();
        let last = taxels <= MAX_SEARCHED_TAXELS;
        let first_g = from(self, !last).unwrap_or(f64::INFINITY);
        let last_g = from(self, last).unwrap_or(f64::INFINITY);
        if begun_g <= first_g.min(last_g) {
            self.go_back_to(&begun);
            return self.score_held_out();
        }
        if first_g < last_g {
            from(self, !last)?;
        }
        Ok(())
    }

    /// How far held-out presses are off, grams.
    pub(super) fn error_g(&self) -> f64 {
        self.score().map_or(f64::INFINITY, Score::mean_error)
    }

    /// How far presses are off that were fitted to, grams.
    pub(super) fn error_on_presses_g(&mut self) -> Option<f64> {
        let estimates = self.evaluator.estimates(&self.model)?;
        let presses = self.evaluator.evidence.presses.iter().zip(&estimates);
        stats::mean(presses.map(|(press, says)| (says.load_g - press.load_g).abs()))
    }

    fn score(&self) -> Option<&Score> {
        self.best.as_ref().map(|(_, score)| score)
    }

    /// What rows and columns resist.
    fn line_words(&self) -> String {
        let (column, row) = self.model.mean_line_ohms();
        let ohms = |ohms: f64, unknown: Unknown| {
            let error = self.found_error(unknown).map(|error| ohms * error);
            let (value, error) = with_error(ohms, error);
            error.map_or(value.clone(), |error| format!("{value} ± {error}"))
        };
        let each = if self.can_separate() {
            ", each line by itself"
        } else {
            ""
        };
        format!(
            "rows resist {} Ohm from one taxel to the next, columns {} Ohm{each}",
            ohms(row, Unknown::RowLines),
            ohms(column, Unknown::ColumnLines),
        )
    }
}

/// Whether two models' lines resist the same, as far as a start tells: both sides.
fn have_same_lines(one: &Model, other: &Model) -> bool {
    let (one, other) = (one.mean_line_ohms(), other.mean_line_ohms());
    let same = |a: f64, b: f64| a.min(b) >= LEAST_OHMS && (a / b).ln().abs() < SAME;
    same(one.0, other.0) && same(one.1, other.1)
}

/// A sensor whose lines all resist so much from one taxel to the next.
fn with_lines(sensor: &Sensor, ohms: f64) -> Result<Sensor, Error> {
    sensor.edited(|spec| {
        spec.readout.r_line_column_ohms = Some(PerLine::One(ohms));
        spec.readout.r_line_row_ohms = Some(PerLine::One(ohms));
    })
}
