//! How far are estimates from known loads?

mod whole_frames;

use taxel::evaluate::accuracy::{Accuracy, Pair, accuracy, by_range};
use taxel_plot::report::{Cell, Figure, Section, Table, number};
use taxel_plot::{Line, LineStyle, Series, cells};

use super::at_end::at_end;
use super::coverage::{self, Labelled};
use super::plan::{Experiment, Plan};
use super::readings::{Group, TrialReading};
use super::{has_place, no_law, too_few};
use crate::error::Error;
use crate::methods::MethodName;
pub(super) use whole_frames::of_whole_frames;

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
    for group in groups {
        let (tables, drawn) = of_group(plan, experiment, group, &methods)?;
        if tables.is_empty() {
            return Err(too_few(experiment, group, "a reading of a known load"));
        }
        section.tables.extend(tables);
        if !drawn.is_empty() {
            section.figures.push(figure(group.title(), drawn)?);
        }
    }
    Ok(section)
}

/// The tables of one setting that have rows, and the pairs of each method that are drawn.
fn of_group(
    plan: &Plan,
    experiment: &Experiment,
    group: &Group,
    methods: &[MethodName],
) -> Result<(Vec<Table>, Drawn), Error> {
    let headed =
        |words: &str, head: &[&str]| Table::new(format!("{words}: {}", group.name()), head);
    let mut drawn = Vec::new();
    let mut taxels = headed("Load on the taxel, g", &HEAD);
    let mut ranges = headed("By load, g", &HEAD);
    let mut regions = headed("Load on the region, g", &HEAD);
    let mut total = headed("Load on the whole array, g", &HEAD);
    let from_known = "Centre of pressure, distance from the known place, mm";
    let mut place = headed(from_known, &PLACE_HEAD);
    let mut held = coverage::table(&group.sensor, &format!(": {}", group.name()));
    let bootstrap = &plan.bootstrap;
    for (number, method) in methods.iter().enumerate() {
        let name = name_of(method);
        let pairs = pairs(plan, group, |trial, reading| {
            let is_of_it = trial.taxel.is_some() && !reading.marked;
            let truth = trial.load_g.filter(|_| is_of_it);
            truth.map(|truth| (truth, reading.answers[number].grams))
        })?;
        let found = accuracy(&pairs, bootstrap);
        taxels
            .rows
            .extend(found.map(|found| row(name.clone(), &found)));
        for (range, found) in by_range(&pairs, &experiment.ranges_g, bootstrap) {
            ranges.push(row(range_name(&name, range), &found));
        }
        for region in group.sensor.regions() {
            let pairs = pairs_of_region(plan, group, number, region.name())?;
            let found = accuracy(&pairs, bootstrap);
            let named = || format!("{name}, {}", region.name());
            regions.rows.extend(found.map(|found| row(named(), &found)));
        }
        let found = accuracy(&pairs_of_totals(plan, group, number)?, bootstrap);
        total
            .rows
            .extend(found.map(|found| row(name.clone(), &found)));
        let labelled = Labelled::of(group, number);
        held.rows.extend(labelled.rows(&name, bootstrap));
        let found = accuracy(&places(group, number), bootstrap);
        place
            .rows
            .extend(found.map(|found| place_row(name.clone(), &found)));
        drawn.extend(known_loads(group, number).map(|known| (name, known)));
    }
    let tables = [taxels, ranges, regions, total, place, held];
    let filled = tables.into_iter().filter(|table| !table.rows.is_empty());
    Ok((filled.collect(), drawn))
}

/// What is drawn of a method: its estimates of single loads, on taxels and regions.
fn known_loads(group: &Group, method: usize) -> Option<Vec<Known>> {
    let known = |reading: &TrialReading| {
        let trial = &group.trials[reading.trial];
        let is_of_it = has_place(trial) && !reading.marked;
        Some(Known {
            truth: trial.load_g.filter(|_| is_of_it)?,
            estimate: reading.answers[method].grams?,
            saturated: reading.saturated,
        })
    };
    let all: Vec<Known> = group.readings.iter().filter_map(known).collect();
    (!all.is_empty()).then_some(all)
}

fn pairs_of_region(
    plan: &Plan,
    group: &Group,
    method: usize,
    name: &str,
) -> Result<Vec<Vec<Pair>>, Error> {
    pairs(plan, group, |trial, reading| {
        let is_of_it = trial.region.as_deref() == Some(name) && !reading.marked;
        let truth = trial.load_g.filter(|_| is_of_it);
        truth.map(|truth| (truth, reading.answers[method].grams))
    })
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

/// What is drawn of each method.
type Drawn = Vec<(String, Vec<Known>)>;

/// A known load beside its estimate, as it is drawn.
#[derive(Debug, Clone, Copy)]
struct Known {
    truth: f64,
    estimate: f64,
    /// The converter's end was reached: more pressed than is said.
    saturated: bool,
}

impl Known {
    /// Of a frame whose readings are all below the converter's end.
    fn of(pair: Pair) -> Self {
        Self {
            truth: pair.truth,
            estimate: pair.estimate,
            saturated: false,
        }
    }
}

fn figure(name: &str, methods: Drawn) -> Result<Figure, Error> {
    let all = || methods.iter().flat_map(|(_, known)| known);
    let most = all().fold(0.0, |most: f64, known| most.max(known.truth));
    let mut lines = vec![
        Line::new("no error", vec![0.0, most])
            .over(vec![0.0, most])
            .style(LineStyle::Dashed)
            .colour(7),
    ];
    let saturated = all().filter(|known| known.saturated);
    let saturated = saturated.map(|known| (known.truth, known.estimate));
    let saturated = at_end(saturated.collect());
    for (i, (method, known)) in methods.into_iter().enumerate() {
        let step = known.len().div_ceil(DRAWN).max(1);
        let some: Vec<Known> = known.into_iter().step_by(step).collect();
        let line = Line::new(method, some.iter().map(|known| known.estimate).collect());
        lines.push(
            line.over(some.iter().map(|known| known.truth).collect())
                .style(LineStyle::Points)
                .colour(i),
        );
    }
    lines.extend(saturated);
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
