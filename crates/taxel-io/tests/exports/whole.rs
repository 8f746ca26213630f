//! The whole recordings that the cuts are of, against the numbers that another reader found in them. They are not in the
//! repository; `cargo test --test exports -- --ignored` reads them beside it, in `../shared/data/vendor`.

use std::io::Read as _;

use taxel_io::exports::{self, ExportAbout, Survey};

use super::*;

fn whole(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data/vendor")
        .join(name)
}

fn survey(file: &Path) -> (ExportAbout, Survey) {
    exports::survey(file).unwrap().expect("an export")
}

/// The one file of an archive, unpacked.
fn unpacked(folder: &Folder, name: &str) -> PathBuf {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(whole(name)).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive
        .by_index(0)
        .unwrap()
        .read_to_end(&mut bytes)
        .unwrap();
    folder.write("an export without an ending", bytes)
}

/// Sum of all, largest, place and sum of the fullest frame, in the unit of the file.
fn check(survey: &Survey, frames: u64, sum: f64, largest: f64, fullest: (u64, f64)) {
    assert_eq!(survey.frames, frames);
    near(
        &[survey.sum, survey.largest],
        &[sum, largest],
        1e-6 * sum.max(1.0),
    );
    let (place, of_fullest) = survey.heaviest.unwrap();
    assert_eq!(place, fullest.0);
    near(&[of_fullest], &[fullest.1], 1e-6 * fullest.1);
}

/// The largest force by the pipeline, and the largest difference from what the file says, newtons.
fn against_the_file(file: &Path) -> (f64, f64) {
    let own = forces(file);
    let told = read(file).into_iter().map(|read| read.reference_newtons);
    let pairs = own
        .iter()
        .zip(told)
        .filter_map(|(own, told)| Some((own, told?)));
    let off = pairs
        .map(|(own, told)| (own - told).abs())
        .fold(0.0, f64::max);
    (own.iter().copied().fold(0.0, f64::max), off)
}

#[test]
#[ignore = "needs ../shared/data/vendor"]
fn tekscan() {
    let file = whole("tekscan/fscan_testL.asf");
    let (about, found) = survey(&file);
    assert_eq!(
        about.pads[0]
            .absent
            .iter()
            .filter(|&&absent| absent)
            .count(),
        305
    );
    check(&found, 205, 3_154_674.0, 760.0, (8, 35_819.0));
    assert_eq!(found.has_raw, Some(true));
    near(&[against_the_file(&file).0], &[924.36], 0.005);
    let raw = read(&file.with_file_name("fscan_testL.asf#raw"));
    let mut levels: Vec<u64> = raw
        .iter()
        .flat_map(|read| read.frame.values())
        .map(|count| *count as u64)
        .collect();
    levels.sort_unstable();
    levels.dedup();
    assert_eq!((levels.len(), levels[1], levels[107]), (108, 3, 128));

    let file = whole("tekscan/iscan_test.csv");
    let (about, found) = survey(&file);
    assert_eq!(
        about.pads[0]
            .absent
            .iter()
            .filter(|&&absent| absent)
            .count(),
        300
    );
    check(&found, 309, 145_083.0, 100.0, (65, 838.0));
    let frames = read(&file);
    near(&[frames[308].frame.time_secs.unwrap()], &[31.1], 1e-9);
}

#[test]
#[ignore = "needs ../shared/data/vendor"]
fn novel() {
    let pedar = whole("novel/pedar_example.asc");
    let (_, left) = survey(&pedar.with_file_name("pedar_example.asc#left"));
    let (_, right) = survey(&pedar.with_file_name("pedar_example.asc#right"));
    near(&[left.sum, right.sum], &[2_977_905.0, 3_968_237.5], 1e-3);
    assert_eq!(
        (left.frames, right.frames, right.largest),
        (1505, 1505, 247.5)
    );

    let pliance = whole("novel/pliance_test.asc");
    let (_, found) = survey(&pliance);
    check(&found, 281, 655_906.68, 140.0, (194, 4248.335));
    let (largest, off) = against_the_file(&pliance);
    near(&[largest], &[230.591], 0.01);
    assert!(off <= 0.009, "{off}");

    let emed = whole("novel/emed_test.lst");
    let (_, found) = survey(&emed);
    assert_eq!(
        (found.frames, found.largest, found.heaviest.unwrap().0),
        (106, 370.0, 61)
    );
    let (largest, off) = against_the_file(&emed);
    near(&[largest], &[818.63], 0.006);
    assert!(off <= 0.0051, "{off}");
}

#[test]
#[ignore = "needs ../shared/data/vendor"]
fn xsensor() {
    let file = whole("xsensor/xsensor_data.csv");
    let left = file.with_file_name("xsensor_data.csv#left");
    let (_, found) = survey(&left);
    near(&[found.sum, found.largest], &[1_471_026.75, 2957.46], 1e-3);
    let frames = read(&left);
    assert_eq!(
        (frames.len(), frames[0].number, frames[100].number),
        (101, Some(1464), Some(1564))
    );
    let (_, found) = survey(&file.with_file_name("xsensor_data.csv#right"));
    near(&[found.sum], &[1_440_097.27], 1e-3);
}

#[test]
#[ignore = "needs ../shared/data/vendor"]
fn rsscan_and_zebris() {
    let folder = Folder::new();
    let file = unpacked(&folder, "rsscan/rsscan_export.zip");
    let (about, found) = survey(&file);
    assert_eq!((about.pads[0].rows, about.pads[0].columns), (256, 63));
    check(&found, 249, 41_166.7, 11.5, (126, 250.4));
    near(&[read(&file)[126].frame.time_secs.unwrap()], &[1.0], 1e-9);

    let file = unpacked(&folder, "zebris/zebris_export.zip");
    let (about, found) = survey(&file);
    assert_eq!((about.pads[0].rows, about.pads[0].columns), (56, 128));
    check(&found, 1472, 892_758.5, 34.5, (267, 972.5));
    let (largest, off) = against_the_file(&file);
    near(&[largest], &[696.86], 0.005);
    // 0.06 % of what the feet's forces add up to.
    assert!(off <= 0.33, "{off}");
}
