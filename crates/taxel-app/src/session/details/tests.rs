use taxel::metric::FrameFigures;
use taxel::pipeline::Pipeline;
use taxel::sensor::{UncertaintySpec, preset};
use taxel::simulate::VirtualSensor;
use taxel::solve::default_method;

use super::*;

fn sensor(uncertainty: Option<UncertaintySpec>) -> Arc<Sensor> {
    let sensor = preset("mat-16x16-cd4067").unwrap().edited(|spec| {
        (spec.array.rows, spec.array.columns) = (4, 5);
        spec.array.labels = None;
        spec.converter.noise_counts = Some(1.0);
        spec.uncertainty = uncertainty;
    });
    Arc::new(sensor.unwrap())
}

/// Under a load of 100 g a taxel.
fn request(sensor: &Arc<Sensor>) -> DetailsRequest {
    let drawn = VirtualSensor::new(sensor, 1).unwrap();
    let reading = drawn.read(&Frame::filled(4, 5, 100.0), 7);
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let result = pipeline.process(&reading.counts);
    let loads = result.newtons().unwrap();
    let figures = FrameFigures::of(loads, sensor);
    let mut shown = FrameMessage::new(4, 5);
    shown.sequence = 7;
    shown.total_newtons = figures.total_force_newtons;
    shown.contact_area_mm2 = figures.contact_area_mm2;
    shown.loads = loads.values().iter().map(|&load| load as f32).collect();
    DetailsRequest {
        siemens: result.siemens.cloned(),
        loads: Some(loads.clone()),
        is_answer: result.outcome.is_answer(),
        sensor: sensor.clone(),
        shown,
    }
}

fn watched(taxels: &[(usize, usize)], figures: bool) -> Watched {
    let mut watched = Watched::default();
    watched.taxels = taxels.to_vec();
    watched.figures = figures;
    watched
}

/// What a viewer is told that watches this, as the worker has answered it.
fn told(watched: &Watched, request: DetailsRequest) -> Message {
    let details = Details::new("sensor.toml".into());
    details.message(watched);
    details.ask(request);
    details.close();
    details.run();
    details.message(watched)
}

fn figures(request: DetailsRequest) -> FigureDetails {
    told(&watched(&[], true), request).figures.unwrap()
}

#[test]
fn nothing_is_worked_out_before_somebody_looks() {
    let details = Details::new("sensor.toml".into());
    assert!(!details.is_wanted());
    assert_eq!(details.message(&watched(&[], true)), Message::default());
    assert!(details.is_wanted());
    // A frame that may stand for long is wanted, however soon it comes.
    details.expect();
    assert!(details.is_wanted());
}

#[test]
fn the_total_has_its_interval_without_a_taxel_pointed_at() {
    let found = figures(request(&sensor(None)));
    assert_eq!((found.sequence, found.why_unbounded.as_str()), (7, ""));
    let half = found.total_half_width_95_newtons.unwrap();
    assert!(0.0 < half && half < 0.1 * found.total_newtons, "{found:?}");
    assert!(found.contact_area_half_width_95_mm2.unwrap() >= 0.0);
    assert!(found.noise_only);

    let calibrated: UncertaintySpec = toml::from_str(
        "model_share = 0.05\nmodel_floor_g = 0.5\nfit_share = 0.05\nfactor_95 = 2.0\npresses = 100",
    )
    .unwrap();
    let known = figures(request(&sensor(Some(calibrated))));
    assert!(!known.noise_only);
    assert!(known.total_half_width_95_newtons.unwrap() > 2.0 * half);
}

#[test]
fn who_asks_for_one_of_the_two_is_not_told_the_other() {
    let taxels = told(&watched(&[(1, 2), (9, 9)], false), request(&sensor(None)));
    assert_eq!((taxels.taxels.len(), &taxels.figures), (1, &None));
    assert!(taxels.taxels[0].half_width_95_newtons > Some(0.0));

    // Errors of taxels are dear: nobody has pointed at one when the frame was looked at.
    let details = Details::new("sensor.toml".into());
    details.message(&watched(&[], true));
    details.ask(request(&sensor(None)));
    details.close();
    details.run();
    let late = details.message(&watched(&[(1, 2)], true));
    assert!(late.figures.is_some());
    assert!(late.taxels[0].siemens.is_some());
    assert_eq!(late.taxels[0].half_width_95_newtons, None);
}

#[test]
fn where_nothing_bounds_the_total_it_is_said_why() {
    let sensor = sensor(None);
    let says = |change: &dyn Fn(&mut DetailsRequest), words: &str| {
        let mut changed = request(&sensor);
        change(&mut changed);
        let found = figures(changed);
        assert!(found.why_unbounded.contains(words), "{found:?}");
        assert_eq!(found.total_half_width_95_newtons, None);
        assert_eq!(found.contact_area_half_width_95_mm2, None);
    };
    let saturate = |request: &mut DetailsRequest| {
        let loads = request.loads.as_mut().unwrap();
        loads.marks_mut()[3] = Mark::Saturated;
    };
    says(&saturate, "at the converter's ceiling");
    says(&|request| request.is_answer = false, "no single answer");
    says(
        &|request| request.shown.is_raw = true,
        "cross-talk is in it",
    );
    says(&|request| request.siemens = None, "a model tells loads");
    // Conductances have no total force.
    let mut siemens = request(&sensor);
    siemens.loads = None;
    assert_eq!(told(&watched(&[], true), siemens).figures, None);
}
