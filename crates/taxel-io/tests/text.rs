//! Text recordings: round trips, every kind of broken file with its exact message, and any bytes at all.

use proptest::prelude::*;
use taxel::{Counts, Frame, Newtons};
use taxel_io::{
    Error, FrameSource, ReadOptions, TextReader, TextWriter, ValuesReader, ValuesWriter,
};

fn options(rows: usize, columns: usize) -> ReadOptions {
    {
        let mut options = ReadOptions::new(rows, columns);
        options.max_count = Some(1023.0);
        options
    }
}

/// All frames' values, the error that ended them, and the frames left out with the reasons.
type Outcome = (Vec<Vec<f64>>, Option<Error>, Vec<(u64, String)>);

fn read(text: &[u8], options: ReadOptions) -> Outcome {
    let mut reader = TextReader::new(text, "rec", options).unwrap();
    let mut frame = Frame::zeros(1, 1);
    let mut frames = Vec::new();
    let mut error = None;
    loop {
        match reader.next_into(&mut frame) {
            Ok(true) => frames.push(frame.values().to_vec()),
            Ok(false) => break,
            Err(found) => error = Some(found),
        }
    }
    assert!(reader.bytes_read() <= text.len() as u64);
    let skips = reader.skips().iter();
    let skips = skips.map(|s| (s.frame, s.error.to_string())).collect();
    (frames, error, skips)
}

fn good(text: &str, options: ReadOptions) -> Vec<Vec<f64>> {
    let (frames, error, _) = read(text.as_bytes(), options);
    assert!(error.is_none(), "{text:?}: {}", error.unwrap());
    frames
}

#[test]
fn every_form_of_the_same_two_frames_reads_alike() {
    let mut txt = options(2, 3);
    txt.extra_line = Some(false);
    let mut told = options(2, 3);
    told.extra_line = Some(true);
    let auto = options(2, 3);
    let frames = [[1., 2., 3., 4., 5., 6.], [7., 8., 9., 10., 11., 12.]];
    for (text, options) in [
        ("1,2,3,\n4,5,6,\n7,8,9,\n10,11,12,\n", txt),
        ("1,2,3\n4,5,6\n7,8,9\n10,11,12", txt),
        ("1,2,3,\r\n4,5,6,\r\n7,8,9,\r\n10,11,12,\r\n\r\n\r\n", txt),
        ("1,2,3,\n4,5,6,\n7,8,9,\n10,11,12,\n", auto),
        ("\u{feff}1, 2, 3\n4, 5.0, 6\n7,8,9\n1e1,11,12\n", auto),
        ("\n1,2,3,\n4,5,6,\n\n7,8,9,\n10,11,12,\n", auto),
        (",,\n1,2,3\n4,5,6\n,,\n7,8,9\n10,11,12\n\n", auto),
        ("a,b,c\n1,2,3\n4,5,6\n7,8,9\n10,11,12\n", auto),
        ("a,b,c\n1,2,3\n4,5,6\na,b,c\n7,8,9\n10,11,12\n", auto),
        ("1,2,3\n4,5,6\n\n7,8,9\n10,11,12\n", auto),
        ("12.25\n1,2,3\n4,5,6\n12.50\n7,8,9\n10,11,12\n", auto),
        (
            "10:31:04.5,\n1,2,3\n4,5,6\n10:31:05.0,\n7,8,9\n10,11,12\n",
            auto,
        ),
        ("header\n1,2,3\n4,5,6\n\n7,8,9\n10,11,12\n", auto),
        ("0,1,2\n1,2,3\n4,5,6\n0,1,2\n7,8,9\n10,11,12\n", told),
    ] {
        assert_eq!(good(text, options), frames, "{text:?}");
    }
}

#[test]
fn a_transposed_file_gives_the_same_frame() {
    let mut options = options(2, 3);
    options.transpose = true;
    assert_eq!(
        good("1,4,\n2,5,\n3,6,\n", options),
        [[1., 2., 3., 4., 5., 6.]]
    );
}

#[test]
fn time_stamps_with_a_unit_are_kept() {
    let text = "time_secs=0.25\n1,2\ntime_secs=0.5\n3,4\n";
    let reader = TextReader::new(text.as_bytes(), "rec", options(1, 2)).unwrap();
    let times: Vec<_> = reader.frames().map(|f| f.unwrap().time_secs).collect();
    assert_eq!(times, [Some(0.25), Some(0.5)]);
}

