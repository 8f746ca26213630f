//! The forces of named regions: what a trial reads of one, known ones, and those of every experiment.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use taxel::evaluate::accuracy::Pair;
use taxel::frame::grams_from_newtons;
use taxel::metric::{is_usable, total_force_newtons};
use taxel::sensor::Region;
use taxel::stats::median;
use taxel::{Frame, Mark, Newtons, Sensor, Volts};
use taxel_io::Trial;
use taxel_plot::cells;
use taxel_plot::report::{Section, Table};

use super::coverage::Intervals;
use super::plan::{Experiment, Plan};
use super::readings::Reader;
use super::{no_law, trials};
use crate::error::Error;
use crate::exported;
use crate::methods::MethodName;
use crate::reporter::Reporter;

/// A mean over experiments, a share, and what a frame's force is uncertain by.
const HEAD: [&str; 7] = [
    "setting",
    "region",
    "frames",
    "force, N",
    "of all, %",
    "± of a frame, N",
    "at the end, %",
];

/// Where a sensor has the region of this name.
pub(super) fn place(name: Option<&str>, sensor: &Sensor) -> Option<usize> {
    let mut regions = sensor.regions().iter();
    name.and_then(|name| regions.position(|region| region.name() == name))
}

/// Every region that a trial names is one of the sensor's.
pub(super) fn check(table: &Path, trials: &[Trial], sensor: &Sensor) -> Result<(), Error> {
    for trial in trials {
        let Some(name) = &trial.region else { continue };
        if place(Some(name), sensor).is_none() {
            let known: Vec<&str> = sensor.regions().iter().map(Region::name).collect();
            return Err(Error::NoRegion {
                table: table.to_owned(),
                line: trial.line,
                region: name.clone(),
                known: match known.len() {
                    0 => "none".to_owned(),
                    _ => known.join(", "),
                },
            });
        }
    }
    Ok(())
}

/// What is to be known of the readings behind a region's force: the end of the converter's range anywhere, no measurement
/// where nothing was measured at all.
pub(super) fn mark(volts: &Frame<Volts>, region: &Region) -> Mark {
    let marks = || region.taxels().iter().map(|&taxel| volts.marks()[taxel]);
    if marks().any(|mark| mark == Mark::Saturated) {
        Mark::Saturated
    } else if marks().any(is_usable) {
        Mark::Good
    } else {
        marks().next().unwrap_or(Mark::Absent)
    }
}

/// The force of a region, grams.
pub(super) fn grams(loads: &Frame<Newtons>, region: &Region) -> f64 {
    grams_from_newtons(newtons(loads, region))
}

fn newtons(loads: &Frame<Newtons>, region: &Region) -> f64 {
    let usable = region.taxels().iter();
    let usable = usable.filter(|&&taxel| is_usable(loads.marks()[taxel]));
    usable.map(|&taxel| loads.values()[taxel]).sum()
}

/// Estimates beside known forces of every region, grams, by experiment.
#[derive(Default)]
pub(super) struct KnownRegions(Vec<Vec<Vec<Pair>>>);

impl KnownRegions {
    /// Another frame whose loads are all known; `is_new`: of another experiment.
    pub(super) fn add(
        &mut self,
        sensor: &Sensor,
        loads: &Frame<Newtons>,
        truth: &Frame<Newtons>,
        is_new: bool,
    ) {
        self.0.resize(sensor.regions().len(), Vec::new());
        for (region, experiments) in sensor.regions().iter().zip(&mut self.0) {
            if is_new || experiments.is_empty() {
                experiments.push(Vec::new());
            }
            let known = region.taxels().iter().map(|&taxel| truth.values()[taxel]);
            let pair = Pair {
                truth: grams_from_newtons(known.sum()),
                estimate: grams(loads, region),
            };
            experiments.last_mut().expect("one was begun").push(pair);
        }
    }

    /// With the regions' names.
    pub(super) fn named<'a>(
        &'a self,
        sensor: &'a Sensor,
    ) -> impl Iterator<Item = (&'a str, &'a [Vec<Pair>])> {
        let names = sensor.regions().iter().map(Region::name);
        names.zip(self.0.iter().map(Vec::as_slice))
    }
}

