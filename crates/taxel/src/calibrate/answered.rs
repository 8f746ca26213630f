//! Frames that the circuit of the parts list explains: where lines are left open, noise puts some beyond every conductance, and
//! a search that wants an answer of every frame would find no circuit.

use super::CalibrationData;
use super::evidence::Evidence;
use super::inverter::{Inverter, Job};
use super::model::with_switches;
use crate::Sensor;
use crate::parallel::{Executor, par_map};
use crate::sensor::PerLine;

/// Switches that are tried where the file's own are not known, or explain too little: too large ones are what makes frames
/// infeasible.
const SMALL_OHMS: f64 = 0.5;
/// Presses of which more than this share would be left out stay, and the search says what it says.
const MOST_LEFT_OUT: f64 = 0.2;

/// The evidence without the presses and even loads that no conductances explain; nothing where all are explained, or too few.
pub(super) fn answered(
    evidence: &Evidence,
    sensor: &Sensor,
    data: &CalibrationData,
    executor: &dyn Executor,
) -> Option<Evidence> {
    let small = || PerLine::One(SMALL_OHMS);
    let tried = [sensor.clone(), with_switches(sensor, small(), small())];
    let presses = evidence.presses.len();
    for sensor in tried {
        let Some(is_answered) = answers(evidence, &sensor, executor) else {
            continue;
        };
        let kept: Vec<usize> = (0..presses).filter(|&press| is_answered[press]).collect();
        let levels: Vec<bool> = is_answered[presses..].to_vec();
        let left_out = presses - kept.len();
        if left_out as f64 > MOST_LEFT_OUT * presses as f64 || !levels.contains(&true) {
            continue;
        }
        if left_out == 0 && !levels.contains(&false) {
            return None;
        }
        let mut fewer = evidence.part(&kept);
        for press in (0..presses).filter(|&press| !is_answered[press]) {
            let press = &evidence.presses[press];
            fewer.left_out.push(format!(
                "{}: no conductances explain its frame",
                press.name(data)
            ));
        }
        for (level, _) in evidence.levels.iter().zip(&levels).filter(|(_, is)| !**is) {
            let load = level.load_g;
            fewer.left_out.push(format!(
                "the even load of {load} g: no conductances explain its frames"
            ));
        }
        let each = fewer.levels.into_iter().zip(levels);
        fewer.levels = each.filter_map(|(level, is)| is.then_some(level)).collect();
        return Some(fewer);
    }
    None
}

/// Of every press and then every even load, whether its frame has an answer with this circuit; nothing where it is not known.
fn answers(evidence: &Evidence, sensor: &Sensor, executor: &dyn Executor) -> Option<Vec<bool>> {
    let inverter = Inverter::new(evidence, sensor)?;
    let all = evidence.presses.len() + evidence.levels.len();
    let jobs: Vec<Job> = (0..all).map(|frame| (frame, None)).collect();
    par_map(executor, jobs, |job| {
        let seen = inverter.invert_each(&mut [job], |_, _| ());
        Some(seen[0].is_some())
    })
}
