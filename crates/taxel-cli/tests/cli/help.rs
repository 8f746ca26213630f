//! What the command says about itself.

use crate::run::Folder;

#[test]
fn without_a_verb_the_help_is_shown_and_the_exit_code_is_2() {
    insta::assert_snapshot!(Folder::new().taxel(""), @"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    From raw frames of a resistive pressure-sensor matrix to calibrated loads

    Usage: taxel <COMMAND>

    Measure:
      live         Show a sensor live in the browser, compensated; record it
      grip         Measure a person's grip: trials by a protocol, live, with one page at the end
      view         Play a recording in the browser
      record       Record a sensor
      replay       Send a recording as a device would, in protocol taxel-1
      stream       Send every frame of a live source as a line of JSON
      convert      Write a recording in another format
      recover      Repair a recording that was cut off
      devices      List the serial ports of this machine

    Look:
      info         Summarise a recording
      measure      Measure forces over time: total, grip, fingers; peak, plateau, fatigue of each trial
      analyse      Look at taxels of a recording over time: a taxel, a row, a column, a region
      plot         Draw frames, or values over frames
      selftest     Test a sensor: open, shorted, stuck, noisy and flickering lines and taxels
      identify     Tell which read-out explains recordings, and what to measure where several do

    Fit and compensate:
      calibrate    Fit switch resistances and load law to labelled presses
      check        Tell whether a calibrated sensor still is what it was
      compensate   Remove the cross-talk from a recording
      batch        Work through an archive of recordings
      dataset      Make a training set
      train        Train a network on labelled presses
      compare      Compare ways from counts to loads on your own data
      model        Show a model's card, or exchange it through ONNX

    Publish:
      evaluate     Evaluate a sensor by a plan: repeatability, response, hysteresis, creep, cross-talk, accuracy
      report       Write an evaluation as one file: every figure, table and plot, the sensor, versions, data fingerprints

    Design and simulate:
      demo         Watch the whole chain at work on a simulated hand
      simulate     Record with a virtual sensor
      design       Size a read-out: test voltage, resistor, settling, ghosts, resolution
      budget       Split a sensor's error by cause; what other parts would make of it
      rig          Plan presses: springs and tips to pressures, and how many experiments
      crosstalk    Draw V_out against the number N of other pressed taxels of a row
      netlist      Write a sensor's circuit as a SPICE netlist
      bench        Time scan and inverse of a sensor on this machine

    Set up:
      completions  Print the script by which a shell completes verbs and options

    Options:
      -h, --help     Print help (see more with '--help')
      -V, --version  Print version

    `taxel VERB --help` tells more of a verb, with examples.
    ");
}

/// What a narrow terminal shows can be copied line by line.
#[test]
fn examples_go_on_in_the_next_line_where_the_terminal_is_narrow() {
    let help = std::process::Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(["calibrate", "-h"])
        .env("COLUMNS", "60")
        .stdin(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .output()
        .unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let examples = help.split_once("Examples:\n").unwrap().1;
    assert_eq!(
        examples.lines().take(5).collect::<Vec<_>>(),
        [
            "  # guided",
            "  taxel calibrate --live sim:mat-16x16-cd4067 \\",
            "    -o calibrated.toml",
            "  taxel calibrate --sensor sensor.toml \\",
            "    --presses experiments.csv -o calibrated.toml",
        ]
    );
}

#[test]
fn an_unknown_verb_names_the_nearest() {
    insta::assert_snapshot!(Folder::new().taxel("compenstae"), @"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: unrecognized subcommand 'compenstae'

      tip: some similar subcommands exist: 'compare', 'completions', 'compensate'

    Usage: taxel <COMMAND>

    For more information, try '--help'.
    ");
}

#[test]
fn flags_of_compensate() {
    insta::assert_snapshot!(Folder::new().taxel("compensate -h"), @"
    exit code: 0
    ----- stdout -----
    Remove the cross-talk from a recording

    Usage: taxel compensate [OPTIONS] <RECORDING>

    Arguments:
      <RECORDING>  Recording (.mcap, .parquet, .txt, .csv, .npy, .npz, - for standard input)

    Options:
          --sensor <FILE|PRESET>     Sensor file, or the name of a preset; .mcap and .parquet bring
                                     their own
          --unit <UNIT>              Unit of what is written; .mcap and .parquet hold newtons, g or N
                                     given [default: g] [possible values: volts, siemens, g, N, kPa,
                                     MPa]
          --input-unit <INPUT_UNIT>  Unit of what is read; volts and siemens are real numbers (.csv,
                                     .npy, .npz) [default: counts] [possible values: counts, volts,
                                     siemens]
      -o, --output <FILE>            Where to write (.csv, .npy, .npz, .mcap, .parquet, .asf, .xdf);
                                     without it, numbers go to standard output
          --as <FORMAT>              Write loads as other programs read them: `tekscan` (ASCII, kPa),
                                     `rsscan` (text, newtons), `xdf` (newtons, with times, marks and the
                                     sensor file), `ros2` (a bag of images and wrenches), `table` (a
                                     line a frame, a column a taxel, newtons); .asf and .xdf say so
                                     themselves
          --method <NAME|MODEL>      How loads are found: auto (what suits the read-out), exact, newton,
                                     raw (no compensation), or the file of a model that `taxel train`
                                     wrote [default: auto]
          --marks <FILE>             Where to write the marks, one code a taxel, in the shape of the
                                     numbers
          --standard-error <FILE>    Where to write the standard error of each number: noise, fit and
                                     model; marks what it exceeds as unresolved
          --interval <FILE>          Where to write half the width of each number's 95 % interval
          --parts                    Write what the standard errors are made of as well, beside them: of
                                     se.npz se.noise.npz, se.fit.npz and se.model.npz
          --figures <FILE>           Where to write total force, contact area and centre of pressure of
                                     each frame, with half of their 95 % intervals and what these are
                                     made of (.csv)
          --keep-going               Leave out frames that cannot be read, instead of stopping at the
                                     first
          --repair                   Replace what was not measured by the median of its neighbours, and
                                     mark it interpolated
          --no-repair                Replace nothing, even if the sensor file asks for it
          --no-tare                  Leave the recording's tare on
          --transpose                The recording has rows and columns swapped
          --with-names               Keep in the header of what is written what a file of another
                                     program says of persons, and names of files; left out else
          --threads <N>              Threads that share the work, with the same results; as many as
                                     there are cores where it is not given
          --json                     Print a summary as JSON
      -h, --help                     Print help (see more with '--help')

    Examples:
      taxel compensate hand.txt --sensor calibrated.toml --unit g -o loads.csv
      taxel compensate hand.txt --sensor calibrated.toml -o loads.npy --marks marks.npy
      taxel compensate hand.txt --sensor calibrated.toml --method model.safetensors -o loads.csv
    ----- stderr -----
    ");
}

#[test]
#[allow(clippy::too_many_lines, reason = "a help is as long as it is")]
fn flags_of_calibrate() {
    insta::assert_snapshot!(Folder::new().taxel("calibrate -h"), @"
    exit code: 0
    ----- stdout -----
    Fit switch resistances and load law to labelled presses

    Usage: taxel calibrate [OPTIONS] --output <FILE>

    Options:
          --sensor <FILE|PRESET>  Sensor file (the parts list), or the name of a preset; .mcap and
                                  .parquet bring their own
          --presses <FILE>        Labelled presses: CSV with recording, frame, row, column (or taxel),
                                  load_g
          --equilibration <FILE>  Frames under the same load everywhere: CSV with recording, frame,
                                  load_g; without presses they tell law and gains alone
          --pairs <FILE>          Fit the load law alone, to pairs of conductance (or resistance) and
                                  load
          --totals <FILE>         Frames of known total load (a scale below, a person's weight): CSV
                                  with recording, frame, load_g (0: empty), perhaps group; tell the law
                                  alone
          --series <FILE>         Instead: a recording whose loads are known all the time, from rest;
                                  finds creep and hysteresis too
          --loads <FILE>          The load of every taxel in every frame of the series, g
          --period <SECONDS>      Seconds between frames of the series, where it tells no times
          --lags <N>              Lags (creep) to fit to the series [default: 3]
          --plays <N>             Plays (hysteresis) to fit to the series [default: 3]
          --static-output <FILE>  Where to write the sensor with the best static law of the series, to
                                  compare with
      -o, --output <FILE>         Where to write the calibrated sensor
          --law <LAW>             The load law; `auto` leaves the power law only where presses clearly
                                  tell another [default: auto] [possible values: auto, power,
                                  saturating, spline]
          --per-line              Fit one switch resistance per line, even without equilibration frames
          --fit-gain              Fit the amplifier's open-loop gain
          --fit-source            Fit the source resistor
          --line-resistance       Look for resistance along the lines on large arrays as well (minutes)
          --label-error <SHARE>   What the labelled loads themselves are off by, such as 2% or 0.02:
                                  taken out of what the sensor is uncertain by [default: 0]
          --residuals <FILE>      Where to write what is read of each press beside its label, by fits
                                  without it and by the fit of all (.csv)
          --picture <FILE>        Where to draw residuals, how many their intervals hold, gain of each
                                  taxel and load law (.png, .svg, .pdf)
          --certificate <FILE>    Where to write the certificate: how far off it is, by what, and of
                                  which files (.html, .pdf)
          --folds <N>             Folds of the cross-validation by press; of --totals that are all one
                                  load, stretches of frames held out [default: 5]
          --transpose             The recordings have rows and columns swapped
          --json                  Print the report as JSON
      -h, --help                  Print help (see more with '--help')

    Guided, with --live:
          --live <SOURCE>          Instead of a table: from this source, press after press, as it asks;
                                   sim:mat-16x16-cd4067 presses itself
          --weights <G,G,…>        What your weights press one taxel with, grams: 50,100,200,500
          --even-weights <G,G,…>   What you can lay on all taxels alike, grams on each taxel
          --folder <FOLDER>        Where calibrations are kept, each in a folder of its own [default:
                                   calibrations]
          --new                    Begin anew, though a calibration of this sensor was left unfinished
          --terminal               Without a page: Enter goes on, words do the rest
          --listen <ADDRESS:PORT>  Address to listen on (a token protects it on other addresses)
                                   [default: 127.0.0.1:8432]
          --token <TOKEN>          Access token, at least 8 of A-Z, a-z, 0-9, - . _ ~; generated when
                                   --listen is not local
          --token-file <FILE>      File whose first line is the access token: unlike --token it does not
                                   show in the list of processes

    Examples:
      taxel calibrate --live sim:mat-16x16-cd4067 -o calibrated.toml    # guided
      taxel calibrate --sensor sensor.toml --presses experiments.csv -o calibrated.toml
      taxel calibrate --sensor calibrated.toml --series run.txt --loads g.csv --period 0.05 -o d.toml
    ----- stderr -----
    ");
}

#[test]
fn flags_of_simulate() {
    insta::assert_snapshot!(Folder::new().taxel("simulate -h"), @"
    exit code: 0
    ----- stdout -----
    Record with a virtual sensor

    Usage: taxel simulate [OPTIONS] --sensor <FILE|PRESET> <--conductance <FILE>|--pattern <PATTERN>>

    Options:
          --sensor <FILE|PRESET>   Sensor file, or the name of a preset
          --conductance <FILE>     Conductances to scan, siemens (.csv, .npy, .npz, - for standard
                                   input)
          --pattern <PATTERN>      What presses on the array [possible values: hand, grip, regrip,
                                   fingers, feet, uniform, random, blobs, press]
          --unit <UNIT>            What to write: V_out in volts (before any noise), or the converter's
                                   counts. Default: volts for --conductance, counts for --pattern
                                   [possible values: volts, counts]
      -o, --output <FILE>          Where to write it (.txt, .csv, .npy, .npz; counts also .mcap, with
                                   the sensor); without it, numbers go to standard output
          --transpose              The file of conductances has rows and columns swapped
          --frames <N>             How many frames [default: 1]
          --seed <S>               The seed of everything that is drawn [default: 1]
          --load-g <G>             The highest load on a taxel, grams; several share the frames between
                                   them, in order
          --period <SECONDS>       Time from frame to frame, seconds; written into .csv
          --imperfect <IMPERFECT>  Draw a sensor that differs from the sensor file [possible values:
                                   uneven, beyond, sheet, creep]
          --stuck <SHARE>          Share of the readings that stand at an end of the converter, whatever
                                   presses: 0.002, 0.2%
          --truth <FILE>           Where to write all loads, grams
          --truth-sensor <FILE>    Where to write the sensor that was drawn
          --presses <FILE>         Where to write one labelled taxel a frame, for `calibrate --presses`;
                                   of a uniform load the load alone, for `calibrate --equilibration`
      -h, --help                   Print help (see more with '--help')

    Examples:
      taxel simulate --sensor econe --pattern press --frames 120 --presses experiments.csv -o p.txt
      taxel simulate --sensor econe --pattern hand --frames 160 --truth truth.csv -o hand.txt
      taxel simulate --sensor econe --pattern uniform --load-g 0 --frames 100 -o empty.txt
    ----- stderr -----
    ");
}

#[test]
fn flags_of_info() {
    insta::assert_snapshot!(Folder::new().taxel("info -h"), @"
    exit code: 0
    ----- stdout -----
    Summarise a recording

    Usage: taxel info [OPTIONS] <RECORDING>

    Arguments:
      <RECORDING>  Recording (.mcap, .parquet, .txt, .csv, .npy, .npz; with a sensor also - for standard
                   input)

    Options:
          --sensor <FILE|PRESET>  Sensor file, or the name of a preset; .mcap and .parquet bring their
                                  own
          --rows <N>              Rows of a frame, where there is no sensor
          --values                The file holds values, not counts; do not screen. Of .mcap and
                                  .parquet: their loads, newtons
          --keep-going            Leave out frames that cannot be read, instead of stopping at the first
          --transpose             The recording has rows and columns swapped
          --with-names            Show, and keep in the sensor file that is written, what a file of
                                  another program says of persons, and names of files; left out else
          --write-sensor <FILE>   Where to write the sensor file that the recording carries (.toml), to
                                  be looked at and changed
          --json                  Print JSON
      -h, --help                  Print help (see more with '--help')

    Examples:
      taxel info run.mcap
      taxel info hand.txt --sensor calibrated.toml --json
    ----- stderr -----
    ");
}

#[test]
fn flags_of_plot() {
    insta::assert_snapshot!(Folder::new().taxel("plot -h"), @"
    exit code: 0
    ----- stdout -----
    Draw frames, or values over frames

    Usage: taxel plot [OPTIONS] --output <FILE> <FILE>

    Arguments:
      <FILE>  Recording of counts (.mcap, .parquet, .txt, .csv, .npy, .npz); with --values any numbers

    Options:
          --sensor <FILE|PRESET>           Sensor file, or the name of a preset; .mcap and .parquet
                                           bring their own
          --frame <N>                      Which frame, from 0
          --frames <A..B>                  Which frames: a..b without b, a..=b with it, a.. to the end
          --mean                           The mean of every taxel over the frames (all of them, or
                                           those of --frames), readings that were lost left out
          --peak                           The highest value of every taxel over the frames, each its
                                           own: what a peak pressure map shows
          --beside <FILE>                  A second recording of the same kind, beside the first over
                                           one range of colours: its same frame, or its own --mean or
                                           --peak
          --taxel <ROW,COLUMN|C7>          A taxel's values over frames; several are several lines
          --row <N>                        A row's values over frames
          --column <N>                     A column's values over frames
          --raw                            Without compensation
          --before-after                   Both without and with compensation
          --body                           On the handle that the array is wrapped around
                                           ([array.geometry]), seen from four sides
          --values                         The numbers are what they are (loads.csv; of .mcap and
                                           .parquet their loads, N): nothing is converted, --unit is for
                                           the label
          --unit <UNIT>                    Unit; without it, g where the sensor has a load law, else
                                           siemens [possible values: volts, siemens, g, N, kPa, MPa]
          --method <NAME|MODEL>            How loads are found: auto, exact, newton, raw, or the file of
                                           a model that `taxel train` wrote [default: auto]
          --interpolation <INTERPOLATION>  How values between taxels are drawn [default: bilinear]
                                           [possible values: bilinear, nearest]
          --rows <N>                       Rows of a frame, where there is no sensor
          --no-tare                        Leave the recording's tare on
          --transpose                      The file has rows and columns swapped
          --title <TEXT>                   The line above the picture
          --range <LOW..HIGH>              Ends of the colours, or of the values' axis, in the unit
                                           drawn, so that pictures compare: 0..50
          --size <WIDTHxHEIGHT>            Size of the picture, which is laid out to fit: pixels of .png
                                           and .gif, points of .svg and .pdf
          --dpi <N>                        Pixels per inch; text keeps its size in points [default: 144
                                           for .png, 96 for .gif]
          --mm                             Axes of maps in millimetres from the first taxel's centre, by
                                           the sensor's pitch
          --speed <TIMES>                  How many times as fast as the recording a .gif is shown
                                           [default: 1]
      -o, --output <FILE>                  Where to write the picture (.png, .svg, .pdf), or the frames
                                           as a movie (.gif)
      -h, --help                           Print help (see more with '--help')

    Examples:
      taxel plot hand.txt --sensor calibrated.toml --frame 68 -o picture.png
      taxel plot run.mcap --frames 100..300 --speed 0.5 -o run.gif    # a movie at half the pace
      taxel plot run.mcap --frame 40 --body --range 0..50 --title 'Left hand' -o left.png
    ----- stderr -----
    ");
}

#[test]
fn flags_of_netlist() {
    insta::assert_snapshot!(Folder::new().taxel("netlist -h"), @"
    exit code: 0
    ----- stdout -----
    Write a sensor's circuit as a SPICE netlist

    Usage: taxel netlist [OPTIONS] [RECORDING]

    Arguments:
      [RECORDING]  Recording of counts whose conductances to take

    Options:
          --sensor <FILE|PRESET>   Sensor file, or the name of a preset; .mcap and .parquet bring their
                                   own
          --conductance <FILE>     Conductances of the taxels, siemens: R lines of C numbers a frame
          --frame <N>              Which frame of the file, from 0 [default: 0]
          --taxel <ROW,COLUMN|C7>  The taxel to read [default: 0,0]
          --scan                   Read every taxel, one after the other (a script for ngspice)
      -o, --output <FILE>          Where to write it; without it, standard output
      -h, --help                   Print help (see more with '--help')

    Examples:
      taxel netlist --sensor sensor.toml --conductance siemens.csv --taxel 3,4 -o taxel.cir
    ----- stderr -----
    ");
}

#[test]
fn flags_of_bench() {
    insta::assert_snapshot!(Folder::new().taxel("bench -h"), @"
    exit code: 0
    ----- stdout -----
    Time scan and inverse of a sensor on this machine

    Usage: taxel bench [OPTIONS]

    Options:
          --sensor <FILE|PRESET>  Sensor file, or the name of a preset [default: econe]
          --method <NAME|MODEL>   How loads are found: auto, exact, newton, raw, or the file of a model
                                  that `taxel train` wrote [default: auto]
          --json                  Print JSON instead of a table
      -h, --help                  Print help (see more with '--help')

    Examples:
      taxel bench --sensor econe
    ----- stderr -----
    ");
}

#[test]
fn flags_of_demo() {
    insta::assert_snapshot!(Folder::new().taxel("demo -h"), @"
    exit code: 0
    ----- stdout -----
    Watch the whole chain at work on a simulated hand

    Usage: taxel demo

    Options:
      -h, --help  Print help (see more with '--help')

    Examples:
      taxel demo
    ----- stderr -----
    ");
}

#[test]
fn an_unknown_unit_is_a_bad_argument() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.taxel("compensate a.txt --sensor sensor.toml --unit lb"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: invalid value 'lb' for '--unit <UNIT>'
      [possible values: volts, siemens, g, N, kPa, MPa]

    For more information, try '--help'.
    ");
}
