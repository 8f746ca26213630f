//! The Python module `taxel._taxel`: what `python/taxel` puts a friendly face on. Thin: arrays in, arrays out; the work is done by the
//! crates that the `taxel` command stands on, with Python free to run meanwhile.

mod arrays;
mod batch;
mod calibration;
mod errors;
mod interrupt;
mod live;
mod measurement;
mod output;
mod pipeline;
mod reader;
mod reports;
mod sensor;
mod simulation;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
mod _taxel {
    #[pymodule_export]
    use crate::batch::Batch;
    #[pymodule_export]
    use crate::calibration::{Calibration, calibrate};
    #[pymodule_export]
    use crate::live::Stream;
    #[pymodule_export]
    use crate::measurement::measure;
    #[pymodule_export]
    use crate::pipeline::Pipeline;
    #[pymodule_export]
    use crate::reader::Reader;
    #[pymodule_export]
    use crate::reports::{evaluate, identify, report};
    #[pymodule_export]
    use crate::sensor::{Sensor, presets};
    #[pymodule_export]
    use crate::simulation::{scan, simulate, solve};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        let marks = pyo3::types::PyDict::new(module.py());
        for mark in taxel::Mark::ALL {
            marks.set_item(mark.word(), mark.code())?;
        }
        module.add("MARKS", marks)
    }
}
