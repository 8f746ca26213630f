//! The e-Cone paper ("Compensation of Cross-talk in a Large Piezoresistive Sensor Array"), table by table and figure by
//! figure, on a simulated e-Cone: recordings are simulated into a folder, a plan evaluates them as it would real ones,
//! and the paper's own numbers are put beside.

mod known;
mod rehearse;

use std::path::Path;

use taxel::Grams;
use taxel::Sensor;
use taxel::evaluate::sweep::{equation_6_volts, full_circuit_volts};
use taxel::frame::grams_from_newtons;
use taxel::metric::cross_talk_drop;
use taxel::screen::Axis;
use taxel::{Frame, design::rig};
use taxel_io::ReadOptions;
use taxel_plot::report::{Cell, Figure, Section, Table};
use taxel_plot::{Line, LineStyle, Panel, Series, Sheet, cells};

use taxel_app::evaluation::plan::Plan;
use taxel_app::evaluation::readings::Reader;
use taxel_app::evaluation::{self, Evaluation};
use taxel_app::frames::open_values;
use taxel_app::{Error, Reporter, Silent};

/// The seed of everything that is drawn.
const SEED: u64 = 2023;
const TITLE: &str = "The e-Cone paper on a simulated e-Cone";

/// Simulates into a folder, evaluates, compares.
pub(crate) fn run(folder: &Path, reporter: &dyn Reporter) -> Result<Evaluation, Error> {
    reporter.note("simulating the paper's experiments");
    let network = rehearse::write_all(folder, SEED, reporter)?;
    let plan = Plan::read(&folder.join("plan.toml"))?;
    reporter.note("evaluating them");
    let mut found = evaluation::run(&plan, reporter)?;
    let report = &mut found.report;
    let sections = std::mem::take(&mut report.sections);
    let summary = known::next_to(&sections, network);
    report.sections = vec![summary, tables_one_to_three()?];
    let data = sections.len() - 1;
    for (i, section) in sections.into_iter().enumerate() {
        if i == data {
            report.sections.push(table_five(&plan.sensor)?);
            report.sections.push(before_and_after(&plan, folder)?);
            report.sections.push(known::corrections());
        }
        report.sections.push(section);
    }
    Ok(found)
}

/// Springs and tips.
fn tables_one_to_three() -> Result<Section, Error> {
    let mut table = Table::new(
        "Largest pressure of each spring and tip, MPa",
        &["spring, N/mm", "tip, mm²", "printed", "force over area"],
    );
    for cell in rig::tables() {
        let printed = if cell.agrees() {
            cell.printed.to_owned()
        } else {
            format!("{} (misprint)", cell.printed)
        };
        let spring = format!("{}", cell.spring.newtons_per_mm);
        table.push(cells![spring, cell.area_mm2, printed, cell.megapascals]);
    }
    let compression: Vec<f64> = (0..=20).map(f64::from).collect();
    let mut lines = Vec::new();
    for spring in rig::SPRINGS {
        let rig = rig::Rig::new(spring.newtons_per_mm, 1.0).expect("a spring of the paper");
        let load = |mm: &f64| {
            if *mm <= spring.largest_mm() {
                grams_from_newtons(rig.newtons(*mm))
            } else {
                f64::NAN
            }
        };
        let name = format!("{} N/mm", spring.newtons_per_mm);
        lines.push(Line::new(name, compression.iter().map(load).collect()));
    }
    let picture = Series::new("compression (mm)", compression, lines)?
        .quantity("load")
        .unit("g")
        .picture()?;
    Ok(Section {
        title: "Tables I to III, Fig. 11: springs and tips".to_owned(),
        paragraphs: vec![format!(
            "Load = rate · compression + {} g, the weight of the moving parts; pressure = load / area (equation 3). `taxel rig` gives compressions for wanted loads and pressures.",
            rig::OFFSET_G
        )],
        tables: vec![table],
        figures: vec![Figure {
            caption: "Load against compression, to the largest that the tables have (Fig. 11 has the 0.08 N/mm spring).".to_owned(),
            picture,
        }],
    })
}

