//! Does the same load read the same? (The paper's Figs. 19 and 20 and its Table IV.)

use crate::stats::{Bootstrap, Estimate, SIGMA_PER_MAD, mean, median, standard_deviation};

/// One reading of the load that is repeated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatedReading {
    /// In any unit.
    pub value: f64,
    /// A screen has marked it, or it is outside of the mask: no measurement.
    pub marked: bool,
}

/// A reading further than this many robust standard deviations ([`SIGMA_PER_MAD`] times the median of |value − median of its
/// experiment| over all unmarked readings) from the median of its experiment is an outlier: Hampel's identifier, wide enough for Gaussian noise to lose
/// one reading in 1.7 million.
pub const OUTLIER_SIGMAS: f64 = 5.0;

/// What repeated readings of one load say.
#[derive(Debug, Clone, PartialEq)]
pub struct Repeatability {
    /// Readings in all.
    pub readings: usize,
    /// Those that a screen has marked.
    pub marked: usize,
    /// Those that are outliers beside.
    pub far: usize,
    /// Marked and far ones as a share of all, 0 to 1.
    pub outlier_share: Estimate,
    /// Coefficient of variation within an experiment, all readings: standard deviation over mean, 0 to 1. `None` with one
    /// reading an experiment.
    pub variation: Option<Estimate>,
    /// The same without outliers.
    pub variation_filtered: Option<Estimate>,
    /// Coefficient of variation of the experiments' means, without outliers: what setting up anew adds. `None` with one
    /// experiment.
    pub variation_between: Option<f64>,
    /// Mean of the readings that are no outliers, in their unit.
    pub mean: Option<Estimate>,
    /// Whether single readings stood for experiments, there being fewer than [`Bootstrap::MIN_EXPERIMENTS`] of those.
    pub over_readings: bool,
}

/// A reading, and whether it is an outlier.
#[derive(Clone, Copy)]
struct Judged {
    experiment: usize,
    value: f64,
    outlier: bool,
}

/// Judges readings of one load, grouped by experiment. `resolution` is the least difference of two readings: scatter
/// below it is no scatter. `None` without readings.
pub fn repeatability(
    experiments: &[Vec<RepeatedReading>],
    resolution: f64,
    bootstrap: &Bootstrap,
) -> Option<Repeatability> {
    let centres: Vec<_> = experiments.iter().map(|group| centre(group)).collect();
    let off = |(group, centre): (&Vec<RepeatedReading>, &Option<f64>)| {
        let good = group.iter().filter(|r| !r.marked);
        let centre = centre.unwrap_or(f64::NAN);
        good.map(|r| (r.value - centre).abs()).collect::<Vec<_>>()
    };
    // One scatter for all: that of the few readings of one experiment would be a matter of luck.
    let scatter = median(experiments.iter().zip(&centres).flat_map(off)).unwrap_or(0.0);
    let reach = OUTLIER_SIGMAS * (SIGMA_PER_MAD * scatter).max(resolution);
    let mut screened = Vec::new();
    let (mut marked, mut far) = (0, 0);
    for (experiment, (readings, centre)) in experiments.iter().zip(&centres).enumerate() {
        let screen = |reading: &RepeatedReading| {
            let is_far = centre.is_some_and(|centre| (reading.value - centre).abs() > reach);
            marked += usize::from(reading.marked);
            far += usize::from(!reading.marked && is_far);
            Judged {
                experiment,
                value: reading.value,
                outlier: reading.marked || is_far,
            }
        };
        screened.push(readings.iter().map(screen).collect::<Vec<_>>());
    }
    let readings = screened.iter().map(Vec::len).sum();
    let filled = screened.iter().filter(|group| !group.is_empty()).count();
    let over_readings = filled < Bootstrap::MIN_EXPERIMENTS;
    if over_readings {
        screened = screened.concat().into_iter().map(|one| vec![one]).collect();
    }
    let share = |all: &[Judged]| mean(all.iter().map(|one| f64::from(u8::from(one.outlier))));
    let means = by_experiment(&screened.concat(), true);
    let means: Vec<f64> = means
        .iter()
        .filter_map(|v| mean(v.iter().copied()))
        .collect();
    Some(Repeatability {
        readings,
        marked,
        far,
        outlier_share: bootstrap.estimate(&screened, share)?,
        variation: bootstrap.estimate(&screened, |all| variation(all, false)),
        variation_filtered: bootstrap.estimate(&screened, |all| variation(all, true)),
        variation_between: standard_deviation(&means)
            .zip(mean(means.iter().copied()))
            .map(|(s, m)| s / m.abs()),
        mean: bootstrap.estimate(&screened, |all| {
            mean(all.iter().filter(|one| !one.outlier).map(|one| one.value))
        }),
        over_readings,
    })
}

/// The median of the unmarked readings.
fn centre(readings: &[RepeatedReading]) -> Option<f64> {
    median(readings.iter().filter(|r| !r.marked).map(|r| r.value))
}

/// Values of each experiment; a drawn one may be there twice, which changes neither its mean nor its spread much.
fn by_experiment(all: &[Judged], filtered: bool) -> Vec<Vec<f64>> {
    let count = all.iter().map(|one| one.experiment + 1).max().unwrap_or(0);
    let mut groups = vec![Vec::new(); count];
    for one in all.iter().filter(|one| !(filtered && one.outlier)) {
        groups[one.experiment].push(one.value);
    }
    groups
}

/// Mean over experiments of the standard deviation within, over the mean.
fn variation(all: &[Judged], filtered: bool) -> Option<f64> {
    let each = by_experiment(all, filtered);
    mean(each.iter().filter_map(|values| {
        let centre = mean(values.iter().copied())?;
        Some(standard_deviation(values)? / centre.abs())
    }))
}

/// Difference of two outlier shares, after − before, with its interval. Experiments of both are drawn anew together, so
/// that how many are of either side varies from draw to draw.
pub fn difference(
    before: &[Vec<f64>],
    after: &[Vec<f64>],
    bootstrap: &Bootstrap,
) -> Option<Estimate> {
    let side = |groups: &[Vec<f64>], is_after: bool| -> Vec<Vec<(f64, bool)>> {
        let tag = |group: &Vec<f64>| group.iter().map(|&value| (value, is_after)).collect();
        groups.iter().map(tag).collect()
    };
    let both = [side(before, false), side(after, true)].concat();
    bootstrap.estimate(&both, |all| {
        let of = |is_after| mean(all.iter().filter(|p| p.1 == is_after).map(|p| p.0));
        Some(of(true)? - of(false)?)
    })
}
