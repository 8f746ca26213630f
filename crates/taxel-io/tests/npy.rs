//! Arrays: round trips, headers as numpy writes them, and headers as nobody should.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use taxel::{Counts, Frame, Siemens};
use taxel_io::npy::Element;
use taxel_io::{
    Error, FrameSource, NpyOptions, NpyReader, NpyWriter, NpzWriter, ReadOptions, open_counts,
    shape_of,
};

/// An array as numpy.save writes it.
fn npy(dictionary: &str, data: &[u8]) -> Vec<u8> {
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend_from_slice(&(dictionary.len() as u16).to_le_bytes());
    out.extend_from_slice(dictionary.as_bytes());
    out.extend_from_slice(data);
    out
}

fn header(descr: &str, fortran: &str, shape: &str) -> String {
    format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n")
}

fn read(bytes: &[u8], options: NpyOptions) -> Result<Vec<Frame<Siemens>>, Error> {
    NpyReader::new(bytes, "a.npy", options)?.frames().collect()
}

fn message(bytes: &[u8], options: NpyOptions) -> String {
    read(bytes, options).unwrap_err().to_string()
}

#[test]
fn every_type_and_byte_order() {
    for (descr, data) in [
        ("|u1", vec![1u8, 2]),
        ("|i1", vec![1, 2]),
        ("<u2", vec![1, 0, 2, 0]),
        (">u2", vec![0, 1, 0, 2]),
        (">i2", vec![0, 1, 0, 2]),
        ("<i4", vec![1, 0, 0, 0, 2, 0, 0, 0]),
        (">u4", vec![0, 0, 0, 1, 0, 0, 0, 2]),
        ("<i8", [1i64.to_le_bytes(), 2i64.to_le_bytes()].concat()),
        (">u8", [1u64.to_be_bytes(), 2u64.to_be_bytes()].concat()),
        ("<f4", [1f32.to_le_bytes(), 2f32.to_le_bytes()].concat()),
        (">f8", [1f64.to_be_bytes(), 2f64.to_be_bytes()].concat()),
    ] {
        let bytes = npy(&header(descr, "False", "(1, 2)"), &data);
        let frames = read(&bytes, NpyOptions::default()).unwrap();
        assert_eq!(frames[0].values(), [1.0, 2.0], "{descr}");
    }
}

#[test]
fn fortran_order_and_transposing_in_every_combination() {
    // Element (r, c) of 2 x 3 is 10 r + c.
    for (fortran, transpose, data) in [
        ("False", false, [0u8, 1, 2, 10, 11, 12]),
        ("True", false, [0, 10, 1, 11, 2, 12]),
        ("False", true, [0, 10, 1, 11, 2, 12]),
        ("True", true, [0, 1, 2, 10, 11, 12]),
    ] {
        let shape = if transpose { "(3, 2)" } else { "(2, 3)" };
        let bytes = npy(&header("|u1", fortran, shape), &data);
        let mut options = NpyOptions::default();
        options.shape = Some((2, 3));
        options.transpose = transpose;
        let frames = read(&bytes, options).unwrap();
        assert_eq!(
            frames[0].values(),
            [0., 1., 2., 10., 11., 12.],
            "{fortran} {transpose}"
        );
        assert_eq!((frames[0].rows(), frames[0].columns()), (2, 3));
    }
}

