//! The structure of a 2 × 2 netlist of every topology.

use super::*;

fn sensor(topology: &str, more: &str) -> Sensor {
    let text = format!(
        "format = 1\n[array]\nrows = 2\ncolumns = 2\n[readout]\ntopology = \"{topology}\"\n\
         v_test_volts = 0.4\nr_feedback_ohms = 2000.0\nopen_loop_gain = 100.0\n\
         r_pull_down_ohms = 1000.0\n{more}\n[converter]\nbits = 16\nfull_scale_volts = 2.2\n"
    );
    Sensor::from_toml(&text).unwrap()
}

const SWITCHES: &str = "r_mux_column_ohms = [5, 6]\nr_mux_row_ohms = [7, 8]";

fn pressed() -> Frame<Siemens> {
    Frame::new(2, 2, vec![1e-3, 2e-3, 4e-3, 0.0]).unwrap()
}

fn text(topology: &str, selection: Selection) -> String {
    netlist(&sensor(topology, SWITCHES), &pressed(), selection).unwrap()
}

/// The netlist of taxel (1, 0): has all `lines`, and `elements` elements in all.
fn assert_elements(topology: &str, elements: usize, lines: &[&str]) {
    let text = text(topology, Selection::Taxel { row: 1, column: 0 });
    for line in lines {
        assert!(text.lines().any(|found| found == *line), "{line}\n{text}");
    }
    let found = text
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_uppercase()));
    assert_eq!(found.count(), elements, "{text}");
    for line in [
        "Vt drive 0 0.4",
        "Rd0 drive col0 5",
        "Rleakrow0 row0 0 1e12",
        "Rleakrow1 row1 0 1e12",
        "Rd1 drive col1 1e12",
        "Rt0_0 col0 row0 1000",
        "Rt0_1 col1 row0 500",
        "Rt1_0 col0 row1 250",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}\n{text}");
    }
    assert!(!text.contains("Rt1_1"), "a taxel of 0 S is left out");
}

const GROUNDED: [&str; 2] = ["Ru0 col0 0 1e12", "Ru1 col1 0 6"];

#[test]
fn tia_grounded_columns() {
    let lines = ["Rr0 row0 sense 1e12", "Rr1 row1 sense 8"];
    let amplifier = ["Rk sense out 2000", "Eamp out 0 0 sense 100"];
    let all = [lines, amplifier, GROUNDED].concat();
    assert_elements("tia-grounded-columns", 14, &all);
}

#[test]
fn tia_zero_potential() {
    let lines = ["Rr0 row0 sense0 7", "Rr1 row1 sense1 8"];
    let amplifiers = [
        "Rk0 sense0 out0 2000",
        "Eamp0 out0 0 0 sense0 100",
        "Rk1 sense1 out1 2000",
        "Eamp1 out1 0 0 sense1 100",
        "Eread out 0 out1 0 1",
    ];
    let all = [&lines[..], &amplifiers[..], &GROUNDED[..]].concat();
    assert_elements("tia-zero-potential", 17, &all);
}

const ROWS: [&str; 3] = ["Rr0 row0 out 1e12", "Rr1 row1 out 8", "Rp out 0 1000"];

#[test]
fn divider_grounded_columns() {
    let all = [&ROWS[..], &GROUNDED[..]].concat();
    assert_elements("divider-grounded-columns", 13, &all);
}

#[test]
fn divider_floating() {
    let leaks = ["Rleakcol0 col0 0 1e12", "Rleakcol1 col1 0 1e12"];
    assert_elements("divider-floating", 13, &[&ROWS[..], &leaks[..]].concat());
}

#[test]
fn divider_voltage_feedback() {
    let follower = [
        "Ru0 col0 follower 1e12",
        "Ru1 col1 follower 6",
        "Efollow follower 0 out 0 1",
    ];
    let all = [&ROWS[..], &follower[..]].concat();
    assert_elements("divider-voltage-feedback", 14, &all);
}

#[test]
fn a_source_resistor_stands_before_the_column_multiplexer() {
    let sensor = sensor(
        "divider-floating",
        &format!("{SWITCHES}\nr_source_ohms = 90"),
    );
    let text = netlist(&sensor, &pressed(), Selection::Scan).unwrap();
    assert!(text.contains("\nVt source 0 0.4\n") && text.contains("\nRv source drive 90\n"));
}

