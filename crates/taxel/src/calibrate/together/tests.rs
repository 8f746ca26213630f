use super::*;
use crate::calibrate::CalibrationOptions;
use crate::calibrate::model::LawModel;
use crate::calibrate::priors::Beliefs;
use crate::sensor::preset;

/// A model whose offset is at most 50 counts.
fn model() -> Model {
    let sensor = preset("econe").unwrap();
    Model {
        levelled: false,
        spread_is_believed: false,
        seeks_lines: false,
        spread: None,
        most_offset_counts: 50.0,
        beliefs: Beliefs::of(&sensor, &CalibrationOptions::default()),
        law: LawModel::blank(),
        sensor,
    }
}

fn of_presses(list: [f64; 2]) -> Residuals {
    Residuals {
        of_terms: [Vec::new(), Vec::new(), list.to_vec()],
        ..Residuals::default()
    }
}

/// Two residuals: offset − 100, and factor + offset/500 − 0.3.
fn step_of(model: &Model) -> Vec<f64> {
    let unknowns = [Unknown::Offset, Unknown::Factor];
    let hears = Hears {
        of: vec![[0.0, 0.0, 1.0]; 2],
        loss: None,
    };
    let point = Point {
        residuals: of_presses([-100.0, -0.3]),
        weights: [Vec::new(), Vec::new(), vec![1.0; 2]],
        scales: Default::default(),
        owners: Default::default(),
    };
    let slopes = [of_presses([1.0, 0.002]), of_presses([0.0, 1.0])];
    newton_step((model, &unknowns), &hears, &point, &slopes, |_, _| true).unwrap()
}

#[test]
fn an_unknown_stops_at_the_end_of_its_range_and_the_others_go_on() {
    let mut model = model();
    let step = step_of(&model);
    // With 50 counts the second residual leaves 0.3 − 0.1 to the factor.
    assert!((step[0] - 50.0).abs() < 1e-6, "{step:?}");
    assert!((step[1] - 0.2).abs() < 1e-6, "{step:?}");
    assert!(model.set(Unknown::Offset, step[0]).is_some());

    model.most_offset_counts = f64::INFINITY;
    let step = step_of(&model);
    assert!((step[0] - 100.0).abs() < 1e-4, "{step:?}");
    assert!((step[1] - 0.1).abs() < 1e-6, "{step:?}");
}

#[test]
fn what_leaves_its_range_is_no_model() {
    let mut model = model();
    for (unknown, value) in [
        (Unknown::Offset, 50.1),
        (Unknown::Sheet, -0.1),
        (Unknown::Saturation, -1e-3),
        (Unknown::CarryOver, 0.4),
        (Unknown::Exponent, f64::NAN),
    ] {
        assert!(model.set(unknown, value).is_none(), "{unknown:?} {value}");
    }
}
