//! Whole pictures: they parse, have the size they say, and no input breaks them.

use proptest::prelude::*;
use resvg::usvg::{Options, Tree};
use taxel::frame::Siemens;
use taxel::{Frame, Mark};
use taxel_plot::{
    Arrangement, ColourMap, ContactSheet, Error, Format, Interpolation, Line, PNG_SCALE, Panel,
    Picture, Series, Sheet,
};

fn blob(rows: usize, columns: usize) -> Vec<f64> {
    let distance = |i: usize| {
        let (row, column) = ((i / columns) as f64, (i % columns) as f64);
        ((row - rows as f64 / 3.0) / rows as f64)
            .hypot((column - columns as f64 / 2.0) / columns as f64)
    };
    (0..rows * columns)
        .map(|i| 4e-6 * (-40.0 * distance(i).powi(2)).exp())
        .collect()
}

/// Parses the SVG and decodes the PNG; both must have the size that the picture says.
fn check(picture: &Picture) {
    let tree = Tree::from_str(picture.svg(), &Options::default()).unwrap();
    assert_eq!(tree.size().width(), picture.width() as f32);
    assert_eq!(tree.size().height(), picture.height() as f32);
    let png = picture.png().unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(&png))
        .read_info()
        .unwrap();
    assert_eq!(reader.info().width, picture.width() * PNG_SCALE);
    assert_eq!(reader.info().height, picture.height() * PNG_SCALE);
    #[cfg(feature = "pdf")]
    assert!(picture.render(Format::Pdf).unwrap().starts_with(b"%PDF"));
}

#[test]
fn arrays_of_every_shape_are_drawn() {
    for (rows, columns) in [
        (1, 1),
        (1, 40),
        (40, 1),
        (2, 3),
        (16, 16),
        (64, 128),
        (1, 3000),
    ] {
        let values = blob(rows, columns);
        for interpolation in [Interpolation::default(), Interpolation::Nearest] {
            let panel = Panel::new(rows, columns, &values)
                .unwrap()
                .title("shape")
                .unit("S");
            check(&panel.interpolation(interpolation).picture().unwrap());
        }
    }
}

#[test]
fn zeros_and_blanks_are_drawn() {
    for value in [
        0.0,
        -7.0,
        f64::NAN,
        f64::INFINITY,
        f64::MAX,
        f64::MIN_POSITIVE,
    ] {
        check(&Panel::new(4, 4, &[value; 16]).unwrap().picture().unwrap());
        let lines = vec![Line::new("only", vec![value; 3])];
        check(
            &Series::new("frame", vec![0.0, 1.0, 2.0], lines)
                .unwrap()
                .picture()
                .unwrap(),
        );
    }
}

#[test]
fn a_wide_array_is_stacked_and_a_square_one_set_side_by_side() {
    let size = |rows, columns, arrangement| {
        let values = blob(rows, columns);
        let panel = |title| Panel::new(rows, columns, &values).unwrap().title(title);
        let sheet = Sheet::new(vec![panel("before"), panel("after")]).unwrap();
        let picture = sheet
            .arrangement(arrangement)
            .shared_range(true)
            .caption("c")
            .picture()
            .unwrap();
        check(&picture);
        (picture.width(), picture.height())
    };
    assert_eq!(
        size(64, 128, Arrangement::Fitting),
        size(64, 128, Arrangement::Stacked)
    );
    assert_eq!(
        size(16, 16, Arrangement::Fitting),
        size(16, 16, Arrangement::SideBySide)
    );
    assert!(size(16, 16, Arrangement::Stacked).1 > size(16, 16, Arrangement::SideBySide).1);
}

#[test]
fn a_frame_brings_its_unit_and_marks() {
    let mut frame = Frame::<Siemens>::new(8, 8, blob(8, 8)).unwrap();
    frame.marks_mut()[..8].fill(Mark::Open);
    let picture = Panel::of(&frame)
        .colour_map(ColourMap::Cividis)
        .picture()
        .unwrap();
    check(&picture);
    assert!(picture.svg().contains("conductance (µS)"));
    assert!(picture.svg().contains("hatched: 8 open"));
}

