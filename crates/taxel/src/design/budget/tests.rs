use super::*;
use crate::Grams;
use crate::sensor::preset;
use crate::simulate::VirtualSensor;

fn small(topology: Topology) -> Sensor {
    preset("econe")
        .unwrap()
        .edited(|spec| {
            spec.array.rows = 8;
            spec.array.columns = 12;
            spec.readout.topology = topology;
            if !topology.is_tia() {
                spec.readout.r_pull_down_ohms = Some(1000.0);
                spec.converter.inverted = false;
            }
        })
        .unwrap()
}

fn budget(sensor: &Sensor) -> Budget {
    Budget::new(sensor, 3, 1).unwrap()
}

fn ideal(sensor: &mut SensorSpec) {
    sensor.readout.r_mux_column_ohms = Some(PerLine::One(IDEAL_OHMS));
    sensor.readout.r_mux_row_ohms = Some(PerLine::One(IDEAL_OHMS));
    sensor.readout.open_loop_gain = Some(IDEAL_GAIN);
}

#[test]
fn with_ideal_parts_no_cause_makes_an_error() {
    for topology in [Topology::TiaGroundedColumns, Topology::TiaZeroPotential] {
        let sensor = small(topology).edited(ideal).unwrap();
        let budget = budget(&sensor);
        for scene in [budget.typical(), budget.worst(None)] {
            for cause in Cause::of(&sensor)
                .into_iter()
                .filter(|c| !c.is_converters())
            {
                let errors = budget.raw(&scene, &[cause]).unwrap();
                assert!(errors.percent.worst < 1e-6, "{cause:?} {errors:?}");
                assert!(errors.grams.unwrap().worst < 1e-5, "{cause:?} {errors:?}");
            }
            assert!(budget.raw(&scene, &[]).unwrap().percent.worst < 1e-6);
        }
    }
}

#[test]
fn without_any_cause_every_read_out_reads_what_is_there() {
    for topology in Topology::ALL {
        let budget = budget(&small(topology));
        for scene in [budget.typical(), budget.worst(None)] {
            let errors = budget.raw(&scene, &[]).unwrap();
            assert!(errors.percent.worst < 1e-6, "{topology:?} {errors:?}");
        }
    }
}

#[test]
fn a_dividers_own_error_is_there_with_ideal_switches() {
    let budget = budget(&small(Topology::DividerFloating));
    let errors = budget.raw(&budget.worst(None), &[Cause::Divider]).unwrap();
    assert!(errors.percent.mean > 10.0, "{errors:?}");
}

#[test]
fn the_error_grows_with_the_switch() {
    for topology in Topology::ALL {
        let base = budget(&small(topology));
        for cause in [Cause::ColumnSwitches, Cause::RowSwitches] {
            let mut causes = vec![cause];
            if !topology.is_tia() {
                causes.push(Cause::Divider);
            }
            let scene = base.typical();
            let own = base.raw(&scene, &causes[1..]).unwrap().percent;
            let mut last = own.mean;
            for ohms in [0.35, 2.5, 4.0, 59.0, 70.0, 125.0, 470.0] {
                let budget = base
                    .with(|sensor| {
                        sensor.readout.r_mux_column_ohms = Some(PerLine::One(ohms));
                        sensor.readout.r_mux_row_ohms = Some(PerLine::One(ohms));
                    })
                    .unwrap();
                let mean = budget.raw(&scene, &causes).unwrap().percent.mean;
                // A divider's own error may have the other sign: only the circuit without one must grow.
                if topology.is_tia() {
                    assert!(mean > last, "{topology:?} {cause:?} {ohms}: {mean} {last}");
                }
                last = mean;
            }
            assert!((last - own.mean).abs() > 0.1, "{topology:?} {cause:?}");
        }
    }
}

