//! What viewers may change of a simulated source: each once, with its name, its range and where it stands.

use taxel_acquire::simulated::SimulationParameters;
use taxel_server::{Slider, SliderKind};

/// A simulated source, and whether the inverse is told of what is changed about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Simulation {
    pub(super) parameters: SimulationParameters,
    pub(super) inverse_knows: bool,
}

/// One thing that can be changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    ColumnSwitch,
    RowSwitch,
    Gain,
    Noise,
    DeadRow,
    DeadColumn,
    InverseKnows,
}

impl Change {
    /// In the order of the page.
    pub(super) const ALL: [Change; 7] = [
        Change::ColumnSwitch,
        Change::RowSwitch,
        Change::Gain,
        Change::Noise,
        Change::DeadRow,
        Change::DeadColumn,
        Change::InverseKnows,
    ];

    pub(super) fn of_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|change| change.key() == key)
    }

    /// Its name in requests.
    pub(super) fn key(self) -> &'static str {
        match self {
            Change::ColumnSwitch => "r_mux_column_ohms",
            Change::RowSwitch => "r_mux_row_ohms",
            Change::Gain => "open_loop_gain",
            Change::Noise => "noise_counts",
            Change::DeadRow => "dead_row",
            Change::DeadColumn => "dead_column",
            Change::InverseKnows => "inverse_knows",
        }
    }

    pub(super) fn label(self) -> &'static str {
        match self {
            Change::ColumnSwitch => "Column switch",
            Change::RowSwitch => "Row switch",
            Change::Gain => "Amplifier gain",
            Change::Noise => "Noise",
            Change::DeadRow => "Dead row",
            Change::DeadColumn => "Dead column",
            Change::InverseKnows => "Compensate with the true circuit",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Change::ColumnSwitch | Change::RowSwitch => "Ω",
            Change::Noise => "counts",
            _ => "",
        }
    }

    pub(super) fn kind(self) -> SliderKind {
        let (min, max, step, logarithmic) = match self {
            Change::ColumnSwitch | Change::RowSwitch => (0.1, 500.0, 0.1, true),
            Change::Gain => (100.0, 1e6, 1.0, true),
            Change::Noise => (0.0, 100.0, 0.1, false),
            Change::DeadRow | Change::DeadColumn | Change::InverseKnows => {
                return SliderKind::Switch;
            }
        };
        SliderKind::Range {
            min,
            max,
            step,
            logarithmic,
        }
    }

    /// Where it stands; of a switch 0 or 1.
    pub(super) fn value(self, of: &Simulation) -> f64 {
        let flag = |on: bool| f64::from(u8::from(on));
        match self {
            Change::ColumnSwitch => of.parameters.r_mux_column_ohms,
            Change::RowSwitch => of.parameters.r_mux_row_ohms,
            Change::Gain => of.parameters.open_loop_gain,
            Change::Noise => of.parameters.noise_counts,
            Change::DeadRow => flag(of.parameters.dead_row),
            Change::DeadColumn => flag(of.parameters.dead_column),
            Change::InverseKnows => flag(of.inverse_knows),
        }
    }

    pub(super) fn set(self, of: &mut Simulation, value: f64) {
        let on = value >= 0.5;
        match self {
            Change::ColumnSwitch => of.parameters.r_mux_column_ohms = value,
            Change::RowSwitch => of.parameters.r_mux_row_ohms = value,
            Change::Gain => of.parameters.open_loop_gain = value,
            Change::Noise => of.parameters.noise_counts = value,
            Change::DeadRow => of.parameters.dead_row = on,
            Change::DeadColumn => of.parameters.dead_column = on,
            Change::InverseKnows => of.inverse_knows = on,
        }
    }

    /// As viewers see it.
    pub(super) fn slider(self, of: &Simulation) -> Slider {
        let mut slider = Slider::new(self.key(), self.label(), self.kind(), self.value(of));
        slider.unit = self.unit().to_owned();
        slider
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_is_read_back() {
        let mut simulation = Simulation {
            parameters: SimulationParameters::of(&taxel::sensor::preset("econe").unwrap()),
            inverse_knows: false,
        };
        for change in Change::ALL {
            assert_eq!(Change::of_key(change.key()), Some(change));
            let kind = change.kind();
            for value in [*kind.range().end(), *kind.range().start()] {
                change.set(&mut simulation, value);
                assert_eq!(change.value(&simulation), value, "{}", change.label());
            }
        }
        assert_eq!(Change::of_key("gain"), None);
    }
}
