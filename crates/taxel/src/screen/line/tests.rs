use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::Mark;
use crate::screen::{FrameScreen, ScreenReport};
use crate::sensor::ScreenSpec;

const FULL: f64 = 65_535.0;
const ROWS: usize = 24;
const COLUMNS: usize = 32;

/// A standard normal number (sum of twelve uniform ones less six: bounded, and good enough here).
pub fn noise(random: &mut impl Rng) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

/// What the virtual array reads when nothing touches it, and what its faults do.
#[derive(Clone, Copy)]
struct Array {
    baseline: f64,
    sigma: f64,
    blobs: usize,
    /// Every taxel's own sensitivity varies by this share.
    uneven: f64,
}

const SOUND: Array = Array {
    baseline: 25.0,
    sigma: 3.0,
    blobs: 4,
    uneven: 0.1,
};

impl Array {
    /// Heights above the baseline, counts: round presses of random place, size and force.
    fn heights(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let presses: Vec<[f64; 4]> = (0..self.blobs)
            .map(|_| {
                [
                    random.random_range(0.0..ROWS as f64),
                    random.random_range(0.0..COLUMNS as f64),
                    random.random_range(1.5..5.0),
                    random.random_range(500.0..20_000.0),
                ]
            })
            .collect();
        let mut heights = vec![0.0; ROWS * COLUMNS];
        for (i, height) in heights.iter_mut().enumerate() {
            let (row, column) = ((i / COLUMNS) as f64, (i % COLUMNS) as f64);
            for [r, c, size, force] in &presses {
                let distance = ((row - r).powi(2) + (column - c).powi(2)) / (size * size);
                *height += force * (-distance).exp();
            }
            *height *= 1.0 + self.uneven * noise(random);
        }
        heights
    }

    /// `baseline(row, column)` and `gain(row, column)` are what a fault changes.
    fn frame(
        &self,
        random: &mut ChaCha8Rng,
        fault: impl Fn(usize, usize, f64) -> f64,
    ) -> Frame<Counts> {
        let mut values = self.heights(random);
        for (i, value) in values.iter_mut().enumerate() {
            let level = fault(i / COLUMNS, i % COLUMNS, self.baseline + *value);
            *value = (level + self.sigma * noise(random))
                .round()
                .clamp(0.0, FULL);
        }
        Frame::new(ROWS, COLUMNS, values).unwrap()
    }
}

/// The faults of `frames` frames; `fault(frame, row, column, noiseless reading)` is what is read instead.
fn faults(
    array: Array,
    seed: u64,
    frames: usize,
    fault: impl Fn(usize, usize, usize, f64) -> f64,
) -> LineFaults {
    faults_at(array, seed, frames, &ScreenOptions::default(), fault)
}

fn faults_at(
    array: Array,
    seed: u64,
    frames: usize,
    options: &ScreenOptions,
    fault: impl Fn(usize, usize, usize, f64) -> f64,
) -> LineFaults {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut screen = LineScreen::new(ROWS, COLUMNS, FULL, options);
    for t in 0..frames {
        let frame = array.frame(&mut random, |r, c, v| fault(t, r, c, v));
        screen.observe(&frame).unwrap();
    }
    screen.finish()
}

fn kinds(faults: &LineFaults) -> Vec<(Axis, usize, LineFaultKind)> {
    let triple = |f: &LineFault| (f.axis, f.index, f.kind);
    faults.faults.iter().map(triple).collect()
}

const DEAD: LineFaultKind = LineFaultKind::Dead;
const FLICKERING: LineFaultKind = LineFaultKind::Flickering;

#[test]
fn sound_arrays_have_no_faults() {
    for seed in 0..12 {
        for baseline in [0.0, 4.0, 25.0, 500.0] {
            for blobs in [0, 1, 4, 12] {
                let array = Array {
                    baseline,
                    blobs,
                    ..SOUND
                };
                let found = faults(array, seed, 20, |_, _, _, v| v);
                assert!(found.is_empty(), "{baseline} {blobs} {seed}: {found:?}");
            }
        }
    }
}

#[test]
fn a_dead_row_is_found_with_its_evidence() {
    for seed in 0..10 {
        let found = faults(SOUND, seed, 20, |_, r, _, v| if r == 11 { 0.0 } else { v });
        assert_eq!(kinds(&found), [(Axis::Row, 11, DEAD)], "seed {seed}");
        let fault = found.faults[0];
        assert!(
            fault.faulty == fault.tested && fault.tested >= 18,
            "{fault:?}"
        );
        assert!(fault.median_counts < 2.0 && fault.next_to > 20.0);
        let text = fault.to_string();
        assert!(text.starts_with("row 11 is dead: median "), "{text}");
    }
}

