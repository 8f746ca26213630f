//! The words of `--unit` and `--input-unit`, with what each means, for help and completion.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use taxel_app::units::{InputUnit, Unit};

/// `volts`, `siemens`, `g`, `N`, `kPa`, `MPa`.
pub(crate) fn unit() -> impl TypedValueParser<Value = Unit> {
    let words = Unit::ALL.map(|unit| PossibleValue::new(unit.word()).help(unit.description()));
    PossibleValuesParser::new(words).map(|word| {
        let known = Unit::ALL.into_iter().find(|unit| unit.word() == word);
        known.expect("the parser lets no other word through")
    })
}

/// `counts`, `volts`, `siemens`.
pub(crate) fn input_unit() -> impl TypedValueParser<Value = InputUnit> {
    let words = InputUnit::ALL.map(|unit| PossibleValue::new(unit.word()).help(unit.description()));
    PossibleValuesParser::new(words).map(|word| {
        let known = InputUnit::ALL.into_iter().find(|unit| unit.word() == word);
        known.expect("the parser lets no other word through")
    })
}
