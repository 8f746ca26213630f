//! Parquet: what is written is read, files of other programs too, and what is no recording is told.
#![cfg(feature = "parquet")]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use taxel::{Counts, Frame, Mark, Newtons, Sensor};
use taxel_io::{
    Error, FrameSource, ParquetError, ParquetReader, ParquetWriter, ReadOptions, ValuesReader,
    open_counts, sensor_toml_of, shape_of,
};

fn sensor(rows: usize, columns: usize) -> Sensor {
    let preset = taxel::sensor::preset("mat-16x16-cd4067").unwrap().to_toml();
    let text = preset.replace("rows = 16\n", &format!("rows = {rows}\n"));
    let text = text.replace("columns = 16\n", &format!("columns = {columns}\n"));
    let sensor = Sensor::from_toml(&text).unwrap();
    assert_eq!((sensor.rows(), sensor.columns()), (rows, columns));
    sensor
}

/// When the host had a frame: whole microseconds, which the file holds.
fn at(frame: usize) -> SystemTime {
    SystemTime::UNIX_EPOCH + Duration::from_micros(1_700_000_000_123_457 + 10_001 * frame as u64)
}

fn counts(rows: usize, columns: usize, frames: usize) -> Vec<Frame<Counts>> {
    let frame = |at: usize| {
        let values = (0..rows * columns).map(|taxel| ((at * 7 + taxel * 13) % 65536) as f64);
        let mut frame = Frame::new(rows, columns, values.collect()).unwrap();
        frame.sequence = at as u64;
        frame.time_secs = Some(0.01 * at as f64);
        frame
    };
    (0..frames).map(frame).collect()
}

fn write(path: &Path, sensor: &Sensor, frames: &[Frame<Counts>]) {
    let mut writer = ParquetWriter::create(path, sensor).unwrap();
    for (place, frame) in frames.iter().enumerate() {
        writer.write(frame, at(place)).unwrap();
    }
    writer.commit().unwrap();
}

#[test]
fn counts_come_back_with_their_times_and_the_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let (sensor, frames) = (sensor(3, 4), counts(3, 4, 20));
    write(&path, &sensor, &frames);
    let shape = shape_of(&path).unwrap();
    assert_eq!(
        (shape.rows, shape.columns, shape.frames),
        (Some(3), Some(4), Some(20))
    );
    assert_eq!(sensor_toml_of(&path).unwrap().unwrap(), sensor.to_toml());
    let mut source = open_counts(&path, ReadOptions::new(3, 4)).unwrap();
    let mut frame = Frame::zeros(1, 1);
    for (place, expected) in frames.iter().enumerate() {
        assert!(source.next_into(&mut frame).unwrap());
        assert_eq!(&frame, expected);
        assert_eq!(source.device_number(), Some(place as u64));
        assert_eq!(source.host_time(), Some(at(place)));
    }
    assert!(!source.next_into(&mut frame).unwrap());
    assert!(source.integrity().is_whole());
    assert_eq!(source.bytes_read(), fs::metadata(&path).unwrap().len());
    let mut transposed = ReadOptions::new(4, 3);
    transposed.transpose = true;
    let turned: Vec<_> = open_counts(&path, transposed).unwrap().frames().collect();
    let turned = turned[5].as_ref().unwrap();
    for row in 0..3 {
        for column in 0..4 {
            assert_eq!(turned.at(column, row), frames[5].at(row, column));
        }
    }
}

#[test]
fn a_table_of_several_groups_is_read_through() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    // The largest frames there are: four of them make a group.
    let (sensor, frames) = (sensor(512, 512), counts(512, 512, 10));
    write(&path, &sensor, &frames);
    let source = open_counts(&path, ReadOptions::new(512, 512)).unwrap();
    let back: Vec<_> = source.frames().map(Result::unwrap).collect();
    assert_eq!(back, frames);
}

