//! How far are estimates from known loads?

use std::collections::BTreeSet;
use std::path::PathBuf;

use taxel::evaluate::accuracy::{Accuracy, Pair, accuracy, by_range};
use taxel::frame::grams_from_newtons;
use taxel::metric::{TaxelCrossTalk, cross_talk_index, ghost_level, is_usable};
use taxel::simulate::{Grams, newtons};
use taxel::{Frame, Newtons};
use taxel_io::ReadOptions;
use taxel_plot::report::{Cell, Figure, Section, Table, number};
use taxel_plot::{Line, LineStyle, Panel, Series, Sheet, cells};

use super::coverage::{self, Labelled};
use super::plan::{Experiment, Plan};
use super::readings::{Answer, Group, Reader};
use super::{no_law, too_few};
use crate::error::Error;
use crate::frames::open_values;
use crate::methods::MethodName;
use crate::reporter::Reporter;

/// Points that a picture shows at most.
const DRAWN: usize = 2000;
/// Distances have no sign, so no bias.
const PLACE_HEAD: [&str; 5] = [
    "",
    "readings",
    "mean",
    "root mean square",
    "95th percentile",
];
const HEAD: [&str; 6] = [
    "",
    "readings",
    "bias",
    "mean absolute",
    "root mean square",
    "95th percentile",
];

/// A method as it stands in a table: a model by its file's name.
fn name_of(method: &MethodName) -> String {
    match method {
        MethodName::Model(file) => file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        other => other.to_string(),
    }
}

fn row(name: String, found: &Accuracy) -> Vec<Cell> {
    cells![
        name,
        found.readings,
        found.bias,
        found.mean_absolute,
        found.root_mean_square,
        found.percentile_95,
    ]
}

fn place_row(name: String, found: &Accuracy) -> Vec<Cell> {
    cells![
        name,
        found.readings,
        found.mean_absolute,
        found.root_mean_square,
        found.percentile_95,
    ]
}

/// Known loads on single taxels, on the whole array, and known places.
pub(super) fn section(
    plan: &Plan,
    experiment: &Experiment,
    groups: &[Group],
) -> Result<Section, Error> {
    let mut section = Section {
        title: experiment.name.clone(),
        paragraphs: vec![format!(
            "Errors are estimate − known; {} intervals are bootstrapped over experiments, never over frames.",
            plan.sure()
        )],
        ..Section::default()
    };
    let methods = experiment.methods(plan.folder())?;
    let headed = |words: &str, group: &Group, head: &[&str]| {
        Table::new(format!("{words}: {}", group.name()), head)
    };
    for group in groups {
        let mut drawn = Vec::new();
        let mut taxels = headed("Load on the taxel, g", group, &HEAD);
        let mut ranges = headed("By load, g", group, &HEAD);
        let mut total = headed("Load on the whole array, g", group, &HEAD);
        let from_known = "Centre of pressure, distance from the known place, mm";
        let mut place = headed(from_known, group, &PLACE_HEAD);
        let mut held = coverage::table(&group.sensor, &format!(": {}", group.name()));
        for (number, method) in methods.iter().enumerate() {
            let name = name_of(method);
            let pairs = pairs(plan, group, |trial, reading| {
                let answer: &Answer = &reading.answers[number];
                let truth = trial
                    .load_g
                    .filter(|_| trial.taxel.is_some() && !reading.marked);
                truth.map(|truth| (truth, answer.grams))
            })?;
            if let Some(found) = accuracy(&pairs, &plan.bootstrap) {
                taxels.push(row(name.clone(), &found));
                drawn.push((name.clone(), pairs.concat()));
            }
            for (range, found) in by_range(&pairs, &experiment.ranges_g, &plan.bootstrap) {
                ranges.push(row(range_name(&name, range), &found));
            }
            let totals = pairs_of_totals(plan, group, number)?;
            total
                .rows
                .extend(accuracy(&totals, &plan.bootstrap).map(|found| row(name.clone(), &found)));
            let labelled = Labelled::of(group, number);
            held.rows.extend(labelled.rows(&name, &plan.bootstrap));
            let places = places(group, number);
            place
                .rows
                .extend(accuracy(&places, &plan.bootstrap).map(|found| place_row(name, &found)));
        }
        if taxels.rows.is_empty() && total.rows.is_empty() && place.rows.is_empty() {
            return Err(too_few(experiment, group, "a reading of a known load"));
        }
        let tables = [taxels, ranges, total, place, held];
        section
            .tables
            .extend(tables.into_iter().filter(|table| !table.rows.is_empty()));
        if !drawn.is_empty() {
            section.figures.push(figure(group.title(), drawn)?);
        }
    }
    Ok(section)
}