#[test]
fn contact_sheets_have_all_their_titles() {
    let values = blob(6, 9);
    let panels = |count: usize| -> Vec<_> {
        (0..count)
            .map(|i| {
                Panel::new(6, 9, &values)
                    .unwrap()
                    .title(format!("frame {i}."))
            })
            .collect()
    };
    for count in [1, 2, 12, 70] {
        let picture = ContactSheet::new(panels(count)).unwrap().picture().unwrap();
        check(&picture);
        assert!((0..count).all(|i| picture.svg().contains(&format!(">frame {i}.<"))));
    }
    let narrow = ContactSheet::new(panels(12))
        .unwrap()
        .columns(1)
        .caption("one column");
    let picture = narrow.range(0.0, 1e-6).picture().unwrap();
    check(&picture);
    assert!(picture.height() > picture.width());
}

#[test]
fn titles_cannot_break_the_document() {
    let title = "a < b & \"c\" </svg> \u{0} \u{7} \u{ffff} 圧力 ".repeat(8);
    let picture = Panel::new(1, 1, &[1.0])
        .unwrap()
        .title(title.as_str())
        .unit("<&>")
        .picture()
        .unwrap();
    check(&picture);
    let lines = vec![Line::new(title.as_str(), vec![1.0])];
    check(
        &Series::new(title.as_str(), vec![0.0], lines)
            .unwrap()
            .caption(title)
            .picture()
            .unwrap(),
    );
}

#[test]
fn rendering_gives_the_format_asked_for() {
    let picture = Panel::new(2, 2, &[0.0, 1.0, 2.0, 3.0])
        .unwrap()
        .picture()
        .unwrap();
    assert!(
        picture
            .render(Format::Png)
            .unwrap()
            .starts_with(b"\x89PNG\r\n")
    );
    assert_eq!(
        picture.render(Format::Svg).unwrap(),
        picture.svg().as_bytes()
    );
}

#[test]
fn what_does_not_fill_the_array_is_refused_with_both_numbers() {
    let error = Panel::new(2, 3, &[0.0; 5]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "values: 2 rows x 3 columns need 6, found 5"
    );
    let error = Panel::new(2, 3, &[0.0; 6])
        .unwrap()
        .marks(&[Mark::Good; 7])
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "marks: 2 rows x 3 columns need 6, found 7"
    );
    assert!(Panel::new(0, 3, &[]).is_err());
    assert!(Panel::new(usize::MAX, 2, &[0.0]).is_err());
    assert!(matches!(
        Sheet::new(vec![]),
        Err(Error::Empty { what: "sheet", .. })
    ));
    assert!(matches!(
        ContactSheet::new(vec![]),
        Err(Error::Empty {
            what: "contact sheet",
            ..
        })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn no_values_break_a_heatmap(
        values in prop::collection::vec(prop::num::f64::ANY, 1..24),
        range in prop::option::of((prop::num::f64::ANY, prop::num::f64::ANY)),
        pitch in [prop::num::f64::ANY, prop::num::f64::ANY],
        factor in 0..12_usize,
        title in ".{0,40}",
    ) {
        for (rows, columns) in [(1, values.len()), (values.len(), 1)] {
            let panel = Panel::new(rows, columns, &values).unwrap().title(title.as_str()).unit("V").pitch_mm(pitch);
            let panel = panel.interpolation(Interpolation::Bilinear(factor));
            check(&match range {
                Some((low, high)) => panel.range(low, high),
                None => panel,
            }.picture().unwrap());
        }
    }

    #[test]
    fn no_values_break_a_series(
        points in prop::collection::vec((prop::num::f64::ANY, prop::num::f64::ANY), 0..20),
        count in 1..14_usize,
        label in "frame|time \\(s\\)",
    ) {
        let (x, values): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        let line = |i| Line::new(format!("line {i}"), values.iter().map(|v| v * i as f64).collect());
        check(&Series::new(label, x, (0..count).map(line).collect()).unwrap().unit("S").picture().unwrap());
    }
}
