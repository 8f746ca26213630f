//! Sensors drawn by seed, each with a read-out, a size, a converter, resistors, switches and a pattern; what `identify` says
//! of their recordings when it knows shape and bits alone. A line for every draw, then the table of docs/identify.md.
//!
//! `cargo run --release -p taxel --example identify_draws -- [SEEDS]`, a list with commas; without one all twelve and the
//! e-Cone.

#[path = "../tests/identify/draw.rs"]
mod draw;

use std::time::Instant;

use draw::Draw;
use taxel::Error;
use taxel::identify::CANDIDATES;
use taxel::identify::{Known, Verdict, identify};
use taxel::parallel::Serial;

/// The seeds of all draws: fixed before the first was looked at.
const SEEDS: std::ops::RangeInclusive<u64> = 101..=112;

/// Of one read-out: draws, right ones first, alone or with others of the same loads, right one left.
#[derive(Default)]
struct Tally {
    draws: usize,
    first: usize,
    told: usize,
    left: usize,
    wrong: usize,
    slowest_secs: f64,
}

fn main() -> Result<(), Error> {
    let seeds: Vec<u64> = match std::env::args().nth(1) {
        Some(text) => text.split(',').filter_map(|n| n.parse().ok()).collect(),
        None => SEEDS.collect(),
    };
    let mut tallies: Vec<Tally> = CANDIDATES.iter().map(|_| Tally::default()).collect();
    for &seed in &seeds {
        for (topology, tally) in CANDIDATES.into_iter().zip(&mut tallies) {
            one(&Draw::new(topology, seed)?, tally)?;
        }
    }
    if std::env::args().nth(1).is_none() {
        one(&Draw::econe()?, &mut tallies[0])?;
    }
    println!("\n| read-out | draws | first | told | left | wrong | slowest, s |");
    println!("|---|---|---|---|---|---|---|");
    for (topology, tally) in CANDIDATES.into_iter().zip(&tallies) {
        println!(
            "| `{}` | {} | {} | {} | {} | {} | {:.1} |",
            topology.name(),
            tally.draws,
            tally.first,
            tally.told,
            tally.left,
            tally.wrong,
            tally.slowest_secs
        );
    }
    Ok(())
}

fn one(draw: &Draw, tally: &mut Tally) -> Result<(), Error> {
    let sensor = draw.real.sensor();
    let truth = sensor.readout().topology;
    let bits = sensor.converter().bits;
    let known = Known::of_shape(sensor.rows(), sensor.columns(), bits)?;
    let frames = draw.frames();
    let begun = Instant::now();
    let found = identify(&known, &frames, &[], &Serial)?;
    let seconds = begun.elapsed().as_secs_f64();
    let is_first = found.standings[0].topology == truth;
    let is_left = found.left().any(|standing| standing.topology == truth);
    let is_told = matches!(found.verdict, Verdict::One | Verdict::Alike);
    tally.draws += 1;
    tally.first += usize::from(is_first);
    tally.told += usize::from(is_told && is_left);
    tally.left += usize::from(is_left);
    tally.wrong += usize::from(is_told && !is_left);
    tally.slowest_secs = tally.slowest_secs.max(seconds);
    let left: Vec<String> = found
        .left()
        .map(|s| format!("{} {:.0}", s.topology.name(), s.excess_nats))
        .collect();
    println!(
        "{} {}: {:?}, first {}, left: {}; {seconds:.1} s",
        if is_first { "right" } else { "WRONG" },
        draw.name,
        found.verdict,
        found.standings[0].topology.name(),
        left.join(", "),
    );
    Ok(())
}
