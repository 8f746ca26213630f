//! What can go wrong in the mathematics, with both numbers in every message.

/// Everything this crate refuses to do, and why.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Values do not fill the array.
    #[error("{what}: {rows} rows x {columns} columns need {expected} values, found {found}")]
    Shape {
        /// What was to be filled.
        what: &'static str,
        /// rows × columns.
        expected: usize,
        /// How many there were.
        found: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
    },
    /// sensor.toml is not TOML, or a value has the wrong type.
    #[error("sensor file: {message}")]
    Toml {
        /// The parser's words, with line and column.
        message: String,
    },
    /// sensor.toml has a key that nobody reads.
    #[error("sensor file, line {line}: unknown key `{key}` in {table}\nhint: {hint}")]
    UnknownKey {
        /// The table it stands in.
        table: String,
        /// The key.
        key: String,
        /// Its line, from 1.
        line: usize,
        /// The nearest known key, or the list of them.
        hint: String,
    },
    /// A key that this read-out needs is absent.
    #[error("sensor file: `{key}` is missing\nhint: {hint}")]
    MissingKey {
        /// Table and key.
        key: &'static str,
        /// What to do.
        hint: String,
    },
    /// Errors of loads that another program has found.
    #[error(
        "nothing tells how far to trust these loads: {program} has found them\nhint: ask for the loads without standard errors and intervals"
    )]
    Exported {
        /// The program.
        program: String,
    },
    /// A topology that is neither a named one nor `line-ends`.
    #[error("sensor file: unknown topology `{found}`\nhint: {hint}")]
    UnknownTopology {
        /// What stands there.
        found: String,
        /// Nearest name and the list.
        hint: String,
    },
    /// Line ends that no board can have, or a word of theirs that is none.
    #[error("sensor file: `{key}` {problem}\nhint: {hint}")]
    LineEnds {
        /// Table and key.
        key: String,
        /// What is wrong with it.
        problem: String,
        /// What to do.
        hint: String,
    },
    /// A named region that is none.
    #[error("region {name} {problem}\nhint: {hint}")]
    Region {
        /// Its name in quotes, or its number.
        name: String,
        /// What is wrong with it.
        problem: String,
        /// What to do.
        hint: &'static str,
    },
    /// A body that no array lies on, or that the array does not fit.
    #[error("sensor file: `array.geometry.{key}` {problem}\nhint: {hint}")]
    Geometry {
        /// Key of the table.
        key: &'static str,
        /// What is wrong with it.
        problem: String,
        /// What to do.
        hint: String,
    },
    /// A number outside its physical range.
    #[error("sensor file: `{key}` is {}, but must be {expected}\nhint: {hint}", plain(*.found))]
    OutOfRange {
        /// Table and key (with the line's index for a list).
        key: String,
        /// The value found.
        found: f64,
        /// The range allowed, in words.
        expected: &'static str,
        /// What to do.
        hint: &'static str,
    },
    /// A list of as many numbers as a key has meanings.
    #[error(
        "sensor file: `{key}` has {found} numbers, but must have {expected}: {meaning}\nhint: numbers after those would be read by nobody"
    )]
    Numbers {
        /// Table and key.
        key: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
        /// What each says.
        meaning: &'static str,
    },
    /// The screen's mask leaves no count good.
    #[error(
        "sensor file: `screen.low_counts` is {low_counts}, but `screen.high_counts` is {high_counts}: every reading would be an outlier\nhint: readings below the first and above the second are outliers"
    )]
    MaskEmpty {
        /// Readings below are outliers, counts.
        low_counts: f64,
        /// Readings above are outliers, counts.
        high_counts: f64,
    },
    /// A per-line or per-taxel list whose length does not fit the array.
    #[error(
        "sensor file: `{key}` has {found} numbers, but the array has {expected} {unit}\nhint: give one number for all, or one per {unit_one}"
    )]
    ListLength {
        /// Table and key.
        key: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        expected: usize,
        /// `columns`, `rows`, `taxels`.
        unit: &'static str,
        /// The same in the singular.
        unit_one: &'static str,
    },
    /// A mask of crossings whose shape is not the array's.
    #[error(
        "sensor file: `array.population` has {lines} lines with {found} numbers in all, but the array has {rows} rows x {columns} columns\nhint: one line a row with one number a column: 1 where the crossing carries a taxel, else 0"
    )]
    PopulationShape {
        /// Lines there are.
        lines: usize,
        /// Numbers in them.
        found: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
    },
    /// A number in the mask of crossings that says neither yes nor no.
    #[error(
        "sensor file: `array.population` is {found} at row {row}, column {column}, but must be 0 or 1\nhint: 1 where the crossing carries a taxel, else 0"
    )]
    PopulationValue {
        /// Row of the number.
        row: usize,
        /// Column of the number.
        column: usize,
        /// What stands there.
        found: f64,
    },
    /// A mask of crossings that leaves no taxel.
    #[error(
        "sensor file: `array.population` says that none of the {crossings} crossings carries a taxel\nhint: 1 where the crossing carries a taxel, 0 where there is none"
    )]
    NothingPopulated {
        /// Crossings of the array.
        crossings: usize,
    },
    /// A place of no taxel, or one that is none.
    #[error(
        "sensor file: `array.positions` puts row {row}, column {column} at x {x_mm} mm, y {y_mm} mm, but the array has {rows} rows x {columns} columns\nhint: rows and columns are whole numbers from 0, places finite numbers within 1 km"
    )]
    PositionOutside {
        /// Row given.
        row: f64,
        /// Column given.
        column: f64,
        /// Place to the right, mm.
        x_mm: f64,
        /// Place downwards, mm.
        y_mm: f64,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
    },
    /// Two places for one taxel.
    #[error(
        "sensor file: `array.positions`: row {row}, column {column} has two places\nhint: one line a taxel"
    )]
    PositionTwice {
        /// Row of the taxel.
        row: usize,
        /// Column of the taxel.
        column: usize,
    },
    /// A taxel without a place.
    #[error(
        "sensor file: `array.positions` says nothing of row {row}, column {column}: {found} of {taxels} taxels have a place\nhint: one line a taxel; crossings without one belong in `array.population`"
    )]
    PositionMissing {
        /// Row of the first taxel without a place.
        row: usize,
        /// Column of it.
        column: usize,
        /// Taxels with a place.
        found: usize,
        /// Taxels there are.
        taxels: usize,
    },
    /// Two taxels in one place.
    #[error(
        "sensor file: `array.positions` puts row {row}, column {column} and row {other_row}, column {other_column} both at x {x_mm} mm, y {y_mm} mm\nhint: no two taxels lie in one place"
    )]
    PositionsCoincide {
        /// Row of the one.
        row: usize,
        /// Column of the one.
        column: usize,
        /// Row of the other.
        other_row: usize,
        /// Column of the other.
        other_column: usize,
        /// Their place to the right, mm.
        x_mm: f64,
        /// Their place downwards, mm.
        y_mm: f64,
    },
    /// Knots that no curve goes through.
    #[error(
        "sensor file: `{key}`: {source}\nhint: knots are ln of the load in grams, ascending; leave [material.bend] out where the law does not bend"
    )]
    Knots {
        /// Table and key.
        key: &'static str,
        /// Which knot, and why.
        source: crate::spline::BadKnots,
    },
    /// A preset name nobody ships.
    #[error("no preset sensor is called `{name}`\nhint: {hint}")]
    UnknownPreset {
        /// The name asked for.
        name: String,
        /// Nearest name and the list.
        hint: String,
    },
    /// A method nobody ships, or one that does not fit the read-out.
    #[error("no method `{name}` for this sensor\nhint: {hint}")]
    UnknownMethod {
        /// The name asked for.
        name: String,
        /// What there is.
        hint: String,
    },
    /// A check without a load that is known.
    #[error(
        "nothing to check with: 0 presses, 0 totals, 0 empty frames\nhint: a few known weights, one total or the empty array tell something each"
    )]
    NothingToCheck,
    /// Nothing but unloaded taxels was compared.
    #[error(
        "no scale was compared: nothing but unloaded taxels was read, which tell the offset alone\nhint: press a few known weights, or give a known total; for the report alone, leave out the file to write"
    )]
    NoScale,
    /// An `[uncertainty]` that was found with another load law.
    #[error(
        "uncertainty.material_factor is {stated}, but material.factor is {factor}: these errors were found by another calibration\nhint: keep the tables of one calibration together, leave [uncertainty] out (standard errors are of noise alone then), or calibrate again"
    )]
    OtherUncertainty {
        /// The factor that the errors were found with, S/g^exponent.
        stated: f64,
        /// The factor in the file, S/g^exponent.
        factor: f64,
    },
    /// A labelled press that points outside the data.
    #[error(
        "a press is labelled row {row}, column {column} in frame {frame}, but the array has {rows} rows x {columns} columns and there are {frames} frames\nhint: rows, columns and frames count from 0; swapped labels mean a swapped recording"
    )]
    PressOutside {
        /// Row of the label.
        row: usize,
        /// Column of the label.
        column: usize,
        /// Frame of the label.
        frame: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
        /// Frames there are.
        frames: usize,
    },
    /// More labelled presses on lines that say nothing than can be left out in good faith.
    #[error(
        "{on_dead_lines} of {presses} presses lie on dead lines; the first at row {row}, column {column} (frame {frame}), on {line}\nhint: are rows and columns of the labels swapped, or is the array wired in another order? A dead line's readings carry no load"
    )]
    PressOnDeadLine {
        /// Row of the label.
        row: usize,
        /// Column of the label.
        column: usize,
        /// Frame of the label.
        frame: usize,
        /// The dead line, such as `row 11`.
        line: String,
        /// Presses on dead lines.
        on_dead_lines: usize,
        /// Presses there are.
        presses: usize,
    },
    /// A labelled press where there is no taxel.
    #[error(
        "the press at row {row}, column {column} (frame {frame}) lies where `array.population` says that there is no taxel\nhint: rows and columns count from 0; correct the label, or the mask"
    )]
    PressOnAbsent {
        /// Row of the label.
        row: usize,
        /// Column of the label.
        column: usize,
        /// Frame of the label.
        frame: usize,
    },
    /// Two labels for one taxel of one frame that say different loads.
    #[error(
        "row {row}, column {column} of frame {frame} is labelled {first_g} g and {second_g} g\nhint: a taxel has one load at a time: remove the wrong label"
    )]
    PressTwice {
        /// Row of the labels.
        row: usize,
        /// Column of the labels.
        column: usize,
        /// Frame of the labels.
        frame: usize,
        /// Load of the first, grams.
        first_g: f64,
        /// Load of the second, grams.
        second_g: f64,
    },
    /// A label that is no load.
    #[error(
        "the press at row {row}, column {column} has a load of {load_g} g\nhint: loads are 0 or more, in grams"
    )]
    PressLoad {
        /// The load given, grams.
        load_g: f64,
        /// Row of the label.
        row: usize,
        /// Column of the label.
        column: usize,
    },
    /// Frames that show no load.
    #[error(
        "no taxel of {frames} frames reads more than the others\nhint: frames must be pressed in some places and not in others: a few fingers, a hand, the corner of a box"
    )]
    NothingPressed {
        /// Frames looked at.
        frames: usize,
    },
    /// Not enough to fit to.
    #[error(
        "{found} readable presses of {given} given, but a calibration needs at least {needed}\nhint: label more presses, spread over the array and the range of loads"
    )]
    TooFewPresses {
        /// Readable presses.
        found: usize,
        /// Presses given.
        given: usize,
        /// Fewest that a fit is tried with.
        needed: usize,
    },
    /// Loads that no calibration can be planned with.
    #[error(
        "presses of {loads_g:?} g on {taxels} taxels tell no load law\nhint: two different loads above nothing at the least, and a taxel that is not on a dead line"
    )]
    NoPressPlan {
        /// The loads, grams.
        loads_g: Vec<f64>,
        /// Taxels that could be pressed.
        taxels: usize,
    },
    /// Presses that are all of one load.
    #[error(
        "all {presses} presses are labelled {load_g} g, but a load law needs several loads\nhint: label presses from the lightest to the heaviest that you will measure"
    )]
    OneLoad {
        /// Presses.
        presses: usize,
        /// Their load, grams.
        load_g: f64,
    },
    /// No circuit and law explain the presses.
    #[error(
        "no circuit explains the labelled presses: {reason}\nhint: check topology, v_test_volts, the feedback or pull-down resistor, full_scale_volts and `inverted`, and that rows and columns are not swapped"
    )]
    NoFit {
        /// What failed.
        reason: String,
    },
    /// A fit that reads held-out presses no better than guessing would.
    #[error(
        "nothing was learnt from the labelled presses: held-out ones are {found_g:.1} g off on average, and guessing their median would be {blind_g:.1} g off\nhint: are the labels of these frames and taxels? Check their order, rows and columns, topology, v_test_volts and the feedback or pull-down resistor"
    )]
    NothingLearnt {
        /// Mean absolute error of held-out presses, grams.
        found_g: f64,
        /// The same of their median, grams.
        blind_g: f64,
    },
    /// No load law suits pairs of conductance and load.
    #[error(
        "no load law suits these pairs: {reason}\nhint: check that conductance (or resistance) and load are not swapped, their units, and that the loads differ"
    )]
    NoLaw {
        /// What failed.
        reason: String,
    },
    /// Uniform loads that tell no law.
    #[error("these uniform loads tell no law: {reason}\nhint: {hint}")]
    NoUniformLaw {
        /// What failed.
        reason: String,
        /// What to do.
        hint: &'static str,
    },
    /// Known totals that tell no law.
    #[error("these totals tell no law: {reason}\nhint: {hint}")]
    NoTotalsLaw {
        /// What failed.
        reason: String,
        /// What to do.
        hint: &'static str,
    },
    /// A series that is too short, or whose parts do not belong together.
    #[error(
        "the series has {frames} frames, {loads} frames of loads and {times} times, needs as many of each and {fewest} or more\nhint: one frame of known loads for each frame of counts"
    )]
    SeriesLength {
        /// Frames of counts.
        frames: usize,
        /// Frames of loads.
        loads: usize,
        /// Times.
        times: usize,
        /// The fewest that a fit is tried with.
        fewest: usize,
    },
    /// Times that do not ascend.
    #[error(
        "frame {frame} of the series is at {now} s, the one before at {before} s\nhint: times must ascend"
    )]
    SeriesTime {
        /// The frame, from 0.
        frame: usize,
        /// Seconds of the frame before.
        before: f64,
        /// Its seconds.
        now: f64,
    },
    /// A series that does not load enough taxels, or loads all.
    #[error(
        "{loaded} taxels of the series are ever loaded and {unloaded} never are, needs {fewest} and 1 or more\nhint: press on more taxels, and leave some free: their ghosts tell the circuit"
    )]
    SeriesTaxels {
        /// Taxels that are ever loaded.
        loaded: usize,
        /// The fewest that a fit is tried with.
        fewest: usize,
        /// Taxels that never are.
        unloaded: usize,
    },
}

/// A number as it is read: not with three hundred digits.
fn plain(number: f64) -> String {
    if number == 0.0 || !number.is_finite() || (1e-5..1e15).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}