#[test]
fn a_dead_line_at_the_edge_two_side_by_side_and_one_that_reads_an_offset_are_found() {
    let edge = faults(SOUND, 1, 20, |_, _, c, v| if c == 0 { 0.0 } else { v });
    assert_eq!(kinds(&edge), [(Axis::Column, 0, DEAD)]);
    let twins = faults(
        SOUND,
        2,
        20,
        |_, r, _, v| if r == 7 || r == 8 { 0.0 } else { v },
    );
    assert_eq!(kinds(&twins), [(Axis::Row, 7, DEAD), (Axis::Row, 8, DEAD)]);
    let array = Array {
        baseline: 50.0,
        ..SOUND
    };
    let offset = faults(array, 3, 20, |_, r, _, v| if r == 5 { 25.0 } else { v });
    assert_eq!(kinds(&offset), [(Axis::Row, 5, DEAD)]);
}

#[test]
fn on_an_array_that_reads_nothing_unloaded_a_dead_line_shows_between_loads() {
    let array = Array {
        baseline: 0.0,
        blobs: 6,
        ..SOUND
    };
    for seed in 0..10 {
        let found = faults(array, seed, 40, |_, _, c, v| if c == 14 { 0.0 } else { v });
        assert_eq!(kinds(&found), [(Axis::Column, 14, DEAD)], "seed {seed}");
    }
}

const SUSPECT: LineFaultKind = LineFaultKind::Suspect;

/// An array that reads nothing unloaded, on the upper rows of which nothing ever stands: no line of columns is vouched for
/// along its whole length.
fn on_the_lower_half(
    seed: u64,
    frames: usize,
    fault: impl Fn(usize, usize, f64) -> f64,
) -> LineFaults {
    let array = Array {
        baseline: 0.0,
        blobs: 6,
        ..SOUND
    };
    faults(array, seed, frames, |_, r, c, v| {
        if r < ROWS / 2 { 0.0 } else { fault(r, c, v) }
    })
}

#[test]
fn a_line_that_reads_nothing_between_loads_is_suspect_where_too_little_vouches_for_it() {
    for seed in 0..10 {
        let sound = on_the_lower_half(seed, 40, |_, _, v| v);
        assert!(sound.is_empty(), "seed {seed}: {sound:?}");
        let dead = on_the_lower_half(seed, 40, |_, c, v| if c == 14 { 0.0 } else { v });
        assert_eq!(kinds(&dead), [(Axis::Column, 14, SUSPECT)], "seed {seed}");
        let fault = dead.faults[0];
        assert!(
            fault.faulty >= 5 && fault.faulty == fault.tested,
            "{fault:?}"
        );
        assert!(fault.median_counts < 2.0 && fault.next_to > 1000.0);
        let text = fault.to_string();
        assert!(text.starts_with("column 14 may be dead: "), "{text}");
        assert_eq!(dead.dead_columns().count(), 0, "nothing is marked");
        let twins = on_the_lower_half(seed, 40, |_, c, v| if c / 2 == 7 { 0.0 } else { v });
        let both = [14, 15].map(|column| (Axis::Column, column, SUSPECT));
        assert_eq!(kinds(&twins), both, "seed {seed}");
    }
}

#[test]
fn where_unloaded_taxels_read_a_little_a_gap_reads_that_and_a_dead_line_less() {
    let plates = |r: usize, c: usize, v: f64| {
        let is_on = (6..18).contains(&r) && (8..22).contains(&c) && c != 14;
        v + if is_on { 5000.0 } else { 0.0 }
    };
    let array = Array {
        baseline: 4.0,
        sigma: 0.3,
        blobs: 0,
        ..SOUND
    };
    for seed in 0..5 {
        let gap = faults(array, seed, 20, |_, r, c, v| plates(r, c, v));
        assert!(gap.is_empty(), "seed {seed}: {gap:?}");
        let dead = |r, c, v| if c == 14 { 0.0 } else { plates(r, c, v) };
        let dead = faults(array, seed, 20, |_, r, c, v| dead(r, c, v));
        assert_eq!(kinds(&dead), [(Axis::Column, 14, DEAD)], "seed {seed}");
        assert!(
            dead.faults[0]
                .to_string()
                .starts_with("column 14 is dead: ")
        );
    }
}

