//! A virtual sensor that scans in real time: a source of frames without hardware, with knobs.

mod person;
mod presser;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::Sensor;
use taxel::sensor::{PerLine, USUAL_OPEN_LOOP_GAIN};
use taxel::simulate::{Pattern, PatternKind, VirtualSensor, default_noise_counts};

use crate::Error;
use crate::protocol::LinkStats;
use crate::transport::{Receiver, State};
pub use person::{DRAWN_RATE, Person, ToldGrip};
pub use presser::{LaidLoads, Presser};

/// What can be turned while it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationParameters {
    /// R_c, on-resistance of every column switch, ohms.
    pub r_mux_column_ohms: f64,
    /// R_r, on-resistance of every row switch, ohms.
    pub r_mux_row_ohms: f64,
    /// A, the amplifier's open-loop gain at the scan rate (`tia-*`).
    pub open_loop_gain: f64,
    /// Standard deviation of the readings' noise, counts.
    pub noise_counts: f64,
    /// A third of the rows down, one row is dead.
    pub dead_row: bool,
    /// A third of the columns along, one column is dead.
    pub dead_column: bool,
}

impl SimulationParameters {
    /// As the sensor file says.
    pub fn of(sensor: &Sensor) -> Self {
        let (readout, converter) = (sensor.readout(), sensor.converter());
        let mean = |ohms: &Option<PerLine>, lines| ohms.as_ref().map_or(0.0, |o| o.mean(lines));
        Self {
            r_mux_column_ohms: mean(&readout.r_mux_column_ohms, sensor.columns()),
            r_mux_row_ohms: mean(&readout.r_mux_row_ohms, sensor.rows()),
            open_loop_gain: readout.open_loop_gain().unwrap_or(USUAL_OPEN_LOOP_GAIN),
            noise_counts: converter
                .noise_counts
                .unwrap_or_else(|| default_noise_counts(converter.bits)),
            dead_row: false,
            dead_column: false,
        }
    }

    /// The sensor with these knobs; what is not turned stays as the file says, line by line.
    ///
    /// # Errors
    /// A knob beyond what physics allows.
    pub fn apply(&self, sensor: &Sensor) -> Result<Sensor, taxel::Error> {
        let nominal = Self::of(sensor);
        sensor.edited(|turned| {
            let readout = &mut turned.readout;
            if self.r_mux_column_ohms != nominal.r_mux_column_ohms {
                readout.r_mux_column_ohms = Some(PerLine::One(self.r_mux_column_ohms));
            }
            if self.r_mux_row_ohms != nominal.r_mux_row_ohms {
                readout.r_mux_row_ohms = Some(PerLine::One(self.r_mux_row_ohms));
            }
            if readout.has_amplifier() {
                readout.open_loop_gain = Some(self.open_loop_gain);
            }
            turned.converter.noise_counts = Some(self.noise_counts);
            if self.dead_row {
                turned.screen.dead_rows.push(sensor.rows() / 3);
            }
            if self.dead_column {
                turned.screen.dead_columns.push(sensor.columns() / 3);
            }
        })
    }
}

/// A virtual sensor under a pattern, frame after frame.
pub struct Simulated {
    sensor: Sensor,
    pattern: Pattern,
    seed: u64,
    frames_per_second: Option<f64>,
    parameters: Arc<Mutex<SimulationParameters>>,
    person: Person,
    presser: Presser,
}

impl Simulated {
    /// `frames_per_second`: `None` for as many as can be.
    ///
    /// # Errors
    /// A sensor without load law or switch resistances.
    pub fn new(
        sensor: &Sensor,
        pattern: Pattern,
        seed: u64,
        frames_per_second: Option<f64>,
    ) -> Result<Self, Error> {
        VirtualSensor::new(sensor, seed)?;
        Ok(Self {
            sensor: sensor.clone(),
            pattern,
            seed,
            frames_per_second,
            parameters: Arc::new(Mutex::new(SimulationParameters::of(sensor))),
            person: Person::default(),
            presser: Presser::default(),
        })
    }

    /// The knobs, to be turned from anywhere.
    pub fn parameters(&self) -> Arc<Mutex<SimulationParameters>> {
        self.parameters.clone()
    }

    /// Who grips, to be told when; `None` of another pattern.
    pub fn person(&self) -> Option<Person> {
        let grips = matches!(self.pattern.kind, PatternKind::Grip { .. });
        grips.then(|| self.person.clone())
    }

