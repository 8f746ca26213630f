use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::Volts;
use crate::circuit::Circuit;
use crate::sensor::{DiodePlace, Reads, preset};

fn small() -> Requirements {
    Requirements {
        rows: 6,
        columns: 9,
        ..Requirements::default()
    }
}

#[test]
fn the_papers_numbers_give_the_papers_choice() {
    let proposal = size(&Requirements::default()).unwrap();
    let readout = proposal.sensor.readout();
    assert_eq!(
        (readout.v_test_volts, readout.r_feedback_ohms()),
        (0.4, Some(2000.0))
    );
    assert!((proposal.exact_ohms - 2062.5).abs() < 1e-9);
    let [light, full] = &proposal.resolution;
    assert!((full.volts - 1.6).abs() < 1e-12 && (full.load_g - 600.0).abs() < 1e-6);
    assert!((light.volts - 0.4 * 2000.0 / 3000.0).abs() < 1e-12);
    assert!((60.0..90.0).contains(&light.load_g), "{light:?}");
}

#[test]
fn nothing_saturates_within_the_range_it_was_sized_for() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for round in 0..60 {
        let topology = Topology::ALL[round % 5];
        let least = 10f64.powf(random.random_range(1.0..4.0));
        let requirements = Requirements {
            topology,
            taxel_ohms: (least, least * random.random_range(1.5..50.0)),
            switch_ohms: 10f64.powf(random.random_range(-0.5..2.5)),
            full_scale_volts: random.random_range(1.0..5.0),
            headroom: random.random_range(0.0..0.5),
            gbw_hz: 10f64.powf(random.random_range(5.0..8.0)),
            ..small()
        };
        let proposal = size(&requirements).unwrap();
        let circuit = SensorCircuit::from_sensor(&proposal.sensor).unwrap();
        let saturated = |w: &Warning| matches!(w, Warning::Saturates { .. });
        assert!(!proposal.warnings.iter().any(saturated), "{requirements:?}");
        for _ in 0..20 {
            let share: f64 = random.random();
            let range = (1.0 / requirements.taxel_ohms.1)..=(1.0 / requirements.taxel_ohms.0);
            let frame = Frame::<Siemens>::zeros(6, 9).map(|_, _| {
                if random.random::<f64>() < share {
                    random.random_range(range.clone())
                } else {
                    unloaded(&requirements)
                }
            });
            let volts: Frame<Volts> = circuit.predict(&frame).unwrap();
            let largest = volts.values().iter().fold(0.0f64, |m, v| m.max(v.abs()));
            assert!(
                largest < requirements.full_scale_volts * (1.0 + 1e-12),
                "{requirements:?} {largest}"
            );
        }
    }
}

#[test]
fn a_resistor_that_is_too_large_is_said_to_saturate_and_does() {
    // Fig. 25: the ceiling is reached at 100 g.
    let requirements = Requirements {
        r_ohms: Some(12_000.0),
        ..small()
    };
    let proposal = size(&requirements).unwrap();
    let from_g = proposal.warnings.iter().find_map(|warning| match warning {
        Warning::Saturates { from_g, .. } => Some(*from_g),
        _ => None,
    });
    let from_g = from_g.expect("a warning");
    assert!((90.0..110.0).contains(&from_g), "{from_g}");
    assert!(proposal.fullest_share > 1.0);
    let law = law(&requirements);
    let volts = 0.4 * 12_000.0 * law.siemens_from_grams(0, from_g);
    assert!((volts - requirements.full_scale_volts).abs() < 1e-9);
}

#[test]
fn ten_millivolts_are_said_to_make_ghosts_and_the_least_voltage_none() {
    let with = |v_test_volts| {
        let requirements = Requirements {
            v_test_volts,
            ..Requirements::default()
        };
        size(&requirements).unwrap()
    };
    let ghosts = |p: &Proposal| {
        let is = |w: &Warning| matches!(w, Warning::GhostsByNoise { .. });
        p.warnings.iter().any(is)
    };
    assert!(ghosts(&with(Some(0.01))));
    let good = with(None);
    assert!(!ghosts(&good));
    let least = good.least_v_test_volts.unwrap();
    assert!((0.01..0.4).contains(&least), "{least}");
    assert!(!ghosts(&with(Some(1.1 * least))) && ghosts(&with(Some(0.8 * least))));
}

