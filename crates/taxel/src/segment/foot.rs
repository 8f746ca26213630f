//! Which part of a footprint is heel, midfoot, forefoot and toes.
//!
//! By shares of the foot's length, as masks of plantar pressure are: the toes begin at 81 % (Forghany, Bonanno, Menz, Landorf, *Journal
//! of Foot and Ankle Research* 11:31, 2018: "the forefoot as between 51 and 81 % of the foot length" is the traditional one), and the foot
//! without its toes is cut into equal thirds (Cavanagh and Rodgers, the arch index, *Journal of Biomechanics* 20:547, 1987), which makes
//! 27 and 54 %. The length goes along the print's own axis; the end at which it is wider is the forefoot.

use super::watershed::{ContactOptions, Segmenter};
use super::{Contact, Part};
use crate::{Frame, Newtons, Sensor};

/// The parts that a footprint is cut into.
pub const FOOT_PARTS: [&str; 4] = ["heel", "midfoot", "forefoot", "toes"];

/// Where midfoot, forefoot and toes begin, from the heel, as shares of the foot's length.
const BEGINS: [f64; 3] = [0.27, 0.54, 0.81];
/// Length of a print, mm: of a child's foot and of a large man's.
const LENGTH_MM: [f64; 2] = [140.0, 340.0];
/// Its width, mm.
const WIDTH_MM: [f64; 2] = [40.0, 140.0];
/// Length over width of whole prints; shorter ones lack their toes.
const USUAL_RATIO: [f64; 2] = [2.2, 3.6];
/// Of any print.
const ANY_RATIO: [f64; 2] = [1.9, 5.0];
/// By how much a forefoot is wider than its heel, where there is no doubt which is which.
const SURELY_WIDER: f64 = 0.25;
/// Nobody has looked at it.
const MAX_CONFIDENCE: f64 = 0.9;
/// Feet on a map at the most.
const MAX_FEET: usize = 12;

/// The parts of the feet in a map of a flat sensor, as [`FOOT_PARTS`]; with several feet `foot 1 heel`, `foot 2 heel`, …, by columns
/// and then by rows. `None` where what presses has not the size and the shape of feet.
///
/// A map does not tell whether it is seen from above, so neither does this tell a left foot from a right one.
pub fn feet(
    map: &Frame<Newtons>,
    segmenter: &Segmenter,
    options: &ContactOptions,
) -> Option<Vec<Part>> {
    let sensor = segmenter.sensor();
    if sensor.handle().is_some() {
        return None;
    }
    let contacts = segmenter.contacts(map, options);
    let points: Vec<Point> = contacts
        .iter()
        .flat_map(|contact| points_of(contact, sensor))
        .collect();
    let mut prints = Vec::new();
    divide(points, sensor, &mut prints);
    let heaviest = prints
        .iter()
        .map(|print| newtons(print, map))
        .fold(0.0, f64::max);
    prints.retain(|print| newtons(print, map) > MIN_SHARE * heaviest);
    if prints.is_empty() || prints.len() > MAX_FEET {
        return None;
    }
    let feet: Vec<Print> = prints
        .iter()
        .map(|points| Print::of(points, sensor))
        .collect::<Option<_>>()?;
    let mut order: Vec<&Print> = feet.iter().collect();
    order.sort_by(|a, b| {
        a.middle[1]
            .total_cmp(&b.middle[1])
            .then(a.middle[0].total_cmp(&b.middle[0]))
    });
    let many = order.len() > 1;
    let parts = order.iter().enumerate().flat_map(|(at, print)| {
        print.parts(if many {
            format!("foot {} ", at + 1)
        } else {
            String::new()
        })
    });
    Some(parts.collect())
}

/// A print lighter than this share of the heaviest is none: dirt, a walking stick.
const MIN_SHARE: f64 = 0.05;

/// A touched taxel, mm across the rows and across the columns.
#[derive(Debug, Clone, Copy)]
struct Point {
    taxel: usize,
    at: [f64; 2],
}

fn points_of(contact: &Contact, sensor: &Sensor) -> Vec<Point> {
    let point = |&taxel: &usize| Point {
        taxel,
        at: sensor.place_mm(taxel),
    };
    contact.taxels.iter().map(point).collect()
}

fn newtons(points: &[Point], map: &Frame<Newtons>) -> f64 {
    points.iter().map(|point| map.values()[point.taxel]).sum()
}

/// Into groups that have the size of one foot, at the widest gaps across rows or columns.
fn divide(points: Vec<Point>, sensor: &Sensor, prints: &mut Vec<Vec<Point>>) {
    if points.is_empty() || is_one_foot(&points) {
        prints.extend((!points.is_empty()).then_some(points));
        return;
    }
    let gaps = [0, 1].map(|axis| widest_gap(&points, axis));
    let axis = usize::from(gaps[1].0 > gaps[0].0);
    let (gap, at) = gaps[axis];
    if gap < 1.5 * sensor.array().pitch_mm[axis] {
        prints.push(points);
        return;
    }
    let (low, high) = points.into_iter().partition(|point| point.at[axis] < at);
    divide(low, sensor, prints);
    divide(high, sensor, prints);
}

