//! What the page's own decoder is tested with: one of each message and some frames, written from here to `testdata/`, and
//! read there by `web-tests/`. In the other direction, the requests in `testdata/requests.js` are what the page's types
//! allow, and are read here.
//!
//! `TAXEL_WRITE_TESTDATA=1 cargo test -p taxel-server wire` writes the files; without it they must be up to date.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::json;
use taxel::Sensor;
use taxel::sensor::{Geometry, Rings, preset};

use super::*;
use crate::Message;
use crate::command;

fn testdata(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("testdata")
        .join(name)
}

/// Writes the file where that is asked for; else it must have this content.
fn keep(name: &str, content: &[u8]) {
    let path = testdata(name);
    if std::env::var_os("TAXEL_WRITE_TESTDATA").is_some() {
        std::fs::write(&path, content).unwrap();
    }
    let there = std::fs::read(&path).unwrap_or_default();
    assert!(
        there == content,
        "{} is not what the server writes now: TAXEL_WRITE_TESTDATA=1 cargo test -p taxel-server wire",
        path.display()
    );
}

/// Four rows along a cone of three rings.
fn cone() -> Sensor {
    let mat = preset("mat-16x16-cd4067").unwrap();
    mat.edited(|spec| {
        (spec.array.rows, spec.array.columns) = (4, 3);
        spec.array.pitch_mm = [8.0, 10.0];
        spec.array.geometry = Some(Geometry::cone(Rings::Columns, [16.0, 12.0]));
    })
    .unwrap()
}

fn hello() -> Hello {
    let sensor = SensorFacts {
        pitch_mm: [2.0, 1.5],
        taxel_area_mm2: 5.0,
        cell_area_mm2: 3.0,
        bits: 16,
        max_count: 65535.0,
        has_load_law: true,
        regions: vec![
            RegionFacts {
                name: "thumb".to_owned(),
                boxes: vec![[0, 1, 1, 2]],
                windows: Vec::new(),
            },
            RegionFacts {
                name: "index".to_owned(),
                boxes: vec![[0, 1, 0, 0]],
                windows: vec![
                    RegionWindow {
                        frames: [0, 9],
                        boxes: vec![[0, 0, 0, 0]],
                    },
                    RegionWindow {
                        frames: [20, 29],
                        boxes: vec![[1, 1, 0, 0]],
                    },
                ],
            },
        ],
        calibration: Some("calibrated 2026-11-10 (12 days ago); not checked since".to_owned()),
        ..SensorFacts::new("a \"mat\" \u{2013} 2 × 3", 2, 3)
    };
    let range = SliderKind::Range {
        min: 0.1,
        max: 500.0,
        step: 0.1,
        logarithmic: true,
    };
    let slider = Slider {
        unit: "Ω".to_owned(),
        ..Slider::new("r_mux_row_ohms", "Row switch", range, 10.0)
    };
    let switch = Slider::new("dead_row", "Dead row", SliderKind::Switch, 1.0);
    Hello {
        methods: vec!["exact".to_owned(), "raw".to_owned()],
        can_record: true,
        sliders: vec![slider, switch],
        ..Hello::new(
            "taxel 0",
            sensor,
            SourceFacts::new("sim:econe?hand", SourceKind::Sim),
        )
    }
}

fn busy_state() -> State {
    let mut recording = RecordingStatus::new("recordings/grip.mcap");
    recording.frames = 250;
    recording.bytes = 4_096_000;
    recording.secs = 2.5;
    State {
        device: DeviceStatus::new(DeviceState::Live, "speaks taxel-1"),
        frames_per_second: 99.5,
        frames: 12_345,
        lost: 1,
        corrupt: 2,
        repeated: 3,
        skipped: 4,
        latency_ms: Latency::new(1.25, 4.5),
        clients: 2,
        tare: TareStatus::new(true, 1_795_255_200.5),
        recording: Some(recording),
        method: "exact".to_owned(),
        player: None,
        sliders: [
            ("dead_row".to_owned(), 1.0),
            ("r_mux_row_ohms".to_owned(), 10.0),
        ]
        .into(),
        bad_lines: BadLines::new(vec![1], vec![0, 2]).with_suspects(Vec::new(), vec![7]),
        grip: None,
        calibration: None,
    }
}

