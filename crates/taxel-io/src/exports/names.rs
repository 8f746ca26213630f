//! What a header may tell of a person: left out of everything that is written.

mod known;

use super::tekscan::keys::is_key;

/// Keys, as a whole, whose values are names more often than not.
const KEYS: [&str; 7] = [
    "code",
    "record",
    "file",
    "file name",
    "filename",
    "trial",
    "comment",
];
/// Words of keys that are about a person, in small letters and languages met.
#[rustfmt::skip]
const WORDS: [&str; 84] = [
    "name", "names", "person", "persons", "personne", "persona", "pessoa", "persoon", "osoba",
    "subject", "subjects", "sujet", "sujeto", "sujeito", "soggetto", "onderwerp", "pt", "pat",
    "client", "clients", "cliente", "klient", "klant", "kunde", "usager", "usuario", "usuário",
    "utente", "utilisateur", "user", "participant", "participante", "teilnehmer", "deelnemer",
    "volunteer", "volontaire", "voluntario", "volontario", "freiwillige", "sportler", "runner",
    "operator", "operateur", "opérateur", "operador", "operatore", "bediener", "tester", "prüfer",
    "doctor", "docteur", "médecin", "medecin", "médico", "medico", "dottore", "doutor", "arts",
    "arzt", "ärztin", "therapeut", "therapist", "nom", "nome", "naam", "nombre", "navn", "namn",
    "nimi", "imię", "nazwisko", "jméno", "név", "cognome", "achternaam", "voornaam", "apellido",
    "apellidos", "sobrenome", "apelido", "born", "dob", "mail", "email",
];
/// The same of births and numbers of telephones.
#[rustfmt::skip]
const MORE_WORDS: [&str; 18] = [
    "né", "née", "nacido", "nacida", "nascido", "nascita", "nascimento", "nacimiento", "nato",
    "nata", "geboorte", "geboortedatum", "född", "født", "phone", "telephone", "telefon", "telefono",
];
/// The same within longer words, as in `Patientenname`, `PatientID`, `Geburtsdatum`.
#[rustfmt::skip]
const PARTS: [&str; 20] = [
    "patient", "patiënt", "pazient", "pacient", "pasient", "potilas", "proband", "athlet", "atlet",
    "examiner", "untersucher", "physician", "surname", "prenom", "prénom", "birth", "geboren",
    "geburt", "naissance", "versuchs",
];
/// Words that stand in such keys beside the ones above.
const BESIDE: [&str; 27] = [
    "first", "last", "full", "given", "family", "middle", "date", "day", "year", "of", "the",
    "and", "du", "de", "des", "del", "della", "di", "der", "le", "la", "id", "no", "nr", "number",
    "code", "e",
];
/// Things whose names are no person's.
const THINGS: [&str; 13] = [
    "sensor", "map", "mat", "device", "program", "software", "hardware", "plate", "platform",
    "mask", "group", "insole", "unit",
];
/// What parts a key from its value.
const SEPARATORS: [char; 5] = [':', '\t', ',', ';', '='];
/// Stands for what was left out.
const LEFT_OUT: &str = "(left out)";

/// A header with the values of such keys, paths of files, comments, and lines that nobody here knows left out.
pub(super) fn without_names(header: &str) -> String {
    let mut kept = Vec::new();
    let mut is_comment = false;
    let mut keys: Vec<&str> = Vec::new();
    for line in header.lines() {
        let word = line.split([' ', ':', '\t', ',', ';', '=']).next();
        let word = word.unwrap_or("");
        // A comment of Tekscan's stands on the lines behind its key, up to one that the header has not had yet.
        let is_next = is_key(word) && !keys.contains(&word);
        keys.push(word);
        if is_comment && !is_next {
            kept.push(LEFT_OUT.to_owned());
            continue;
        }
        is_comment = word.eq_ignore_ascii_case("comments");
        kept.push(without_name(line, is_comment));
    }
    kept.dedup_by(|own, before| own == before && own == LEFT_OUT);
    kept.join("\n")
}

