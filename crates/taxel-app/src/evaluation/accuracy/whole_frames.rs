//! A recording with the load of every taxel in every frame.

use std::collections::BTreeSet;
use std::path::PathBuf;

use taxel::evaluate::accuracy::{Pair, accuracy, by_range};
use taxel::frame::grams_from_newtons;
use taxel::metric::{TaxelCrossTalk, cross_talk_index, ghost_level, is_usable};
use taxel::simulate::{Grams, newtons};
use taxel::{Frame, Mark, Newtons};
use taxel_io::ReadOptions;
use taxel_plot::report::{Cell, Figure, Section, Table};
use taxel_plot::{Panel, Sheet, cells};

use super::{HEAD, Known, PLACE_HEAD, coverage, figure, name_of, place_row, range_name, row};
use crate::error::Error;
use crate::evaluation::plan::{Experiment, Plan};
use crate::evaluation::readings::Reader;
use crate::evaluation::regions::KnownRegions;
use crate::evaluation::{faulty_lines, no_law};
use crate::frames::open_values;
use crate::methods::MethodName;
use crate::reporter::Reporter;

/// What the frames of a recording with all loads known say of a method.
#[derive(Default)]
struct Whole {
    loaded: Vec<Vec<Pair>>,
    total: Vec<Vec<Pair>>,
    regions: KnownRegions,
    centre: Vec<Vec<Pair>>,
    ghosts: Vec<f64>,
    index: Vec<f64>,
    each: Option<TaxelCrossTalk>,
    has_unmeasured: bool,
    held: Option<coverage::WholeFrames>,
}

/// A recording with the load of every taxel in every frame.
pub(in crate::evaluation) fn of_whole_frames(
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
    let mut words = vec![words_of(frames, experiment)];
    let without = whole.iter().any(|whole| whole.has_unmeasured);
    words.extend(without.then(|| UNMEASURED.to_owned()));
    words.extend(faulty_lines(&reader.faulty, reporter));
    Ok((
        whole_section(plan, experiment, &sensor, &methods, whole, words)?,
        lost,
    ))
}

/// What the section is about.
fn words_of(frames: u64, experiment: &Experiment) -> String {
    format!(
        "All loads are known in each of {frames} frames; {}. Errors are over taxels that carry a load; a ghost is what a taxel without load reports; the cross-talk index is the mean of unloaded taxels that share a line with a loaded one over the mean of the loaded ones.",
        match experiment.frames_per_experiment() {
            1 => "each is an experiment".to_owned(),
            some => format!("{some} that follow each other are one experiment"),
        }
    )
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
        let last = self.total.last_mut().expect("one was begun");
        last.extend(coverage::measured_sums(truth, loads).map(|(truth, found)| pair(truth, found)));
        let is_lost = |mark: &Mark| !is_usable(*mark) && *mark != Mark::Absent;
        self.has_unmeasured |= loads.marks().iter().any(is_lost);
        self.regions.add(sensor, loads, truth, is_new);
        let centre = |frame| taxel::metric::FrameFigures::of(frame, sensor).centre_mm;
        let mut of_measured = truth.clone();
        of_measured.marks_mut().copy_from_slice(loads.marks());
        if let (Some(known), Some(found)) = (centre(&of_measured), centre(loads)) {
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

const UNMEASURED: &str = "What stands where nothing was measured is in no figure: a sum is of the taxels that were, known loads as well.";
const GHOSTS: &str = "Cross-talk; the worst taxel is named by its row and column";
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

fn region_rows(plan: &Plan, name: &str, whole: &Whole, sensor: &taxel::Sensor) -> Vec<Vec<Cell>> {
    let of = |(region, pairs): (&str, &[Vec<Pair>])| {
        let found = accuracy(pairs, &plan.bootstrap)?;
        Some(row(format!("{name}, {region}"), &found))
    };
    whole.regions.named(sensor).filter_map(of).collect()
}

fn whole_section(
    plan: &Plan,
    experiment: &Experiment,
    sensor: &taxel::Sensor,
    methods: &[MethodName],
    whole: Vec<Whole>,
    words: Vec<String>,
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
    let mut regions = Table::new("Load on the region, g", &HEAD);
    let mut centre = Table::new(
        "Centre of pressure, distance from the true one, mm",
        &PLACE_HEAD,
    );
    let mut ghosts = Table::new(GHOSTS, &GHOST_HEAD);
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
        regions
            .rows
            .extend(region_rows(plan, &name, &whole, sensor));
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
        let loaded = whole.loaded.concat();
        drawn.push((name, loaded.into_iter().map(Known::of).collect()));
    }
    let tables = [loaded, ranges, regions, total, centre, held, ghosts];
    let mut figures = vec![figure("loaded taxels", drawn)?];
    if !maps.is_empty() {
        figures.push(index_map(sensor, maps)?);
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs: words,
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
