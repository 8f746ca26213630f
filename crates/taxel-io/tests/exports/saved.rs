//! What programs and spreadsheets may write as well: read, or told by the name of its format.

use taxel_io::{exports, sensor_toml_of};

use super::*;

#[test]
fn pliance_with_the_words_of_pedar() {
    let folder = Folder::new();
    let text = latin(&cut("pliance.asc")).replace("mat type s2160_001", "sensor type: S2073_11");
    near(
        &sums(&folder.write("p.asc", text)),
        &[4245.002, 4248.335, 4241.669],
        1e-6,
    );
}

const FOOT: &str = "Rectangle width\t2\nRectangle height\t1\n\nFrame 0 (0.00 ms)\n0.5\t1.5\n\nFrame 1 (4.00 ms)\n2.5\t3.5\n\n";

#[test]
fn rsscan_files_of_two_feet() {
    let folder = Folder::new();
    let right = FOOT
        .replace("width\t2", "width\t3")
        .replace(".5\n", ".5\t4.0\n");
    let text = format!("Dynamic Roll off\nLeft foot data\n\n{FOOT}Right foot data\n\n{right}");
    let file = folder.write("r.txt", &text);
    let error = exports::sensor_of(&file).unwrap_err().to_string();
    assert!(error.contains("holds 2 sensors: left, right"), "{error}");
    let [left, right] = ["left", "right"].map(|foot| file.with_file_name(format!("r.txt#{foot}")));
    near(&sums(&left), &[2.0, 6.0], 1e-9);
    near(&sums(&right), &[6.0, 10.0], 1e-9);
    assert_eq!(missing_of(&left) + &missing_of(&right), "");
    // A foot's broken frame is none of the other's.
    let file = folder.write("r.txt", text.replace("2.5\t3.5\n", "2.5\n"));
    let left = file.with_file_name("r.txt#left");
    let kept = read_with(&left, &sensor_of(&left), true);
    assert_eq!((kept.frames.len(), kept.left_out.len()), (1, 1));
    near(
        &sums(&file.with_file_name("r.txt#right")),
        &[6.0, 10.0],
        1e-9,
    );
    // One foot alone has its name, and needs none.
    let file = folder.write("r.txt", format!("Right foot data\n\n{FOOT}"));
    near(&sums(&file), &[2.0, 6.0], 1e-9);
    near(
        &sums(&file.with_file_name("r.txt#right")),
        &[2.0, 6.0],
        1e-9,
    );
}

#[test]
fn files_that_a_spreadsheet_has_saved() {
    let folder = Folder::new();
    let rsscan = &FOOT[FOOT.find("Frame 0").unwrap()..];
    let pedar = std::fs::read_to_string(whole_pedar(&folder)).unwrap();
    let zebris = latin(&cut("zebris.txt"));
    let fsa = vec!["7.5"; 2048].join("\t") + "\n";
    for (name, pad, text, expected) in [
        ("r.csv", "", rsscan.replace('\t', ","), vec![2.0, 6.0]),
        (
            "r.csv",
            "",
            rsscan.replace('\t', ";").replace('.', ","),
            vec![2.0, 6.0],
        ),
        (
            "pedar.asc",
            "#left",
            pedar.replace('\t', ","),
            vec![1980.0, 2020.0, 2002.5, 2035.0],
        ),
        (
            "pedar.asc",
            "#right",
            pedar.replace('\t', ";").replace('.', ","),
            vec![2670.0, 2695.0, 2702.5, 2727.5],
        ),
        ("z.csv", "", zebris.replace('\t', ";"), vec![972.5, 887.0]),
        ("f.txt", "", fsa.clone(), vec![15360.0]),
        (
            "f.csv",
            "",
            fsa.replace('\t', ";").replace('.', ","),
            vec![15360.0],
        ),
    ] {
        let file = folder.write(name, text);
        let found = sums(&file.with_file_name(format!("{name}{pad}")));
        near(&found, &expected, 1e-6);
    }
    // Matrices need no quotes where no comma parts the cells; numbers may have a power of ten.
    let cells = vec!["1.0e+01"; 495].join(", ");
    for (one, quote) in [(";", ""), ("\t", "\""), (",", "\"")] {
        let text = format!("time{one}Matrix_0\n0.5{one}{quote}[{cells}]{quote}\n");
        near(&sums(&folder.write("i.csv", text)), &[4950.0], 0.0);
    }
    // Counts of one's own are no newtons.
    let own = folder.write(
        "own.csv",
        "Frame 0 (0 ms)\n1,2\n3,4\n\nFrame 1 (10 ms)\n1,2\n3,4\n",
    );
    assert!(!exports::is_export(&own));
}