#[test]
fn a_gap_between_two_loads_is_at_most_suspect_and_a_line_that_is_ever_touched_is_sound() {
    // Two plates with a gap of one column between them, or of three.
    let plate = |c: usize| {
        if (8..14).contains(&c) || (15..22).contains(&c) {
            5000.0
        } else {
            0.0
        }
    };
    let array = Array {
        baseline: 0.0,
        blobs: 0,
        ..SOUND
    };
    let on = |r: usize, heavy: f64| if (6..18).contains(&r) { heavy } else { 0.0 };
    for seed in 0..5 {
        let gap = faults(array, seed, 30, |_, r, c, _| on(r, plate(c)));
        assert_eq!(kinds(&gap), [(Axis::Column, 14, SUSPECT)], "seed {seed}");
        let wide = |c| if (13..16).contains(&c) { 0.0 } else { plate(c) };
        let wide = faults(array, seed, 30, |_, r, c, _| on(r, wide(c)));
        assert!(wide.is_empty(), "seed {seed}: {wide:?}");
        // Two fingers that are round: what they press falls off towards the gap.
        let round =
            |c: usize| 5000.0 * (1.0 - (c.abs_diff(11).min(c.abs_diff(17)) as f64 / 3.0).powi(2));
        let fingers = faults(array, seed, 30, |_, r, c, _| on(r, round(c).max(0.0)));
        assert!(fingers.is_empty(), "seed {seed}: {fingers:?}");
        // Something in the gap, once.
        let finger = |t, c| if t == 12 && c == 14 { 3000.0 } else { plate(c) };
        let touched = faults(array, seed, 30, |t, r, c, _| on(r, finger(t, c)));
        assert!(touched.is_empty(), "seed {seed}: {touched:?}");
    }
}

#[test]
fn a_flickering_column_is_found_and_its_drops_are_named_frame_by_frame() {
    let out = |t: usize| t % 5 == 3;
    for (seed, baseline) in [(1, 25.0), (2, 25.0), (3, 600.0)] {
        let array = Array { baseline, ..SOUND };
        let fault = |t, _, c, v| if c == 20 && out(t) { 0.0 } else { v };
        let found = faults(array, seed, 30, fault);
        assert_eq!(kinds(&found), [(Axis::Column, 20, FLICKERING)]);
        assert_eq!((found.faults[0].faulty, found.faults[0].tested), (6, 30));

        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let options = ScreenOptions::default();
        let mut screen = FrameScreen::new(ROWS, COLUMNS, FULL, &options);
        screen.set_lines(&found);
        for t in 0..30 {
            let mut frame = array.frame(&mut random, |r, c, v| fault(t, r, c, v));
            screen.mark(&mut frame).unwrap();
            let is_dropped = screen.dropped().contains(&(Axis::Column, 20));
            assert_eq!(is_dropped, out(t), "frame {t}");
        }
    }
}

#[test]
fn a_line_that_is_out_in_one_frame_only_does_not_flicker_unless_asked() {
    let fault = |t, r: usize, _, v| if r == 9 && t == 4 { 0.0 } else { v };
    assert!(faults(SOUND, 5, 20, fault).is_empty());
}

#[test]
fn a_line_whose_offset_is_low_is_neither_dead_nor_flickering() {
    let array = Array {
        baseline: 60.0,
        blobs: 8,
        ..SOUND
    };
    for seed in 0..10 {
        let found = faults(
            array,
            seed,
            40,
            |_, _, c, v| if c == 10 { v - 30.0 } else { v },
        );
        assert!(found.is_empty(), "seed {seed}: {found:?}");
    }
}

#[test]
fn shorted_lines_are_found_and_smooth_or_equal_loads_are_not_taken_for_them() {
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut screen = LineScreen::new(ROWS, COLUMNS, FULL, &ScreenOptions::default());
        for _ in 0..20 {
            let mut frame = SOUND.frame(&mut random, |_, _, v| v);
            for c in 0..COLUMNS {
                // Both lines see both taxels in parallel.
                let sum = frame.at(6, c) + frame.at(7, c) - SOUND.baseline;
                frame.values_mut()[6 * COLUMNS + c] = sum.max(0.0);
                frame.values_mut()[7 * COLUMNS + c] = (sum + 3.0 * noise(&mut random)).max(0.0);
            }
            screen.observe(&frame).unwrap();
        }
        let kind = LineFaultKind::Shorted { with: 7 };
        assert_eq!(
            kinds(&screen.finish()),
            [(Axis::Row, 6, kind)],
            "seed {seed}"
        );
    }
    let even = Array {
        uneven: 0.0,
        ..SOUND
    };
    assert!(faults(even, 7, 30, |_, _, _, v| v).is_empty());
    assert!(faults(even, 8, 30, |t, _, _, _| 25.0 + 300.0 * t as f64).is_empty());
}

#[test]
fn a_frame_that_is_all_out_blames_no_line() {
    let found = faults(SOUND, 9, 20, |t, _, _, v| if t % 8 == 5 { 0.0 } else { v });
    assert!(found.is_empty(), "{found:?}");
    assert_eq!(found.blank_frames, 2, "{found:?}");
}

