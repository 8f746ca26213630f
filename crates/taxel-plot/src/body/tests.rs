use taxel::Sensor;
use taxel::sensor::{Geometry, preset};

use super::*;

/// A handle of 12 × 20 taxels, 5 mm apart.
fn handle(geometry: Geometry) -> Sensor {
    let sensor = preset("mat-16x16-cd4067").unwrap().edited(|spec| {
        (spec.array.rows, spec.array.columns) = match geometry.rings {
            Some(Rings::Columns) => (20, 12),
            _ => (12, 20),
        };
        spec.array.pitch_mm = [5.0, 5.0];
        spec.array.geometry = Some(geometry);
    });
    sensor.unwrap()
}

fn handles() -> Vec<Sensor> {
    let mut all = Vec::new();
    for rings in Rings::ALL {
        all.push(handle(Geometry::cylinder(rings, 32.0)));
        all.push(handle(Geometry::cylinder(rings, 40.0)));
        all.push(handle(Geometry::cone(rings, [50.0, 32.0])));
        all.push(handle(Geometry::cone(rings, [32.0, 50.0])));
    }
    all
}

/// Where a taxel's centre is drawn, and whether it faces the eye.
fn drawn(view: &View<'_>, taxel: usize) -> ((f64, f64), bool) {
    let handle = view.handle;
    let (ring, line) = handle.ring_and_line(taxel);
    let ((sin, cos), (up, level)) = (view.side, ELEVATION.sin_cos());
    let (s, c) = handle.angles[line].sin_cos();
    let radius = handle.radii_mm[ring];
    let right = radius * (s * cos - c * sin);
    let away = radius * (c * cos + s * sin);
    let [(upper, _), (lower, last)] = view.ends();
    let height = (last + 0.5) * view.step_mm();
    let z = -(ring as f64 + 0.5) * view.step_mm();
    // The middle of the picture, by its outermost points.
    let (top, bottom) = (upper * up, -height * level - lower * up);
    let at = z * level - away * up - (top + bottom) / 2.0;
    let slope = (upper - lower) / height;
    let faces = level * away / radius - up * slope;
    ((right, at), faces > 0.05)
}

#[test]
fn a_taxel_is_seen_where_it_lies() {
    for sensor in handles() {
        let handle = sensor.handle().unwrap();
        let mut seen = 0;
        for side in 0..VIEWS {
            let view = View::new(handle, side);
            for taxel in 0..sensor.rows() * sensor.columns() {
                let ((right, up), faces) = drawn(&view, taxel);
                if !faces {
                    continue;
                }
                let found = view.at(right, up);
                let Some(Seen::Surface(at)) = found else {
                    panic!("{found:?}");
                };
                let (ring, line) = handle.ring_and_line(taxel);
                assert!((at.ring - ring as f64).abs() < 1e-6, "{at:?} {ring}");
                assert!((at.line - line as f64).abs() < 1e-6, "{at:?} {line}");
                assert!((DARKEST..=1.0).contains(&at.light));
                let [width, height] = view.size_mm();
                assert!(right.abs() <= width / 2.0 && up.abs() <= height / 2.0);
                seen += 1;
            }
        }
        // Half of the taxels a side, but for those at its edge.
        let taxels = sensor.rows() * sensor.columns();
        assert!((taxels..2 * taxels + 1).contains(&seen), "{seen} {taxels}");
    }
}

#[test]
fn its_values_are_those_of_its_taxels_and_the_seam_is_bare() {
    for sensor in handles() {
        let (handle, taxels) = (sensor.handle().unwrap(), sensor.rows() * sensor.columns());
        let values: Vec<f64> = (0..taxels).map(|t| (t * t % 97) as f64).collect();
        for way in [Interpolation::Nearest, Interpolation::Bilinear(10)] {
            let panel = Panel::new(sensor.rows(), sensor.columns(), &values).unwrap();
            let body = Body::new(panel.interpolation(way), handle).unwrap();
            let value = |ring: f64, line: f64| {
                let at = Surface {
                    ring,
                    line,
                    light: 1.0,
                };
                body.value(at, &values)
            };
            for (taxel, wanted) in values.iter().enumerate() {
                let (ring, line) = handle.ring_and_line(taxel);
                let found = value(ring as f64, line as f64).unwrap();
                assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
            }
            // In the middle of the seam.
            let whole = TAU / handle.angles[1];
            let seam = value(3.0, (whole + 19.0) / 2.0);
            assert_eq!(seam.is_some(), handle.closes());
        }
    }
}

#[test]
fn above_it_and_beside_it_is_nothing_and_its_end_is_an_end() {
    let sensor = handle(Geometry::cylinder(Rings::Rows, 40.0));
    let view = View::new(sensor.handle().unwrap(), 1);
    let [width, height] = view.size_mm();
    assert_eq!(view.at(width / 2.0 + 0.1, 0.0), None);
    assert_eq!(view.at(0.0, height / 2.0 + 0.1), None);
    assert_eq!(view.at(0.0, -height / 2.0 - 0.1), None);
    let middle_of_end = height / 2.0 - 20.0 * ELEVATION.sin();
    assert_eq!(view.at(0.0, middle_of_end), Some(Seen::End));
}

#[test]
fn a_picture_has_four_sides_and_says_what_is_marked() {
    let sensor = handle(Geometry::cylinder(Rings::Rows, 40.0));
    let values = vec![0.5; 240];
    let mut marks = vec![taxel::Mark::Good; 240];
    marks[7] = taxel::Mark::Stuck;
    let panel = Panel::new(12, 20, &values).unwrap();
    let panel = panel.marks(&marks).unwrap().unit("g");
    let body = Body::new(panel, sensor.handle().unwrap()).unwrap();
    let picture = body.clone().caption("run").picture().unwrap();
    assert_eq!(picture.svg().matches("<image").count(), VIEWS + 1);
    assert!(picture.svg().contains("run; marked: 1 stuck"));
    let extent = Extent::points(900, 500).unwrap();
    let fitted = body.fit(extent).picture().unwrap();
    assert_eq!((fitted.width(), fitted.height()), (900, 500));
    let other = preset("econe").unwrap();
    let panel = Panel::new(12, 20, &values).unwrap();
    let error = Body::new(panel, other.handle().unwrap()).unwrap_err();
    assert!(matches!(error, Error::Shape { found: 8192, .. }), "{error}");
}