#[test]
fn loads_come_back_with_their_marks_alone_and_beside_counts() {
    let folder = tempfile::tempdir().unwrap();
    let (sensor, counts) = (sensor(3, 4), counts(3, 4, 5));
    let loads = |place: usize| {
        let values = (0..12).map(|taxel| (place as f64 - 2.0) * 1e-3 / f64::from(taxel + 1));
        let mut loads = Frame::<Newtons>::new(3, 4, values.collect()).unwrap();
        loads.marks_mut()[place] = Mark::ALL[place + 1];
        loads.sequence = place as u64;
        loads
    };
    for has_counts in [false, true] {
        let path = folder.path().join(format!("{has_counts}.parquet"));
        let mut writer = ParquetWriter::create_with_loads(&path, &sensor, has_counts).unwrap();
        for (place, counts) in counts.iter().enumerate() {
            let beside = has_counts.then_some(counts);
            writer
                .write_loads(beside, &loads(place), at(place))
                .unwrap();
        }
        writer.commit().unwrap();
        let options = ReadOptions::new(3, 4);
        let source = ParquetReader::<Newtons>::open_loads(&path, options).unwrap();
        for (place, frame) in source.frames().enumerate() {
            assert_eq!(frame.unwrap(), loads(place));
        }
        let read = ParquetReader::open_counts(&path, options);
        if has_counts {
            let back = read.unwrap().frames().map(Result::unwrap);
            for (back, counts) in back.zip(&counts) {
                // All taxels good: the marks are those of the loads. The time is that of the loads too.
                let mut expected = counts.clone();
                expected.time_secs = None;
                assert_eq!(back, expected);
            }
        } else {
            let error = read.err().unwrap().to_string();
            assert!(
                error.contains(
                    "no column `counts` in "
                ) && error.ends_with("it has sequence, time_secs, host_time, newtons, marks\nhint: it is a table of loads, which are read as values"),
                "{error}"
            );
        }
    }
}

#[test]
fn a_table_of_version_0_1_is_read() {
    // Written by this program's own hand, with one page a column and group; testdata/parquet has what it said as text.
    let file = |ending: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/parquet");
        folder.join(format!("version-0.1.{ending}"))
    };
    let options = ReadOptions::new(4, 6);
    let read = |path: PathBuf| -> Vec<_> {
        let source = open_counts(path, options).unwrap();
        source
            .frames()
            .map(|frame| frame.unwrap().values().to_vec())
            .collect()
    };
    let counts = read(file("parquet"));
    assert_eq!((counts.len(), &counts), (5, &read(file("counts.txt"))));
    let loads = ParquetReader::<Newtons>::open_loads(file("parquet"), options).unwrap();
    let expected = ValuesReader::<Newtons>::open(file("newtons.csv"), options).unwrap();
    for (found, expected) in loads.frames().zip(expected.frames()) {
        assert_eq!(found.unwrap().values(), expected.unwrap().values());
    }
}

#[test]
fn the_shape_of_another_programs_table_is_unknown_and_half_a_shape_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let row: &[Option<i64>] = &[Some(1)];
    of_lists(&path, PANDAS, Compression::UNCOMPRESSED, &[row; 3]);
    let shape = shape_of(&path).unwrap();
    assert_eq!(
        (shape.rows, shape.columns, shape.frames),
        (None, None, Some(3))
    );
    write(&path, &sensor(3, 4), &counts(3, 4, 1));
    let whole = fs::read(&path).unwrap();
    for key in ["taxel.rows", "taxel.columns"] {
        let at = whole.windows(key.len()).position(|w| w == key.as_bytes());
        let at = at.unwrap();
        // The key is another, or what stands under it (behind a type and a length) is no number.
        for (place, byte) in [(at, b'T'), (at + key.len() + 2, b'x')] {
            let mut bytes = whole.clone();
            bytes[place] = byte;
            fs::write(&path, bytes).unwrap();
            let error = shape_of(&path).unwrap_err().to_string();
            let words = format!("no number `{key}` in its metadata\nhint: give the sensor file");
            assert!(error.ends_with(&words), "{error}");
        }
    }
}

#[test]
fn gaps_in_the_numbers_of_the_device_and_times_that_go_back_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let mut frames = counts(2, 2, 6);
    let told = [(5, 0.5), (6, 0.6), (9, 0.2), (10, 0.2), (0, 0.1), (1, 0.0)];
    for (frame, (number, secs)) in frames.iter_mut().zip(told) {
        (frame.sequence, frame.time_secs) = (number, Some(secs));
    }
    write(&path, &sensor(2, 2), &frames);
    let mut source = open_counts(&path, ReadOptions::new(2, 2)).unwrap();
    let mut frame = Frame::zeros(2, 2);
    let mut places = Vec::new();
    while source.next_into(&mut frame).unwrap() {
        places.push(frame.sequence);
    }
    assert_eq!(places, [0, 1, 2, 3, 4, 5]);
    let (gaps, times) = (source.integrity().gaps, source.integrity().times);
    assert_eq!((gaps.missing, gaps.first), (2, Some((6, 2))));
    // Where the numbers began anew the clock may have done so too.
    assert_eq!((gaps.restarts, times.repeated), (1, 2));
}