/// The forces of all regions in everything that the plan reads, and how many frames have no answer; `None` where no region
/// has a name.
pub(super) fn section(
    plan: &Plan,
    reporter: &dyn Reporter,
) -> Result<(Option<Section>, u64), Error> {
    let (mut tables, mut lost) = (Vec::new(), 0);
    let mut intervals_of = exported::NOTHING;
    for experiment in &plan.experiments {
        let mut table = Table::new(
            format!(
                "Force of regions, N: {}; {} intervals over experiments",
                experiment.name,
                plan.sure()
            ),
            &HEAD,
        );
        for (setting, wanted) in wanted(plan, experiment)? {
            let own = experiment.settings.get(&setting);
            let (sensor, file) = plan.sensor_of(own.or(experiment.sensor.as_ref()))?;
            if sensor.regions().is_empty() {
                continue;
            }
            if sensor.material().is_none() && sensor.exported().is_none() {
                if plan.regions.is_some() {
                    return Err(no_law(plan));
                }
                continue;
            }
            intervals_of = exported::intervals_of(&sensor);
            let mut reader = Reader::new(
                &sensor,
                &file,
                &[MethodName::Auto],
                plan.frames_per_second,
                reporter,
            )?;
            let forces = Forces::read(experiment, &sensor, &mut reader, &wanted)?;
            lost += reader.unsolved;
            forces.rows(plan, &sensor, &setting, &mut table);
        }
        if !table.rows.is_empty() {
            tables.push(table);
        }
    }
    let section = Section {
        title: "Regions".to_owned(),
        paragraphs: vec![format!(
            "The force of each named region, whatever the experiment above looks at: the sum of the loads of its taxels, cross-talk removed (`auto`), each frame once; its mean, and its part of the force on the whole array. ± of a frame is half of the 95 % interval of one frame's force, the median of all: it knows of {intervals_of}. At the end: frames in which readings of the region stand at the end of the converter's range, so that more pressed than is said."
        )],
        tables,
        figures: Vec::new(),
    };
    Ok((
        Some(section).filter(|section| !section.tables.is_empty()),
        lost,
    ))
}

/// By recording: of each experiment the frames that it reads, `None` for all.
pub(super) type Wanted = BTreeMap<PathBuf, BTreeMap<String, Option<BTreeSet<u64>>>>;

/// What an experiment of a plan reads, by setting, in the order of its table.
pub(super) fn wanted(plan: &Plan, experiment: &Experiment) -> Result<Vec<(String, Wanted)>, Error> {
    let mut all: Vec<(String, Wanted)> = Vec::new();
    if let Some(recording) = &experiment.recording {
        let each = BTreeMap::from([(String::new(), None)]);
        all.push((String::new(), BTreeMap::from([(recording.clone(), each)])));
    }
    for trial in trials(plan, experiment)? {
        let setting = trial.setting.clone().unwrap_or_default();
        let at = all.iter().position(|(name, _)| *name == setting);
        let at = at.unwrap_or_else(|| {
            all.push((setting, Wanted::new()));
            all.len() - 1
        });
        // Lines without a word that name one frame are one experiment here: their force is the same.
        let word = trial
            .experiment
            .clone()
            .unwrap_or_else(|| match trial.frame {
                Some(frame) => format!("{}, frame {frame}", trial.recording.display()),
                None => trial.recording.display().to_string(),
            });
        let words = all[at].1.entry(trial.recording.clone()).or_default();
        let frames = words.entry(word).or_insert_with(|| Some(BTreeSet::new()));
        match (trial.frame, frames.as_mut()) {
            (Some(frame), Some(frames)) => {
                frames.insert(frame as u64);
            }
            (None, _) => *frames = None,
            (Some(_), None) => {}
        }
    }
    Ok(all)
}

/// Force of every region and of the whole array, newtons, by experiment; halves of the intervals of each region.
#[derive(Default)]
struct Forces {
    experiments: BTreeMap<String, Vec<(Vec<f64>, f64)>>,
    halves: Vec<Vec<f64>>,
    /// Of each region, frames with readings at the end of the converter's range.
    saturated: Vec<usize>,
    frames: usize,
}

