//! What viewers are told of a sensor.

use std::time::SystemTime;

use taxel::Sensor;
use taxel::sensor::Region;
use taxel_server::{HandleFacts, RegionFacts, SensorFacts};

use crate::calibration_age::calibration_history;
use crate::exported::exported_facts;

/// Of a sensor, and of parts of it.
pub(super) fn sensor_facts(sensor: &Sensor, regions: &[Region]) -> SensorFacts {
    let array = sensor.array();
    let mut facts = SensorFacts::new(sensor.name(), array.rows, array.columns);
    facts.pitch_mm = array.pitch_mm;
    facts.taxel_area_mm2 = array.taxel_area_mm2;
    let cells = (0..sensor.taxels()).map(|taxel| sensor.cell_mm2(taxel));
    facts.cell_area_mm2 = cells.fold(0.0, f64::max);
    facts.bits = sensor.converter().bits;
    facts.max_count = sensor.max_count();
    facts.positions_mm = sensor.positions().map(|places| {
        let place =
            |(taxel, place): (usize, &[f64; 2])| (!sensor.is_absent(taxel)).then_some(*place);
        places.iter().enumerate().map(place).collect()
    });
    let regions = regions.iter();
    facts.regions = regions
        .map(|region| RegionFacts::new(region, array.columns))
        .collect();
    facts.handle = sensor.handle().map(HandleFacts::new);
    facts.calibration = calibration_history(sensor, Some(SystemTime::now()));
    facts.exported = exported_facts(sensor);
    facts.has_load_law = sensor.material().is_some();
    facts
}
