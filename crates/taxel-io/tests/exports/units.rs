//! Units of lengths, areas, times and loads, however a file writes them, and those that nobody knows.

use super::*;

fn pedcad(more: &str) -> String {
    format!(
        "[General]\nUnitPressure=N/cm2\n[Technical]\nSensCountX=1\nSensCountY=2\nLDistX=0.8\nLDistY=1\nMinIdx=0\nMaxIdx=1\nTimeDiff=0.5\n{more}\n[Data]\n3\t4\n[Data0]\n1\t2\n[Data1]\n3\t4\n"
    )
}

fn tekscan(header: &str, frame: &str) -> String {
    format!(
        "ROWS 1\nCOLS 2\nROW_SPACING 10 mm\nCOL_SPACING 10 mm\n{header}\nASCII_DATA @@\n\nFrame 1\n{frame}\n\n@@\n"
    )
}

#[test]
fn pedcad_says_its_units_of_length_and_time() {
    let folder = Folder::new();
    for (more, pitch_mm, secs) in [
        ("", [0.8, 1.0], 0.5e-3),
        ("UnitDistance=mm\nUnitTime=ms", [0.8, 1.0], 0.5e-3),
        ("UnitDistance=cm\nUnitTime=s", [8.0, 10.0], 0.5),
        ("UnitDistance=m\nUnitTime=S", [800.0, 1000.0], 0.5),
    ] {
        let file = folder.write("a.apd", pedcad(more));
        near(&spec_of(&file).array.pitch_mm, &pitch_mm, 1e-9);
        near(&[read(&file)[1].frame.time_secs.unwrap()], &[secs], 1e-12);
    }
    for (more, says) in [
        ("UnitDistance=ell", "unknown unit `ell` at"),
        ("UnitTime=weeks", "unknown unit `weeks` at"),
    ] {
        let error = error_of(&folder.write("a.apd", pedcad(more)));
        assert!(error.contains(says) && error.contains("line 11"), "{error}");
    }
}

#[test]
fn areas_of_tekscan_in_words_and_in_none() {
    let folder = Folder::new();
    for area in [
        "25 sq mm",
        "0.25 cm^2",
        "0.25 sq cm",
        "0.03875 in^2",
        "0.03875 sq in",
    ] {
        let file = folder.write(
            "a.asf",
            tekscan(&format!("SENSEL_AREA {area}\nUNITS KPa"), "1,2"),
        );
        near(&[spec_of(&file).array.taxel_area_mm2], &[25.0], 1e-3);
    }
    for area in ["25 ell2", "25", "mm2", "0 mm2"] {
        let file = folder.write(
            "a.asf",
            tekscan(&format!("SENSEL_AREA {area}\nUNITS KPa"), "1,2"),
        );
        let error = error_of(&file);
        assert!(
            error.contains(&format!("unknown unit `{area}`")) && error.contains("line 5"),
            "{error}"
        );
    }
    // Distances that are not told are those of squares.
    let text = tekscan("SENSEL_AREA 25 mm2\nUNITS KPa", "1,2")
        .replace("ROW_SPACING 10 mm\nCOL_SPACING 10 mm\n", "");
    near(
        &spec_of(&folder.write("a.asf", text)).array.pitch_mm,
        &[5.0, 5.0],
        0.0,
    );
}

/// A converter of eight bits gives no 760: the values are pressures whose unit is not told, or another.
#[test]
fn raw_counts_above_their_converter_are_none() {
    let folder = Folder::new();
    for (header, says) in [
        ("NOISE_THRESHOLD 3", "header tells no unit"),
        ("UNITS raw", "header says that they are raw"),
    ] {
        let error = error_of(&folder.write("a.asf", tekscan(header, "3,760")));
        assert!(error.contains(says) && error.contains("760 at"), "{error}");
        assert!(
            error.contains("line 9") && error.contains("0 to 255"),
            "{error}"
        );
        near(
            &sums(&folder.write("b.asf", tekscan(header, "3,255"))),
            &[258.0],
            0.0,
        );
    }
    // A number that was changed is told by the sum of its frame, and costs that frame alone.
    let frames = "3,255\n\nFrame 2,1,,,,,Raw Sum=,,258\n3,2555";
    let file = folder.write("c.asf", tekscan("UNITS raw", frames));
    let kept = read_with(&file, &sensor_of(&file), true);
    assert!(kept.error.is_none());
    assert_eq!((kept.frames.len(), kept.left_out.len()), (1, 1));
}

