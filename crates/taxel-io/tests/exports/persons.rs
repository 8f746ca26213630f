//! What a header tells of persons is left out of all that is written.

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