#[test]
fn bad_files_say_what_where_and_both_numbers() {
    let broken = "a line is broken, or this is no recording";
    let stopped = "the recording stopped inside a frame";
    let torn = "a line was torn or lost";
    let missing = "a reading that is missing or broken";
    let cases: Vec<(&str, String)> = vec![
        ("", "no frame in rec: 0 found, at least 1 expected\nhint: the file is empty or holds blank lines only; was the recording ever started?".into()),
        ("\n \r\n", "no frame in rec: 0 found, at least 1 expected\nhint: the file is empty or holds blank lines only; was the recording ever started?".into()),
        ("1,2,3,\n4,5,6,\n7,8,9,\n", format!("frame 1 is cut short at rec, line 4, column 1: 1 whole lines found, 2 expected\nhint: {stopped}")),
        ("1,2,3,\n4,5,6,\n7,8,9,\n10,1", format!("frame 1 is cut short at rec, line 4, column 1: 1 whole lines found, 2 expected\nhint: {stopped}")),
        ("1,2,3,\n4,5,6,\n7,8,9,\n10,11,1", format!("frame 1 is cut short at rec, line 4, column 1: 1 whole lines found, 2 expected\nhint: {stopped}")),
        ("1,2,\n3,4,\n5,6,\n", "wrong number of values at rec, line 1, column 1: 2 found, 3 expected\nhint: rows and columns are swapped in this file".into()),
        ("1,2,3,4,\n", "wrong number of values at rec, line 1, column 1: 4 found, 3 expected\nhint: the recording is of another sensor; check rows and columns in the sensor file".into()),
        ("1,2,3,\n4,5,6,\n7,8,9,\n10,11,12,13,\n", format!("wrong number of values at rec, line 4, column 1: 4 found, 3 expected\nhint: {torn}")),
        ("1,2,3,\n4,abc,6,\n", format!("not a number at rec, line 2, column 3: value 2 of 3 is `abc`\nhint: {broken}")),
        ("1,2,3,\n4,,6,\n", "not a number at rec, line 2, column 3: value 2 of 3 is ``\nhint: a value is missing between two commas".into()),
        ("1,2,3,\n4;5;6\n", "not a number at rec, line 2, column 1: value 1 of 3 is `4;5;6`\nhint: values are separated by commas".into()),
        ("1,2,3,\n4,nan,6,\n", format!("not a finite number at rec, line 2, column 3: value 2 of 3 is `nan`\nhint: {missing}")),
        ("1,2,3,\n4,-inf,6,\n", format!("not a finite number at rec, line 2, column 3: value 2 of 3 is `-inf`\nhint: {missing}")),
        ("1,2,3,\n4,5, -6,\n", "negative count at rec, line 2, column 6: -6, at least 0 expected\nhint: counts are what the converter gives, 0 and up; loads and volts are read as values".into()),
        ("1,2,3,\n4,5,1024,\n", "count above the converter's range at rec, line 2, column 5: 1024, at most 1023 expected\nhint: check `bits` under [converter] in the sensor file, or the recording is broken there".into()),
        ("\n1,2,3\n4,5,6\n\n1,2,3\n4,5,6\n1,2,3\n4,5,6\n", "frame 2 has no extra line before it at rec, line 7, column 1: line 3 of 2 of the frame before it?\nhint: every frame so far began with an extra line; one is missing, or a line is doubled".into()),
        ("\n1,2,3\n4,5,6\n\n1,2,3\n\n1,2,3\n4,5,6\n", "frame 1 is cut short at rec, line 6, column 1: 1 whole lines found, 2 expected\nhint: the next frame begins there".into()),
    ];
    for (text, message) in cases {
        let (_, error, _) = read(text.as_bytes(), options(2, 3));
        let error = error.unwrap_or_else(|| panic!("{text:?} was read"));
        assert_eq!(error.to_string(), message, "{text:?}");
    }
}

#[test]
fn a_blank_line_in_a_txt_is_no_separator() {
    let mut options = options(1, 2);
    options.extra_line = Some(false);
    let (frames, error, _) = read(b"1,2,\n\n3,4,\n", options);
    assert_eq!(frames.len(), 1);
    assert!(error.unwrap().to_string().contains("the .csv form"));
}

