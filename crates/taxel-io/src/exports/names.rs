//! What a header may tell of a person: left out of everything that is written.

/// Keys of names and birthdays, in small letters and languages met; and of paths, which hold names more often than not.
const KEYS: [&str; 30] = [
    "person",
    "patient",
    "patient name",
    "subject",
    "client",
    "athlete",
    "name",
    "first name",
    "firstname",
    "last name",
    "lastname",
    "surname",
    "given name",
    "vorname",
    "nachname",
    "prénom",
    "nom",
    "born",
    "birthday",
    "birthdate",
    "birth date",
    "date of birth",
    "dob",
    "geboren",
    "geburtsdatum",
    "code",
    "record",
    "file",
    "file name",
    "filename",
];

/// Stands for what was left out.
const LEFT_OUT: &str = "(left out)";

/// A header with the values of such keys left out.
pub(super) fn without_names(header: &str) -> String {
    let lines: Vec<String> = header.lines().map(without_name).collect();
    lines.join("\n")
}

fn without_name(line: &str) -> String {
    for separator in [':', '\t', ',', ';', '=', ' '] {
        let Some((key, value)) = line.split_once(separator) else {
            continue;
        };
        let word = key.trim().trim_matches('"').to_lowercase();
        let is_path = value.contains('\\') && value.contains('.');
        if (KEYS.contains(&word.as_str()) || is_path) && !value.trim().is_empty() {
            return format!("{key}{separator} {LEFT_OUT}");
        }
        // The first of them parts key and value, but for blanks within a key.
        if separator != ' ' && is_path {
            break;
        }
    }
    line.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_birthdays_and_paths_are_left_out_and_nothing_else() {
        let header = "Person\tnor, mal\nSex\tF\nPatient name: Anna Muster\nFirst name: Anna\nFILENAME C:\\data\\anna.fsx\n\
            File:,\"C:\\Users\\anna\\walk.XSN\",,\nCALIBRATION_INFO C:\\data\\anna.fsx\nROWS 60\nUnits:,mmHg\nBorn\t\nfile name: anna.sol\tdate/time 25.04.23";
        let kept = without_names(header);
        for name in ["nor", "Anna", "anna", "Muster"] {
            assert!(!kept.contains(name), "{name}: {kept}");
        }
        for line in ["Sex\tF", "ROWS 60", "Units:,mmHg", "Born\t"] {
            assert!(kept.lines().any(|kept| kept == line), "{line}: {kept}");
        }
    }
}