/// In the middle of a grip session.
fn grip_state() -> State {
    let measured = GripMeasured {
        max_newtons: 412.5,
        plateau_newtons: Some(380.25),
        variation_percent: Some(2.5),
        time_to_peak_secs: 0.75,
        total_newtons: 650.0,
        doubts: vec!["3 frames were lost".to_owned()],
    };
    let mut first = GripTrial::planned(GripHand::Right, 1);
    first.repeats = 1;
    first.accepted = Some(measured.clone());
    let grip = GripSession {
        phase: GripPhase::Rest,
        remaining_secs: Some(41.5),
        lasts_secs: Some(60.0),
        person: "P01".to_owned(),
        folder: "grips/P01/20261123-120000".to_owned(),
        trial: Some(1),
        trials: vec![first, GripTrial::planned(GripHand::Left, 1)],
        measured: Some(measured),
        protocol: GripProtocol {
            name: "maximal grip".to_owned(),
            posture: "seated, elbow at 90°".to_owned(),
            hold_secs: 8.0,
            rest_secs: 60.0,
            target_newtons: Some([100.0, 150.0]),
            force: "grip force".to_owned(),
        },
        warnings: vec!["the zero has drifted by 3 N".to_owned()],
        is_simulated: true,
        files: vec!["page.pdf".to_owned()],
        ..GripSession::default()
    };
    State {
        grip: Some(Box::new(grip)),
        ..State::default()
    }
}

/// In the middle of a guided calibration: a press stands elsewhere.
fn calibration_state() -> State {
    let mut asked = AskedPress::of_taxel(3, 5, 200.0);
    asked.is_among_others = true;
    asked.why = "this load tells most of the law and of the switches now".to_owned();
    let mut seen = SeenPress::new(3, 6);
    seen.standing = 0.5;
    seen.problem = "row 3, column 6 is pressed most, not row 3, column 5".to_owned();
    let mut taken = TakenPress::new(AskedPress::of_taxel(7, 7, 500.0));
    taken.says_g = Some(491.5);
    let mut left_out = TakenPress::new(AskedPress::of_all(5.0));
    left_out.left_out = "undone by the operator".to_owned();
    let calibration = CalibrationSession {
        phase: CalibrationPhase::Elsewhere,
        asked: Some(asked),
        seen: Some(seen),
        presses: vec![taken, left_out],
        progress: vec![
            HeldOutError::new(8, None),
            HeldOutError::new(9, Some((12.5, 2.25))),
        ],
        is_enough: false,
        advice: "held-out presses are 12.5 ± 2.3 g off".to_owned(),
        least_presses: 8,
        loads_g: vec![50.0, 200.0, 500.0],
        sensor: "mat 16x16".to_owned(),
        folder: "calibrations/2026-11-24-120000".to_owned(),
        output: "calibrated.toml".to_owned(),
        warnings: vec!["row 2: dead or flickering, not looked at".to_owned()],
        is_resumed: true,
        is_simulated: true,
        ..CalibrationSession::default()
    };
    State {
        calibration: Some(Box::new(calibration)),
        ..State::default()
    }
}

/// Of a sensor around a cone.
fn cone_hello() -> Hello {
    Hello {
        sensor: SensorFacts {
            pitch_mm: [8.0, 10.0],
            taxel_area_mm2: 40.0,
            cell_area_mm2: 80.0,
            has_load_law: true,
            handle: cone().handle().map(HandleFacts::new),
            ..SensorFacts::new("a cone", 4, 3)
        },
        ..hello()
    }
}

/// Of a recording, on a sensor whose taxels lie anywhere.
fn file_hello() -> Hello {
    let mut exported = ExportedFacts::new("numbers as another program has exported them");
    exported.unit = Some("kPa".to_owned());
    exported.per_siemens = 2e8;
    Hello {
        file: Some(FileFacts::new(500, 5.0)),
        ..Hello::new(
            "taxel 0",
            SensorFacts {
                positions_mm: Some(vec![Some([1.5, -2.0]), None]),
                exported: Some(exported),
                ..SensorFacts::new("", 1, 2)
            },
            SourceFacts::new("file:run.mcap", SourceKind::File),
        )
    }
}

