//! How constant the total of one person is over postures: as read, with rows equalised, and by calibrations learnt from the
//! totals of other postures. What comes out, and what it does not show: docs/real-mats.md.
//!
//! `cargo run --release -p taxel-io --example bed_totals popu-96kg.npz`

mod hold_out;
mod law;
mod recording;
mod ridge;

use std::error::Error;
use std::path::PathBuf;

use hold_out::{Held, Leave, held_out, variation};
use law::{Model, Rows, Shape, Tare};
use recording::{COLUMNS, Posture, ROWS, Recording};
use taxel::stats::{Bootstrap, mean, quantile};

const WEIGHT_KG: f64 = 96.0;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).map(PathBuf::from);
    let path =
        path.ok_or("which file? popu-96kg.npz of the PoPu dataset, doi 10.3390/data8070120")?;
    let recording = recording::read(&path)?;
    print_lines(&recording);
    let raw = Tare { empty: None };
    let net = Tare {
        empty: Some(recording.empty.clone()),
    };
    let models = models(&raw, &net, &recording.postures);
    for (leave, name) in Leave::ALL {
        println!("\nleft out: {name}\n{HEADER}");
        for model in &models {
            let held = held_out(model, &recording.postures, leave);
            print_row(model, &recording.postures, &held);
        }
    }
    println!("\nnothing left out: mean total of each family, kg");
    for model in &models {
        print_families(model, &recording.postures);
    }
    let power = models.iter().find(|model| model.name == "power law");
    let power = power.ok_or("no power law")?;
    print_exponent(power, &recording.postures)?;
    print_others(power, &recording);
    Ok(())
}

fn models<'a>(raw: &'a Tare, net: &'a Tare, postures: &[Posture]) -> Vec<Model<'a>> {
    let linear = || vec![Shape::Power(1.0)];
    let powers = || {
        (2..=75)
            .map(|n| Shape::Power(0.02 * f64::from(n)))
            .collect()
    };
    let bents = [4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 25.0].map(|knee| {
        (0..=10).map(move |n| Shape::Bent {
            knee,
            slope: 0.1 * f64::from(n),
        })
    });
    let counts = (1..=40).map(|n| Shape::Count(f64::from(n)));
    vec![
        Model::new("as read", raw, linear(), Rows::Alike, postures),
        Model::new("empty mat off", net, linear(), Rows::Alike, postures),
        Model::new("equalised", net, linear(), Rows::Equalised, postures),
        Model::new("power law", net, powers(), Rows::Equalised, postures),
        Model::new(
            "bent line",
            net,
            bents.into_iter().flatten().collect(),
            Rows::Equalised,
            postures,
        ),
        Model::new("power, 8 bands", net, powers(), Rows::Banded, postures),
        Model::new(
            "touched taxels",
            net,
            counts.collect(),
            Rows::Alike,
            postures,
        ),
    ]
}

const HEADER: &str = "                mean error       worst            CV  in a posture  last/first  95 % interval       holds   chosen";

fn print_row(model: &Model<'_>, postures: &[Posture], held: &[Held]) {
    let totals: Vec<f64> = held.iter().map(|one| one.total).collect();
    let error = |one: &Held| 100.0 * (one.total - 1.0).abs();
    let average = |of: fn(&Held) -> f64| mean(held.iter().map(of)).unwrap_or(f64::NAN);
    let half_width = average(|one| 0.5 * (one.interval.1 - one.interval.0));
    let holds = |one: &&Held| one.interval.0 <= 1.0 && 1.0 <= one.interval.1;
    let worst = held.iter().max_by(|a, b| error(a).total_cmp(&error(b)));
    let worst = worst.map(|one| (error(one), postures[one.posture].name.as_str()));
    let (worst, name) = worst.unwrap_or_default();
    let mut chosen: Vec<usize> = held.iter().map(|one| one.shape).collect();
    chosen.sort_unstable();
    let (first, last) = (chosen[0], chosen[chosen.len() - 1]);
    let mut range = model.shapes[first].to_string();
    if last != first {
        range = format!("{range} … {}", model.shapes[last]);
    }
    println!(
        "{:15} {:8.1} % {worst:6.1} % {name:9} {:6.1} % {:10.1} % {:11.2}     ± {:4.1} kg {:6} of {}   {range}",
        model.name,
        mean(held.iter().map(error)).unwrap_or(f64::NAN),
        100.0 * variation(&totals),
        100.0 * average(|one| one.within.powi(2)).sqrt(),
        average(|one| one.rise),
        WEIGHT_KG * half_width,
        held.iter().filter(holds).count(),
        held.len(),
    );
}