#[test]
fn xsensor_cells_without_a_sensel() {
    let folder = Folder::new();
    let frame = |number: u32, rows: &str| {
        format!(
            "FRAME,{number}\nTime, 08:21:1{number}\nSENSOR,S\nRows,2\nColumns,3\nSENSELS\n{rows}\n"
        )
    };
    for none in ["", "-", "-1", "NaN"] {
        let rows = [["1", "2"], ["3", "4"]].map(|[a, b]| format!("{none},{a},2\n4,{b},{none}"));
        let text = format!("Units:,mmHg\n{}{}", frame(1, &rows[0]), frame(2, &rows[1]));
        let file = folder.write("x.csv", &text);
        near(&sums(&file), &[9.0, 13.0], 0.0);
        assert_eq!(sensor_of(&file).taxels(), 4, "{none}");
        // What only one frame lacks was lost.
        let error = error_of(&folder.write("x.csv", text.replace("4,4,", &format!("{none},4,"))));
        assert!(error.contains("value 1 of 3 is"), "{none}: {error}");
    }
}

#[test]
fn emed_with_long_summaries_before_its_pictures() {
    let folder = Folder::new();
    let text = latin(&cut("emed.lst"));
    let rows: String = (1..96)
        .map(|row| format!("{row}{}\n", "\t0.00".repeat(65)))
        .collect();
    let page =
        |name: &str| format!("\tMatrix: 64x95\n\tSensor area: 0.25 cm2\n\t{name}\n{rows}\x0c");
    let file = folder.write(
        "e.lst",
        [page("MPP"), page("MVP"), page("MPP"), text].concat(),
    );
    near(&sums(&file), &[32695.0, 32745.0, 32665.0], 0.0);
    let header = spec_of(&file).exported.unwrap().header.unwrap();
    assert!(!header.contains("0.00\t0.00"), "{header}");
}

#[test]
fn headers_of_other_languages_are_known_for_what_they_are() {
    let folder = Folder::new();
    let zebris = latin(&cut("zebris.txt"))
        .replace("Frequency", "Frequenz")
        .replace("Count", "Anzahl")
        .replace("Platform", "Plattform")
        .replace("Columns", "Spalten");
    let pedar = "Dateiname: a\nDruckwerte in kPa\nZeit[s]\t1\t2\t1\t2\n0.01\t1\t2\t3\t4\n";
    let emed = latin(&cut("emed.lst")).replace("Sensor area", "Sensorfläche");
    let emed = emed.replace("Pict-No.", "Bild-Nr.");
    let rsscan = FOOT.replace("Frame", "Bild");
    for (name, text, says) in [
        ("z.txt", zebris, "zebris FDM"),
        ("p.asc", pedar.to_owned(), "pedar, pliance or emed"),
        ("e.lst", emed, "pedar, pliance or emed"),
        ("r.txt", rsscan, "RSscan"),
    ] {
        let error = error_of(&folder.write(name, text));
        assert!(
            error.contains(says) && error.contains("set to English") && error.contains(name),
            "{error}"
        );
        assert!(!error.contains("line 0"), "{error}");
    }
}