/// A line without the value that is a person's, or a path's, or a comment.
fn without_name(line: &str, is_comment: bool) -> String {
    let end = line.find(SEPARATORS);
    let key = &line[..end.unwrap_or(line.len())];
    let personal = match end {
        Some(end) if is_comment => Some(end + 1),
        None if is_comment => Some(key.find(' ').unwrap_or(key.len())),
        _ => end_of_personal_key(key, end.is_some()),
    };
    let cut = personal.or_else(|| {
        let first = end.map_or_else(|| line.find(' '), Some)?;
        has_path(&line[first + 1..]).then_some(first + 1)
    });
    if cut.is_none() && !known::is_known(line) {
        return LEFT_OUT.to_owned();
    }
    match cut {
        Some(cut) if !line[cut..].trim().is_empty() => {
            format!("{} {LEFT_OUT}", line[..cut].trim_end_matches(' '))
        }
        _ => line.to_owned(),
    }
}

/// Where the value of a key begins that is about a person; `None` of any other. A key that `is_closed` by a separator goes up to
/// that, unless words stand in it that are none of a key's: a name behind a blank, and a comma in it.
fn end_of_personal_key(key: &str, is_closed: bool) -> Option<usize> {
    let words = words_of(key);
    let whole: Vec<&str> = words.iter().map(|(word, _)| word.as_str()).collect();
    let whole = whole.join(" ");
    if is_closed && KEYS.contains(&whole.as_str()) {
        return Some(key.len() + 1);
    }
    let has_thing = words
        .iter()
        .any(|(word, _)| THINGS.contains(&word.as_str()));
    let is_personal = |word: &str| match word {
        "name" => !has_thing,
        word => is_about_person(word),
    };
    let first = words.iter().position(|(word, _)| is_personal(word));
    let Some(first) = first else {
        // A key and its value, parted by a blank.
        let (word, end) = words.first()?;
        return (!is_closed && KEYS.contains(&word.as_str())).then_some(*end);
    };
    let is_of_key = |word: &str| is_personal(word) || BESIDE.contains(&word);
    // Without a separator the words before would be a value.
    if !is_closed && !words[..first].iter().all(|(word, _)| is_of_key(word)) {
        return None;
    }
    let behind = words[first..]
        .iter()
        .take_while(|(word, _)| is_of_key(word));
    let count = first + behind.count();
    if is_closed && count == words.len() {
        Some(key.len() + 1)
    } else {
        Some(words[count - 1].1)
    }
}

/// Whether a word of a key is about a person.
fn is_about_person(word: &str) -> bool {
    WORDS.contains(&word)
        || MORE_WORDS.contains(&word)
        || PARTS.iter().any(|part| word.contains(part))
        || word.ends_with("person")
        || word.ends_with("name") && !["filename", "mapname", "sensorname"].contains(&word)
}

/// The words of a key in small letters, each with where it ends: parted by whatever is no letter, and `FirstName` by its capital.
fn words_of(key: &str) -> Vec<(String, usize)> {
    let mut words = Vec::new();
    let mut word = String::new();
    let mut was_small = false;
    for (at, c) in key.char_indices() {
        let is_next = c.is_uppercase() && was_small;
        if (!c.is_alphanumeric() || is_next) && !word.is_empty() {
            words.push((std::mem::take(&mut word), at));
        }
        if c.is_alphanumeric() {
            word.extend(c.to_lowercase());
        }
        was_small = c.is_lowercase();
    }
    if !word.is_empty() {
        words.push((word, key.len()));
    }
    words
}

