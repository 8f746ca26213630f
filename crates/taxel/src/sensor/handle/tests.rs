use super::*;
use crate::Sensor;
use crate::sensor::preset;

/// The 32 × 32 mat, lines 2 mm apart.
fn with(geometry: Geometry) -> Result<Sensor, Error> {
    let mat = preset("mat-32x32-adg732").unwrap();
    mat.edited(|spec| {
        spec.array.pitch_mm = [2.0, 2.0];
        spec.array.geometry = Some(geometry);
    })
}

const CLOSED: f64 = 64.0 / PI;

#[test]
fn a_handle_survives_its_file_and_a_plane_is_none() {
    let mut cone = Geometry::cone(Rings::Columns, [CLOSED, 18.0]);
    cone.height_mm = Some(62.5);
    cone.seam_gap_mm = Some(1.5);
    for geometry in [Geometry::cylinder(Rings::Rows, 25.0), cone] {
        let sensor = with(geometry).unwrap();
        let text = sensor.to_toml();
        assert_eq!(Sensor::from_toml(&text).unwrap(), sensor, "{text}");
    }
    let flat = with(Geometry::flat()).unwrap();
    assert!(flat.handle().is_none());
    assert_eq!(flat.cell_mm2(5), 4.0);
}

#[test]
fn lines_go_round_by_pitch_or_by_what_the_seam_leaves() {
    let sensor = with(Geometry::cylinder(Rings::Rows, 1.25 * CLOSED)).unwrap();
    let handle = sensor.handle().unwrap();
    // 31 pitches of 80 mm; the rest is the seam.
    assert!((handle.angles[31] - 2.0 * PI * 62.0 / 80.0).abs() < 1e-12);
    assert!((handle.seam_gap_mm - 18.0).abs() < 1e-9 && !handle.closes());
    let mut geometry = Geometry::cylinder(Rings::Rows, CLOSED);
    geometry.seam_gap_mm = Some(2.5);
    let sensor = with(geometry).unwrap();
    let handle = sensor.handle().unwrap();
    assert!((handle.pitch_round_mm - 61.5 / 31.0).abs() < 1e-12 && handle.closes());
    assert!((sensor.cell_mm2(0) - 2.0 * 61.5 / 31.0).abs() < 1e-12);
    // A calliper's hundredth short is no lie.
    assert!(with(Geometry::cylinder(Rings::Rows, 0.9999 * 62.0 / PI)).is_ok());
}

#[test]
fn a_place_in_millimetres_is_one_in_lines() {
    let cone = Geometry::cone(Rings::Columns, [CLOSED, 15.0]);
    let sensor = with(cone).unwrap();
    let handle = sensor.handle().unwrap();
    let (row, column) = (7, 20);
    let along = handle.step_mm * column as f64;
    let round = handle.angles[row] * handle.radii_mm[column];
    let [r, c] = sensor.lines_from_mm([round, along]);
    assert!((r - 7.0).abs() < 1e-9 && (c - 20.0).abs() < 1e-9, "{r} {c}");
    let flat = with(Geometry::flat()).unwrap();
    assert_eq!(flat.lines_from_mm([3.0, 8.0]), [1.5, 4.0]);
}

#[test]
fn bodies_that_cannot_be_are_refused_with_their_numbers() {
    let refused = |words: &[&str], change: &dyn Fn(&mut Geometry)| {
        let mut geometry = Geometry::cylinder(Rings::Rows, CLOSED);
        change(&mut geometry);
        let error = with(geometry).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    refused(&["diameter_mm", "circumference of 31.4", "take 62"], &|g| {
        g.diameter_mm = Some(10.0);
    });
    refused(&["diameter_mm", "NaN"], &|g| g.diameter_mm = Some(f64::NAN));
    refused(&["diameter_mm", "missing"], &|g| g.diameter_mm = None);
    refused(&["rings", "missing"], &|g| g.rings = None);
    refused(&["seam_gap_mm", "leaves 1.419", "says 2"], &|g| {
        g.seam_gap_mm = Some(20.0)
    });
    refused(&["seam_gap_mm", "is -1"], &|g| g.seam_gap_mm = Some(-1.0));
    refused(&["height_mm", "3.2258", "says 2.0000"], &|g| {
        g.height_mm = Some(100.0)
    });
    refused(&["diameters_mm", "stands beside shape `cylinder`"], &|g| {
        g.diameters_mm = Some([20.0, 10.0]);
    });
    refused(&["rings", "stands beside shape `flat`"], &|g| {
        g.shape = Shape::Flat
    });
    refused(
        &["diameters_mm", "differ by 180", "62.0000 mm along"],
        &|g| {
            *g = Geometry::cone(Rings::Rows, [200.0, 20.0]);
        },
    );
    let text = with(Geometry::cylinder(Rings::Rows, CLOSED))
        .unwrap()
        .to_toml();
    let typed = |from: &str, to: &str| {
        let changed = text.replace(from, to);
        assert_ne!(changed, text);
        Sensor::from_toml(&changed).unwrap_err().to_string()
    };
    let error = typed("\"cylinder\"", "\"cylindre\"");
    assert!(error.contains("did you mean `cylinder`"), "{error}");
    let error = typed("rings = \"rows\"", "rings = \"row\"");
    assert!(error.contains("did you mean `rows`"), "{error}");
    let error = typed("diameter_mm", "diametre_mm");
    assert!(error.contains("did you mean `diameter_mm`"), "{error}");
    let error = typed(
        "diameter_mm = ",
        "diameters_mm = [1.0, 2.0, 3.0]\ndiameter_mm = ",
    );
    assert!(error.contains("3 numbers"), "{error}");
}

#[test]
fn places_on_a_plane_do_not_go_round_a_handle() {
    use crate::sensor::Positions;
    let places = (0..1024).map(|t| [t / 32, t % 32, t % 32, t / 32].map(f64::from));
    let sensor = with(Geometry::cylinder(Rings::Rows, CLOSED)).unwrap();
    let placed = sensor.edited(|s| s.array.positions = Some(Positions::Each(places.collect())));
    let error = placed.unwrap_err().to_string();
    assert!(error.contains("array.positions"), "{error}");
}