fn pairs_of_totals(plan: &Plan, group: &Group, method: usize) -> Result<Vec<Vec<Pair>>, Error> {
    pairs(plan, group, |trial, reading| {
        trial
            .total_g
            .map(|truth| (truth, reading.answers[method].total_g))
    })
}

/// Distances from a known place: the truth is 0.
fn places(group: &Group, method: usize) -> Vec<Vec<Pair>> {
    let distance = |reading: &&super::readings::TrialReading| {
        let (x, y) = group.trials[reading.trial].place_mm?;
        let [down, across] = reading.answers[method].centre_mm?;
        Some(Pair {
            truth: 0.0,
            estimate: (across - x).hypot(down - y),
        })
    };
    let experiments = group.experiments();
    experiments
        .iter()
        .map(|one| one.iter().filter_map(distance).collect())
        .collect()
}

fn pairs(
    plan: &Plan,
    group: &Group,
    of: impl Fn(&taxel_io::Trial, &super::readings::TrialReading) -> Option<(f64, Option<f64>)>,
) -> Result<Vec<Vec<Pair>>, Error> {
    let mut out = Vec::new();
    for one in group.experiments() {
        let mut pairs = Vec::new();
        for reading in one {
            if let Some((truth, found)) = of(&group.trials[reading.trial], reading) {
                let estimate = found.ok_or_else(|| no_law(plan))?;
                pairs.push(Pair { truth, estimate });
            }
        }
        out.push(pairs);
    }
    Ok(out)
}

fn range_name(method: &str, (from, to): (f64, f64)) -> String {
    if to.is_finite() {
        format!("{method}, {} to {} g", number(from), number(to))
    } else {
        format!("{method}, from {} g", number(from))
    }
}

fn figure(name: &str, methods: Vec<(String, Vec<Pair>)>) -> Result<Figure, Error> {
    let most = methods
        .iter()
        .flat_map(|(_, pairs)| pairs)
        .fold(0.0, |m: f64, p| m.max(p.truth));
    let mut lines = vec![
        Line::new("no error", vec![0.0, most])
            .over(vec![0.0, most])
            .style(LineStyle::Dashed)
            .colour(7),
    ];
    for (i, (method, pairs)) in methods.into_iter().enumerate() {
        let step = pairs.len().div_ceil(DRAWN).max(1);
        let some: Vec<Pair> = pairs.into_iter().step_by(step).collect();
        let line = Line::new(method, some.iter().map(|p| p.estimate).collect());
        lines.push(
            line.over(some.iter().map(|p| p.truth).collect())
                .style(LineStyle::Points)
                .colour(i),
        );
    }
    let picture = Series::new("known load (g)", Vec::new(), lines)?
        .title(name)
        .quantity("estimate")
        .unit("g")
        .picture()?;
    Ok(Figure {
        caption: format!("Estimates beside known loads, {name}."),
        picture,
    })
}

/// What the frames of a recording with all loads known say of a method.
#[derive(Default)]
struct Whole {
    loaded: Vec<Vec<Pair>>,
    total: Vec<Vec<Pair>>,
    centre: Vec<Vec<Pair>>,
    ghosts: Vec<f64>,
    index: Vec<f64>,
    each: Option<TaxelCrossTalk>,
    held: Option<coverage::WholeFrames>,
}

