//! What do other pressed taxels of the line do to one?

use taxel::evaluate::sweep::{
    Sweep, SweepReading, equation_6_volts, full_circuit_volts, misfit, siemens_of_volts, sweep,
};
use taxel::metric::cross_talk_drop;
use taxel::screen::Axis;
use taxel_plot::report::{Cell, Figure, Section, Table};
use taxel_plot::{Line, LineStyle, Series, cells};

use super::at_end::readings_at_end;
use super::plan::{Along, Experiment, Plan, Value};
use super::readings::Group;
use super::response::half;
use super::{no_value, too_few};
use crate::error::Error;

/// Curves beside the measured one, volts.
struct Models {
    siemens: Option<f64>,
    full: Vec<f64>,
    equation_6: Vec<f64>,
}

const HEAD: [&str; 10] = [
    "setting",
    "experiments",
    "others",
    "drop, %",
    "taxel, Ω",
    "full circuit: drop, %",
    "misfit, %",
    "equation 6: drop, %",
    "misfit, %",
    "compensated: drop, %",
];

pub(super) fn section(
    plan: &Plan,
    experiment: &Experiment,
    groups: &[Group],
) -> Result<Section, Error> {
    let along = match experiment.along() {
        Along::Row => Axis::Row,
        Along::Column => Axis::Column,
    };
    let mut table = Table::new(
        format!(
            "Cross-talk: how much less is read with the most others pressed than with the fewest, %; {} intervals over experiments. Misfit: root mean square distance from the mean curve, % of its first point",
            plan.sure()
        ),
        &HEAD,
    );
    let mut curve = Table::new(
        "Mean V_out, V",
        &[
            "setting",
            "others",
            "readings",
            "V_out",
            "full circuit",
            "equation 6",
        ],
    );
    let mut figures = Vec::new();
    for group in groups {
        check_others(experiment, group, along)?;
        let experiments = readings(plan, group, |reading| Some(reading.volts))?;
        let found = sweep(&experiments, &plan.bootstrap)
            .ok_or_else(|| too_few(experiment, group, "readings with two numbers of others"))?;
        let models = models(group, along, &found)?;
        table.push(row(plan, group, &found, &models)?);
        for (i, point) in found.points.iter().enumerate() {
            curve.push(cells![
                group.name().to_owned(),
                point.others,
                point.readings,
                point.value,
                models.full[i],
                models.equation_6[i],
            ]);
        }
        figures.push(figure(plan, group, &found, &models)?);
    }
    Ok(Section {
        title: experiment.name.clone(),
        paragraphs: vec![format!(
            "One taxel is read while others of its {along} are pressed alike. The full circuit is the scan of the whole array with the sensor file's switches, gain and resistors; its taxels have the one conductance that gives the first point of the mean curve. Equation 6 of the e-Cone paper knows the amplifier's gain and nothing of the switches; it is scaled to the first point."
        )],
        tables: vec![table, curve],
        figures,
    })
}

/// No more others than the line has.
fn check_others(experiment: &Experiment, group: &Group, along: Axis) -> Result<(), Error> {
    let taxels = match along {
        Axis::Row => group.sensor.columns(),
        Axis::Column => group.sensor.rows(),
    };
    let beyond = |trial: &&taxel_io::Trial| trial.others.is_some_and(|n| n >= taxels);
    match group.trials.iter().find(beyond) {
        Some(trial) => Err(Error::Plan {
            file: experiment.trials.clone().unwrap_or_default(),
            reason: format!(
                "line {}: {} others pressed, but a {along} has {taxels} taxels",
                trial.line,
                trial.others.unwrap_or_default()
            ),
        }),
        None => Ok(()),
    }
}

fn readings(
    plan: &Plan,
    group: &Group,
    value: impl Fn(&super::readings::TrialReading) -> Option<f64>,
) -> Result<Vec<Vec<SweepReading>>, Error> {
    group.collect(
        super::readings::TrialReading::is_measured,
        |trial, reading| {
            Ok(SweepReading {
                others: trial.others.unwrap_or_default(),
                value: value(reading).ok_or_else(|| no_value(plan, Value::Siemens))?,
            })
        },
    )
}

fn models(group: &Group, along: Axis, found: &Sweep) -> Result<Models, Error> {
    let sensor = &group.sensor;
    let taxel = group.trials[0].taxel.unwrap_or_default();
    let rest = sensor.material().map_or(0.0, |m| m.g_zero_siemens);
    let others: Vec<usize> = found.points.iter().map(|point| point.others).collect();
    let first = found.points[0];
    let siemens = siemens_of_volts(sensor, taxel, along, rest, first.others, first.value.value)?;
    let nothing = vec![f64::NAN; others.len()];
    Ok(match siemens {
        Some(siemens) => Models {
            full: full_circuit_volts(sensor, taxel, along, siemens, rest, &others)?,
            equation_6: equation_6_volts(sensor, 1.0 / siemens, first.value.value, &others),
            siemens: Some(siemens),
        },
        None => Models {
            siemens: None,
            full: nothing.clone(),
            equation_6: nothing,
        },
    })
}

fn row(plan: &Plan, group: &Group, found: &Sweep, models: &Models) -> Result<Vec<Cell>, Error> {
    let ends = (&found.points[0], &found.points[found.points.len() - 1]);
    let drop = |curve: &[f64]| 100.0 * cross_talk_drop(curve[0], curve[curve.len() - 1]);
    let off = |curve: &[f64]| misfit(&found.points, curve).map(|share| 100.0 * share);
    let siemens = |reading: &super::readings::TrialReading| reading.value(Value::Siemens);
    // A model estimates loads and has none: its cell is empty.
    let has_siemens = group.readings.iter().all(|r| siemens(r).is_some());
    let compensated = if has_siemens {
        sweep(&readings(plan, group, siemens)?, &plan.bootstrap)
    } else {
        None
    };
    Ok(cells![
        group.name(),
        found.drop_percent.experiments,
        format!("{} to {}", ends.0.others, ends.1.others),
        found.drop_percent,
        models.siemens.map(|siemens| 1.0 / siemens),
        drop(&models.full),
        off(&models.full),
        drop(&models.equation_6),
        off(&models.equation_6),
        compensated.map(|sweep| sweep.drop_percent),
    ])
}

fn figure(plan: &Plan, group: &Group, found: &Sweep, models: &Models) -> Result<Figure, Error> {
    let x: Vec<f64> = found
        .points
        .iter()
        .map(|point| point.others as f64)
        .collect();
    let size = |values: &[f64]| values.iter().map(|v| v.abs()).collect::<Vec<_>>();
    let measured: Vec<f64> = found.points.iter().map(|p| p.value.value.abs()).collect();
    let mut lines = vec![
        Line::new(format!("measured, {}", plan.sure()), measured)
            .style(LineStyle::Points)
            .errors(found.points.iter().map(|p| half(&p.value)).collect())
            .colour(0),
        Line::new("full circuit", size(&models.full)).colour(1),
        Line::new("equation 6", size(&models.equation_6))
            .style(LineStyle::Dashed)
            .colour(2),
    ];
    lines.extend(readings_at_end(group, |trial, reading, _| {
        Some((trial.others? as f64, reading.volts.abs()))
    }));
    let picture = Series::new("other taxels pressed", x, lines)?
        .title(group.title())
        .quantity("|V_out|")
        .unit("V")
        .picture()?;
    Ok(Figure {
        caption: format!(
            "V_out against the number of other pressed taxels, {}.",
            group.title()
        ),
        picture,
    })
}
