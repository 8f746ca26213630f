//! Files that end before their recording does.

use super::*;

const CUT: &str = "the end of the file is missing";

fn of_left(file: &Path) -> PathBuf {
    file.with_file_name("pedar.asc#left")
}

/// Its header says how long it took: what was cut between two lines is missing.
#[test]
fn pedar_has_as_many_lines_as_its_header_says() {
    let folder = Folder::new();
    let file = whole_pedar(&folder);
    assert_eq!(missing_of(&of_left(&file)), "");
    let missing = missing_of(&of_left(&cut("pedar.asc")));
    assert_eq!(missing, "1501 frames missing that the file says it has");
    // A line that its times tell of is not told of twice.
    let text = std::fs::read_to_string(whole_pedar(&folder)).unwrap();
    let third = text.lines().nth(12).unwrap().to_owned();
    let file = folder.write("pedar.asc", text.replace(&format!("{third}\n"), ""));
    let missing = missing_of(&of_left(&file));
    assert_eq!(
        missing,
        "1 of the frames missing by their times after frame 1"
    );
    // A part of a recording begins later, and nothing is known of its length.
    let part = text.replace("     0.0", "     7.0");
    assert_eq!(missing_of(&of_left(&folder.write("pedar.asc", part))), "");
}

#[test]
fn pedar_cut_within_a_number_is_told() {
    let folder = Folder::new();
    let text = std::fs::read_to_string(whole_pedar(&folder)).unwrap();
    let text = text.trim_end_matches('\n');
    // The whole one closes its last line with a tab.
    assert_eq!(missing_of(&of_left(&folder.write("pedar.asc", text))), "");
    let text = text.trim_end_matches('\t');
    for keep in [1, 2, 3] {
        let file = folder.write("pedar.asc", &text[..text.len() - keep]);
        let missing = missing_of(&of_left(&file));
        assert!(missing.contains(CUT), "{keep}: {missing}");
    }
    // Within the line before that, its frame is lost as well.
    let file = of_left(&folder.write("pedar.asc", &text[..text.len() - 300]));
    let kept = read_with(&file, &sensor_of(&file), true);
    assert_eq!((kept.frames.len(), kept.left_out.len()), (3, 1));
    assert!(kept.missing.join("; ").contains(CUT), "{:?}", kept.missing);
}

#[test]
fn pedcad_cut_within_a_number_is_told() {
    let folder = Folder::new();
    let head = "[General]\nUnitPressure=N/cm2\n[Technical]\nSensCountX=2\nSensCountY=2\nLDistX=5\nLDistY=5\n[Data]\n";
    let whole = format!("{head}-1\t0.5\n4.0\t1.5");
    assert_eq!(missing_of(&folder.write("a.apd", &whole)), "");
    let missing = missing_of(&folder.write("a.apd", &whole[..whole.len() - 1]));
    assert!(missing.contains(CUT), "{missing}");
}