/// The widest gap between touched lines along an axis, mm, and its middle.
fn widest_gap(points: &[Point], axis: usize) -> (f64, f64) {
    let mut along: Vec<f64> = points.iter().map(|point| point.at[axis]).collect();
    along.sort_by(f64::total_cmp);
    let gaps = along
        .windows(2)
        .map(|pair| (pair[1] - pair[0], 0.5 * (pair[0] + pair[1])));
    gaps.fold(
        (0.0, 0.0),
        |best, gap| if gap.0 > best.0 { gap } else { best },
    )
}

fn is_one_foot(points: &[Point]) -> bool {
    let (_, [length, width]) = axes(points);
    length <= LENGTH_MM[1] && width <= WIDTH_MM[1]
}

/// The axis that the points lie along (a unit vector), with their extent along it and across it, mm.
fn axes(points: &[Point]) -> ([f64; 2], [f64; 2]) {
    let mean = middle(points);
    let moment = |a: usize, b: usize| -> f64 {
        points
            .iter()
            .map(|p| (p.at[a] - mean[a]) * (p.at[b] - mean[b]))
            .sum()
    };
    let angle = 0.5 * (2.0 * moment(0, 1)).atan2(moment(0, 0) - moment(1, 1));
    let axis = [angle.cos(), angle.sin()];
    (
        axis,
        [axis, [-axis[1], axis[0]]].map(|of| extent(points.iter(), of)),
    )
}

fn middle(points: &[Point]) -> [f64; 2] {
    let count = points.len() as f64;
    [0, 1].map(|axis| points.iter().map(|p| p.at[axis]).sum::<f64>() / count)
}

/// How far points reach along an axis (a unit vector), mm; −∞ of none.
fn extent<'a>(points: impl Iterator<Item = &'a Point>, axis: [f64; 2]) -> f64 {
    let along = points.map(|p| p.at[0] * axis[0] + p.at[1] * axis[1]);
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
        (l.min(x), h.max(x))
    });
    high - low
}

/// A footprint: its taxels by their share of the length from the heel.
struct Print {
    middle: [f64; 2],
    taxels: Vec<(usize, f64)>,
    confidence: f64,
}

impl Print {
    fn of(points: &[Point], sensor: &Sensor) -> Option<Self> {
        let (axis, [length, width]) = axes(points);
        let pitch = sensor.array().pitch_mm;
        // From the edge of the first cell to the edge of the last.
        let cell = |of: [f64; 2]| of[0].abs() * pitch[0] + of[1].abs() * pitch[1];
        let across = [-axis[1], axis[0]];
        let (length, width) = (length + cell(axis), width + cell(across));
        let ratio = length / width;
        let is_within = |x: f64, [low, high]: [f64; 2]| (low..=high).contains(&x);
        if !is_within(length, LENGTH_MM)
            || !is_within(width, WIDTH_MM)
            || !is_within(ratio, ANY_RATIO)
        {
            return None;
        }
        let along = |p: &Point| p.at[0] * axis[0] + p.at[1] * axis[1];
        let first = points.iter().map(along).fold(f64::INFINITY, f64::min) - 0.5 * cell(axis);
        let share = |p: &Point| (along(p) - first) / length;
        let wide = |from: f64, to: f64| {
            let there = points.iter().filter(|p| (from..to).contains(&share(p)));
            (extent(there, across) + cell(across)).max(0.0)
        };
        // The ball of the foot lies at 60 to 80 %, the heel at 5 to 25 %, from whichever end.
        let ends = [
            wide(0.6, 0.8) - wide(0.05, 0.25),
            wide(0.2, 0.4) - wide(0.75, 0.95),
        ];
        let is_turned = ends[1] > ends[0];
        let wider = (ends[0] - ends[1]).abs() / (2.0 * width);
        let usual = if ratio < USUAL_RATIO[0] {
            (ratio / USUAL_RATIO[0]).powi(2)
        } else {
            (USUAL_RATIO[1] / ratio).min(1.0).powi(2)
        };
        let taxels = points
            .iter()
            .map(|p| (p.taxel, if is_turned { 1.0 - share(p) } else { share(p) }));
        Some(Self {
            middle: middle(points),
            taxels: taxels.collect(),
            confidence: MAX_CONFIDENCE * usual * (0.5 + 0.5 * (wider / SURELY_WIDER).min(1.0)),
        })
    }

    fn parts(&self, prefix: String) -> Vec<Part> {
        let part = |at: usize| {
            let here = self
                .taxels
                .iter()
                .filter(|(_, share)| BEGINS.iter().filter(|b| share >= b).count() == at);
            let taxels: Vec<usize> = here.map(|(taxel, _)| *taxel).collect();
            let name = format!("{prefix}{}", FOOT_PARTS[at]);
            (!taxels.is_empty()).then(|| Part::new(name, taxels, Some(self.confidence)))
        };
        (0..FOOT_PARTS.len()).filter_map(part).collect()
    }
}