#[test]
fn bad_arrays_say_what_where_and_both_numbers() {
    let any = NpyOptions::default;
    let of = |rows, columns| {
        let mut options = NpyOptions::default();
        options.shape = Some((rows, columns));
        options
    };
    let numpy = "hint: write it with numpy.save, without pickled objects";
    let types = "expected one of f8 f4 i1 u1 i2 u2 i4 u4 i8 u8";
    for (bytes, options, text) in [
        (vec![], any(), format!("not a .npy array: a.npy, byte 0: found ``, expected \\x93NUMPY and a version\n{numpy}")),
        (b"1,2,3,4,".to_vec(), any(), format!("not a .npy array: a.npy, byte 0: found `1,2,3,4,`, expected \\x93NUMPY and a version\n{numpy}")),
        (b"\x93NUMPY\x09\x00".to_vec(), any(), format!("not a .npy array: a.npy, byte 6: found `9`, expected version 1, 2 or 3\n{numpy}")),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(), any(), format!("not a .npy array: a.npy, byte 8: found `4294967295`, expected a header of at most 65536 bytes\n{numpy}")),
        (npy(&header("|O", "False", "(1, 2)"), &[]), any(), format!("not a .npy array: a.npy, byte 20: found `'|O', 'fortran_o`, {types}\n{numpy}")),
        (npy("{'descr': [('a', '<f8')]}", &[]), any(), format!("not a .npy array: a.npy, byte 20: found `[('a', '<f8')]}}`, {types}\n{numpy}").replace("}}", "}")),
        (npy(&header("<u2", "False", "(4,)"), &[]), any(), "wrong shape of a.npy: (4), expected (rows, columns) or (frames, rows, columns)\nhint: reshape the array with numpy.reshape".into()),
        (npy(&header("<u2", "True", "(2, 2, 2)"), &[]), any(), "wrong shape of a.npy: (2, 2, 2), expected 3-D in C order\nhint: write numpy.ascontiguousarray(frames): in Fortran order no frame lies together".into()),
        (npy(&header("<u2", "False", "(7, 3, 2)"), &[]), of(2, 3), "wrong shape of a.npy: (7, 3, 2), expected frames of 2 rows x 3 columns\nhint: rows and columns are swapped in this file".into()),
        (npy(&header("<u2", "False", "(7, 4, 4)"), &[]), of(2, 3), "wrong shape of a.npy: (7, 4, 4), expected frames of 2 rows x 3 columns\nhint: the recording is of another sensor; check rows and columns in the sensor file".into()),
        (npy(&header("<u2", "False", "(1, 99999999999, 99999999999)"), &[]), any(), "cannot read a.npy as frames of 99999999999 rows x 99999999999 columns: a frame has 1 to 262144 taxels, so that memory stays below 256 MiB\nhint: check rows and columns in the sensor file".into()),
        (npy(&header("<u2", "False", "(2, 1, 2)"), &[1, 0, 2, 0, 3]), any(), "a.npy is cut short in frame 1: 5 bytes of data found, 8 expected\nhint: the file was copied or written in part".into()),
        (npy(&header("<f4", "False", "(1, 2)"), &[0, 0, 0, 0, 0, 0, 0xc0, 0x7f]), any(), format!("not a finite number in a.npy, frame 0, row 0, column 1: NaN, expected -{} to {}\nhint: a reading that is missing or broken", f64::MAX, f64::MAX)),
        (npy(&header("<f4", "False", "(0, 1, 2)"), &[]), any(), "no frame in a.npy: 0 found, at least 1 expected\nhint: the file is empty or holds blank lines only; was the recording ever started?".into()),
    ] {
        assert_eq!(message(&bytes, options), text);
    }
}

fn counts(rows: usize, columns: usize, n: usize) -> Vec<Frame<Counts>> {
    (0..n)
        .map(|i| {
            let values = (0..rows * columns).map(|j| ((i * 7 + j * 13) % 1024) as f64);
            let mut frame = Frame::new(rows, columns, values.collect()).unwrap();
            frame.sequence = i as u64;
            frame
        })
        .collect()
}

fn all(path: &Path, options: ReadOptions) -> Vec<Frame<Counts>> {
    let source = open_counts(path, options).unwrap();
    source.frames().map(Result::unwrap).collect()
}

#[test]
fn counts_go_through_npy_and_npz_and_the_extension_chooses() {
    let folder = tempfile::tempdir().unwrap();
    let frames = counts(3, 4, 5);
    let npy = folder.path().join("a.npy");
    let mut writer = NpyWriter::create(&npy, 3, 4, Element::U2).unwrap();
    frames.iter().for_each(|frame| writer.write(frame).unwrap());
    writer.commit().unwrap();
    assert_eq!(fs::metadata(&npy).unwrap().len(), 192 + 5 * 12 * 2);
    assert_eq!(all(&npy, ReadOptions::new(3, 4)), frames);

    let npz = folder.path().join("a.npz");
    let mut writer = NpzWriter::create(&npz).unwrap();
    writer
        .begin_array("counts", Some(5), 3, 4, Element::U2)
        .unwrap();
    frames.iter().for_each(|frame| writer.write(frame).unwrap());
    writer.begin_array("one", None, 3, 4, Element::F8).unwrap();
    writer.write(&frames[4]).unwrap();
    writer.commit().unwrap();
    assert_eq!(all(&npz, ReadOptions::new(3, 4)), frames);
    let mut options = NpyOptions::default();
    options.array = Some("one".into());
    let one: Vec<_> = NpyReader::open(&npz, options).unwrap().frames().collect();
    assert_eq!(one[0].as_ref().unwrap().values(), frames[4].values());
    for path in [npy, npz] {
        let shape = shape_of(path).unwrap();
        assert_eq!(
            (shape.rows, shape.columns, shape.frames),
            (Some(3), Some(4), Some(5))
        );
    }
}

