//! What `taxel rig` says.

use std::fmt;

use serde::Serialize;
use taxel::design::rig::Cell;

/// Everything that was asked.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) presses: Vec<Press>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) tables: Vec<TableCell>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) experiments: Option<Experiments>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) readings: Option<Readings>,
}

/// A spring, a tip, and how far to compress it.
#[derive(Debug, Serialize)]
pub(super) struct Press {
    pub(super) newtons_per_mm: f64,
    pub(super) area_mm2: f64,
    pub(super) load_newtons: f64,
    pub(super) load_g: f64,
    pub(super) megapascals: f64,
    /// None: the moving parts alone weigh more.
    pub(super) compression_mm: Option<f64>,
    /// The compression at the largest force of the paper's mechanism.
    pub(super) largest_mm: Option<f64>,
}

/// A number of the paper's tables beside ours.
#[derive(Debug, Serialize)]
pub(super) struct TableCell {
    table: &'static str,
    newtons_per_mm: f64,
    area_mm2: f64,
    largest_newtons: f64,
    printed_megapascals: &'static str,
    megapascals: f64,
    agrees: bool,
}

impl From<Cell> for TableCell {
    fn from(cell: Cell) -> Self {
        Self {
            table: cell.spring.table,
            newtons_per_mm: cell.spring.newtons_per_mm,
            area_mm2: cell.area_mm2,
            largest_newtons: cell.spring.largest_newtons,
            printed_megapascals: cell.printed,
            megapascals: cell.megapascals,
            agrees: cell.agrees(),
        }
    }
}

/// How many repetitions a mean needs.
#[derive(Debug, Serialize)]
pub(super) struct Experiments {
    pub(super) confidence: f64,
    pub(super) margin_g: f64,
    pub(super) standard_deviation_g: f64,
    pub(super) count: u64,
}

/// How many readings of each sensor tell their shares of outliers apart.
#[derive(Debug, Serialize)]
pub(super) struct Readings {
    pub(super) confidence: f64,
    pub(super) power: f64,
    pub(super) shares: [f64; 2],
    pub(super) of_each: u64,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.presses(f)?;
        self.tables(f)?;
        if let Some(found) = &self.experiments {
            writeln!(
                f,
                "{} experiments: repetitions that scatter by {} g give a mean within {} g, {} % sure",
                found.count,
                found.standard_deviation_g,
                found.margin_g,
                percent(found.confidence)
            )?;
        }
        if let Some(found) = &self.readings {
            let [a, b] = found.shares.map(percent);
            writeln!(
                f,
                "{} readings of each sensor: shares of {a} % and {b} % are told apart, {} % sure, {} times in 100",
                found.of_each,
                percent(found.confidence),
                percent(found.power)
            )?;
        }
        Ok(())
    }
}

/// 0.95 as 95, and 0.999 as 99.9.
fn percent(share: f64) -> f64 {
    (1e8 * share).round() / 1e6
}

impl Report {
    fn presses(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.presses.is_empty() {
            return Ok(());
        }
        writeln!(
            f,
            "{:>12}{:>10}{:>18}{:>14}{:>14}",
            "spring N/mm", "tip mm2", "load", "pressure", "compression"
        )?;
        for press in &self.presses {
            let load = format!("{:.1} g {:.3} N", press.load_g, press.load_newtons);
            let pressure = format!("{:.4} MPa", press.megapascals);
            let (compression, note) = match (press.compression_mm, press.largest_mm) {
                (None, _) => ("-".to_owned(), "  the moving parts weigh more".to_owned()),
                (Some(mm), Some(largest)) if mm > largest => (
                    format!("{mm:.2} mm"),
                    format!("  more than the paper's mechanism has, {largest:.1} mm"),
                ),
                (Some(mm), _) => (format!("{mm:.2} mm"), String::new()),
            };
            writeln!(
                f,
                "{:>12}{:>10}{load:>18}{pressure:>14}{compression:>14}{note}",
                press.newtons_per_mm, press.area_mm2
            )?;
        }
        Ok(())
    }

    fn tables(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut table = "";
        for cell in &self.tables {
            if cell.table != table {
                table = cell.table;
                writeln!(
                    f,
                    "Table {table}: {} N/mm, {} N at most",
                    cell.newtons_per_mm, cell.largest_newtons
                )?;
                writeln!(f, "{:>9}{:>14}{:>14}", "tip mm2", "paper MPa", "ours MPa")?;
            }
            let digits = cell.printed_megapascals.len().saturating_sub(2);
            let ours = rounded(cell.megapascals, digits);
            let note = if cell.agrees {
                ""
            } else {
                "  misprint in the paper"
            };
            writeln!(
                f,
                "{:>9}{:>14}{ours:>14}{note}",
                cell.area_mm2, cell.printed_megapascals
            )?;
        }
        Ok(())
    }
}

/// With as many decimals as the paper prints, halves rounded up as there.
fn rounded(value: f64, digits: usize) -> String {
    let scale = 10f64.powi(digits as i32);
    format!("{:.digits$}", (value * scale + 1e-6).round() / scale)
}