fn file_state() -> State {
    let mut player = Player::new(500, 5.0);
    player.position_secs = 1.25;
    player.frame = 125;
    let mut failed = RecordingStatus::new("recordings/full.mcap");
    failed.error = Some("No space left on device (os error 28)".to_owned());
    State {
        device: DeviceStatus::new(DeviceState::Paused, "playing run.mcap"),
        player: Some(player),
        recording: Some(failed),
        ..State::default()
    }
}

fn details() -> Message {
    let known = TaxelDetails {
        sequence: 41,
        load: 0.25,
        raw: 0.75,
        counts: 1234,
        mark: 0,
        siemens: Some(1.5e-5),
        half_width_95_newtons: Some(0.0625),
        noise_only: true,
        ..TaxelDetails::at(1, 2)
    };
    let bad = TaxelDetails {
        mark: 1,
        ..TaxelDetails::at(0, 0)
    };
    let figures = FigureDetails {
        sequence: 41,
        total_newtons: 21.5,
        total_half_width_95_newtons: Some(0.75),
        contact_area_mm2: 12.5,
        contact_area_half_width_95_mm2: Some(2.5),
        ..FigureDetails::default()
    };
    Message::Details(Details {
        figures: Some(figures),
        ..Details::new(vec![known, bad])
    })
}

/// Only what a frame amounts to is looked at, and nothing bounds it.
fn details_of_nothing() -> Message {
    let figures = FigureDetails {
        sequence: 42,
        total_newtons: 210.0,
        contact_area_mm2: 12.5,
        noise_only: true,
        why_unbounded: "a taxel is at the converter's ceiling".to_owned(),
        ..FigureDetails::default()
    };
    Message::Details(Details {
        figures: Some(figures),
        ..Details::default()
    })
}

/// Of three frames, of which the second has no answer.
fn curve() -> Message {
    Message::Curve(Curve {
        method: "exact".to_owned(),
        secs: vec![0.0, 0.5, 1.25],
        total_newtons: vec![0.0, f32::NAN, 12.5],
        peak_kilopascals: vec![0.0, f32::NAN, 62.5],
        contact_area_mm2: vec![0.0, f32::NAN, 9.0],
    })
}

/// Each kind of message with the name and the type that the page's tests know it by.
fn all_messages() -> [(&'static str, &'static str, Message); 13] {
    let refused = Refused::because("3.0 N stand on the sensor: take the load off");
    let hello_of = |hello| Message::Hello(Box::new(hello));
    let state_of = |state| Message::State(Box::new(state));
    let answer = |id, result| Message::Answer(Answer::new(id, result));
    [
        ("hello", "Hello", hello_of(hello())),
        ("helloOfFile", "Hello", hello_of(file_hello())),
        ("helloOfCone", "Hello", hello_of(cone_hello())),
        ("state", "State", state_of(busy_state())),
        ("stateOfFile", "State", state_of(file_state())),
        ("stateOfGrip", "State", state_of(grip_state())),
        ("stateOfCalibration", "State", state_of(calibration_state())),
        (
            "event",
            "Event",
            Message::Event(Event::new(1_795_255_201.25, "let go")),
        ),
        ("details", "Details", details()),
        ("detailsUnbounded", "Details", details_of_nothing()),
        ("curve", "Curve", curve()),
        ("answer", "Answer", answer(7, Ok(Reply::saying("Tared")))),
        ("refusal", "Answer", answer(8, Err(refused))),
    ]
}

/// The page's type checker reads these as values of its own types: what one side alone has is an error there.
#[test]
fn messages_of_the_wire_are_those_that_the_page_is_tested_with() {
    let mut text = String::from(
        "// Written by crates/taxel-server/src/tests/wire.rs; see there. Not to be changed by hand.\n",
    );
    for (name, of, message) in all_messages() {
        let json = serde_json::to_string_pretty(&message).unwrap();
        let value: serde_json::Value = serde_json::from_str(&message.to_json()).unwrap();
        assert_eq!(
            value,
            serde_json::from_str::<serde_json::Value>(&json).unwrap()
        );
        write!(
            text,
            "\n/** @type {{Wire.{of}}} */\nexport const {name} = {json};\n"
        )
        .unwrap();
    }
    keep("messages.js", text.as_bytes());
}