/// What is in a file goes before what it is called.
#[test]
fn exports_under_the_names_of_recordings() {
    let folder = Folder::new();
    let bytes = std::fs::read(cut("fscan.asf")).unwrap();
    for name in ["a.npy", "a.npz", "a.mcap", "a.parquet"] {
        let file = folder.write(name, &bytes);
        near(&sums(&file), &[35389.0, 35819.0, 34574.0], 0.0);
        assert!(sensor_toml_of(&file).unwrap().is_some(), "{name}");
    }
    for (name, bytes) in [
        ("b.npz", &b"PK\x03\x04"[..]),
        ("b.npy", b"\x93NUMPY"),
        ("b.mcap", b""),
    ] {
        assert!(!exports::is_export(&folder.write(name, bytes)), "{name}");
    }
}

/// Every cell between quotes, as some spreadsheets save: commas stand inside of them.
fn between_quotes(text: &str, from: char, to: &str) -> String {
    let line = |line: &str| {
        let cells = line
            .split(from)
            .map(|cell| format!("\"{}\"", cell.trim_matches('"')));
        cells.collect::<Vec<_>>().join(to)
    };
    text.lines()
        .map(|own| line(own.trim_end_matches('\r')) + "\r\n")
        .collect()
}

#[test]
fn cells_between_quotes() {
    let folder = Folder::new();
    let zebris = latin(&cut("zebris.txt"));
    for part in ["\t", ";", ","] {
        let file = folder.write("z.csv", between_quotes(&zebris, '\t', part));
        near(&sums(&file), &[972.5, 887.0], 1e-6);
        near(&forces(&file), &forces(&cut("zebris.txt")), 1e-9);
    }
    // Without quotes where none are needed.
    let plain = between_quotes(&zebris, '\t', ",");
    let plain: String = plain
        .split('"')
        .map(|cell| {
            if cell.len() > 1 && cell.contains(',') {
                format!("\"{cell}\"")
            } else {
                cell.to_owned()
            }
        })
        .collect();
    near(&sums(&folder.write("z.csv", plain)), &[972.5, 887.0], 1e-6);
    let fsa = vec!["7"; 2048].join("\t") + "\n";
    for part in ["\t", ";", ","] {
        let file = folder.write("f.csv", between_quotes(&fsa, '\t', part));
        near(&sums(&file), &[14336.0], 0.0);
        near(
            &sums(&folder.write("f.csv", fsa.replace('\t', part))),
            &[14336.0],
            0.0,
        );
    }
}

#[test]
fn tekscan_lines_between_quotes_as_a_whole() {
    let folder = Folder::new();
    for name in ["fscan.asf", "iscan.csv"] {
        let text = latin(&cut(name));
        let expected = sums(&cut(name));
        let whole = |blank: &str, behind: &str| -> String {
            let line = |line: &str| match line.trim_end_matches('\r') {
                "" => format!("{blank}\n"),
                line => format!("\"{line}\"{behind}\n"),
            };
            text.lines().map(line).collect()
        };
        for text in [
            whole("", ""),
            whole("\"\"", ""),
            whole("", ",,,"),
            between_quotes(&text, ',', ","),
            between_quotes(&text, ',', ";"),
        ] {
            let file = folder.write(name, text);
            near(&sums(&file), &expected, 0.0);
            let sensor = sensor_of(&file);
            let own = sensor_of(&cut(name));
            assert_eq!(
                (sensor.taxels(), sensor.rows()),
                (own.taxels(), own.rows()),
                "{name}"
            );
        }
    }
}