/// A recording with the load of every taxel in every frame.
pub(super) fn of_whole_frames(
    plan: &Plan,
    experiment: &Experiment,
    files: &mut BTreeSet<PathBuf>,
    reporter: &dyn Reporter,
) -> Result<(Section, u64), Error> {
    let recording = experiment.recording.clone().unwrap_or_default();
    let truth_file = experiment.truth_g.clone().unwrap_or_default();
    files.extend([recording.clone(), truth_file.clone()]);
    let (sensor, file) = plan.sensor_of(experiment.sensor.as_ref())?;
    files.insert(file.clone());
    let methods = experiment.methods(plan.folder())?;
    files.extend(methods.iter().filter_map(MethodName::file));
    let mut reader = Reader::new(&sensor, &file, &methods, plan.frames_per_second, reporter)?;
    let mut options = ReadOptions::of(&sensor);
    options.max_count = None;
    let mut truths = open_values::<Grams>(&truth_file, options)?;
    let mut truth = Frame::<Grams>::zeros(sensor.rows(), sensor.columns());
    let mut whole: Vec<Whole> = methods.iter().map(|_| Whole::default()).collect();
    let (mut frames, mut known, mut last) = (0, 0, None);
    reader.each_frame(&recording, |reader, frame, index| {
        // A frame that could not be read has loads all the same.
        while known <= index {
            if !truths.next_into(&mut truth)? {
                return Err(Error::FewerTruths {
                    truth: truth_file.clone(),
                    found: known,
                    recording: recording.clone(),
                });
            }
            known += 1;
        }
        let mut is_answered = true;
        for method in 0..whole.len() {
            is_answered &= reader.solve(method, frame);
        }
        if !is_answered {
            return Ok(());
        }
        frames += 1;
        let number = index / experiment.frames_per_experiment();
        let is_new = last != Some(number);
        last = Some(number);
        for (method, whole) in whole.iter_mut().enumerate() {
            let loads = reader.result(method).newtons().map_err(|_| no_law(plan))?;
            let truth = newtons(&truth);
            whole.add(&sensor, loads, &truth, is_new)?;
            let held = whole
                .held
                .get_or_insert_with(|| coverage::WholeFrames::new(&sensor, &methods[method]));
            held.add(&reader.result(method), &truth, is_new);
        }
        Ok(())
    })?;
    let lost = reader.skipped + reader.unsolved;
    let words = format!(
        "All loads are known in each of {frames} frames; {}. Errors are over taxels that carry a load; a ghost is what a taxel without load reports; the cross-talk index is the mean of unloaded taxels that share a line with a loaded one over the mean of the loaded ones.",
        match experiment.frames_per_experiment() {
            1 => "each is an experiment".to_owned(),
            some => format!("{some} that follow each other are one experiment"),
        }
    );
    Ok((
        whole_section(plan, experiment, &sensor, &methods, whole, words)?,
        lost,
    ))
}

impl Whole {
    fn add(
        &mut self,
        sensor: &taxel::Sensor,
        loads: &Frame<Newtons>,
        truth: &Frame<Newtons>,
        is_new: bool,
    ) -> Result<(), Error> {
        for list in [&mut self.loaded, &mut self.total, &mut self.centre] {
            if is_new || list.is_empty() {
                list.push(Vec::new());
            }
        }
        let pair = |truth: f64, estimate: f64| Pair {
            truth: grams_from_newtons(truth),
            estimate: grams_from_newtons(estimate),
        };
        let both = truth.values().iter().zip(loads.values()).zip(loads.marks());
        let loaded = both.filter(|((truth, _), mark)| **truth > 0.0 && is_usable(**mark));
        let last = self.loaded.last_mut().expect("one was begun");
        last.extend(loaded.map(|((&truth, &load), _)| pair(truth, load)));
        let sum = |frame: &Frame<Newtons>| frame.values().iter().sum::<f64>();
        let last = self.total.last_mut().expect("one was begun");
        last.push(pair(sum(truth), sum(loads)));
        let centre = |frame| taxel::metric::FrameFigures::of(frame, sensor).centre_mm;
        if let (Some(known), Some(found)) = (centre(truth), centre(loads)) {
            self.centre.last_mut().expect("one was begun").push(Pair {
                truth: 0.0,
                estimate: (known[0] - found[0]).hypot(known[1] - found[1]),
            });
        }
        self.ghosts
            .extend(ghost_level(loads, truth, 0.0)?.map(|g| grams_from_newtons(g.largest)));
        self.index.extend(cross_talk_index(loads, truth, 0.0)?);
        let each = self
            .each
            .get_or_insert_with(|| TaxelCrossTalk::new(loads.rows(), loads.columns()));
        each.add(loads, truth, 0.0)?;
        Ok(())
    }
}