fn print_families(model: &Model<'_>, postures: &[Posture]) {
    let all: Vec<usize> = (0..postures.len()).collect();
    let fitted = model.fit(&all);
    let total = |&one: &usize| WEIGHT_KG * model.total(&fitted, one);
    let cv = 100.0 * variation(&all.iter().map(total).collect::<Vec<f64>>());
    print!("{:15} CV {cv:4.1} %", model.name);
    for family in Leave::Family.groups(postures) {
        let kg = mean(family.iter().map(total)).unwrap_or(f64::NAN);
        print!("   {} {kg:5.1}", postures[family[0]].family());
    }
    println!();
}

/// Which rows and columns stand out, all postures taken together.
fn print_lines(recording: &Recording) {
    let postures = &recording.postures;
    let (mut rows, mut columns) = ([0.0; ROWS], [0.0; COLUMNS]);
    for snapshot in postures.iter().flat_map(|one| &one.snapshots) {
        for (taxel, reading) in snapshot.iter().enumerate() {
            columns[taxel % COLUMNS] += reading;
            // Column 0 repeats what the others carry.
            rows[taxel / COLUMNS] += if taxel.is_multiple_of(COLUMNS) {
                0.0
            } else {
                *reading
            };
        }
    }
    println!(
        "{} postures, {} snapshots, {} of others",
        postures.len(),
        postures
            .iter()
            .map(|one| one.snapshots.len())
            .sum::<usize>(),
        recording.others.len()
    );
    let all: f64 = columns.iter().sum();
    println!(
        "column 0: {:.1} % of all readings, {:.0} times column 1",
        100.0 * columns[0] / all,
        columns[0] / columns[1]
    );
    let beside = |line: &[f64], at: usize| line[at] / (0.5 * (line[at - 1] + line[at + 1]));
    println!(
        "column 2: {:.1} % of all readings, {:.2} of its neighbours' mean",
        100.0 * columns[2] / all,
        beside(&columns, 2)
    );
    let mut low: Vec<usize> = (1..ROWS - 1).collect();
    low.sort_by(|&a, &b| beside(&rows, a).total_cmp(&beside(&rows, b)));
    for &row in &low[..3] {
        println!(
            "row {row}: {:.2} of its neighbours' mean",
            beside(&rows, row)
        );
    }
}

/// The exponent and how far one weight tells it: poses drawn anew.
fn print_exponent(model: &Model<'_>, postures: &[Posture]) -> Result<(), Box<dyn Error>> {
    let poses = Leave::Pose.groups(postures);
    let exponent = |drawn: &[usize]| match model.shapes[model.fit(drawn).shape] {
        Shape::Power(exponent) => Some(exponent),
        _ => None,
    };
    let bootstrap = Bootstrap {
        resamples: 500,
        ..Bootstrap::default()
    };
    let found = bootstrap.estimate(&poses, exponent).ok_or("no exponent")?;
    let (low, high) = found.interval.ok_or("no interval")?;
    println!(
        "\nexponent {:.2}, 95 % interval over poses {low:.2} to {high:.2}",
        found.value
    );
    let half = |exponent: f64| WEIGHT_KG * 0.5f64.powf(exponent);
    println!(
        "half of every reading would weigh {:.0} kg, {:.0} to {:.0}; by a straight line {:.0}",
        half(found.value),
        half(high),
        half(low),
        half(1.0)
    );
    for family in Leave::Family.groups(postures) {
        let alone = exponent(&family).unwrap_or(f64::NAN);
        println!("  {} alone: {alone:.2}", postures[family[0]].family());
    }
    Ok(())
}

/// Snapshots without a posture: nobody says how much of the person lay on the mat.
fn print_others(model: &Model<'_>, recording: &Recording) {
    let fitted = model.fit(&(0..recording.postures.len()).collect::<Vec<usize>>());
    let others = recording.others.iter();
    let totals: Vec<f64> = others
        .map(|one| WEIGHT_KG * model.total_of(&fitted, one))
        .collect();
    let kg = |share| quantile(totals.iter().copied(), share).unwrap_or(f64::NAN);
    println!(
        "\n`others`, {} snapshots, by the power law: {} below 1 kg; quartiles {:.0}, {:.0}, {:.0} kg, most {:.0} kg",
        totals.len(),
        totals.iter().filter(|&&total| total < 1.0).count(),
        kg(0.25),
        kg(0.5),
        kg(0.75),
        kg(1.0)
    );
}
