//! `--presses`, `--rows` and what goes with them: where a model's presses come from.

use std::path::PathBuf;

use taxel_app::training_set::TrainingFiles;

/// Where presses come from.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Sources {
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g
    #[arg(long, value_name = "FILE", required_unless_present = "rows")]
    pub(crate) presses: Option<PathBuf>,
    /// Labelled rows, the paper's table: taxel, the values of its row, load; no header
    #[arg(long, value_name = "FILE")]
    pub(crate) rows: Option<PathBuf>,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    pub(crate) transpose: bool,
    /// Reject labels above this load, g
    #[arg(long, value_name = "GRAMS", default_value_t = 10_000.0)]
    pub(crate) most_load: f64,
}

impl Sources {
    /// What is read.
    pub(crate) fn files(&self) -> TrainingFiles {
        TrainingFiles {
            presses: self.presses.clone(),
            rows: self.rows.clone(),
            transpose: self.transpose,
            max_load_g: self.most_load,
        }
    }
}