const GHOST_HEAD: [&str; 5] = [
    "",
    "largest ghost, g",
    "index",
    "of the worst taxel",
    "which",
];

fn ghost_row(
    name: String,
    whole: &Whole,
    each: Option<&[f64]>,
    sensor: &taxel::Sensor,
) -> Vec<Cell> {
    let largest = whole.ghosts.iter().copied().reduce(f64::max);
    let mean = taxel::stats::mean(whole.index.iter().copied());
    let worst = each.and_then(worst);
    let place = worst
        .map(|(taxel, _)| format!("{}, {}", taxel / sensor.columns(), taxel % sensor.columns()));
    cells![name, largest, mean, worst.map(|w| w.1), place]
}

fn whole_section(
    plan: &Plan,
    experiment: &Experiment,
    sensor: &taxel::Sensor,
    methods: &[MethodName],
    whole: Vec<Whole>,
    words: String,
) -> Result<Section, Error> {
    let mut loaded = Table::new(
        format!(
            "Load on loaded taxels, g; {} intervals over experiments",
            plan.sure()
        ),
        &HEAD,
    );
    let mut ranges = Table::new("By load, g", &HEAD);
    let mut total = Table::new("Load on the whole array, g", &HEAD);
    let mut centre = Table::new(
        "Centre of pressure, distance from the true one, mm",
        &PLACE_HEAD,
    );
    let mut ghosts = Table::new(
        "Cross-talk; the worst taxel is named by its row and column",
        &GHOST_HEAD,
    );
    let mut held = coverage::table(sensor, "");
    let mut drawn = Vec::new();
    let mut maps = Vec::new();
    for (method, whole) in methods.iter().zip(whole) {
        let name = name_of(method);
        for (table, pairs) in [(&mut loaded, &whole.loaded), (&mut total, &whole.total)] {
            table
                .rows
                .extend(accuracy(pairs, &plan.bootstrap).map(|found| row(name.clone(), &found)));
        }
        centre.rows.extend(
            accuracy(&whole.centre, &plan.bootstrap).map(|found| place_row(name.clone(), &found)),
        );
        for (range, found) in by_range(&whole.loaded, &experiment.ranges_g, &plan.bootstrap) {
            ranges.push(row(range_name(&name, range), &found));
        }
        let rows = whole
            .held
            .as_ref()
            .map(|held| held.rows(&name, &plan.bootstrap));
        held.rows.extend(rows.into_iter().flatten());
        let each = whole.each.as_ref().and_then(TaxelCrossTalk::index);
        ghosts.push(ghost_row(name.clone(), &whole, each.as_deref(), sensor));
        maps.extend(each.map(|each| (name.clone(), each)));
        drawn.push((name, whole.loaded.concat()));
    }
    let tables = [loaded, ranges, total, centre, held, ghosts];
    let mut figures = vec![figure("loaded taxels", drawn)?];
    if !maps.is_empty() {
        figures.push(index_map(sensor, maps)?);
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs: vec![words],
        tables: tables
            .into_iter()
            .filter(|table| !table.rows.is_empty())
            .collect(),
        figures,
    })
}

/// The taxel with the largest index, and that index.
fn worst(each: &[f64]) -> Option<(usize, f64)> {
    let known = each
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, index)| index.is_finite());
    known.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The cross-talk index of every taxel by each method, one range of colours.
fn index_map(sensor: &taxel::Sensor, mut maps: Vec<(String, Vec<f64>)>) -> Result<Figure, Error> {
    for (_, each) in &mut maps {
        // Never without load beside a loaded one: nothing is known, and nothing shown.
        each.iter_mut()
            .filter(|index| !index.is_finite())
            .for_each(|index| *index = 0.0);
    }
    let mut panels = Vec::new();
    for (name, each) in &maps {
        let panel = Panel::new(sensor.rows(), sensor.columns(), each)?.title(name.as_str());
        let pitch = sensor.array().pitch_mm;
        panels.push(panel.quantity("cross-talk index").pitch_mm(pitch));
    }
    Ok(Figure {
        caption: "Cross-talk index of each taxel: the mean of what it says while it carries nothing and shares a line with a loaded one, over the mean of what loaded taxels say.".to_owned(),
        picture: Sheet::new(panels)?.shared_range(true).picture()?,
    })
}