    /// Who lays weights on the sensor, to be told which; as long as nobody is told anything, the pattern presses.
    pub fn presser(&self) -> Presser {
        self.presser.clone()
    }

    fn virtual_sensor(&self, sensor: &Sensor) -> Result<VirtualSensor, taxel::Error> {
        let sensor = VirtualSensor::new(sensor, self.seed)?;
        Ok(match self.frames_per_second {
            Some(rate) => sensor.with_period_secs(1.0 / rate),
            None => sensor,
        })
    }

    /// Scans until it is stopped. Patterns were drawn for 100 frames a second: at another rate they move as fast.
    pub fn run(&self, receiver: &mut dyn Receiver) {
        let begun = Instant::now();
        let mut turned = SimulationParameters::of(&self.sensor);
        let Ok(mut virtual_sensor) = self.virtual_sensor(&self.sensor) else {
            return receiver.state(State::Ended, "the sensor cannot be simulated");
        };
        let mut memory = virtual_sensor.memory();
        let mut link_stats = LinkStats::default();
        let mut told = begun;
        receiver.state(State::Live, &format!("simulated {}", self.sensor.name()));
        for number in 0u64.. {
            if receiver.stopped() {
                return;
            }
            let parameters = *self
                .parameters
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            if parameters != turned {
                turned = parameters;
                // A knob beyond what physics allows leaves the sensor as it was.
                let sensor = parameters.apply(&self.sensor);
                let turned = sensor.and_then(|sensor| self.virtual_sensor(&sensor));
                if let Ok(sensor) = turned {
                    memory = sensor.memory();
                    virtual_sensor = sensor;
                }
            }
            let secs = match self.frames_per_second {
                Some(rate) => number as f64 / rate,
                None => begun.elapsed().as_secs_f64(),
            };
            let shape = person::drawn_frame(secs);
            let array = self.sensor.array();
            let laid = self.presser.loads(array, secs);
            let told_to = laid.or_else(|| self.person.loads(array, self.seed, secs));
            let loads = told_to.unwrap_or_else(|| self.pattern.loads(array, self.seed, shape));
            let mut counts = virtual_sensor.read_next(&mut memory, &loads, number).counts;
            if let Some(rate) = self.frames_per_second {
                let due = begun + Duration::from_secs_f64((number + 1) as f64 / rate);
                let now = Instant::now();
                if due > now {
                    std::thread::sleep(due - now);
                }
            }
            counts.sequence = number;
            counts.time_secs = Some(secs);
            link_stats.frames += 1;
            receiver.frame(&counts, SystemTime::now());
            if told.elapsed() > Duration::from_millis(50) {
                told = Instant::now();
                receiver.link_stats(link_stats);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel::sensor::preset;
    use taxel::{Counts, Frame};

    /// Takes some frames, and turns a knob in the middle.
    struct Taker {
        frames: Vec<Frame<Counts>>,
        parameters: Arc<Mutex<SimulationParameters>>,
    }

    impl Receiver for Taker {
        fn frame(&mut self, frame: &Frame<Counts>, _: SystemTime) {
            self.frames.push(frame.clone());
            if self.frames.len() == 3 {
                self.parameters.lock().unwrap().dead_row = true;
            }
        }
        fn state(&mut self, _: State, _: &str) {}
        fn link_stats(&mut self, _: LinkStats) {}
        fn stopped(&self) -> bool {
            self.frames.len() == 6
        }
    }

    #[test]
    fn a_knob_turned_shows_in_the_next_frame() {
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let source = Simulated::new(&sensor, Pattern::named("uniform").unwrap(), 1, Some(1e6));
        let source = source.unwrap();
        let mut taker = Taker {
            frames: Vec::new(),
            parameters: source.parameters(),
        };
        source.run(&mut taker);
        let row = |frame: &Frame<Counts>| (0..16).map(|c| frame.at(5, c)).sum::<f64>();
        assert!(row(&taker.frames[2]) > 100.0);
        assert!(row(&taker.frames[3]) < 30.0);
        let sequences: Vec<u64> = taker.frames.iter().map(|f| f.sequence).collect();
        assert_eq!(sequences, [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn knobs_that_nobody_turned_leave_the_sensor_alone() {
        let sensor = preset("econe").unwrap();
        let turned = SimulationParameters::of(&sensor).apply(&sensor).unwrap();
        assert_eq!(turned.readout(), sensor.readout());
        assert_eq!(turned.screen(), sensor.screen());
    }
}