#[test]
fn an_endless_line_is_refused_with_its_length() {
    let text = vec![b'1'; 1 << 20];
    let (_, error, _) = read(&text, options(2, 3));
    let message = error.unwrap().to_string();
    assert!(
        message.starts_with(
            "line too long at rec, line 1, column 1: 1048576 bytes, at most 4096 expected"
        ),
        "{message}"
    );
}

#[test]
fn keep_going_leaves_out_the_broken_frame_and_no_other() {
    let first = "1,2,3,\n4,5,6,\n";
    let last = "7,8,9,\n10,11,12,\n";
    let endless = format!("{}\n4,5,6,\n", "1,".repeat(5000));
    for broken in [
        "1,x,3,\n4,5,6,\n",
        "1,2,3,\n4,5,\n",
        "1,2,3,\n4,nan,6,\n",
        "1,2000,3,\n4,5,6,\n",
        "1,2,3,4,5,6,\n",     // joined
        "1,2,34,5,6,\n",      // joined in a number
        "1,2,3,\n4,\n5,6,\n", // torn
        "1,\n2,3,\n4,5,6,\n",
        "\u{1}\u{2}\n4,5,6,\n",
        "garbage\ngarbage\n",
    ] {
        for extra in ["", "\n", "t,t,t\n"] {
            let text = format!("{extra}{first}{extra}{first}{extra}{broken}{extra}{last}");
            let (frames, error, skips) = read(text.as_bytes(), {
                let mut options = options(2, 3);
                options.keep_going = true;
                options.extra_line = extra.is_empty().then_some(false);
                options
            });
            assert!(error.is_none(), "{text:?}");
            assert_eq!(skips.len(), 1, "{text:?} {skips:?}");
            assert_eq!(skips[0].0, 2);
            assert_eq!(frames.len(), 3, "{text:?} {skips:?}");
            assert_eq!(frames[2], [7., 8., 9., 10., 11., 12.]);
        }
    }
    let text = format!("{first}{endless}{last}");
    let mut going = options(2, 3);
    going.keep_going = true;
    let (frames, error, skips) = read(text.as_bytes(), going);
    assert!(
        error.is_none() && skips.len() == 1 && frames.len() == 2,
        "{skips:?}"
    );
}

#[test]
fn frames_behind_a_line_of_the_wrong_length_are_said_to_be_shifted_perhaps() {
    let frame = "1,2,3,\n4,5,6,\n";
    let words = |extra: &str, broken: &str, behind: usize| {
        let mut going = options(2, 3);
        going.keep_going = true;
        going.extra_line = extra.is_empty().then_some(false);
        let whole = format!("{extra}{frame}");
        let text = format!("{whole}{whole}{extra}{broken}{}", whole.repeat(behind));
        let mut reader = TextReader::new(text.as_bytes(), "rec", going).unwrap();
        while reader.next_into(&mut Frame::zeros(2, 3)).unwrap() {}
        assert!(reader.skipped() > 0, "{text:?}");
        reader.integrity().words()
    };
    // Bytes lost inside a line, with or without its end; a line more.
    for broken in ["1,2,3,\n4,5,\n", "1,2,34,5,\n", "1,2,3,\n4,\n4,5,6,\n"] {
        assert_eq!(
            words("", broken, 1),
            [
                "frame 3 and those behind it may be shifted by a line: one before them had too many or too few numbers, and nothing stands between frames here"
            ]
        );
        assert!(words("t,t,t\n", broken, 1).is_empty(), "{broken:?}");
    }
    assert!(words("", "1,2,3,\n4,5,\n", 0).is_empty());
    // Two lines torn in two, or four that were cut off.
    assert_eq!(words("", "1,\n2,3,\n4,\n5,6,\n", 1).len(), 1);
    // Two lines in one, one in two, and a number that is none: it is known how many lines there were.
    for broken in [
        "1,2,3,4,5,6,\n",
        "1,2,3,\n4,\n5,6,\n",
        "1,\n2,3,\n4,5,6,\n",
        "1,x,3,\n4,5,6,\n",
    ] {
        assert!(words("", broken, 1).is_empty(), "{broken:?}");
    }
}

#[test]
fn an_extra_line_finds_the_next_frame_after_a_lost_line() {
    let mut going = options(2, 3);
    going.keep_going = true;
    let text =
        "\n1,2,3\n4,5,6\n\n1,2,3\n4,5,6\n\n1,2,3\n\n7,8,9\n10,11,12\n7,8,9\n\n1,2,3\n4,5,6\n";
    let (frames, _, skips) = read(text.as_bytes(), going);
    assert_eq!(skips.iter().map(|s| s.0).collect::<Vec<_>>(), [2, 4]);
    assert_eq!(frames.len(), 4);
    assert_eq!(frames[3], [1., 2., 3., 4., 5., 6.]);
}