#[test]
fn compensation_removes_the_ghost_that_switches_make() {
    let requirements = Requirements {
        switch_ohms: 70.0,
        frames_per_second: 1.0,
        ..small()
    };
    let proposal = size(&requirements).unwrap();
    for ghost in &proposal.ghosts {
        let (raw, after) = (ghost.raw.percent.ghost, ghost.compensated.percent.ghost);
        assert!(raw > 10.0 * after, "{ghost:?}");
    }
    assert!(
        size(&Requirements { rows: 1, ..small() })
            .unwrap()
            .ghosts
            .is_empty()
    );
}

#[test]
fn a_dividers_resistor_spreads_the_range_most() {
    let requirements = Requirements {
        topology: Topology::DividerGroundedColumns,
        taxel_ohms: (500.0, 8000.0),
        full_scale_volts: 3.3,
        ..small()
    };
    let proposal = size(&requirements).unwrap();
    assert_eq!(proposal.sensor.readout().r_pull_down_ohms(), Some(2000.0));
    assert_eq!(proposal.sensor.readout().v_test_volts, 3.3);
    assert!(proposal.gain.is_none() && proposal.least_v_test_volts.is_none());
    let swing = |p: &Proposal| p.resolution[1].volts - p.resolution[0].volts;
    for ohms in [1500.0, 2700.0] {
        let other = size(&Requirements {
            r_ohms: Some(ohms),
            ..requirements.clone()
        })
        .unwrap();
        assert!(swing(&proposal) > swing(&other));
    }
}

#[test]
fn timing_is_what_its_definition_says() {
    let requirements = small();
    let timing = size(&requirements).unwrap().timing;
    assert!((timing.available_secs - 1.0 / (30.0 * 54.0)).abs() < 1e-15);
    assert!((timing.column_secs - 1.2e-9).abs() < 1e-18);
    let amplifier = (1.0 + 2000.0 / 500.0) / (2.0 * std::f64::consts::PI * 10e6);
    assert!((timing.amplifier_secs - amplifier).abs() < 1e-15);
    let rate = timing.greatest_frames_per_second(54);
    let fast = Requirements {
        frames_per_second: 2.0 * rate,
        ..requirements
    };
    let late = |w: &Warning| {
        matches!(
            w,
            Warning::Unsettled {
                full_row: false,
                ..
            }
        )
    };
    assert!(size(&fast).unwrap().warnings.iter().any(late));
}

#[test]
fn the_sensor_file_reads_back_and_nonsense_is_refused() {
    let sensor = size(&small()).unwrap().sensor;
    assert_eq!(Sensor::from_toml(&sensor.to_toml()).unwrap(), sensor);
    let refused = |requirements: Requirements| size(&requirements).unwrap_err().to_string();
    let swapped = Requirements {
        taxel_ohms: (3000.0, 500.0),
        ..small()
    };
    assert!(refused(swapped).contains("3000 Ω at full load and 500 Ω"));
    assert!(refused(Requirements { rows: 0, ..small() }).contains("0 rows"));
    assert!(
        refused(Requirements {
            columns: 5000,
            ..small()
        })
        .contains("5000 columns")
    );
    assert!(
        refused(Requirements {
            switch_ohms: f64::NAN,
            ..small()
        })
        .contains("NaN")
    );
    assert!(
        refused(Requirements {
            headroom: 1.0,
            ..small()
        })
        .contains("100 %")
    );
    let wide = Requirements {
        taxel_ohms: (1e-20, 1e20),
        ..small()
    };
    assert!(refused(wide).contains("twelve decades"));
    assert!(refused(Requirements { bits: 0, ..small() }).contains("0 bits"));
}

