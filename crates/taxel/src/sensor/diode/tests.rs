use super::*;
use crate::sensor::{Sensor, preset};

fn with(preset_name: &str, diode: &str) -> Result<Sensor, Error> {
    let text = preset(preset_name).unwrap().to_toml();
    Sensor::from_toml(&text.replace(
        "[converter]",
        &format!("[readout.diode]\n{diode}\n\n[converter]"),
    ))
}

fn refused(preset_name: &str, diode: &str, words: &[&str]) {
    let error = with(preset_name, diode).unwrap_err().to_string();
    for word in words {
        assert!(error.contains(word), "{diode}: {word} in {error}");
    }
}

#[test]
fn a_part_is_its_numbers_and_warms_up_as_spice_has_it() {
    let cold = with("econe", "place = \"taxel\"\npart = \"1n-4148\"").unwrap();
    let diode = cold.readout().diode.unwrap();
    assert_eq!((diode.saturation_amperes, diode.emission), (2.52e-9, 1.752));
    // ngspice 39, .model dio d(is=2.52n n=1.752 xti=3 eg=1.11) at 27 °C and 60 °C: 1 mA drops this much.
    let drop = |diode: &Diode| diode.scale_volts() * (1e-3 / diode.saturation_amperes).ln_1p();
    let warm = with(
        "econe",
        "place = \"taxel\"\npart = \"1N4148\"\ntemperature_celsius = 60",
    );
    let warm = warm.unwrap().readout().diode.unwrap();
    for (diode, volts) in [(&diode, 0.584_171_5), (&warm, 0.517_377_03)] {
        assert!((drop(diode) - volts).abs() < 1e-6, "{}", drop(diode));
    }
}

#[test]
fn numbers_that_no_diode_has_are_refused_in_words() {
    let numbers = |i_s: &str, n: &str| {
        format!("place = \"taxel\"\nsaturation_amperes = {i_s}\nemission = {n}")
    };
    refused(
        "econe",
        &numbers("0.0", "1.7"),
        &["saturation_amperes", "is 0", "above 0"],
    );
    refused(
        "econe",
        &numbers("-1e-9", "1.7"),
        &["saturation_amperes", "above 0"],
    );
    refused("econe", &numbers("nan", "1.7"), &["saturation_amperes"]);
    refused(
        "econe",
        &numbers("1e-9", "0.4"),
        &["emission", "0.4", "0.5 to 3"],
    );
    refused(
        "econe",
        &numbers("1e-9", "3.1"),
        &["emission", "3.1", "0.5 to 3"],
    );
    refused("econe", "place = \"taxel\"", &["saturation_amperes", "I_s"]);
    let kelvin = numbers("1e-9", "1.7") + "\ntemperature_celsius = 300";
    refused(
        "econe",
        &kelvin,
        &["temperature_celsius", "300", "looks like kelvin"],
    );
    refused(
        "econe",
        "place = \"taxel\"\npart = \"1N4184\"",
        &["1N4184", "did you mean `1N4148`?"],
    );
    let both = "place = \"taxel\"\npart = \"1N4148\"\nemission = 1.7";
    refused("econe", both, &["part", "emission"]);
    refused(
        "econe",
        "place = \"taxle\"\npart = \"1N4148\"",
        &["taxle", "did you mean `taxel`?"],
    );
    refused(
        "econe",
        "place = \"taxel\"\npart = \"1N4148\"\nn = 2",
        &["unknown", "`n`"],
    );
}

#[test]
fn read_outs_that_no_diode_fits_in_are_refused_in_words() {
    let driven = "place = \"driven-line\"\npart = \"1N4148\"";
    refused("econe", driven, &["driven-line", "divider-pulled-rows"]);
    for (part, celsius, fits) in [
        ("1N4148", 85, true),
        ("BAT54", 27, true),
        ("BAT54", 60, false),
        ("1N5817", 27, false),
    ] {
        let warm =
            format!("place = \"driven-line\"\npart = \"{part}\"\ntemperature_celsius = {celsius}");
        let text = preset("mat-32x32-adg732").unwrap().to_toml();
        let text = text.replace("tia-grounded-columns", "tia-zero-potential");
        let text = text.replace(
            "[converter]",
            &format!("[readout.diode]\n{warm}\n\n[converter]"),
        );
        let straight = Sensor::from_toml(&text).unwrap();
        let resisting =
            straight.edited(|spec| spec.readout.r_line_row_ohms = Some(PerLine::One(2.0)));
        let told = resisting.map_err(|error| error.to_string());
        assert_eq!(told.is_ok(), fits, "{part} at {celsius}: {told:?}");
        assert!(
            told.err()
                .is_none_or(|told| told.contains("µA per driven line"))
        );
    }
    let taxel = "place = \"taxel\"\npart = \"1N4148\"";
    let sheet = with("econe", taxel).unwrap().edited(|spec| {
        let material = spec.material.as_mut().unwrap();
        material.sheet = Some(crate::sensor::SheetSpec::new(10e3, 3.0));
    });
    assert!(sheet.unwrap_err().to_string().contains("material.sheet"));
    let lines = with("mat-16x16-cd4067", taxel)
        .unwrap()
        .edited(|spec| spec.readout.r_line_row_ohms = Some(PerLine::One(2.0)));
    let lines = lines.unwrap_err().to_string();
    assert!(
        lines.contains("r_line_row_ohms") && lines.contains("divider-floating"),
        "{lines}"
    );
}
