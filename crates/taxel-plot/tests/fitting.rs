//! Pictures of a size that is asked for.

use taxel_plot::{ContactSheet, Error, Extent, Format, Line, Panel, Series, Sheet};

fn values(count: usize) -> Vec<f64> {
    (0..count).map(|i| (i % 17) as f64).collect()
}

/// Width and height of the first heatmap of a picture, in points.
fn plot(svg: &str) -> (f64, f64) {
    let image = svg.split("<image ").nth(1).unwrap();
    let number = |key: &str| {
        let rest = image.split(&format!("{key}=\"")).nth(1).unwrap();
        rest.split('"').next().unwrap().parse::<f64>().unwrap()
    };
    (number("width"), number("height"))
}

#[test]
fn every_size_is_met_to_the_pixel_or_refused() {
    let (square, wide) = (values(256), values(64 * 128));
    for (width, height) in [(700, 500), (1001, 999), (2400, 640), (640, 1800)] {
        for dots in [72.0, 144.0, 250.0] {
            let extent = Extent::pixels(width, height, dots).unwrap();
            let panels = || {
                vec![
                    Panel::new(16, 16, &square).unwrap(),
                    Panel::new(64, 128, &wide).unwrap(),
                ]
            };
            let sheet = Sheet::new(panels()).unwrap().title("two").fit(extent);
            let few = ContactSheet::new(panels()).unwrap().fit(extent);
            for drawn in [sheet.picture(), few.picture()] {
                let picture = match drawn {
                    Ok(picture) => picture,
                    Err(Error::NoRoom {
                        needed_width,
                        needed_height,
                        ..
                    }) => {
                        let small = needed_width > width.into() || needed_height > height.into();
                        assert!(small, "{width} x {height} is enough");
                        continue;
                    }
                    Err(other) => panic!("{other}"),
                };
                let png = picture.dots_per_inch(dots).render(Format::Png).unwrap();
                let reader = png::Decoder::new(std::io::Cursor::new(&png));
                let info = reader.read_info().unwrap();
                assert_eq!((info.info().width, info.info().height), (width, height));
            }
        }
    }
}

#[test]
fn a_larger_picture_has_a_larger_plot() {
    let square = values(256);
    let side = |width: u32, height: u32| {
        let panel = Panel::new(16, 16, &square).unwrap().title("a map");
        let extent = Extent::points(width, height).unwrap();
        let sheet = Sheet::new(vec![panel]).unwrap().fit(extent);
        plot(sheet.picture().unwrap().svg()).0
    };
    assert!(side(900, 900) > 1.5 * side(500, 500));
    assert_eq!(side(900, 500), side(1800, 500), "its height is the limit");
    // All but margins, title and axis is the map's.
    assert!(side(2000, 900) > 780.0, "{}", side(2000, 900));
}

#[test]
fn values_beyond_the_range_are_drawn_at_its_end() {
    let line = |values: Vec<f64>| vec![Line::new("", values)];
    let drawn = |values: Vec<f64>| {
        let series = Series::new("frame", vec![0.0, 1.0, 2.0], line(values)).unwrap();
        series.range(0.0, 10.0).picture().unwrap().svg().to_owned()
    };
    assert_eq!(drawn(vec![0.0, 10.0, 5.0]), drawn(vec![-7.0, 99.0, 5.0]));
    assert_ne!(drawn(vec![0.0, 10.0, 5.0]), drawn(vec![0.0, 9.0, 5.0]));
}

#[test]
fn axes_in_millimetres_count_from_the_first_centre() {
    let square = values(24);
    let panel = Panel::new(4, 6, &square).unwrap().pitch_mm([5.0, 10.0]);
    let svg = panel.axes_mm(true).picture().unwrap().svg().to_owned();
    assert!(svg.contains(">x (mm)<") && svg.contains(">50<"), "{svg}");
    assert!(!svg.contains(">60<"), "the last centre is at 50 mm: {svg}");
}
