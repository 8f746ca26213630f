//! Crossings without a taxel, readings below a floor, taxels at places of their own.

use crate::run::{Folder, SENSOR};

const MASK: &str = "1,1,1,1,1,0\n1,1,1,1,0,0\n1,1,1,1,0,0\n1,1,1,1,1,0\n";

/// The small sensor with a mask whose last column is not there at all.
fn sparse(more: &str) -> Folder {
    let folder = Folder::new();
    let array = format!("[array]\npopulation = \"mask.csv\"\n{more}");
    folder.write("sensor.toml", &SENSOR.replace("[array]\n", &array));
    folder.write("mask.csv", MASK);
    folder
}

fn absent() -> Vec<bool> {
    let numbers = crate::run::numbers(MASK);
    numbers.into_iter().map(|number| number == 0.0).collect()
}

#[test]
fn what_is_simulated_without_taxels_is_found_again_and_marked() {
    let folder = sparse("");
    folder.good("simulate --sensor sensor.toml --pattern blobs --frames 3 --seed 2 --truth truth.csv -o r.txt");
    let run = folder.good("compensate r.txt --sensor sensor.toml --unit g -o loads.csv");
    let text = run.to_string();
    assert!(!text.contains("absent"), "{text}");
    let (truth, loads) = (folder.numbers("truth.csv"), folder.numbers("loads.csv"));
    let marks = folder.numbers("loads.marks.csv");
    let absent = absent();
    let mut loaded = 0;
    for (at, ((truth, load), mark)) in truth.iter().zip(&loads).zip(&marks).enumerate() {
        if absent[at % 24] {
            assert_eq!((*truth, *load, *mark), (0.0, 0.0, 10.0));
        } else {
            loaded += usize::from(*truth > 1.0);
            assert!((truth - load).abs() < 2.0, "{at}: {truth} {load}");
            assert!(*mark != 10.0);
        }
    }
    assert!(loaded > 10, "{loaded}");
    let info = folder
        .good("info r.txt --sensor sensor.toml --json")
        .to_string();
    assert!(
        !info.contains("absent") && info.contains("\"good\""),
        "{info}"
    );
    let netlist = folder
        .good("netlist --sensor sensor.toml --scan")
        .to_string();
    assert!(
        netlist.contains("Rt0_4 ") && !netlist.contains("Rt0_5 "),
        "{netlist}"
    );
}

#[test]
fn a_recorder_that_leaves_readings_out_is_told_of() {
    let folder = Folder::new();
    let floor = SENSOR.replace("[converter]\n", "[converter]\nfloor_count = 3000\n");
    folder.write("sensor.toml", &floor);
    folder.good("simulate --sensor sensor.toml --pattern blobs --frames 3 --seed 2 --truth truth.csv -o r.txt");
    let counts = folder.numbers("r.txt");
    assert!(counts.iter().all(|&count| count == 0.0 || count > 3000.0));
    let run = folder
        .good("compensate r.txt --sensor sensor.toml --unit g -o loads.csv --standard-error e.csv");
    let text = run.to_string();
    assert!(
        text.contains("method newton") && text.contains("below the floor"),
        "{text}"
    );
    let marks = folder.numbers("loads.marks.csv");
    let loads = folder.numbers("loads.csv");
    for ((count, mark), load) in counts.iter().zip(&marks).zip(&loads) {
        assert_eq!(*count == 0.0, *mark == 11.0);
        assert!(*mark != 11.0 || load.abs() < 1e-9, "{load}");
    }
    let refused = folder.taxel("compensate r.txt --sensor sensor.toml --method exact -o x.csv");
    assert!(
        refused.to_string().contains("converter.floor_count"),
        "{refused}"
    );
    for (count, words) in [
        ("-1", "is -1"),
        ("65535", "is 65535"),
        ("70000", "is 70000"),
    ] {
        folder.write("bad.toml", &floor.replace("= 3000", &format!("= {count}")));
        let refused = folder.fails("info r.txt --sensor bad.toml").to_string();
        assert!(
            refused.contains("floor_count") && refused.contains(words),
            "{refused}"
        );
    }
}

#[test]
fn masks_and_places_that_cannot_be_say_where() {
    let folder = sparse("positions = \"places.csv\"\n");
    folder.write("r.txt", &"24,25,26,27,28,29\n".repeat(4));
    let places = |skip: usize, other: &str| {
        let absent = absent();
        let mut text = "row,column,x_mm,y_mm\n".to_owned();
        for taxel in (0..24).filter(|&t| !absent[t] && t != skip) {
            text += &format!(
                "{},{},{},{}\n",
                taxel / 6,
                taxel % 6,
                3 * (taxel % 6),
                taxel
            );
        }
        text + other
    };
    let refused = |words: &[&str]| {
        let run = folder.fails("info r.txt --sensor sensor.toml").to_string();
        for word in words {
            assert!(run.contains(word), "{word}: {run}");
        }
    };
    folder.write("places.csv", &places(24, ""));
    folder.good("plot r.txt --sensor sensor.toml -o picture.svg");
    assert!(folder.read("picture.svg").contains("x (mm)"));
    folder.write("places.csv", &places(8, ""));
    refused(&["row 1, column 2", "17 of 18"]);
    folder.write("places.csv", &places(8, "1,2,0,0\n"));
    refused(&["row 0, column 0 and row 1, column 2", "hint"]);
    folder.write("places.csv", &places(8, "1,2,zero,0\n"));
    refused(&["`x_mm` is `zero`", "places.csv, line 19"]);
    // Cells of a picture, as far apart as the lines.
    folder.write(
        "places.csv",
        &places(24, "").replace("x_mm,y_mm", "picture_column,picture_row"),
    );
    folder.good("plot r.txt --sensor sensor.toml -o picture.svg");
    folder.write("places.csv", &places(24, ""));
    folder.write(
        "mask.csv",
        &MASK.replace("1,1,1,1,1,0\n1,1,1,1,0,0", "1,1,1,1,1,0\n1,1,2,1,0,0"),
    );
    refused(&["population", "row 1, column 2", "is 2"]);
    folder.write("mask.csv", "1,1,1\n1,1,1\n");
    refused(&["mask.csv"]);
    folder.write("mask.csv", &"0,0,0,0,0,0\n".repeat(4));
    refused(&["none of the 24"]);
    folder.write("mask.csv", MASK);
    folder.write(
        "p.csv",
        "recording,frame,row,column,load_g\nr.txt,0,1,5,100\n",
    );
    let run = folder.fails("calibrate --sensor sensor.toml --presses p.csv -o c.toml");
    assert!(
        run.to_string().contains("row 1, column 5 carries no taxel"),
        "{run}"
    );
}
