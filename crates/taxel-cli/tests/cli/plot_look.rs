//! `taxel plot`: title, range, size, pixels per inch, and axes in millimetres.

use std::fs;

use crate::run::{Folder, SENSOR};

const PLOT: &str = "plot recording.txt --sensor sensor.toml";

fn recorded() -> Folder {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --frames 12 --seed 4 --load-g 200 \
         -o recording.txt --truth truth.csv",
    );
    folder
}

/// Width and height of a PNG, and what its chunk pHYs says: pixels per metre.
fn png(folder: &Folder, name: &str) -> (u32, u32, Option<u32>) {
    let bytes = fs::read(folder.path(name)).unwrap();
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    let physical = bytes.windows(4).position(|word| word == b"pHYs");
    let density = physical.map(|at| {
        assert_eq!(number(at + 4), number(at + 8), "as many across as down");
        assert_eq!(bytes[at + 12], 1, "the unit is the metre");
        number(at + 4)
    });
    (number(16), number(20), density)
}

fn svg(folder: &Folder, words: &str) -> String {
    folder.good(&format!("{PLOT} {words} -o p.svg"));
    folder.read("p.svg")
}

/// The pictures that are drawn in place of values: colours alone, without axes and labels.
fn images(svg: &str) -> Vec<String> {
    let parts = svg.split("base64,").skip(1);
    parts
        .map(|part| part.split('"').next().unwrap().to_owned())
        .collect()
}

#[test]
fn a_picture_has_the_size_asked_for_in_every_format() {
    let folder = recorded();
    for what in [
        "--frame 3",
        "--frame 3 --raw",
        "--frames 2..9",
        "--taxel 1,2",
        "--row 1",
    ] {
        folder.good(&format!("{PLOT} {what} --size 1203x877 -o p.png"));
        assert_eq!(png(&folder, "p.png"), (1203, 877, None), "{what}");
        let text = svg(&folder, &format!("{what} --size 640x480"));
        assert!(text.contains("width=\"640\" height=\"480\""), "{what}");
        folder.good(&format!("{PLOT} {what} --size 640x480 -o p.pdf"));
        let pdf = fs::read(folder.path("p.pdf")).unwrap();
        let page = b"/MediaBox[0 0 640 480]";
        assert!(pdf.windows(page.len()).any(|at| at == page), "{what}");
    }
}

#[test]
fn pixels_per_inch_are_written_and_text_keeps_its_size() {
    let folder = recorded();
    folder.good(&format!("{PLOT} -o p.png"));
    let (width, height, none) = png(&folder, "p.png");
    assert_eq!(none, None);
    folder.good(&format!("{PLOT} --dpi 288 -o p.png"));
    // Twice the 144 that are usual: the same points, twice the pixels.
    assert_eq!(png(&folder, "p.png"), (2 * width, 2 * height, Some(11339)));
    folder.good(&format!("{PLOT} --dpi 300 --size 1900x1600 -o p.png"));
    assert_eq!(png(&folder, "p.png"), (1900, 1600, Some(11811)));
}

#[test]
fn a_range_makes_pictures_compare_and_tells_what_lies_beyond() {
    let folder = recorded();
    let ranged = svg(&folder, "--frame 3 --range 0..40 --unit g");
    assert!(ranged.contains(" above (most "), "{ranged}");
    assert!(ranged.contains("the range 0 to 40 g"), "{ranged}");
    let wide = svg(&folder, "--frame 3 --range -1e4..1e4 --unit g");
    assert!(!wide.contains("the range"), "{wide}");
    assert_ne!(images(&ranged), images(&wide));
    let other = svg(&folder, "--frame 7 --range 0..40 --unit g");
    for (picture, ends) in [(&ranged, [">0<", ">40<"]), (&other, [">0<", ">40<"])] {
        assert!(ends.iter().all(|end| picture.contains(end)), "{picture}");
    }
    let curve = svg(&folder, "--taxel 1,2 --range -20..40 --unit g");
    assert!(curve.contains(">−20<") && curve.contains(">40<"), "{curve}");
    assert!(!curve.contains(">60<"), "{curve}");
}

#[test]
fn titles_and_millimetres_stand_in_the_picture() {
    let folder = recorded();
    let run = folder.good(&format!(
        "{PLOT} --frame 3 --title left&hand --mm --range 0..9 -o p.svg"
    ));
    assert!(run.err.contains("wrote p.svg"), "{run}");
    let map = folder.read("p.svg");
    assert!(map.contains(">left&amp;hand</text>"), "{map}");
    assert!(
        map.contains(">x (mm)<") && map.contains(">y (mm)<"),
        "{map}"
    );
    // Six columns 2 mm apart: the last centre is at 10 mm, the edge at 11.
    assert!(map.contains(">10<") && !map.contains(">12<"), "{map}");
    let lines = svg(&folder, "--frame 3");
    assert!(lines.contains(">column<") && !lines.contains("(mm)"));
    assert!(svg(&folder, "--row 1 --title left").contains(">left<"));
    assert!(svg(&folder, "--frames 2..5 --title left").contains(">left<"));
}