fn frames() -> [(&'static str, FrameMessage); 3] {
    let full = FrameMessage {
        is_load: true,
        is_tared: true,
        sequence: (1 << 40) + 7,
        device_secs: Some(12.125),
        at: Some(UNIX_EPOCH + Duration::from_millis(1_795_255_200_250)),
        total_newtons: 21.5,
        grip_newtons: Some(17.25),
        peak_kilopascals: 101.25,
        contact_area_mm2: 12.5,
        centre: Some([0.5, 1.75]),
        outlier_share: 0.25,
        frames_per_second: 99.5,
        counts: vec![0, 1, 255, 256, 4660, 65535],
        raw: vec![-0.5, 0.0, 1.0, 2.5, 1e-9, 3.25],
        loads: vec![-0.25, 0.0, 0.5, 1.25, 2e-9, 20.0],
        marks: vec![0, 1, 2, 3, 4, 5],
        ..FrameMessage::new(2, 3)
    };
    // An odd number of taxels: the loads are padded to a multiple of four bytes. Of much nothing is known.
    let odd = FrameMessage {
        is_load: true,
        is_raw: true,
        sequence: 3,
        counts: vec![1, 2, 3],
        marks: vec![6, 7, 9],
        ..FrameMessage::new(1, 3)
    };
    let siemens = FrameMessage {
        loads: vec![1.5e-5, 2.5e-5],
        raw: vec![1e-5, 2e-5],
        marks: vec![8, 0],
        ..FrameMessage::new(2, 1)
    };
    [("full", full), ("odd", odd), ("siemens", siemens)]
}

/// What the page must read out of the bytes; null is no number there.
fn expected(frame: &FrameMessage, now: SystemTime) -> serde_json::Value {
    let since = |at: SystemTime| at.duration_since(UNIX_EPOCH).unwrap().as_secs_f64();
    let age = |at| 1e3 * now.duration_since(at).unwrap().as_secs_f64();
    json!({
        "rows": frame.rows, "columns": frame.columns, "sequence": frame.sequence,
        "newtons": frame.is_load, "tared": frame.is_tared, "rawMethod": frame.is_raw,
        "device": frame.device_secs, "host": frame.at.map(since), "age": frame.at.map(age),
        "total": frame.total_newtons, "peak": frame.peak_kilopascals, "area": frame.contact_area_mm2,
        "copRow": frame.centre.map(|centre| centre[0]), "copColumn": frame.centre.map(|centre| centre[1]),
        "outliers": frame.outlier_share, "rate": frame.frames_per_second, "grip": frame.grip_newtons,
        "counts": frame.counts, "raw": frame.raw, "compensated": frame.loads, "marks": frame.marks,
    })
}

#[test]
fn frames_of_the_wire_are_those_that_the_page_is_tested_with() {
    let now = UNIX_EPOCH + Duration::from_millis(1_795_255_200_500);
    let mut all = serde_json::Map::new();
    for (name, frame) in frames() {
        keep(&format!("{name}.frame"), &frame.encode(now));
        all.insert(name.to_owned(), expected(&frame, now));
    }
    let mut text = serde_json::to_string_pretty(&all).unwrap();
    text.push('\n');
    keep("frames.json", text.as_bytes());
}

/// All that the page may ask for is understood, and it may ask for all that is.
#[test]
fn requests_of_the_page_are_understood() {
    let text = std::fs::read_to_string(testdata("requests.js")).unwrap();
    let (_, list) = text.split_once("requests = ").unwrap();
    let requests: Vec<serde_json::Value> =
        serde_json::from_str(list.trim_end().trim_end_matches(';')).unwrap();
    let mut verbs = std::collections::BTreeSet::new();
    for request in &requests {
        let read = command::parse(&request.to_string());
        assert!(read.is_ok(), "{request}: {read:?}");
        verbs.insert(request["do"].as_str().unwrap().to_owned());
    }
    // What a request that is none is answered with names all that there are.
    let (_, known) = command::parse(r#"{"do":"explode"}"#).unwrap_err();
    let known = known.split("expected one of").nth(1).unwrap();
    let own = ["got", "rate", "watch"].map(str::to_owned);
    let words = known.split('`').skip(1).step_by(2).map(str::to_owned);
    let all: std::collections::BTreeSet<_> = words.chain(own).collect();
    assert_eq!(verbs, all);
}
