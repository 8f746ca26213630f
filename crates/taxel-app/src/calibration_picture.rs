//! A calibration in four pictures: what is left, how often the stated intervals hold it, how taxels differ, and the law.

use taxel::calibrate::{Calibration, PressResidual};
use taxel::material::LoadLaw;
use taxel::stats::median;
use taxel::{Mark, Sensor};
use taxel_plot::{Board, ColourMap, Interpolation, Line, LineStyle, Panel, Picture, Series};

use crate::error::Error;

/// Points along a curve.
const POINTS: usize = 80;
/// Residuals are counted up to so many half-widths.
const MOST_HALVES: f64 = 3.0;
/// Residuals beyond so many of the widest half-widths are told, not drawn: all others would be a line.
const DRAWN_HALVES: f64 = 5.0;
/// Colours of what was held out, of what was fitted, and of what is stated.
const HELD_OUT: usize = 3;
const FITTED: usize = 7;
const STATED: usize = 0;

/// The picture of a calibration.
///
/// # Errors
/// [`Error::Plot`] should a heatmap not be encodable; a sensor without a load law.
pub fn of(calibration: &Calibration) -> Result<Picture, Error> {
    let sensor = &calibration.sensor;
    let law = LoadLaw::from_sensor(sensor)?;
    let (held_out, fitted): (Vec<_>, Vec<_>) =
        calibration.residuals.iter().partition(|r| r.held_out);
    let loads = calibration.residuals.iter().map(|r| r.load_g);
    let most_g = loads.clone().fold(1.0, f64::max);
    let usual_g = median(loads.filter(|g| *g > 0.0)).unwrap_or(1.0);
    let pictures = vec![
        residuals(&held_out, &fitted, most_g, sensor)?.picture()?,
        coverage(&held_out, &fitted)?,
        gains(sensor, &law, usual_g)?,
        the_law(sensor, &law, most_g)?.picture()?,
    ];
    let name = match sensor.name() {
        "" => "Calibration".to_owned(),
        name => format!("Calibration of {name}"),
    };
    Ok(Board::new(pictures)?.title(name).picture())
}

/// What is left of the presses, and the law, each in a picture whose plot has that size, points, without a legend.
///
/// # Errors
/// As [`of`].
pub fn small(
    calibration: &Calibration,
    (width, height): (f64, f64),
) -> Result<[Picture; 2], Error> {
    let sensor = &calibration.sensor;
    let law = LoadLaw::from_sensor(sensor)?;
    let (held_out, fitted): (Vec<_>, Vec<_>) =
        calibration.residuals.iter().partition(|r| r.held_out);
    let loads = calibration.residuals.iter().map(|r| r.load_g);
    let most_g = loads.fold(1.0, f64::max);
    let residuals = residuals(&held_out, &fitted, most_g, sensor)?;
    let law = the_law(sensor, &law, most_g)?;
    // Their captions say more there.
    let small = |series: Series| {
        let series = series.title("").caption("").unnamed();
        series.size(width, height).picture()
    };
    Ok([small(residuals)?, small(law)?])
}

/// Half of what is stated to hold 95 %, grams, without noise.
fn half_g(sensor: &Sensor, load_g: f64) -> f64 {
    let stated = sensor.uncertainty();
    stated.map_or(0.0, |stated| {
        stated.factor_95 * stated.beyond_noise_g(load_g)
    })
}

fn curve(most_g: f64) -> Vec<f64> {
    let step = most_g / (POINTS - 1) as f64;
    (0..POINTS).map(|i| step * i as f64).collect()
}

fn residuals(
    held_out: &[&PressResidual],
    fitted: &[&PressResidual],
    most_g: f64,
    sensor: &Sensor,
) -> Result<Series, Error> {
    let loads = curve(most_g);
    let all = || held_out.iter().chain(fitted);
    let widest = all().map(|r| r.half_width_95_g).fold(0.0, f64::max);
    let is_drawn = |r: &PressResidual| (r.estimate_g - r.load_g).abs() <= DRAWN_HALVES * widest;
    let beyond = held_out.iter().filter(|r| !is_drawn(r)).count();
    let mut caption =
        "Each press twice: read by a fit without it, and by the fit of all.".to_owned();
    if beyond > 0 {
        let limit = DRAWN_HALVES * widest;
        caption +=
            &format!(" {beyond} held-out presses are farther off than {limit:.2} g and not drawn.");
    }
    let dots = |name: &str, of: &[&PressResidual], colour| {
        let value = |r: &&PressResidual| {
            let off = r.estimate_g - r.load_g;
            if is_drawn(r) { off } else { f64::NAN }
        };
        let values = of.iter().map(value).collect();
        Line::new(name, values)
            .over(of.iter().map(|r| r.load_g).collect())
            .style(LineStyle::Points)
            .colour(colour)
    };
    let mut lines = vec![
        dots("fitted", fitted, FITTED),
        dots("held out", held_out, HELD_OUT),
    ];
    if sensor.uncertainty().is_some() {
        for (name, sign) in [("stated 95 %", 1.0), ("", -1.0)] {
            let values = loads.iter().map(|&g| sign * half_g(sensor, g)).collect();
            lines.push(
                Line::new(name, values)
                    .style(LineStyle::Dashed)
                    .colour(STATED),
            );
        }
    }
    let series = Series::new("load (g)", loads, lines)?
        .title("What presses read, less their labels")
        .quantity("read − label")
        .unit("g")
        .caption(caption);
    Ok(series)
}

