//! What goes wrong, as the exceptions of `taxel._errors`: the same words as the command's, with place, both numbers and hint.

use std::fmt::Display;

use pyo3::prelude::*;

/// The exceptions of `taxel._errors`.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// An array of the wrong shape, type or content.
    Array,
    /// A file that cannot be read or written, or what stands in it.
    File,
    /// What the sensor file says, or the mathematics refuses.
    Sensor,
    /// Anything else.
    Other,
}

impl Kind {
    fn class(self) -> &'static str {
        match self {
            Kind::Array => "ArrayError",
            Kind::File => "FileError",
            Kind::Sensor => "SensorError",
            Kind::Other => "Error",
        }
    }

    fn raise(self, message: &dyn Display) -> PyErr {
        Python::attach(|py| {
            let class = py
                .import("taxel._errors")
                .and_then(|errors| errors.getattr(self.class()));
            match class.and_then(|class| class.call1((message.to_string(),))) {
                Ok(error) => PyErr::from_value(error),
                Err(error) => error,
            }
        })
    }
}

/// An array that cannot be used.
pub(crate) fn array(message: impl Display) -> PyErr {
    Kind::Array.raise(&message)
}

/// Any other refusal.
pub(crate) fn other(message: impl Display) -> PyErr {
    Kind::Other.raise(&message)
}

/// What the library refuses.
pub(crate) fn of_taxel(error: taxel::Error) -> PyErr {
    Kind::Sensor.raise(&error)
}

/// What reading or writing refuses.
pub(crate) fn of_io(error: taxel_io::Error) -> PyErr {
    match error {
        taxel_io::Error::SensorFile(error @ taxel_io::SensorFileError::Invalid { .. }) => {
            Kind::Sensor.raise(&error)
        }
        error => Kind::File.raise(&error),
    }
}

/// What reading frames refuses: the option that goes on without one goes by another name than the command's.
pub(crate) fn of_frames(error: taxel_app::Error) -> PyErr {
    let error = match error {
        taxel_app::Error::Io(error) if error.is_one_frame() => error,
        error => return of_app(error),
    };
    let text = error
        .to_string()
        .replace("--keep-going", "`keep_going=True`");
    if text.contains("keep_going") {
        return Kind::File.raise(&text);
    }
    let joint = if text.contains("\nhint: ") {
        "; "
    } else {
        "\nhint: "
    };
    Kind::File.raise(&format_args!(
        "{text}{joint}`keep_going=True` leaves its frame out"
    ))
}

/// What a person's work refuses.
pub(crate) fn of_app(error: taxel_app::Error) -> PyErr {
    match error {
        taxel_app::Error::Io(error) => of_io(error),
        taxel_app::Error::Taxel(error) => of_taxel(error),
        error @ taxel_app::Error::InFile { .. } => Kind::Sensor.raise(&error),
        error => Kind::Other.raise(&error),
    }
}