/// A comment may begin with the word of a key.
#[test]
fn the_unit_is_the_one_that_is_known() {
    let folder = Folder::new();
    let header = "COMMENTS:\nUNITS were checked\nUNITS KPa";
    let file = folder.write("a.asf", tekscan(header, "1,2"));
    assert_eq!(spec_of(&file).exported.unwrap().unit, "KPa");
    let error = error_of(&folder.write("a.asf", tekscan("UNITS were checked", "1,2")));
    assert!(error.contains("unknown unit `were checked`"), "{error}");
}

const XSENSOR: &str = "Units:,psi\n\nFRAME,1\nTime, 08:21:17.982\nSENSOR,LX100\nRows,1\nColumns,2\nSensel Width (in),0.5\nSensel Height (in),0.25\nEst. Load (lbf),10\nSENSELS\n1,2\n";

#[test]
fn xsensor_in_inches_millimetres_and_grams() {
    let folder = Folder::new();
    let file = folder.write("x.csv", XSENSOR);
    near(&spec_of(&file).array.pitch_mm, &[6.35, 12.7], 1e-9);
    let text = XSENSOR
        .replace("(in)", "(mm)")
        .replace("(lbf),10", "(g),1000");
    let file = folder.write("x.csv", text);
    near(&spec_of(&file).array.pitch_mm, &[0.25, 0.5], 1e-9);
    near(
        &[read(&file)[0].reference_newtons.unwrap()],
        &[9.80665],
        1e-9,
    );
}

#[test]
fn zebris_in_centimetres_and_with_names_between_quotes() {
    let folder = Folder::new();
    let text = latin(&cut("zebris.txt"))
        .replace("Cell width,mm\t8.47", "Cell width,cm\t0.847")
        .replace("Cell height,mm\t8.46", "Cell height,cm\t0.846")
        .replace(
            "\tLi Kraft,N\tRe Kraft,N",
            "\t\"Li Kraft,N\"\t\"Re Kraft,N\"",
        );
    assert!(text.contains("\"Re Kraft,N\"") && text.contains("width,cm"));
    let file = folder.write("z.txt", text);
    near(&spec_of(&file).array.pitch_mm, &[8.46, 8.47], 1e-9);
    near(&[read(&file)[0].reference_newtons.unwrap()], &[697.1], 1e-9);
}

/// Points and commas in one file: the second sign parts thousands.
#[test]
fn commas_that_part_thousands_in_other_formats() {
    let folder = Folder::new();
    let pedar = std::fs::read_to_string(whole_pedar(&folder)).unwrap();
    let pliance = latin(&cut("pliance.asc"));
    let of_pliance = pliance.replacen("13.83333   0.000", "13.83333   1,206", 1);
    let of_emed = latin(&cut("emed.lst")).replacen("\t20.00\t", "\t20,00\t", 1);
    for (name, pad, text) in [
        (
            "a.apd",
            "",
            pedcad("").replace("[Data0]\n1\t2", "[Data0]\n1,206\t0.5"),
        ),
        (
            "pedar.asc",
            "#left",
            pedar.replacen(" 32.500", "  1,206", 1),
        ),
        ("pliance.asc", "", of_pliance),
        ("emed.lst", "", of_emed),
    ] {
        let file = folder.write(name, text);
        let error = error_of(&file.with_file_name(format!("{name}{pad}")));
        assert!(
            error.contains("expected decimals behind a "),
            "{name}: {error}"
        );
        assert!(error.contains("parts thousands"), "{name}: {error}");
    }
}