#[test]
fn the_error_grows_as_the_gain_falls_and_as_bits_go() {
    let base = budget(&small(Topology::TiaGroundedColumns));
    let scene = base.typical();
    let error = |change: &dyn Fn(&mut SensorSpec), cause| {
        let budget = base.with(|sensor| change(sensor)).unwrap();
        budget.raw(&scene, &[cause]).unwrap().percent.mean
    };
    let gains = [1e6, 1e4, 1e3, 1e2].map(|a| {
        error(
            &|s: &mut SensorSpec| s.readout.open_loop_gain = Some(a),
            Cause::Gain,
        )
    });
    assert!(gains.is_sorted() && gains[3] > 1.0, "{gains:?}");
    let bits =
        [16, 12, 10, 8].map(|b| error(&|s: &mut SensorSpec| s.converter.bits = b, Cause::Bits));
    assert!(bits.is_sorted() && bits[0] > 0.0, "{bits:?}");
}

#[test]
fn compensation_leaves_what_the_converter_did_and_nothing_else() {
    for topology in [
        Topology::TiaGroundedColumns,
        Topology::DividerGroundedColumns,
    ] {
        let budget = budget(&small(topology));
        let scene = budget.typical();
        let all = Cause::of(budget.sensor());
        let before = budget.raw(&scene, &all).unwrap();
        let after = budget.compensated(&scene, &all).unwrap();
        assert!(after.is_known() && after.draws == 3, "{after:?}");
        assert!(
            before.percent.mean > 10.0 * after.percent.mean,
            "{before:?} {after:?}"
        );
        let exact = budget.compensated(&scene, &[]).unwrap();
        assert!(exact.percent.worst < 1e-4, "{topology:?} {exact:?}");
    }
}

#[test]
fn a_badly_sized_feedback_resistor_saturates_and_no_inverse_brings_it_back() {
    let sensor = small(Topology::TiaGroundedColumns)
        .edited(|spec| {
            spec.readout.r_feedback_ohms = Some(10_000.0);
        })
        .unwrap();
    let budget = budget(&sensor);
    let errors = budget.raw(&budget.worst(None), &[Cause::Range]).unwrap();
    assert_eq!(errors.saturated, 96);
    assert!(errors.percent.mean > 40.0, "{errors:?}");
    let good = budget
        .with(|s| s.readout.r_feedback_ohms = Some(2000.0))
        .unwrap();
    let errors = good.raw(&good.worst(None), &[Cause::Range]).unwrap();
    assert_eq!((errors.saturated, errors.percent.worst < 1e-6), (0, true));
}

#[test]
fn without_a_load_law_there_are_percents_alone() {
    let sensor = small(Topology::TiaGroundedColumns)
        .edited(|spec| {
            spec.material = None;
        })
        .unwrap();
    let budget = budget(&sensor);
    let scene = budget.worst(None);
    assert!((scene.siemens.at(0, 0) - 2e-3).abs() < 1e-12);
    let errors = budget.raw(&scene, &Cause::of(&sensor)).unwrap();
    assert!(errors.grams.is_none() && errors.percent.mean > 1.0);
}

#[test]
fn the_same_seed_gives_the_same_numbers() {
    let sensor = small(Topology::TiaGroundedColumns);
    let all = Cause::of(&sensor);
    let of = |seed| {
        let budget = Budget::new(&sensor, 2, seed).unwrap();
        budget.compensated(&budget.typical(), &all).unwrap()
    };
    assert_eq!(of(1), of(1));
    assert_ne!(of(1), of(2));
}