#[test]
fn what_cannot_be_drawn_is_a_bad_argument_with_both_numbers() {
    let folder = recorded();
    for (words, parts) in [
        (
            "--range 50..0 -o p.png",
            "the low end 50 is not below the high end 0",
        ),
        ("--range 5 -o p.png", "expected LOW..HIGH"),
        ("--size 1200 -o p.png", "expected WIDTHxHEIGHT"),
        (
            "--size 90x60 -o p.png",
            "a picture of 90 x 60 pixels has no room",
        ),
        (
            "--size 90x60 --row 1 -o p.svg",
            "a picture of 90 x 60 points has no room",
        ),
        (
            "--size 90x60 --frames 2..9 -o p.pdf",
            "a picture of 90 x 60 points has no room",
        ),
        (
            "--size 20000x20000 -o p.png",
            "20000 x 20000 pixels is over the limit of 100000000",
        ),
        ("--dpi 5000 -o p.png", "5000 is not in 36..=2400"),
        ("--dpi 300 -o p.svg", "--dpi 300: p.svg has no pixels"),
        (
            "--mm --frames 2..4 -o p.png",
            "--mm: the small maps of several frames",
        ),
        ("--mm --row 1 -o p.png", "cannot be used with"),
    ] {
        let run = folder.taxel(&format!("{PLOT} {words}"));
        assert_eq!(run.code, Some(2), "{words}: {run}");
        assert!(run.err.contains(parts), "{words}: {run}");
        assert!(
            !folder.exists("p.png") && !folder.exists("p.svg"),
            "{words}"
        );
    }
    let run = folder.taxel("plot truth.csv --values --rows 4 --mm -o p.png");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("--mm: truth.csv does not say"), "{run}");
}

/// The size that a refusal names is one that does.
#[test]
fn the_least_size_named_is_large_enough() {
    let folder = recorded();
    for what in ["--frame 3", "--row 1", "--frames 2..9"] {
        let run = folder.fails(&format!("{PLOT} {what} --size 30x20 -o p.png"));
        let needed = run.err.split("they need ").nth(1).unwrap();
        let size = needed.lines().next().unwrap().replace(" x ", "x");
        folder.good(&format!("{PLOT} {what} --size {size} -o p.png"));
        let (width, height, _) = png(&folder, "p.png");
        assert_eq!(format!("{width}x{height}"), size, "{what}");
    }
}

#[test]
fn a_frame_is_drawn_on_the_handle_that_the_sensor_file_tells_of() {
    let folder = recorded();
    folder.good("simulate --sensor econe --pattern hand --frames 3 --seed 4 -o hand.txt");
    let body = "plot hand.txt --sensor econe --frame 2 --body";
    folder.good(&format!("{body} -o body.svg"));
    folder.good(&format!("{body} --raw -o raw.svg"));
    let (text, raw) = (folder.read("body.svg"), folder.read("raw.svg"));
    // Four sides and the colour bar.
    assert_eq!(images(&text).len(), 5);
    assert_ne!(images(&text)[0], images(&raw)[0]);
    for said in ["frame 2", "270° (column 96)", "cross-talk removed"] {
        assert!(text.contains(said), "{said}");
    }
    assert!(raw.contains("no compensation"));
    folder.good(&format!("{body} --size 1000x600 -o body.png"));
    assert_eq!(png(&folder, "body.png"), (1000, 600, None));
    for (words, said) in [
        (
            "plot recording.txt --sensor sensor.toml --body -o p.png",
            "--body: sensor.toml tells of no handle\nhint: `[array.geometry]`",
        ),
        (
            "plot hand.txt --sensor econe --body --mm -o p.png",
            "a body has no axes",
        ),
        (
            "plot hand.txt --sensor econe --body --frames 0..2 -o p.png",
            "--body: several frames are drawn\nhint: draw one frame, with --frame",
        ),
        (
            "plot hand.txt --sensor econe --body -o p.gif",
            "--body: several frames are drawn",
        ),
        (
            "plot hand.txt --sensor econe --body --frame 7 -o p.png",
            "hand.txt",
        ),
    ] {
        let run = folder.fails(words);
        assert!(run.err.contains(said), "{run}");
        assert!(!folder.exists("p.png") && !folder.exists("p.gif"));
    }
}

/// A curve without a point is told: an empty picture says nothing.
#[test]
fn taxels_of_a_dead_row_are_told_to_have_no_curve() {
    let folder = Folder::new();
    folder.write(
        "dead.toml",
        &(SENSOR.to_owned() + "\n[screen]\ndead_rows = [2]\n"),
    );
    folder.good("simulate --sensor dead.toml --pattern blobs --frames 3 -o r.npy");
    let run = folder.good("plot r.npy --sensor dead.toml --row 2 -o row.png");
    assert!(run.err.contains("6 of 6 curves have no point"), "{run}");
    let run = folder.good("plot r.npy --sensor dead.toml --column 2 -o column.png");
    assert!(run.err.contains("1 of 4 curves have no point"), "{run}");
    let run = folder.good("plot r.npy --sensor dead.toml --row 1 -o other.png");
    assert!(!run.err.contains("no point"), "{run}");
}
