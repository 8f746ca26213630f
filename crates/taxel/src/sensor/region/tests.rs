use super::*;
use crate::sensor::{Geometry, Population, preset};

fn mat() -> Sensor {
    preset("mat-16x16-cd4067").unwrap()
}

impl RegionSpec {
    fn with_still(self) -> Self {
        Self {
            frames: None,
            ..self
        }
    }
}

fn one(spec: RegionSpec, sensor: &Sensor) -> Region {
    Region::all(&[spec], sensor).unwrap().remove(0)
}

#[test]
fn boxes_and_outlines_hold_the_taxels_that_they_go_around() {
    let sensor = mat();
    let boxes = RegionSpec::new("Ball of the thumb").with_boxes(vec![[2, 3, 4, 6], [3, 4, 6, 6]]);
    let region = one(boxes, &sensor);
    let at = |r: usize, c: usize| r * 16 + c;
    let wanted = [
        at(2, 4),
        at(2, 5),
        at(2, 6),
        at(3, 4),
        at(3, 5),
        at(3, 6),
        at(4, 6),
    ];
    assert_eq!(region.taxels(), wanted);
    assert_eq!(region.key(), "ball_of_the_thumb");
    let triangle =
        RegionSpec::new("heel").with_outline(vec![[-0.5, -0.5], [-0.5, 3.6], [3.6, -0.5]]);
    let region = one(triangle, &sensor);
    // Rows of 4, 3, 2 and 1 taxels.
    assert_eq!(region.taxels().len(), 10);
}

#[test]
fn taxels_make_boxes_and_boxes_make_the_same_taxels() {
    let sensor = mat();
    let taxels: Vec<usize> = (0..256)
        .filter(|t| (t * 7) % 5 < 3 || t / 16 == 4)
        .collect();
    let spec = RegionSpec::of_taxels("odd", &taxels, 16);
    assert_eq!(one(spec, &sensor).taxels(), taxels);
    let block: Vec<usize> = (3..9)
        .flat_map(|r| (5..12).map(move |c| r * 16 + c))
        .collect();
    assert_eq!(
        RegionSpec::of_taxels("b", &block, 16).boxes,
        [[3, 8, 5, 11]]
    );
}

#[test]
fn a_region_that_moves_lies_where_each_of_its_windows_says() {
    let sensor = mat();
    let part = |from: u64, to: u64, row: usize| {
        RegionSpec::new("thumb")
            .with_boxes(vec![[row, row, 0, 1]])
            .with_frames([from, to])
    };
    let specs = [part(100, 149, 4), part(0, 99, 2)];
    let regions = Region::of_recording(&specs, &sensor).unwrap();
    assert_eq!(regions.len(), 1);
    let at = |frame| regions[0].taxels_at(frame);
    assert_eq!((at(0), at(99)), (&[32, 33][..], &[32, 33][..]));
    assert_eq!((at(100), at(149)), (&[64, 65][..], &[64, 65][..]));
    assert!(at(150).is_empty() && regions[0].moves());
    assert_eq!(regions[0].taxels(), [32, 33, 64, 65]);
    let still = one(part(0, 0, 3).with_still(), &sensor);
    assert!(still.taxels_at(7) == [48, 49] && !still.moves());
    let refused = |specs: &[RegionSpec], words: &str| {
        let error = Region::of_recording(specs, &sensor).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    };
    refused(&[part(5, 4, 0)], "frames 5 to 4, which end before they");
    refused(
        &[part(0, 9, 0), part(9, 12, 0)],
        "frames 9 to 12 and of frames 0 to 9, which overlap",
    );
    refused(&[part(0, 9, 0), part(0, 0, 1).with_still()], "twice");
    let error = Region::all(&specs, &sensor).unwrap_err().to_string();
    assert!(
        error.contains("frames 100 to 149, and here are no frames"),
        "{error}"
    );
}

#[test]
fn a_box_goes_across_the_seam_of_a_handle_alone() {
    let seam = RegionSpec::new("thumb").with_boxes(vec![[0, 1, 14, 1]]);
    let handle = mat().edited(|spec| {
        spec.array.pitch_mm = [8.0, 8.0];
        spec.array.geometry = Some(Geometry::cylinder(Rings::Rows, 41.0));
    });
    let region = one(seam.clone(), &handle.unwrap());
    assert_eq!(region.taxels(), [0, 1, 14, 15, 16, 17, 30, 31]);
    let error = Region::all(&[seam], &mat()).unwrap_err().to_string();
    assert!(
        error.contains("`thumb`") && error.contains("[0, 1, 14, 1]"),
        "{error}"
    );
}

#[test]
fn regions_that_cannot_be_are_refused_in_words() {
    let sensor = mat();
    let refused = |specs: &[RegionSpec], words: &str| {
        let error = Region::all(specs, &sensor).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let thumb = || RegionSpec::new("Thumb").with_boxes(vec![[0, 1, 0, 1]]);
    refused(&[RegionSpec::new(" ")], "number 1 has no name");
    refused(&[RegionSpec::new("thumb")], "holds no taxel");
    refused(
        &[
            thumb(),
            RegionSpec {
                name: "thumb ".into(),
                ..thumb()
            },
        ],
        "twice",
    );
    refused(&[thumb().with_boxes(vec![[0, 16, 0, 1]])], "rows 0 to 15");
    refused(
        &[thumb().with_outline(vec![[0.0, 0.0], [1.0, 1.0]])],
        "2 corners",
    );
    refused(
        &[thumb().with_outline(vec![[0.0, f64::NAN], [1.0, 1.0], [2.0, 0.0]])],
        "NaN",
    );
    let holes = sensor.edited(|spec| {
        let hole = |r: usize| if r < 2 { vec![0.0; 16] } else { vec![1.0; 16] };
        spec.array.population = Some(Population::Each((0..16).map(hole).collect()));
    });
    let error = Region::all(&[thumb()], &holes.unwrap())
        .unwrap_err()
        .to_string();
    assert!(error.contains("holds no taxel"), "{error}");
}