#[test]
fn a_scan_moves_the_switches_and_reads_every_taxel() {
    let script: Vec<String> = text("tia-grounded-columns", Selection::Scan)
        .lines()
        .filter_map(|line| line.strip_prefix("*# "))
        .filter(|line| line.starts_with("alter") || line.starts_with("echo"))
        .map(str::to_owned)
        .collect();
    let column_1 = ["rd0 = 1e12", "rd1 = 6", "ru0 = 5", "ru1 = 1e12"];
    let column_0 = ["rd1 = 1e12", "rd0 = 5", "ru1 = 6", "ru0 = 1e12"];
    let row_1 = ["rr0 = 1e12", "rr1 = 8"];
    let alter = |lines: &[&str]| lines.iter().map(|l| format!("alter {l}")).collect();
    let echo = |r, c| vec![format!("echo -n \"taxel {r} {c} \"")];
    let expected: Vec<Vec<String>> = vec![
        echo(0, 0),
        alter(&column_1),
        echo(0, 1),
        alter(&column_0),
        alter(&row_1),
        echo(1, 0),
        alter(&column_1),
        echo(1, 1),
    ];
    assert_eq!(script, expected.concat());
}

#[test]
fn one_amplifier_a_row_is_read_where_it_stands() {
    let text = text(
        "tia-zero-potential",
        Selection::Taxels(vec![(1, 1), (0, 1)]),
    );
    let prints: Vec<&str> = text.lines().filter(|l| l.contains("print")).collect();
    assert_eq!(prints, ["*# print v(out1)", "*# print v(out0)"]);
    assert!(!text.contains("alter"), "rows have no switch to move");
}

#[test]
fn unknown_switches_and_impossible_requests_are_refused() {
    let known = sensor("divider-floating", SWITCHES);
    let refused = |sensor: &Sensor, frame: &Frame<Siemens>, selection| {
        netlist(sensor, frame, selection).unwrap_err().to_string()
    };
    let unknown = sensor("divider-floating", "r_mux_column_ohms = 5.0");
    let error = refused(&unknown, &pressed(), Selection::Scan);
    assert!(error.contains("r_mux_row_ohms"), "{error}");
    let error = refused(&known, &Frame::zeros(2, 3), Selection::Scan);
    assert!(error.contains('4') && error.contains('6'), "{error}");
    let outside = Selection::Taxel { row: 0, column: 2 };
    let error = refused(&known, &pressed(), outside);
    assert!(error.contains("selected column"), "{error}");
    let error = refused(&known, &pressed(), Selection::Taxels(Vec::new()));
    assert!(error.contains("number of selected"), "{error}");
    let error = refused(&known, &Frame::filled(2, 2, f64::NAN), Selection::Scan);
    assert!(error.contains("conductance"), "{error}");
}

#[test]
fn a_crossing_without_a_taxel_has_no_resistor_and_is_not_scanned() {
    let sensor = sensor("divider-floating", SWITCHES)
        .edited(|spec| {
            let lines = vec![vec![1.0, 0.0], vec![1.0, 1.0]];
            spec.array.population = Some(crate::sensor::Population::Each(lines));
        })
        .unwrap();
    let text = netlist(&sensor, &pressed(), Selection::Scan).unwrap();
    assert!(
        text.contains("Rt0_0 ") && !text.contains("Rt0_1 "),
        "{text}"
    );
    assert!(
        text.contains("taxel 1 1") && !text.contains("taxel 0 1"),
        "{text}"
    );
}

#[test]
fn a_diode_stands_before_its_taxel_or_behind_its_driver() {
    let diode = |topology: &str, place: &str| {
        let table = format!(
            "{SWITCHES}\n[readout.diode]\nplace = \"{place}\"\npart = \"BAT54\"\ntemperature_celsius = 27.0"
        );
        let selection = Selection::Taxels(vec![(1, 0), (1, 1)]);
        netlist(&sensor(topology, &table), &pressed(), selection).unwrap()
    };
    let model = ".model dio d(is=2e-7 n=1.05)";
    let has = |text: &str, lines: &[&str]| {
        for line in lines {
            assert!(text.lines().any(|found| found == *line), "{line}\n{text}");
        }
    };
    let taxels = diode("tia-grounded-columns", "taxel");
    let all = ["Dt0_0 col0 mid0_0 dio", "Rt0_0 mid0_0 row0 1000", model];
    has(&taxels, &all);
    assert!(!taxels.contains("Dt1_1"), "a taxel of 0 S is left out");
    let lines = diode("divider-pulled-rows", "driven-line");
    let all = [
        "Dd0 driver0 col0 dio",
        "Rds0_0 driver0 drive 5",
        "Rrest0 driver0 0 1e12",
        "Rrest1 driver1 0 1",
        "*# alter rrest0 = 1",
        "*# alter rrest1 = 1e12",
        model,
    ];
    has(&lines, &all);
}