/// A file of one group with one list of integers a row, as `schema` has it.
fn of_lists(path: &Path, schema: &str, packing: Compression, lists: &[&[Option<i64>]]) {
    of_columns(path, schema, packing, &[lists]);
}

/// The same with several such columns.
fn of_columns(path: &Path, schema: &str, packing: Compression, columns: &[&[&[Option<i64>]]]) {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder().set_compression(packing).build();
    let file = File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for lists in columns {
        let mut column = group.next_column().unwrap().unwrap();
        let (mut values, mut definition, mut repetition) = (Vec::new(), Vec::new(), Vec::new());
        for list in *lists {
            for (place, value) in list.iter().enumerate() {
                values.extend(value);
                definition.push(if value.is_some() { 3 } else { 2 });
                repetition.push(i16::from(place > 0));
            }
            if list.is_empty() {
                definition.push(1);
                repetition.push(0);
            }
        }
        column
            .typed::<Int64Type>()
            .write_batch(&values, Some(&definition), Some(&repetition))
            .unwrap();
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

/// What pandas makes of a column of lists.
const PANDAS: &str = "message schema { optional group counts (LIST) { repeated group list { optional int64 element; } } }";

fn zstd() -> Compression {
    Compression::ZSTD(ZstdLevel::default())
}

#[test]
fn lists_as_pandas_writes_them_are_frames_and_rows_that_are_none_are_left_out_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let good = [Some(1), Some(2), Some(3), Some(4)];
    let lists: [&[Option<i64>]; 6] = [
        &good,
        &[Some(1), None, Some(3), Some(4)],
        &[Some(1), Some(2), Some(3)],
        &[],
        &[Some(1), Some(-2), Some(3), Some(4)],
        &good,
    ];
    for packing in [Compression::UNCOMPRESSED, zstd()] {
        of_lists(&path, PANDAS, packing, &lists);
        let mut options = ReadOptions::new(2, 2);
        options.keep_going = true;
        let mut source = open_counts(&path, options).unwrap();
        let mut frame = Frame::zeros(2, 2);
        let mut places = Vec::new();
        while source.next_into(&mut frame).unwrap() {
            assert_eq!(frame.values(), [1.0, 2.0, 3.0, 4.0]);
            assert_eq!((frame.time_secs, source.host_time()), (None, None));
            places.push(frame.sequence);
        }
        assert_eq!(places, [0, 5]);
        let told: Vec<_> = source.skips().iter().map(|s| s.error.to_string()).collect();
        assert_eq!(told.len(), 4);
        for (told, words) in told.iter().zip([
            "`counts` has 3 numbers in ",
            "`counts` has 3 numbers in ",
            "`counts` has 0 numbers in ",
            "value out of range in ",
        ]) {
            assert!(told.starts_with(words), "{told}");
        }
        assert!(
            told[1].contains("frame 2, expected 2 rows x 2 columns = 4"),
            "{told:?}"
        );
        assert!(
            told[3].contains("frame 4, row 0, column 1: -2, expected 0 to"),
            "{told:?}"
        );
        let strict = open_counts(&path, ReadOptions::new(2, 2)).unwrap();
        assert!(matches!(
            strict.frames().nth(1),
            Some(Err(Error::Parquet(ParquetError::RowLength {
                frame: 1,
                ..
            })))
        ));
    }
}

#[test]
fn marks_that_are_missing_or_unknown_are_told_and_never_become_good() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let list = |name: &str| {
        format!(
            "optional group {name} (LIST) {{ repeated group list {{ optional int64 element; }} }}"
        )
    };
    let schema = format!("message schema {{ {} {} }}", list("newtons"), list("marks"));
    let loads: [&[Option<i64>]; 7] = [&[Some(1), Some(2), Some(3), Some(4)]; 7];
    let good = [Some(0), Some(9), Some(2), Some(0)];
    let marks: [&[Option<i64>]; 7] = [
        &good,
        &[Some(0), None, Some(2), Some(0)],
        &[Some(0), Some(1), Some(2)],
        &[],
        &[Some(0), Some(1), Some(12), Some(0)],
        &[Some(0), Some(-1), Some(2), Some(0)],
        &good,
    ];
    of_columns(&path, &schema, zstd(), &[&loads, &marks]);
    let mut options = ReadOptions::new(2, 2);
    options.keep_going = true;
    let mut source = ParquetReader::<Newtons>::open_loads(&path, options).unwrap();
    let mut frame = Frame::zeros(2, 2);
    let mut places = Vec::new();
    while source.next_into(&mut frame).unwrap() {
        let expected = [Mark::Good, Mark::Unfamiliar, Mark::Saturated, Mark::Good];
        assert_eq!(frame.marks(), expected);
        places.push(frame.sequence);
    }
    assert_eq!(places, [0, 6]);
    let told: Vec<_> = source.skips().iter().map(|s| s.error.to_string()).collect();
    assert_eq!(told.len(), 5);
    for (told, words) in told.iter().zip([
        "`marks` has 3 numbers in ",
        "`marks` has 3 numbers in ",
        "`marks` has 0 numbers in ",
        "mark 12 in ",
        "mark -1 in ",
    ]) {
        assert!(told.starts_with(words), "{told}");
    }
    let words = "frame 4, row 1, column 0, expected a whole number of 0 to 11";
    assert!(told[3].contains(words), "{told:?}");
    // Without being asked to go on, it ends there.
    let strict = ParquetReader::<Newtons>::open_loads(&path, ReadOptions::new(2, 2)).unwrap();
    assert!(matches!(
        strict.frames().nth(1),
        Some(Err(Error::Parquet(ParquetError::RowLength {
            column: "marks",
            ..
        })))
    ));
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn files_that_hold_no_frames_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let error = |path: &PathBuf| {
        let opened = open_counts(path, ReadOptions::new(2, 2));
        let error = match opened {
            Ok(source) => source.frames().find_map(Result::err).unwrap(),
            Err(error) => error,
        };
        error
            .to_string()
            .replace(&path.display().to_string(), "a.parquet")
    };
    for (bytes, words) in [
        (
            &b""[..],
            "cannot read a.parquet as Parquet: it has 0 bytes, at least 12 expected\nhint: it is cut short, damaged, or of another kind",
        ),
        (
            b"sequence,counts\n1,2\n",
            "cannot read a.parquet as Parquet: it ends with `1,2\\n`, not `PAR1`\nhint: it is cut short, damaged, or of another kind",
        ),
        (
            b"PAR1\xff\xff\xff\x7fPAR1",
            "cannot read a.parquet as Parquet: its description has 2147483647 bytes, at most 0 expected\nhint: it is cut short, damaged, or of another kind",
        ),
    ] {
        fs::write(&path, bytes).unwrap();
        assert_eq!(error(&path), words);
    }
    let hint = "\nhint: a table of this program has a list of numbers in each row: counts in `counts`, loads in `newtons`";
    of_lists(
        &path,
        &PANDAS.replace("counts", "loads"),
        zstd(),
        &[&[Some(1)]],
    );
    assert_eq!(
        error(&path),
        format!("no column `counts` in a.parquet: it has loads{hint}")
    );
    of_lists(&path, PANDAS, zstd(), &[]);
    assert!(
        error(&path).starts_with("no frame in a.parquet: 0 found"),
        "{}",
        error(&path)
    );
    of_lists(&path, PANDAS, Compression::UNCOMPRESSED, &[&[Some(1)]]);
    // One number a row.
    let schema =
        Arc::new(parse_message_type("message schema { required double counts; }").unwrap());
    let file = File::create(&path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column
        .typed::<DoubleType>()
        .write_batch(&[1.0], None, None)
        .unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    let told = error(&path);
    assert!(
        told.starts_with("column `counts` of a.parquet has one DOUBLE a row, expected a list"),
        "{told}"
    );
    // Frames of another sensor.
    write(&path, &sensor(3, 4), &counts(3, 4, 1));
    let told = error(&path);
    assert!(
        told.contains("3 rows x 4 columns") && told.contains("2 rows x 2 columns"),
        "{told}"
    );
}

#[test]
fn a_row_or_page_without_bounds_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    // A megabyte of a file or less: one row of eight million zeros.
    let zeros = vec![Some(0); 8 << 20];
    of_lists(&path, PANDAS, zstd(), &[&zeros]);
    assert!(fs::metadata(&path).unwrap().len() < 1 << 20);
    let source = open_counts(&path, ReadOptions::new(2, 2)).unwrap();
    let error = source.frames().next().unwrap().unwrap_err().to_string();
    assert!(error.starts_with("cannot read frame 0 of "), "{error}");
    assert!(
        error.contains("at most") || error.contains("more than"),
        "{error}"
    );
}
