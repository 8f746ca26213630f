//! A table of numbers: a line a frame, a column a taxel that there is, newtons. What was not measured is empty.

use taxel::frame::{Frame, Newtons};
use taxel::metric::is_usable;
use taxel::{Mark, Sensor};

use super::Layout;
use crate::number::push_number;

pub(super) struct Plain {
    /// The names of the columns, until they are written.
    heading: Option<String>,
    number: zmij::Buffer,
}

impl Plain {
    pub(super) fn new(sensor: &Sensor) -> Self {
        let taxels = (0..sensor.rows() * sensor.columns()).filter(|&at| !sensor.is_absent(at));
        let names =
            taxels.map(|at| format!(",r{}c{}", at / sensor.columns(), at % sensor.columns()));
        Self {
            heading: Some(format!("frame,time_s{}\n", names.collect::<String>())),
            number: zmij::Buffer::new(),
        }
    }

    fn begin(&mut self, out: &mut Vec<u8>) {
        if let Some(heading) = self.heading.take() {
            out.extend_from_slice(heading.as_bytes());
        }
    }
}

impl Layout for Plain {
    fn frame(&mut self, loads: &Frame<Newtons>, secs: f64, out: &mut Vec<u8>) {
        self.begin(out);
        out.extend_from_slice(itoa::Buffer::new().format(loads.sequence).as_bytes());
        out.push(b',');
        push_number(out, &mut self.number, secs);
        for (&load, mark) in loads.values().iter().zip(loads.marks()) {
            if *mark == Mark::Absent {
                continue;
            }
            out.push(b',');
            if is_usable(*mark) {
                push_number(out, &mut self.number, load);
            }
        }
        out.push(b'\n');
    }

    fn end(&mut self, out: &mut Vec<u8>) {
        self.begin(out);
    }
}