#[test]
fn a_line_at_the_ceiling_is_dead_too() {
    let found = faults(
        SOUND,
        10,
        10,
        |_, r, _, v| if r == 3 { FULL + 30.0 } else { v },
    );
    assert_eq!(kinds(&found), [(Axis::Row, 3, DEAD)]);
    assert_eq!(found.faults[0].median_counts, FULL);
}

#[test]
fn the_report_reads_well_and_counts_right() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let options = ScreenOptions::default();
    let mut lines = LineScreen::new(ROWS, COLUMNS, FULL, &options);
    let mut frames: Vec<_> = (0..10)
        .map(|_| SOUND.frame(&mut random, |r, _, v| if r == 11 { 0.0 } else { v }))
        .collect();
    frames.iter().for_each(|f| lines.observe(f).unwrap());
    let mut screen = FrameScreen::new(ROWS, COLUMNS, FULL, &options);
    screen.set_lines(&lines.finish());
    let mut report = ScreenReport::new(lines.finish());
    for frame in &mut frames {
        screen.mark(frame).unwrap();
        report.add(frame);
    }
    assert_eq!(report.count(Mark::Open), 10 * COLUMNS as u64);
    assert!((report.outlier_share() - 1.0 / ROWS as f64).abs() < 1e-12);
    let text = report.to_string();
    for line in [
        "10 frames, 7680 readings",
        "outliers 4.17 % (320 readings)",
        "row 11 is dead",
    ] {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn declared_faults_are_taken_from_the_sensor_file() {
    let spec = ScreenSpec {
        dead_rows: vec![3],
        flickering_columns: vec![5, 6],
        ..ScreenSpec::default()
    };
    let faults = LineFaults::from_spec(&spec);
    assert_eq!(faults.dead_rows().collect::<Vec<_>>(), [3]);
    assert_eq!(faults.flickering_columns().collect::<Vec<_>>(), [5, 6]);
    assert_eq!(
        faults.dead_columns().count() + faults.flickering_rows().count(),
        0
    );
}

#[test]
fn a_frame_of_another_shape_is_refused() {
    let mut screen = LineScreen::new(4, 4, FULL, &ScreenOptions::default());
    assert!(matches!(
        screen.observe(&Frame::zeros(4, 5)),
        Err(Error::Shape { .. })
    ));
}

/// Unloaded taxels read one count or two, so that none can fall from it.
const NEXT_TO_NOTHING: Array = Array {
    baseline: 1.4,
    sigma: 0.3,
    blobs: 2,
    ..SOUND
};

fn next_to_nothing() -> ScreenOptions {
    ScreenOptions {
        baseline_counts: Some(1.4),
        noise_counts: Some(0.4),
        ..ScreenOptions::default()
    }
}

#[test]
fn where_no_reading_can_fall_those_of_a_line_fall_together() {
    for seed in 0..20 {
        // Column 5 is out in every third frame, row 0 at the edge in all.
        let level = next_to_nothing();
        let found = faults_at(NEXT_TO_NOTHING, seed, 60, &level, |t, r, c, v| {
            let is_out = r == 0 || (c == 5 && t % 3 == 0);
            if is_out { 0.0 } else { v }
        });
        assert_eq!(
            kinds(&found),
            [(Axis::Row, 0, DEAD), (Axis::Column, 5, FLICKERING)],
            "seed {seed}"
        );
        let dead = found.faults[0];
        assert_eq!((dead.faulty, dead.tested), (60, 60));
        let flickers = found.faults[1];
        assert!(flickers.has_fallen, "{flickers:?}");
        assert_eq!((flickers.faulty, flickers.tested), (20, 60));
    }
}

#[test]
fn a_line_of_a_low_or_drifting_offset_and_a_frame_of_nothing_are_no_faults() {
    for seed in 0..20 {
        let level = next_to_nothing();
        let low = |_: usize, r: usize, _: usize, v: f64| if r == 9 { v - 1.2 } else { v };
        // From nothing to what others read, over the recording.
        let drifting = |t: usize, _: usize, c: usize, v: f64| {
            let still = if c == 5 { 1.0 - t as f64 / 60.0 } else { 0.0 };
            v - 1.4 * still
        };
        let blank = |t: usize, _: usize, _: usize, v: f64| if t % 4 == 1 { 0.0 } else { v };
        let found = [
            faults_at(NEXT_TO_NOTHING, seed, 60, &level, low),
            faults_at(NEXT_TO_NOTHING, seed, 60, &level, drifting),
            faults_at(NEXT_TO_NOTHING, seed, 60, &level, blank),
        ];
        assert!(
            found.iter().all(LineFaults::is_empty),
            "seed {seed}: {found:?}"
        );
    }
}