fn coverage(held_out: &[&PressResidual], fitted: &[&PressResidual]) -> Result<Picture, Error> {
    let halves: Vec<f64> = (0..=300)
        .map(|i| MOST_HALVES * f64::from(i) / 300.0)
        .collect();
    let share = |of: &[&PressResidual]| -> Vec<f64> {
        let within = |most: f64| {
            let off =
                |r: &&&PressResidual| (r.estimate_g - r.load_g).abs() <= most * r.half_width_95_g;
            100.0 * of.iter().filter(off).count() as f64 / of.len().max(1) as f64
        };
        halves.iter().map(|&most| within(most)).collect()
    };
    let outside = held_out
        .iter()
        .filter(|r| (r.estimate_g - r.load_g).abs() > r.half_width_95_g)
        .count();
    let mut lines = vec![
        Line::new("fitted", share(fitted))
            .style(LineStyle::Dashed)
            .colour(FITTED),
    ];
    if !held_out.is_empty() {
        lines.push(Line::new("held out", share(held_out)).colour(HELD_OUT));
    }
    lines.push(
        Line::new("stated: 95 % within 1", vec![95.0])
            .over(vec![1.0])
            .style(LineStyle::Points)
            .colour(STATED),
    );
    let series = Series::new(
        "size of the residual (half-widths of its 95 % interval)",
        halves.clone(),
        lines,
    )?
    .title("How many presses their intervals hold")
    .quantity("presses within")
    .unit("%")
    .caption(format!(
        "{outside} of {} held-out presses are outside their interval.",
        held_out.len()
    ));
    Ok(series.picture()?)
}

/// What each taxel conducts under the usual load beside their median.
fn gains(sensor: &Sensor, law: &LoadLaw, usual_g: f64) -> Result<Picture, Error> {
    let taxels = sensor.rows() * sensor.columns();
    let g_zero = sensor.material().map_or(0.0, |m| m.g_zero_siemens);
    let all: Vec<f64> = (0..taxels)
        .map(|taxel| law.siemens_from_grams(taxel, usual_g) - g_zero)
        .collect();
    let there = (0..taxels).filter(|&taxel| !sensor.is_absent(taxel));
    let middle = median(there.map(|taxel| all[taxel])).unwrap_or(1.0);
    let mut marks = vec![Mark::Good; taxels];
    sensor.mark_absent(&mut marks);
    let gains: Vec<f64> = all.iter().map(|g| g / middle).collect();
    let alike = gains.iter().all(|gain| (gain - 1.0).abs() < 1e-9);
    let title = if alike {
        "Gain of each taxel: taken to be alike, no uniform loads told them apart".to_owned()
    } else {
        format!("Gain of each taxel at {usual_g:.0} g, of their median")
    };
    let mut panel = Panel::new(sensor.rows(), sensor.columns(), &gains)?
        .marks(&marks)?
        .title(title)
        .quantity("gain")
        .pitch_mm(sensor.array().pitch_mm)
        .interpolation(Interpolation::Nearest)
        .colour_map(ColourMap::Viridis);
    if alike {
        panel = panel.range(0.5, 1.5);
    }
    Ok(panel.picture()?)
}

/// The law of the taxel whose gain is in the middle, between the loads that an interval allows.
fn the_law(sensor: &Sensor, law: &LoadLaw, most_g: f64) -> Result<Series, Error> {
    let loads = curve(most_g);
    let taxels = 0..sensor.rows() * sensor.columns();
    let mut by_gain: Vec<(f64, usize)> = taxels
        .filter(|&taxel| !sensor.is_absent(taxel))
        .map(|taxel| (law.siemens_from_grams(taxel, most_g / 2.0), taxel))
        .collect();
    by_gain.sort_by(|a, b| a.0.total_cmp(&b.0));
    let taxel = by_gain[by_gain.len() / 2].1;
    // A band that nobody could see is drawn wider than it is.
    let widest = half_g(sensor, most_g).max(1e-12) / most_g;
    let times = 10f64.powf((0.02 / widest).log10().ceil().clamp(0.0, 6.0));
    let siemens = |sign: f64| -> Vec<f64> {
        let at = |&load: &f64| (load + sign * times * half_g(sensor, load)).max(0.0);
        let each = loads.iter().map(at);
        each.map(|load| law.siemens_from_grams(taxel, load))
            .collect()
    };
    let mut lines = vec![Line::new("load law", siemens(0.0)).colour(HELD_OUT)];
    if sensor.uncertainty().is_some() {
        let name = if times > 1.0 {
            format!("stated 95 %, {times} times")
        } else {
            "stated 95 %".to_owned()
        };
        for (name, sign) in [(name.as_str(), 1.0), ("", -1.0)] {
            lines.push(
                Line::new(name, siemens(sign))
                    .style(LineStyle::Dashed)
                    .colour(STATED),
            );
        }
    }
    let series = Series::new("load (g)", loads.clone(), lines)?
        .title("What a taxel of middling gain conducts")
        .quantity("conductance")
        .unit("S");
    Ok(series)
}