#[test]
fn novel_spells_the_unit_of_its_times_in_several_ways() {
    let folder = Folder::new();
    let pedar = std::fs::read_to_string(whole_pedar(&folder)).unwrap();
    let pliance = latin(&cut("pliance.asc"));
    for [names, unit] in [
        ["time [secs]", " [secs]"],
        ["Time [s]", "[s]"],
        ["time[sec]", " [sec]"],
    ] {
        let spell = |text: &str| text.replace("time[secs]", names).replace(" [secs]", unit);
        let file = folder.write("pedar.asc", spell(&pedar));
        let left = file.with_file_name("pedar.asc#left");
        near(&sums(&left), &[1980.0, 2020.0, 2002.5, 2035.0], 1e-6);
        assert_eq!(missing_of(&left), "");
        let times = |file: &Path| read(file)[1].frame.time_secs;
        assert_eq!(times(&left), Some(0.02));
        let file = folder.write("pliance.asc", spell(&pliance));
        near(&sums(&file), &sums(&cut("pliance.asc")), 0.0);
        near(&forces(&file), &forces(&cut("pliance.asc")), 0.0);
    }
}

/// The keys of XSENSOR's blocks in English, and in another language; those that say a unit keep it.
const ENGLISH: [&str; 12] = [
    "Units:",
    "Threshold:",
    "FRAME",
    "Time",
    "SENSOR",
    "Rows",
    "Columns",
    "Sensel Width",
    "Sensel Height",
    "Est. Load",
    "SENSELS",
    "GROUP",
];
#[rustfmt::skip]
const OTHERS: [[&str; 12]; 4] = [
    ["Einheiten:", "Schwellwert:", "BILD", "Zeit", "SENSOR", "Zeilen", "Spalten", "Sensel-Breite", "Sensel-Höhe", "Geschätzte Last", "SENSELS", "GRUPPE"],
    ["Unités:", "Seuil:", "IMAGE", "Heure", "CAPTEUR", "Rangées", "Colonnes", "Largeur de sensel", "Hauteur de sensel", "Charge est.", "CELLULES", "GROUPE"],
    ["Unidades:", "Umbral:", "CUADRO", "Hora", "SENSOR", "Filas", "Columnas", "Ancho de celda", "Alto de celda", "Carga est.", "CELDAS", "GRUPO"],
    ["Eenheden:", "Drempel:", "FRAME", "Tijd", "SENSOR", "Rijen", "Kolommen", "Breedte", "Hoogte", "Gesch. belasting", "SENSELS", "GROEP"],
];

#[test]
fn xsensor_in_other_languages() {
    let folder = Folder::new();
    let english = std::fs::read_to_string(cut("xsensor.csv")).unwrap();
    let english = english.trim_start_matches('\u{FEFF}');
    let own = cut("xsensor.csv");
    let pads = |file: &Path| {
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        ["left", "right"].map(|pad| file.with_file_name(format!("{name}#{pad}")))
    };
    for words in OTHERS {
        // Every key that nothing is looked for in, too.
        let mut text: String = english
            .lines()
            .map(|line| {
                let known = ENGLISH.iter().zip(words);
                let found = known.clone().find(|(key, _)| line.starts_with(*key));
                match found {
                    Some((key, word)) => line.replacen(key, word, 1) + "\n",
                    None if line.starts_with(|c: char| c.is_alphabetic()) => format!("Ü{line}\n"),
                    None => format!("{line}\n"),
                }
            })
            .collect();
        assert_ne!(text, *english);
        text.insert(0, '\u{FEFF}');
        let file = folder.write("x.csv", text);
        for (file, own) in pads(&file).iter().zip(&pads(&own)) {
            near(&sums(file), &sums(own), 0.0);
            near(&forces(file), &forces(own), 0.0);
            let (spec, expected) = (spec_of(file), spec_of(own));
            assert_eq!(spec.array.pitch_mm, expected.array.pitch_mm, "{}", words[0]);
            let [found, expected] = [spec, expected].map(|spec| spec.exported.unwrap());
            assert_eq!(
                (found.unit, found.threshold),
                (expected.unit, expected.threshold)
            );
            let times = |file: &Path| -> Vec<_> {
                read(file)
                    .iter()
                    .map(|read| (read.number, read.frame.time_secs))
                    .collect()
            };
            assert_eq!(times(file), times(own), "{}", words[0]);
        }
    }
}
