// What goes over the WebSocket as text: the page's side of crates/taxel-server/src/messages.rs and command.rs.
// testdata/messages.js has one of each message as the server writes it, and is checked against these types.

declare namespace Wire {
  type Message = Hello | State | Event | Details | Curve | Answer;

  /** What the page must know first; another one starts it afresh. */
  interface Hello {
    kind: "hello";
    protocol: number;
    program: string;
    sensor: SensorFacts;
    source: { address: string; type: "device" | "sim" | "file" };
    methods: string[];
    can_record: boolean;
    sliders: Slider[];
    file: { frames: number; duration_secs: number } | null;
    /** In the order of their codes. */
    marks: MarkMeaning[];
  }

  interface SensorFacts {
    name: string;
    rows: number;
    columns: number;
    /** Between rows, between columns. */
    pitch_mm: [number, number];
    /** Of a taxel, on a cone of one of the widest ring: what its load acts on, and its cell from line to line. */
    taxel_area_mm2: number;
    cell_area_mm2: number;
    bits: number;
    max_count: number;
    has_load_law: boolean;
    calibration: string | null;
    /** What has to be known of numbers that another program has found; null where they are read here. */
    exported: ExportedFacts | null;
    /** Where the taxels lie, x and y, row by row; null where they lie at the crossings of their lines. */
    positions_mm: ([number, number] | null)[] | null;
    /** Named parts of it. */
    regions: RegionFacts[];
    /** The cylinder or cone that the array is wrapped around; null where it is flat. */
    handle: HandleFacts | null;
  }

  interface RegionFacts {
    name: string;
    /** First row, last row, first column, last column, ends included; none goes across a seam. */
    boxes: [number, number, number, number][];
    /** Where it lies in which frames of a recording, the first and the last of them; none where it lies still in all. */
    windows: { frames: [number, number]; boxes: [number, number, number, number][] }[];
  }

  interface ExportedFacts {
    words: string;
    /** Of numbers that are no loads. */
    unit: string | null;
    per_siemens: number;
  }

  interface HandleFacts {
    /** Which lines run round it; the others run along it. */
    rings: "rows" | "columns";
    /** Of each line along it, radians, ascending from 0 to below 2π. */
    angles: number[];
    /** Of each ring. */
    radii_mm: number[];
    /** Of each ring above the first, along the axis. */
    heights_mm: number[];
    /** Of each ring: the areas of its taxels as a share of those of the widest. */
    narrowness: number[];
    /** Angle between surface and axis, radians: positive where the body narrows from the first ring to the last. */
    slope: number;
    /** Whether the last line along it is a neighbour of the first. */
    closes: boolean;
  }

  type Slider = Range | Switch;
  interface SliderFacts {
    key: string;
    label: string;
    unit: string;
    value: number;
  }
  interface Range extends SliderFacts {
    type: "range";
    min: number;
    max: number;
    step: number;
    logarithmic: boolean;
  }
  interface Switch extends SliderFacts {
    type: "switch";
  }

  interface MarkMeaning {
    word: string;
    text: string;
    /** 2: do not trust the value; 1: be careful with it. */
    severity: 0 | 1 | 2;
    /** The taxel counts in totals. */
    counts: boolean;
    /** Its value may set the scale of colours. */
    scales: boolean;
  }

  /** How things stand. */
  interface State {
    kind: "state";
    device: { state: DeviceState; text: string };
    frames_per_second: number;
    frames: number;
    lost: number;
    corrupt: number;
    repeated: number;
    skipped: number;
    latency_ms: { median: number; p99: number };
    clients: number;
    tare: { on: boolean; host_secs: number };
    recording: Recording | null;
    method: string;
    player: Player | null;
    sliders: Record<string, number>;
    bad_lines: BadLines;
    /** null where there is no grip session. */
    grip: GripSession | null;
    /** null where there is no guided calibration. */
    calibration: CalibrationSession | null;
  }

  /** Press after press, until more gain nothing. */
  interface CalibrationSession {
    phase: CalibrationPhase;
    /** What is to be pressed now; null where nothing is. */
    asked: AskedPress | null;
    /** What presses now; null where nothing does. */
    seen: SeenPress | null;
    /** All presses that were taken, in order. */
    presses: TakenPress[];
    /** How good the calibration was after so many presses, in order. */
    progress: HeldOutError[];
    /** Whether more presses gain nothing any more. */
    is_enough: boolean;
    /** What the calibration says of itself, in words; may be empty. */
    advice: string;
    /** Presses before which it is not asked whether that is enough. */
    least_presses: number;
    /** The loads that there are, grams, ascending. */
    loads_g: number[];
    sensor: string;
    folder: string;
    /** Where the calibrated sensor goes. */
    output: string;
    /** What makes the result doubtful, in words. */
    warnings: string[];
    /** Why the calibrated sensor should not be used as it is; empty where it may, and before the end. */
    doubts: string[];
    /** Why something did not work; empty where all did. */
    trouble: string;
    is_resumed: boolean;
    is_simulated: boolean;
    /** To be fetched from /results/; empty before the calibration has ended. */
    files: string[];
  }

  type CalibrationPhase =
    | "empty" | "reading" | "others" | "press" | "elsewhere" | "taking" | "off" | "finishing" | "done";

  interface AskedPress {
    /** From 0; null (both) where the whole sensor is to be loaded evenly. */
    row: number | null;
    column: number | null;
    /** On that taxel, or on each taxel, grams. */
    load_g: number;
    /** Other things lie on the sensor meanwhile. */
    is_among_others: boolean;
    /** Why this one, in words. */
    why: string;
    /** It was pressed before, and the others contradict it. */
    is_again: boolean;
  }

