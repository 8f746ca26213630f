//! `taxel plot -o movie.gif`: decoded again, it has the frames, the times and the colours.

use std::fs::File;

use crate::run::Folder;

/// A picture as it is seen: how long, and its pixels.
struct Seen {
    hundredths: u16,
    pixels: Vec<[u8; 3]>,
}

/// All pictures of a GIF, and how wide they are.
fn decoded(folder: &Folder, name: &str) -> (usize, Vec<Seen>) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::Indexed);
    let mut decoder = options
        .read_info(File::open(folder.path(name)).unwrap())
        .unwrap();
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let palette = decoder.global_palette().unwrap().to_vec();
    let colours: Vec<[u8; 3]> = palette
        .chunks_exact(3)
        .map(|c| [c[0], c[1], c[2]])
        .collect();
    let (width, height) = (usize::from(decoder.width()), usize::from(decoder.height()));
    let mut screen = vec![[0; 3]; width * height];
    let mut all = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        let (left, top) = (usize::from(frame.left), usize::from(frame.top));
        for (i, &index) in frame.buffer.iter().enumerate() {
            let (row, column) = (i / usize::from(frame.width), i % usize::from(frame.width));
            screen[(top + row) * width + left + column] = colours[usize::from(index)];
        }
        all.push(Seen {
            hundredths: frame.delay,
            pixels: screen.clone(),
        });
    }
    (width, all)
}

/// Four taxels, one after the other at 9 g.
fn walk() -> Folder {
    let folder = Folder::new();
    let mut text = String::new();
    for frame in 0..4 {
        let load = |taxel: usize| if taxel == frame { "9" } else { "0" };
        text += &format!("{},{}\n{},{}\n", load(0), load(1), load(2), load(3));
    }
    folder.write("walk.csv", &text);
    folder
}

const BRIGHT: [u8; 3] = [252, 255, 164];
const DARK: [u8; 3] = [0, 0, 4];

/// Where the pixels of that colour lie: their mean column and row, of those in the map.
fn middle(seen: &Seen, width: usize, colour: [u8; 3], right: usize) -> (f64, f64) {
    let places: Vec<(f64, f64)> = seen
        .pixels
        .iter()
        .enumerate()
        .filter(|(i, pixel)| **pixel == colour && i % width < right)
        .map(|(i, _)| ((i % width) as f64, (i / width) as f64))
        .collect();
    assert!(places.len() > 1000, "{} pixels", places.len());
    let count = places.len() as f64;
    let (x, y) = places
        .iter()
        .fold((0.0, 0.0), |sum, at| (sum.0 + at.0, sum.1 + at.1));
    (x / count, y / count)
}

#[test]
fn every_frame_is_seen_for_its_time_in_its_colours() {
    let folder = walk();
    let run = folder.good(
        "plot walk.csv --values --rows 2 --unit g --interpolation nearest --speed 0.5 -o walk.gif",
    );
    assert!(run.err.contains("as if 25 a second"), "{run}");
    let (width, seen) = decoded(&folder, "walk.gif");
    let delays: Vec<u16> = seen.iter().map(|seen| seen.hundredths).collect();
    assert_eq!(delays, [8; 4]);
    // The colour bar at the right has all colours as well: look left of it only.
    let map = width * 3 / 4;
    let bright: Vec<(f64, f64)> = seen
        .iter()
        .map(|seen| middle(seen, width, BRIGHT, map))
        .collect();
    let right = bright[1].0 - bright[0].0;
    let down = bright[2].1 - bright[0].1;
    assert!(right > 50.0 && (bright[1].1 - bright[0].1).abs() < 1.0);
    assert!(down > 50.0 && (bright[2].0 - bright[0].0).abs() < 1.0);
    assert!((bright[3].0 - bright[1].0).abs() < 1.0 && (bright[3].1 - bright[2].1).abs() < 1.0);
    for seen in &seen {
        let paper = seen.pixels.iter().filter(|pixel| **pixel == [255; 3]);
        assert!(paper.count() > seen.pixels.len() / 10);
        let dark = seen.pixels.iter().filter(|pixel| **pixel == DARK).count();
        let shining = seen.pixels.iter().filter(|pixel| **pixel == BRIGHT).count();
        assert!((2.5..3.5).contains(&(dark as f64 / shining as f64)));
    }
}

#[test]
fn a_recording_with_times_keeps_its_pace_and_frames_of_a_range_alone_are_drawn() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 9 --period 0.1 -o r.mcap");
    let gif = |words: &str| {
        folder.good(&format!("plot r.mcap {words} -o r.gif"));
        decoded(&folder, "r.gif").1
    };
    let delays = |seen: &[Seen]| -> Vec<u16> { seen.iter().map(|s| s.hundredths).collect() };
    assert_eq!(delays(&gif("")), [10; 9]);
    let some = gif("--frames 2..7 --speed 2");
    assert_eq!(delays(&some), [5; 5]);
    assert_eq!(
        delays(&gif("--speed 10")),
        [4; 3],
        "of 100 a second 25 are left"
    );
    let (width, both) = {
        folder.good("plot r.mcap --before-after --size 901x450 --title two --mm -o r.gif");
        decoded(&folder, "r.gif")
    };
    assert_eq!((width, both[0].pixels.len()), (901, 901 * 450));
    // The time is written on each: no two are the same.
    for (a, b) in both.iter().zip(&both[1..]) {
        assert!(a.pixels != b.pixels);
    }
}

#[test]
fn a_movie_that_cannot_be_is_refused_and_leaves_no_file() {
    let folder = walk();
    let long = "1,2\n3,4\n".repeat(5001);
    folder.write("long.csv", &long);
    for (words, parts) in [
        ("walk.csv --frame 1", "is a movie of whole frames"),
        ("walk.csv --taxel 0,0", "is a movie of whole frames"),
        (
            "long.csv",
            "a movie of 5001 pictures is over the limit of 5000",
        ),
        (
            "walk.csv --size 3000x2000",
            "3000 x 2000 pixels is over the limit of 4000000",
        ),
        (
            "walk.csv --size 60x40",
            "a picture of 60 x 40 pixels has no room",
        ),
        ("walk.csv --speed 0", "must be a number above 0"),
    ] {
        let run = folder.taxel(&format!("plot {words} --values --rows 2 -o m.gif"));
        assert_eq!(run.code, Some(2), "{words}: {run}");
        assert!(run.err.contains(parts), "{words}: {run}");
        assert!(!folder.exists("m.gif"), "{words}");
    }
    let run = folder.taxel("plot walk.csv --values --rows 2 --speed 2 -o m.png");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("--speed 2: m.png does not move"), "{run}");
    let run = folder.taxel("plot walk.csv --values --rows 2 --frames 7..9 -o m.gif");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(
        run.err.contains("frame 7 of walk.csv, but it has 4 frames"),
        "{run}"
    );
}