/// Equation 6 and the full circuit with the paper's own numbers.
fn table_five(sensor: &Sensor) -> Result<Section, Error> {
    let others: Vec<usize> = (0..=20).collect();
    let mut lines = Vec::new();
    let mut table = Table::new(
        "Drop of V_out with 20 other taxels of the row pressed at 1 kΩ each, %",
        &["switches, Ω", "equation 6", "full circuit"],
    );
    let x: Vec<f64> = others.iter().map(|&n| n as f64).collect();
    for (i, ohms) in [0.0f64, 4.0, 10.0, 70.0].into_iter().enumerate() {
        let switches = Some(taxel::sensor::PerLine::One(ohms.max(1e-3)));
        let sensor = sensor.edited(|spec| {
            spec.readout.r_mux_column_ohms = switches.clone();
            spec.readout.r_mux_row_ohms = switches;
        })?;
        let full = full_circuit_volts(&sensor, (32, 64), Axis::Row, 1e-3, 0.0, &others)?;
        let six = equation_6_volts(&sensor, 1000.0, full[0], &others);
        let drop = |curve: &[f64]| 100.0 * cross_talk_drop(curve[0], curve[20]);
        table.push(cells![format!("{ohms}"), drop(&six), drop(&full)]);
        if i == 0 {
            let size = six.iter().map(|v| v.abs()).collect();
            lines.push(
                Line::new("equation 6", size)
                    .style(LineStyle::Dashed)
                    .colour(7),
            );
        }
        let size = full.iter().map(|v| v.abs()).collect();
        lines.push(Line::new(format!("full circuit, {ohms} Ω"), size).colour(i));
    }
    let picture = Series::new("other taxels pressed", x, lines)?
        .quantity("|V_out|")
        .unit("V")
        .picture()?;
    Ok(Section {
        title: "Table V, Fig. 29: equation 6 with its own numbers".to_owned(),
        paragraphs: vec![
            "A = 100 000, R_k = 2 kΩ, R_i = R_taxel = 1 kΩ, V_test = 0.4 V. With these numbers equation 6 cannot make a drop that is seen; the resistance of the row's switch, which the equation leaves out, makes one. `taxel crosstalk` draws both for any numbers.".to_owned(),
        ],
        tables: vec![table],
        figures: vec![Figure {
            caption: "V_out of a taxel against the number of other taxels pressed in its row.".to_owned(),
            picture,
        }],
    })
}

/// A hand, as read and compensated.
fn before_and_after(plan: &Plan, folder: &Path) -> Result<Section, Error> {
    let methods = ["raw", "auto"].map(|name| name.parse().expect("known methods"));
    let mut reader = Reader::new(&plan.sensor, &plan.sensor_file, &methods, None, &Silent)?;
    let mut truths = open_values::<Grams>(
        &folder.join("hand-load-g.npy"),
        ReadOptions::of(&plan.sensor),
    )?;
    let (rows, columns) = (plan.sensor.rows(), plan.sensor.columns());
    let mut truth = Frame::<Grams>::zeros(rows, columns);
    truths.next_into(&mut truth)?;
    let mut shown = Vec::new();
    reader.each_frame(&folder.join("hand.npy"), |reader, frame, index| {
        if index == 0 {
            for method in 0..2 {
                reader.solve(method, frame);
                let loads = reader.result(method).newtons()?;
                shown.push(loads.map::<Grams>(|_, newtons| grams_from_newtons(newtons)));
            }
        }
        Ok(())
    })?;
    shown.push(truth);
    let names = ["as read", "cross-talk removed", "true"];
    let panels = names.iter().zip(&shown).map(|(name, frame)| {
        let panel = Panel::new(rows, columns, frame.values())?;
        Ok(panel
            .title(*name)
            .quantity("load")
            .unit("g")
            .pitch_mm(plan.sensor.array().pitch_mm))
    });
    let panels = panels.collect::<Result<Vec<_>, taxel_plot::Error>>()?;
    Ok(Section {
        title: "Figs. 7, 35 and 36: a hand before and after".to_owned(),
        paragraphs: vec![
            "The same frame with the load law alone and with the circuit undone, beside the loads that were simulated.".to_owned(),
        ],
        tables: Vec::new(),
        figures: vec![Figure {
            caption: "A gripping hand on the simulated e-Cone.".to_owned(),
            picture: Sheet::new(panels)?.shared_range(true).picture()?,
        }],
    })
}

/// The cell of a section's first table in the column of this name and a row.
fn cell(section: &Section, column: &str, row: usize) -> Cell {
    let table = section.tables.first();
    let found = table.and_then(|table| {
        let place = table.head.iter().position(|name| name == column)?;
        table.rows.get(row)?.get(place).cloned()
    });
    found.unwrap_or(Cell::Number(f64::NAN))
}
