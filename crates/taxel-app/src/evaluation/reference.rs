//! The force that recordings themselves tell (of the program that exported them) beside the total that is found.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use taxel::pipeline::Pipeline;
use taxel::{Frame, Sensor};
use taxel_io::{FrameSource, ReadOptions, exports, open_counts};
use taxel_plot::cells;
use taxel_plot::report::{Section, Table};

use super::plan::Plan;
use super::trials;
use crate::error::Error;
use crate::frames::show;
use crate::measure::Reference;
use crate::methods::MethodName;
use crate::reporter::Reporter;

/// A table of all recordings of the plan's trials that tell a force of their own, each by the sensor of its experiment; `None`
/// where there are none.
pub(super) fn section(plan: &Plan, reporter: &dyn Reporter) -> Result<Option<Section>, Error> {
    let names = [
        "recording",
        "frames",
        "largest, N",
        "mean difference, N",
        "largest difference, N",
        "ratio",
    ];
    let caption = "total force less the one that the recording tells; ratio: median where that is above a tenth of its largest";
    let mut table = Table::new(caption, &names);
    let mut seen = BTreeSet::new();
    for experiment in &plan.experiments {
        // By the sensor of the setting, as its figures are.
        let recordings: BTreeSet<(PathBuf, Option<&String>)> = trials(plan, experiment)?
            .into_iter()
            .filter(|trial| exports::is_export(&trial.recording))
            .map(|trial| {
                let own = trial
                    .setting
                    .and_then(|word| experiment.settings.get(&word));
                (trial.recording, own.or(experiment.sensor.as_ref()))
            })
            .collect();
        for (recording, word) in recordings {
            let (sensor, sensor_file) = plan.sensor_of(word)?;
            if !seen.insert((recording.clone(), sensor_file.clone())) {
                continue;
            }
            let Some(found) = compare(&recording, &sensor, &sensor_file, reporter)? else {
                continue;
            };
            let name = recording.strip_prefix(plan.folder()).unwrap_or(&recording);
            table.push(cells![
                name.display().to_string(),
                found.frames,
                format!("{:.2}", found.largest_n),
                format!("{:+.3}", found.mean_difference_n),
                format!("{:.3}", found.largest_difference_n),
                found
                    .ratio
                    .map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.4}")),
            ]);
        }
    }
    if seen.is_empty() || table.rows.is_empty() {
        return Ok(None);
    }
    Ok(Some(Section {
        title: "The recordings' own force".to_owned(),
        paragraphs: vec![
            "Some recordings tell a force that their program has found, by its own sum or by another instrument. No figure above rests on it."
                .to_owned(),
        ],
        tables: vec![table],
        figures: Vec::new(),
    }))
}

/// Every frame's total beside the force told with it.
fn compare(
    recording: &Path,
    sensor: &Sensor,
    sensor_file: &Path,
    reporter: &dyn Reporter,
) -> Result<Option<Reference>, Error> {
    let mut pipeline: Pipeline = MethodName::Auto.pipeline(sensor, sensor_file)?;
    let mut options = ReadOptions::of(sensor);
    options.keep_going = true;
    let mut source = open_counts(recording, options)?;
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    let stage = reporter.stage("reading");
    let mut both = Vec::new();
    while source.next_into(&mut frame)? {
        show(&source, &*stage);
        let result = pipeline.process(&frame);
        let is_answer = result.outcome.is_answer();
        if let (Some(told), Some(loads)) = (source.reference_newtons(), result.loads)
            && is_answer
        {
            both.push((loads.values().iter().sum(), told));
        }
    }
    Ok(Reference::of_pairs(&both))
}