/// Whether a value has the path of a file in it.
fn has_path(value: &str) -> bool {
    let is_path = |word: &str| {
        let Some((folders, file)) = word.rsplit_once('/') else {
            return false;
        };
        let begins = word.strip_prefix('/').and_then(|rest| rest.chars().next());
        let is_rooted = begins.is_some_and(char::is_alphabetic) && word.matches('/').count() > 1
            || word.starts_with("~/");
        let ending = file.rsplit_once('.').map_or("", |(_, ending)| ending);
        let has_ending = ending.starts_with(char::is_alphabetic)
            && ending.len() <= 5
            && ending.chars().all(char::is_alphanumeric);
        is_rooted || has_ending && folders.contains(char::is_alphabetic)
    };
    let mut words = value.split(|c: char| c.is_whitespace() || matches!(c, '"' | ',' | ';' | '\''));
    value.contains('\\') || words.any(is_path)
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

    #[test]
    fn keys_of_persons_in_more_forms_and_languages() {
        for line in [
            "Patient: Anna",
            "Patientenname: Anna",
            "Subject name: Anna",
            "Full name: Anna",
            "Naam: Anna",
            "Nome: Anna",
            "Nom du patient: Anna",
            "Prénom: Anna",
            "Proband Anna",
            "OPERATOR Anna Muster",
            "PATIENT_NAME Anna",
            "PATIENT_ID,Anna",
            "NAME Anna, born 1980",
            "First name Anna",
            "LastName=Anna",
            "Apellidos: Anna",
            "Cognome;Anna",
            "Date of birth: Anna",
            "Birth: Anna",
            "Geburtsdatum\tAnna",
            "FILENAME Anna.fsx",
            "CALIBRATION_INFO /home/Anna/walk.cal",
            "CALIBRATION_INFO D:/Anna/walk.cal",
            "Source: data/Anna/walk.cal",
            "Client Name: Anna",
            "E-mail: Anna@x",
            "Examiner: Anna",
            "Vorname\tAnna",
            "Versuchsperson=Anna",
            "Untersucher: Dr. Anna",
            "Paciente: Anna",
            "Sujet: Anna",
            "PT_NAME Anna",
            "Utente Anna",
            "Nombre del paciente: Anna",
            "Naam van de patiënt: Anna",
            "Voornaam\tAnna",
            "TRIAL Anna_Muster_left",
            "Participant 7 Anna",
            // Keys that nobody here knows, and lines without any.
            "患者: Anna",
            "WALKER Anna",
            "Anna Muster, left",
            "Anna Muster, 34",
            "JOHN SMITH Anna",
            "Dynamic Roll off of Anna Muster",
        ] {
            let kept = without_names(line);
            assert!(!kept.contains("Anna"), "{line}: {kept}");
            assert!(kept.contains(LEFT_OUT), "{line}: {kept}");
        }
    }

    #[test]
    fn what_is_of_no_person_is_kept() {
        for line in [
            "UNITS KPa",
            "ROWS\t60",
            "SENSEL_AREA,25 mm2",
            "Sensor name: LX100",
            "Map name: F-Scan",
            "#\tName\tStart,sec\tLength,sec",
            "Time,ms\tPosition,m\tLi Kraft,N",
            "TIME Thursday, August 19, 2010 11:09:28 AM",
            "TIME 12/2/2019 6:21:52.34PM",
            "UnitPressure=N/cm2",
            "pressure values in  kPa",
            "Creation date\t23/05/2008 12:23:17",
            "total time [secs]:  15.050\ttime per frame [secs]:  0.01000",
            "MAP_VERSION 3.1",
            "SENSITIVITY Custom",
            "MY_KEY 7",
            "MaxSensorsX=32",
            "MY_SIDE: 70 mm",
            "}",
            "[Technical]",
            "12\t0.5\t0.7",
            "mat type s2160_001",
            "Right foot data",
            "",
        ] {
            assert_eq!(without_names(line), line);
        }
    }

    #[test]
    fn comments_are_left_out_up_to_the_next_key() {
        let kept = without_names("ROWS 2\nCOMMENTS:\nAnna walks\nand Bob, too\nUNITS KPa");
        assert_eq!(kept, "ROWS 2\nCOMMENTS:\n(left out)\nUNITS KPa");
        // Words in capitals end it as little as a key that has been there.
        let lines = "ROWS 2\nCOMMENTS:\nANNA SMITH born 1970\nROWS of Anna\nBOB JONES\nUNITS KPa";
        let kept = without_names(lines);
        assert_eq!(kept, "ROWS 2\nCOMMENTS:\n(left out)\nUNITS KPa");
        let kept = without_names("COMMENTS: Anna walks\nUNITS KPa");
        assert_eq!(kept, "COMMENTS: (left out)\nUNITS KPa");
    }
}