/// A table is one cause, and its switches are causes where it has any.
#[test]
fn a_table_of_line_ends_is_a_cause() {
    let table = |switched: &str| {
        let text = format!(
            "format = 1\n[array]\nrows = 8\ncolumns = 8\n[readout]\ntopology = \"line-ends\"\nreads = \"voltage\"\nv_test_volts = 5.0\n{switched}\n\
             sensed.selected = {{ to = \"ground\", ohms = 1000.0 }}\n\
             sensed.unselected = {{ to = \"ground\", ohms = 1000.0 }}\n\
             [converter]\nbits = 10\nfull_scale_volts = 5.0\n"
        );
        Sensor::from_toml(&text).unwrap()
    };
    let none = table(
        "driven.selected = { to = \"v_test\", ohms = 45.0 }\ndriven.unselected = { to = \"ground\", ohms = 45.0 }",
    );
    let some = table(
        "r_mux_column_ohms = 70.0\ndriven.selected = { to = \"v_test\", switched = true }\ndriven.unselected = { to = \"ground\", switched = true }",
    );
    for (sensor, switched) in [(&none, false), (&some, true)] {
        let causes = Cause::of(sensor);
        assert!(causes.contains(&Cause::LineEnds) && !causes.contains(&Cause::Divider));
        assert_eq!(causes.contains(&Cause::ColumnSwitches), switched);
        assert_eq!(
            changes(sensor, 1e3)
                .iter()
                .any(|change| matches!(change, Change::Switches { .. })),
            switched
        );
        let budget = budget(sensor);
        let scene = budget.worst(None);
        let ideal = budget.raw(&scene, &[]).unwrap();
        assert!(ideal.percent.worst < 1e-6, "{ideal:?}");
        let own = budget.raw(&scene, &[Cause::LineEnds]).unwrap();
        assert!(own.percent.mean > 1.0, "{own:?}");
        let exact = budget.compensated(&scene, &[]).unwrap();
        assert!(exact.percent.worst < 1e-4, "{exact:?}");
    }
}

/// Mean error of the loaded taxels, grams: readings of a virtual sensor, which is none of the budget's own, by a method.
fn error_by_chance(sensor: &Sensor, scene: &BudgetScene, method: &dyn Method, draws: u64) -> f64 {
    let law = LoadLaw::from_sensor(sensor).unwrap();
    let grams = |taxel, siemens| law.grams_from_siemens(taxel, siemens).max(0.0);
    let loads = scene.siemens.map::<Grams>(&grams);
    let real = VirtualSensor::new(sensor, 5).unwrap();
    let converter = Converter::from_sensor(sensor);
    let least = LOADED_SHARE * largest_of(scene.siemens.values());
    let (mut sum, mut count) = (0.0, 0u32);
    for draw in 0..draws {
        let volts = converter.volts_from_counts(&real.read(&loads, draw).counts);
        let solved = method.solve(&volts);
        assert!(solved.outcome.stop.is_good());
        for (taxel, &siemens) in solved.frame.values().iter().enumerate() {
            if scene.siemens.values()[taxel] > least {
                sum += (grams(taxel, siemens) - loads.values()[taxel]).abs();
                count += 1;
            }
        }
    }
    sum / f64::from(count)
}

#[test]
fn lines_that_resist_weigh_in_a_budget_as_they_do_by_chance() {
    let cases = [
        (Topology::TiaGroundedColumns, 5.0),
        (Topology::TiaZeroPotential, 5.0),
        (Topology::DividerGroundedColumns, 5.0),
        (Topology::DividerVoltageFeedback, 2.0),
        (Topology::DividerFloating, 2.0),
    ];
    for (topology, ohms) in cases {
        let sensor = small(topology).edited(|spec| {
            spec.readout.r_line_row_ohms = Some(PerLine::One(ohms));
            spec.readout.r_line_column_ohms = Some(PerLine::One(2.0 * ohms));
            spec.converter.noise_counts = Some(3.0);
        });
        let sensor = sensor.unwrap();
        let budget = Budget::new(&sensor, 60, 1).unwrap();
        let scene = budget.typical();
        let all = Cause::of(&sensor);
        let raw = budget.raw(&scene, &all).unwrap();
        let left = budget.compensated(&scene, &all).unwrap();
        let by = |method: &dyn Method| error_by_chance(&sensor, &scene, method, 60);
        // A raw reading is wrong by the circuit, which takes no chance; what is left is all noise.
        let pairs = [
            (raw, by(&Raw::from_sensor(&sensor)), 0.0016),
            (left, by(&*default_method(&sensor).unwrap()), 0.033),
        ];
        for (budget, chance, within) in pairs {
            let mean = budget.grams.unwrap().mean;
            assert!(
                (mean / chance - 1.0).abs() < within,
                "{topology:?}: {mean} g, by chance {chance} g"
            );
        }
    }
}