#[test]
fn skips_are_counted_without_bound_and_remembered_with_one() {
    let mut going = options(1, 1);
    going.keep_going = true;
    going.extra_line = Some(false);
    let text = "x\n".repeat(1000) + "7\n";
    let mut reader = TextReader::new(text.as_bytes(), "rec", going).unwrap();
    let mut frame = Frame::zeros(1, 1);
    assert!(reader.next_into(&mut frame).unwrap());
    assert_eq!((reader.skipped(), reader.skips().len()), (1000, 100));
    assert_eq!((frame.sequence, frame.at(0, 0)), (1000, 7.0));
}

fn frames_of<Q: std::fmt::Debug>(
    value: impl Strategy<Value = f64> + Clone,
) -> impl Strategy<Value = Vec<Frame<Q>>> {
    (1usize..6, 2usize..7, 1usize..4).prop_flat_map(move |(rows, columns, n)| {
        let values = proptest::collection::vec(value.clone(), rows * columns);
        let times = proptest::option::of(0.0..1e6);
        let frame = (values, times).prop_map(move |(values, time)| {
            let mut frame = Frame::new(rows, columns, values).unwrap();
            frame.time_secs = time;
            frame
        });
        proptest::collection::vec(frame, n).prop_map(|mut frames| {
            for (i, frame) in frames.iter_mut().enumerate() {
                frame.sequence = i as u64;
            }
            frames
        })
    })
}

fn counts() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![(0u32..65536).prop_map(f64::from), 0.0..65535.0,]
}

fn finite() -> impl Strategy<Value = f64> + Clone {
    proptest::num::f64::NORMAL
        | proptest::num::f64::SUBNORMAL
        | proptest::num::f64::ZERO
        | proptest::num::f64::NEGATIVE
        | proptest::num::f64::POSITIVE
}

proptest! {
    #[test]
    fn counts_written_read_back(frames in frames_of::<Counts>(counts()), csv: bool) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(if csv { "a.csv" } else { "a.txt" });
        let mut writer = TextWriter::create(&path).unwrap();
        for frame in &frames {
            writer.write(frame).unwrap();
        }
        writer.commit().unwrap();
        let options = ReadOptions::new(frames[0].rows(), frames[0].columns());
        let back: Result<Vec<_>, _> = TextReader::open(&path, options).unwrap().frames().collect();
        let mut frames = frames;
        if !csv {
            frames.iter_mut().for_each(|frame| frame.time_secs = None);
        }
        prop_assert_eq!(back.unwrap(), frames);
    }

    #[test]
    fn values_written_read_back(mut frames in frames_of::<Newtons>(finite())) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut writer = ValuesWriter::create(&path).unwrap();
        for frame in &frames {
            writer.write(frame).unwrap();
        }
        writer.commit().unwrap();
        let options = ReadOptions::new(frames[0].rows(), frames[0].columns());
        let reader = ValuesReader::<Newtons>::open(&path, options).unwrap();
        let back: Result<Vec<_>, _> = reader.frames().collect();
        frames.iter_mut().for_each(|frame| frame.time_secs = None);
        prop_assert_eq!(back.unwrap(), frames);
    }

    #[test]
    fn no_bytes_can_break_the_reader(
        bytes in prop_oneof![
            proptest::collection::vec(any::<u8>(), 0..600),
            proptest::collection::vec(
                proptest::sample::select(b"0123456789,,,,\n\n\n\r.-eExn \xEF\xBB\xBF".to_vec()), 0..600),
        ],
        rows in 1usize..5, columns in 1usize..5,
        transpose: bool, keep_going: bool, extra_line in proptest::option::of(any::<bool>()),
    ) {
        let mut options = ReadOptions::new(rows, columns);
        options.max_count = None;
        options.transpose = transpose;
        options.keep_going = keep_going;
        options.extra_line = extra_line;
        let (frames, error, skips) = read(&bytes, options);
        for values in frames {
            prop_assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0));
        }
        if let Some(error) = error {
            prop_assert!(error.to_string().contains("\nhint: "));
            prop_assert!(!keep_going || !error.is_one_frame());
        }
        prop_assert!(keep_going || skips.is_empty());
    }
}