impl Forces {
    fn read(
        experiment: &Experiment,
        sensor: &Sensor,
        reader: &mut Reader<'_>,
        wanted: &Wanted,
    ) -> Result<Self, Error> {
        let mut forces = Self {
            halves: vec![Vec::new(); sensor.regions().len()],
            saturated: vec![0; sensor.regions().len()],
            ..Self::default()
        };
        let mut intervals = Intervals::new(sensor, &MethodName::Auto);
        for (recording, words) in wanted {
            reader.each_frame(recording, |reader, frame, index| {
                let is_wanted = |frames: &Option<BTreeSet<u64>>| {
                    frames.as_ref().is_none_or(|frames| frames.contains(&index))
                };
                // A material that remembers sees every frame.
                let is_answer = reader.solve(0, frame);
                if !is_answer || !words.values().any(is_wanted) {
                    return Ok(());
                }
                let result = reader.result(0);
                let Some(loads) = result.loads else {
                    return Ok(());
                };
                // Of a recording with all loads so many frames that follow each other are one experiment.
                let of_whole = (index / experiment.frames_per_experiment()).to_string();
                let is_whole = experiment.recording.is_some();
                let words = words.iter().filter(|(_, frames)| is_wanted(frames));
                let words = words.map(|(word, _)| if is_whole { &of_whole } else { word });
                let halves = intervals.as_mut().and_then(|found| found.of(&result));
                forces.add(
                    sensor,
                    loads,
                    words,
                    halves.map_or(&[], |halves| halves.regions),
                );
                Ok(())
            })?;
        }
        Ok(forces)
    }

    /// Another frame, of these experiments; `halves_g`: of the interval of each region's force, where it is known.
    fn add<'a>(
        &mut self,
        sensor: &Sensor,
        loads: &Frame<Newtons>,
        experiments: impl Iterator<Item = &'a String>,
        halves_g: &[f64],
    ) {
        let each = sensor.regions().iter();
        let each: Vec<f64> = each.map(|region| newtons(loads, region)).collect();
        let all = total_force_newtons(loads);
        for word in experiments {
            let experiment = self.experiments.entry(word.clone()).or_default();
            experiment.push((each.clone(), all));
        }
        for (kept, half_g) in self.halves.iter_mut().zip(halves_g) {
            kept.push(half_g / grams_from_newtons(1.0));
        }
        for (count, region) in self.saturated.iter_mut().zip(sensor.regions()) {
            let mut taxels = region.taxels().iter();
            let is_at_end = |taxel: &usize| loads.marks()[*taxel] == Mark::Saturated;
            *count += usize::from(taxels.any(is_at_end));
        }
        self.frames += 1;
    }

    fn rows(&self, plan: &Plan, sensor: &Sensor, setting: &str, table: &mut Table) {
        let name = if setting.is_empty() { "all" } else { setting };
        for (at, region) in sensor.regions().iter().enumerate() {
            let of_it = |frames: &Vec<(Vec<f64>, f64)>| -> Vec<[f64; 2]> {
                frames.iter().map(|(each, all)| [each[at], *all]).collect()
            };
            let experiments: Vec<Vec<[f64; 2]>> = self.experiments.values().map(of_it).collect();
            let figures = |frames: &[[f64; 2]]| {
                let sum = |of: usize| frames.iter().map(|frame| frame[of]).sum::<f64>();
                let mean = sum(0) / frames.len() as f64;
                (!frames.is_empty()).then(|| [mean, 100.0 * sum(0) / sum(1)])
            };
            let Some([force, share]) = plan.bootstrap.estimates(&experiments, figures) else {
                continue;
            };
            let frames: usize = experiments.iter().map(Vec::len).sum();
            let half = median(self.halves[at].iter().copied());
            let at_end = 100.0 * self.saturated[at] as f64 / self.frames as f64;
            table.push(cells![
                name,
                region.name(),
                frames,
                force,
                share,
                half,
                at_end
            ]);
        }
    }
}