  interface SeenPress {
    /** The taxel that is pressed most, from 0. */
    row: number;
    column: number;
    is_there: boolean;
    /** 0 to 1: how far it stands. */
    standing: number;
    /** What is wrong with it, in words; empty where nothing is. */
    problem: string;
  }

  interface TakenPress {
    /** What was asked for, at the taxel where it stood. */
    asked: AskedPress;
    /** What the calibration without this press says of it, grams. */
    says_g: number | null;
    /** Why it is left out; empty where it counts. */
    left_out: string;
  }

  /** How good the calibration was after so many presses. */
  interface HeldOutError {
    presses: number;
    /** Grams; null as long as nothing could be fitted. */
    mean_absolute_g: number | null;
    standard_error_g: number;
  }

  /** `is` and what belongs to it, in `{ do: "calibrate", step }`. */
  type CalibrationStep =
    | { is: "ready" } | { is: "here" } | { is: "skip" } | { is: "load"; load_g: number } | { is: "undo" } | { is: "finish" };

  /** One person, one operator, trial after trial. */
  interface GripSession {
    phase: GripPhase;
    /** Until the phase ends by itself; null where the operator ends it. */
    remaining_secs: number | null;
    /** How long it lasts in all. */
    lasts_secs: number | null;
    /** Empty before the session begins. */
    person: string;
    folder: string;
    /** The trial that is next or going on: its place in `trials`. */
    trial: number | null;
    trials: GripTrial[];
    /** What was measured last, to be accepted or repeated. */
    measured: GripMeasured | null;
    protocol: GripProtocol;
    /** What makes the numbers doubtful, in words. */
    warnings: string[];
    /** Why something did not work; empty where all did. */
    trouble: string;
    is_resumed: boolean;
    is_simulated: boolean;
    /** To be fetched from /results/; empty before the session has ended. */
    files: string[];
  }

  type GripPhase =
    | "setup" | "zero" | "ready" | "countdown" | "hold" | "measuring" | "review" | "rest" | "finishing" | "done";

  interface GripTrial {
    hand: "left" | "right";
    /** Which of that hand's trials, from 1. */
    number: number;
    repeats: number;
    accepted: GripMeasured | null;
  }

  /** What a trial came to; forces are what the protocol speaks of. */
  interface GripMeasured {
    max_newtons: number;
    plateau_newtons: number | null;
    variation_percent: number | null;
    time_to_peak_secs: number;
    total_newtons: number;
    doubts: string[];
  }

  interface GripProtocol {
    name: string;
    posture: string;
    hold_secs: number;
    rest_secs: number;
    /** From and to; null: as strongly as possible. */
    target_newtons: [number, number] | null;
    /** What the force is, in words. */
    force: string;
  }

  type DeviceState = "live" | "waiting" | "lost" | "ended" | "paused";

  interface Recording {
    name: string;
    frames: number;
    bytes: number;
    secs: number;
    error: string | null;
  }

  interface Player {
    playing: boolean;
    speed: number;
    position_secs: number;
    duration_secs: number;
    frame: number;
    frames: number;
  }

  interface BadLines {
    rows: number[];
    columns: number[];
    suspect_rows: number[];
    suspect_columns: number[];
  }

  interface Event {
    kind: "event";
    host_secs: number;
    text: string;
  }

  /** What the whole of a recording looks like, before any of it was played; null where a frame has no answer. */
  interface Curve {
    kind: "curve";
    /** How its loads were found. */
    method: string;
    /** Since its first frame. */
    secs: number[];
    total_newtons: (number | null)[];
    peak_kilopascals: (number | null)[];
    contact_area_mm2: (number | null)[];
  }

  interface Details {
    kind: "details";
    taxels: TaxelDetails[];
    /** null where nothing is known, or frames are no loads. */
    figures: FigureDetails | null;
  }

  /** What the figures of one frame are uncertain by; null where nothing bounds it. */
  interface FigureDetails {
    sequence: number;
    total_newtons: number;
    total_half_width_95_newtons: number | null;
    contact_area_mm2: number;
    contact_area_half_width_95_mm2: number | null;
    /** Whether those are of the noise alone. */
    noise_only: boolean;
    /** Empty where something does. */
    why_unbounded: string;
  }

  interface TaxelDetails {
    row: number;
    column: number;
    sequence: number;
    load: number;
    raw: number;
    counts: number;
    mark: number;
    /** null where loads are estimated without one. */
    siemens: number | null;
    /** null where it means nothing. */
    half_width_95_newtons: number | null;
    /** Whether that is of the noise alone. */
    noise_only: boolean;
  }

  interface Answer {
    kind: "answer";
    to: number;
    ok: boolean;
    text: string;
  }

  /** What the page may ask for; its number, `id`, is added when it is sent. */
  type Request =
    | { do: "tare"; force?: boolean }
    | { do: "untare" }
    | { do: "record"; name?: string }
    | { do: "stop" }
    | { do: "event"; text: string }
    | { do: "method"; name: string }
    | { do: "slider"; key: string; value: number }
    | { do: "play" }
    | { do: "pause" }
    | { do: "seek"; secs: number }
    | { do: "speed"; factor: number }
    | { do: "watch"; taxels: [number, number][]; figures: boolean }
    | { do: "grip"; step: GripStep }
    | { do: "calibrate"; step: CalibrationStep }
    | { do: "rate"; frames_per_second: number }
    | { do: "got"; sequence: number };

  /** What the operator of a grip session does. */
  type GripStep =
    | { is: "begin"; person: string; note?: string }
    | { is: "zero"; force?: boolean }
    | { is: "start" }
    | { is: "cancel" }
    | { is: "accept" }
    | { is: "repeat"; reason: string }
    | { is: "skip-rest" }
    | { is: "finish" };
}
