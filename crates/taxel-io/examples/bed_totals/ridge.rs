//! Factors of bands of the bed, none negative, drawn towards one.

use crate::recording::ROWS;

const BANDS: usize = 8;
type Bands = [f64; BANDS];

/// How strongly factors are drawn towards one: at the last, next to nothing of the totals is left in them.
const STRENGTHS: [f64; 5] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Multiplies each band of rows by a factor, so that the totals of these postures come closer to one. The strength is the one
/// that does best at poses left out of them.
pub fn weigh_bands(
    weights: &mut [f64; ROWS],
    sums: &[[f64; ROWS]],
    training: &[usize],
    poses: &[usize],
) {
    let bands: Vec<(usize, Bands)> = training
        .iter()
        .map(|&p| (poses[p], band_sums(weights, &sums[p])))
        .collect();
    let misses = STRENGTHS.map(|strength| miss(&bands, strength));
    let best = (0..STRENGTHS.len()).min_by(|&a, &b| misses[a].total_cmp(&misses[b]));
    let factors = solve(bands.iter(), STRENGTHS[best.unwrap_or(0)]);
    for (row, weight) in weights.iter_mut().enumerate() {
        *weight *= factors[row * BANDS / ROWS];
    }
}

fn band_sums(weights: &[f64; ROWS], sums: &[f64; ROWS]) -> Bands {
    let mut bands = [0.0; BANDS];
    for row in 0..ROWS {
        bands[row * BANDS / ROWS] += weights[row] * sums[row];
    }
    bands
}

/// The sum of squared errors at poses that are left out in turn.
fn miss(bands: &[(usize, Bands)], strength: f64) -> f64 {
    let mut poses: Vec<usize> = bands.iter().map(|&(pose, _)| pose).collect();
    poses.dedup();
    let of_pose = |&left_out: &usize| {
        let factors = solve(
            bands.iter().filter(|&&(pose, _)| pose != left_out),
            strength,
        );
        let held_out = bands.iter().filter(|&&(pose, _)| pose == left_out);
        held_out
            .map(|(_, sums)| (total(&factors, sums) - 1.0).powi(2))
            .sum::<f64>()
    };
    poses.iter().map(of_pose).sum()
}

fn total(factors: &Bands, sums: &Bands) -> f64 {
    factors.iter().zip(sums).map(|(a, b)| a * b).sum()
}

/// Least squares of the totals' errors, and of factors less one; one factor at a time until they stay.
fn solve<'a>(rows: impl Iterator<Item = &'a (usize, Bands)>, strength: f64) -> Bands {
    let (mut normal, mut right) = ([[0.0; BANDS]; BANDS], [0.0; BANDS]);
    for (_, sums) in rows {
        for a in 0..BANDS {
            right[a] += sums[a];
            for b in 0..BANDS {
                normal[a][b] += sums[a] * sums[b];
            }
        }
    }
    // The penalty is a share of what a band carries over all postures: one that hardly carries anything is hardly held.
    for a in 0..BANDS {
        let pull = strength * right[a];
        normal[a][a] += pull;
        right[a] += pull;
    }
    let mut factors = [1.0; BANDS];
    for _ in 0..500 {
        let mut moved = 0.0f64;
        for a in 0..BANDS {
            let gradient = right[a] - total(&factors, &normal[a]);
            let next = (factors[a] + gradient / normal[a][a].max(1e-12)).max(0.0);
            moved = moved.max((next - factors[a]).abs());
            factors[a] = next;
        }
        if moved < 1e-6 {
            break;
        }
    }
    factors
}