#[test]
fn what_an_array_cannot_hold_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let mut writer = NpyWriter::create(&path, 1, 1, Element::U2).unwrap();
    let frame = |value| Frame::<Counts>::filled(1, 1, value);
    let name = path.display();
    assert_eq!(
        writer.write(&frame(70000.0)).unwrap_err().to_string(),
        format!(
            "70000 does not fit type u2 of {name}: expected 0 to 65535, whole\nhint: write 8-byte floating point (`f8`) instead"
        )
    );
    assert!(matches!(
        writer.write(&frame(0.5)),
        Err(Error::DoesNotFit { .. })
    ));
    assert!(matches!(
        writer.write(&frame(f64::NAN)),
        Err(Error::Value { .. })
    ));
    drop(writer);
    assert!(!path.exists());
}

#[test]
fn a_damaged_archive_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npz");
    let mut writer = NpzWriter::create(&path).unwrap();
    writer
        .begin_array("a", Some(50), 3, 4, Element::U2)
        .unwrap();
    for frame in counts(3, 4, 50) {
        writer.write(&frame).unwrap();
    }
    writer.commit().unwrap();
    let whole = fs::read(&path).unwrap();
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        fs::write(&path, &bytes).unwrap();
        let result = open_counts(&path, ReadOptions::new(3, 4))
            .and_then(|source| source.frames().collect::<Result<Vec<_>, _>>());
        // Damage to a date or a size nobody reads goes unnoticed; damage to the data must not.
        if let Ok(frames) = result {
            assert!(frames == counts(3, 4, 50), "byte {at}");
        }
    }
    let mut options = NpyOptions::default();
    options.array = Some("b".into());
    fs::write(&path, &whole).unwrap();
    let error = NpyReader::open(&path, options).err().unwrap();
    assert!(error.to_string().contains("no array `b`"), "{error}");
    assert!(error.to_string().contains("it has a\n"), "{error}");
}

#[test]
fn keep_going_leaves_out_bad_frames_of_an_array() {
    let data: Vec<u8> = [1f32, 2., f32::NAN, 4., 5., 6.]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let bytes = npy(&header("<f4", "False", "(4, 1, 2)"), &data);
    let mut options = NpyOptions::default();
    options.keep_going = true;
    let mut reader = NpyReader::<Siemens, _>::new(&bytes[..], "a", options).unwrap();
    let mut frame = Frame::zeros(1, 2);
    let mut seen = Vec::new();
    while reader.next_into(&mut frame).unwrap() {
        seen.push((frame.sequence, frame.at(0, 0)));
    }
    assert_eq!(seen, [(0, 1.0), (2, 5.0)]);
    assert_eq!(reader.skipped(), 2);
}

proptest! {
    #[test]
    fn values_written_read_back(
        values in proptest::collection::vec(
            proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO, 1..40),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        let n = values.len();
        let frame = Frame::<Siemens>::new(1, n, values).unwrap();
        let mut writer = NpyWriter::create(&path, 1, n, Element::F8).unwrap();
        writer.write(&frame).unwrap();
        writer.commit().unwrap();
        let reader = NpyReader::<Siemens>::open_values(&path, NpyOptions::default()).unwrap();
        let back: Vec<_> = reader.frames().map(Result::unwrap).collect();
        prop_assert_eq!(back, vec![frame]);
    }

    #[test]
    fn no_bytes_can_break_the_reader(
        start in proptest::sample::select(vec![
            npy("", &[]),
            b"\x93NUMPY\x01\x00\x60\x00".to_vec(),
            b"\x93NUMPY\x01\x00\x60\x00{'descr': '<u2', 'fortran_order': False, 'shape': (".to_vec(),
            vec![],
        ]),
        rest in prop_oneof![
            proptest::collection::vec(any::<u8>(), 0..300),
            proptest::collection::vec(proptest::sample::select(b"(){}',: 0123456789<>|fu248TrueFalse".to_vec()), 0..300),
        ],
        keep_going: bool, transpose: bool,
    ) {
        let bytes = [start, rest].concat();
        let mut options = NpyOptions::default();
        options.keep_going = keep_going;
        options.transpose = transpose;
        if let Ok(reader) = NpyReader::<Siemens, _>::new(&bytes[..], "a", options) {
            let taxels = reader.shape().0 * reader.shape().1;
            if taxels < 1 << 16 {
                reader.frames().take(10).for_each(drop);
            }
        }
    }
}