#[test]
fn a_diode_gets_its_drop_and_full_load_its_current() {
    for (part, least_drop) in [("1N4148", 0.5), ("BAT54", 0.15)] {
        let requirements = Requirements {
            diode: Some(DiodeSpec::of_part(DiodePlace::Taxel, part)),
            ..small()
        };
        let proposal = size(&requirements).unwrap();
        let readout = proposal.sensor.readout();
        let drop = readout.v_test_volts - 0.4;
        assert!(drop > least_drop && drop < 1.0, "{part}: {drop}");
        assert!((proposal.taxel_amperes - 0.8e-3).abs() < 1e-12);
        // Switches, and the amplifier's finite gain, take a little.
        let full = proposal.resolution[1].volts / readout.r_feedback_ohms().unwrap();
        assert!((0.96..1.0).contains(&(full / 0.8e-3)), "{part}: {full}");
        // With the test voltage of a sensor without diodes, hardly anything is read.
        let blind = size(&Requirements {
            v_test_volts: Some(0.4),
            r_ohms: Some(2000.0),
            ..requirements
        });
        let blind = blind.unwrap();
        assert!(blind.resolution[1].volts < 0.7 * proposal.resolution[1].volts);
    }
}

#[test]
fn lines_are_too_long_by_the_rule_and_the_far_corner_reads_less() {
    // 30 taxels a row of 500 Ω: r ḡ n² is 10 at 5.56 Ω.
    for (ohms, too_long) in [(0.0, false), (5.0, false), (6.0, true)] {
        let requirements = Requirements {
            rows: 6,
            columns: 30,
            line_ohms: [ohms, 0.0],
            ..Requirements::default()
        };
        let proposal = size(&requirements).unwrap();
        let told: Vec<&Warning> = proposal
            .warnings
            .iter()
            .filter(|w| matches!(w, Warning::LineTooLong { .. }))
            .collect();
        assert_eq!(told.len(), usize::from(too_long), "{ohms} Ω");
        if let [warning] = told[..] {
            let text = warning.to_string();
            assert!(text.contains("row") && text.contains("5.56 Ω"), "{text}");
        }
        let far = proposal.resolution[1].volts;
        // One taxel of 500 Ω behind 30 pitches, two switches and the amplifier's input.
        let gain = proposal.gain.unwrap();
        let series =
            500.0 + 29.0 * ohms + f64::from(u8::from(ohms > 0.0)) * (8.0 + 2000.0 / (1.0 + gain));
        assert!((far / (0.4 * 2000.0 / series) - 1.0).abs() < 0.01, "{far}");
        assert!(proposal.timing.row_secs >= 0.5 * 30.0 * ohms * requirements.line_farads);
    }
}

#[test]
fn another_wiring_is_kept_and_its_table_judged_as_it_stands() {
    let mat = preset("mat-16x16-cd4067").unwrap();
    let table = mat.readout().table.clone();
    let mut readout = mat.spec().readout.clone();
    readout.topology = Topology::LineEnds;
    readout.reads = Some(Reads::Voltage);
    (readout.driven, readout.sensed) = (Some(table.driven), Some(table.sensed));
    readout.r_pull_down_ohms = None;
    let like = |readout: ReadoutSpec| Requirements {
        rows: 16,
        columns: 16,
        bits: 10,
        full_scale_volts: 5.0,
        readout: Some(readout),
        ..Requirements::default()
    };
    let named = like(mat.spec().readout.clone());
    let ohms = mat.readout().r_pull_down_ohms();
    let named = size(&Requirements {
        r_ohms: ohms,
        ..named
    })
    .unwrap();
    let tabled = size(&like(readout.clone())).unwrap();
    assert_eq!(tabled.sensor.spec().readout.driven, readout.driven);
    assert_eq!(tabled.sensor.spec().readout.sensed, readout.sensed);
    assert_eq!(
        tabled.sensor.readout().v_test_volts,
        mat.readout().v_test_volts
    );
    // The same circuit, said in two ways.
    assert!((tabled.fullest_share - named.fullest_share).abs() < 1e-9);
    assert_eq!(tabled.ghosts[0].raw, named.ghosts[0].raw);
    let refused = size(&Requirements {
        r_ohms: Some(1e3),
        ..like(readout)
    });
    assert!(refused.unwrap_err().to_string().contains("table"));
}
