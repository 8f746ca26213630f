//! Tables of zebris: lines and columns by their names, times, forces of the feet, and several platforms.

use taxel_io::exports;

use super::*;

/// A zebris file with one frame of 2 x 3, its names as they are given.
fn zebris(forces: &str, frame: &str) -> String {
    format!(
        "Frequency,Hz\t100\nCount\t1\n{forces}Platform {{\nColumns\t3\nLines\t2\nCell width,mm\t5\nCell height,mm\t5\nUnits\tN/cm^2\n\n{frame}}}\n"
    )
}

const TABLE: &str = "Frame 1 {\nTime, ms\t10.00\n\n\tx1\tx2\tx3\ny1\t0\t1\t2\ny2\t3\t4\t5\n}\n";

#[test]
fn zebris_columns_lie_by_their_numbers() {
    let folder = Folder::new();
    let counts = |frame: &str| {
        let file = folder.write("z.txt", zebris("", frame));
        read(&file)[0].frame.values().to_vec()
    };
    let straight = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    assert_eq!(counts(TABLE), straight);
    let turned = TABLE.replace("x1\tx2\tx3", "x3\tx2\tx1");
    assert_eq!(counts(&turned), [2.0, 1.0, 0.0, 5.0, 4.0, 3.0]);
    assert_eq!(counts(&TABLE.replace("x1\tx2\tx3", "x0\tx1\tx2")), straight);
    // A region as large as the header says, and a part of the platform.
    let region = TABLE.replace("x1\tx2\tx3", "x98\tx99\tx100");
    let region = region.replace("y1", "y20").replace("y2\t", "y21\t");
    assert_eq!(counts(&region), straight);
    let part = "Frame 1 {\nTime, ms\t10.00\n\n\tx2\tx3\ny2\t1\t2\n}\n";
    assert_eq!(counts(part), [0.0, 0.0, 0.0, 0.0, 1.0, 2.0]);
    for names in ["x1\tx1\tx3", "x1\tx2\tx4", "x1\tx2\tx3\tx4"] {
        let frame = TABLE.replace("x1\tx2\tx3", names);
        let error = error_of(&folder.write("z.txt", zebris("", &frame)));
        assert!(error.contains("expected the names of 3 columns"), "{error}");
    }
}

#[test]
fn zebris_times_in_seconds_and_forces_with_a_total() {
    let folder = Folder::new();
    let secs = |frame: &str| {
        let file = folder.write("z.txt", zebris("", frame));
        read(&file)[0].frame.time_secs.unwrap()
    };
    near(&[secs(TABLE)], &[0.01], 1e-12);
    near(
        &[secs(&TABLE.replace("ms\t10.00", "s\t0.05"))],
        &[0.05],
        1e-12,
    );
    let table = |names: &str| format!("Time,ms\t{names}\n\n10\t9\t3\t4\n");
    for (names, newtons) in [
        ("Total,N\tLi Kraft,N\tRe Kraft,N", 7.0),
        ("Force gauche,N\tForce droite,N\tPapillon.force,N", 12.0),
        ("Left,N\tRight,N\tButterfly.force,N", 12.0),
    ] {
        let file = folder.write("z.txt", zebris(&table(names), TABLE));
        near(
            &[read(&file)[0].reference_newtons.unwrap()],
            &[newtons],
            0.0,
        );
    }
    let names = "Kraft 1,N\tKraft 2,N\tKraft 3,N";
    let error = error_of(&folder.write("z.txt", zebris(&table(names), TABLE)));
    assert!(
        error.contains("3 columns in newtons") && error.contains("line 3"),
        "{error}"
    );
}

#[test]
fn zebris_platforms_are_sensors_of_their_own() {
    let folder = Folder::new();
    let one = zebris("", TABLE);
    let at = one.find("Platform").unwrap();
    let other = one[at..].replace("\t4\t5", "\t4\t9");
    let file = folder.write("z.txt", format!("{one}{other}"));
    let error = exports::sensor_of(&file).unwrap_err().to_string();
    assert!(error.contains("holds 2 sensors: 1, 2"), "{error}");
    near(&sums(&file.with_file_name("z.txt#1")), &[15.0], 0.0);
    near(&sums(&file.with_file_name("z.txt#2")), &[19.0], 0.0);
}

/// Exercises before them may be many.
#[test]
fn zebris_behind_a_long_header() {
    let folder = Folder::new();
    let exercises = "1\tGait\t0.00\t14.72\n".repeat(300);
    let text = format!("Exercises\t{{\n{exercises}}}\n{}", zebris("", TABLE));
    near(&sums(&folder.write("z.txt", text)), &[15.0], 0.0);
}
