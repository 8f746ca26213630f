//! What a header tells of persons is left out of all that is written.

use taxel_io::shape_of;

use super::*;

#[test]
fn no_name_of_a_header_is_written() {
    let folder = Folder::new();
    let names = "Patientenname: Anna Muster\nNom du patient: Anna Muster\nProband Muster\nPATIENT_NAME Anna Muster\nCALIBRATION_INFO /home/Anna/Muster.cal\nExaminer: Muster\nVorname\tAnna\nCOMMENTS:\nAnna Muster walks\nMuster: Anna";
    let text = format!(
        "ROWS 1\nCOLS 2\n{names}\nSENSEL_AREA 25 mm2\nUNITS KPa\nASCII_DATA @@\n\nFrame 1\n1,2\n\n@@\n"
    );
    let header = spec_of(&folder.write("a.asf", text))
        .exported
        .unwrap()
        .header
        .unwrap();
    assert!(
        !header.contains("Anna") && !header.contains("Muster"),
        "{header}"
    );
    for line in ["ROWS 1", "SENSEL_AREA 25 mm2", "UNITS KPa"] {
        assert!(header.lines().any(|own| own == line), "{header}");
    }
}

#[test]
fn comments_in_capitals_and_keys_that_nobody_knows() {
    let folder = Folder::new();
    let names = "COMMENTS:\nJOHN MUSTER born 1970 walks\nANNA MUSTER\nROWS of Muster";
    let keys = "Paciente: Muster\nPT_NAME Muster\nSujet: Muster\nTRIAL Muster_left\nMuster, 34";
    let text = format!(
        "{keys}\nROWS 1\nCOLS 2\n{names}\nUNITS KPa\nMY_KEY 7\nASCII_DATA @@\n\nFrame 1\n1,2\n\n@@\n"
    );
    let file = folder.write("a.asf", text);
    let exported = spec_of(&file).exported.unwrap();
    let header = exported.header.unwrap();
    for name in ["Muster", "MUSTER", "JOHN", "ANNA"] {
        assert!(!header.contains(name), "{header}");
    }
    assert!(header.contains("UNITS KPa") && header.contains("MY_KEY 7"));
    // The comment's own words are no keys.
    let sensor = sensor_of(&file);
    assert_eq!((sensor.rows(), sensor.columns()), (1, 2));
}

/// What is not understood may be a name: its place and its length are told.
#[test]
fn no_error_tells_a_name() {
    let folder = Folder::new();
    let file = folder.write("a.txt", "Patient Anna Muster, born 1970\nleft foot\n");
    let error = shape_of(&file).unwrap_err().to_string();
    assert!(
        error.contains("line 1, column 1 has 30 characters") && !error.contains("Anna"),
        "{error}"
    );
    let text = "ROWS 1\nCOLS 2\nUNITS KPa\nASCII_DATA @@\n\nAnna Muster\nFrame 1\n1,2\n\n@@\n";
    let error = error_of(&folder.write("a.asf", text));
    assert!(
        error.contains("a line of 11 characters at") && error.contains("line 6"),
        "{error}"
    );
    assert!(!error.contains("Anna"), "{error}");
}
