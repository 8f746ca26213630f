// Types that several parts of the page share.

declare namespace Page {
  /** A frame as the parts use it; loads in newtons, or in siemens without a load law. */
  interface Frame extends FrameScalars {
    rows: number;
    columns: number;
    counts: Uint16Array;
    raw: Float32Array;
    compensated: Float32Array;
    marks: Uint8Array;
  }

  /** NaN: unknown. */
  interface FrameScalars {
    sequence: number;
    /** Seconds since 1970. */
    host: number;
    /** Seconds of the device's clock. */
    device: number;
    flags: number;
    /** Newtons, kPa, mm2. */
    total: number;
    peak: number;
    area: number;
    copRow: number;
    copColumn: number;
    /** A share. */
    outliers: number;
    /** Milliseconds. */
    age: number;
    /** Frames a second. */
    rate: number;
    /** The largest grip force along any direction, N; NaN of a sensor that is no handle. */
    grip: number;
  }

  /** A packed value v is low + v * step. */
  interface PackedRange {
    low: number;
    step: number;
  }

  /** A frame in the buffer, its loads packed. */
  interface Slot extends FrameScalars {
    counts: Uint16Array;
    marks: Uint8Array;
    raw: Uint16Array;
    compensated: Uint16Array;
    rawRange: PackedRange;
    compensatedRange: PackedRange;
    /** The load from which on a taxel is in contact; NaN: not worked out yet. */
    threshold: number;
  }

  interface Taxel {
    row: number;
    column: number;
  }

  /** [column, row] in taxels. */
  type Corner = [number, number];

  interface Unit {
    key: string;
    text: string;
    pressure: boolean;
    factor: number;
  }

  interface Measures {
    force: number;
    peak: number;
    mean: number;
    area: number;
  }

  interface ItemFacts {
    number: number;
    label: string;
    colour: string;
    taxels: number[];
    series: import("../web/js/series.js").Series<keyof Measures>;
  }
  interface Pin extends ItemFacts, Taxel {
    letter: "P";
  }
  interface Region extends ItemFacts {
    letter: "R";
    /** What people call it: as its label, until it is given a name. */
    name: string;
    /** How it was drawn, or where it comes from. */
    shape: string;
    /** Closed lines around it. */
    outlines: Corner[][];
    /** Where it lies in which frames, the first and the last of them; none where it lies still in all. */
    windows: RegionWindow[];
  }
  interface RegionWindow extends Place {
    frames: [number, number];
  }
  /** Where something lies. */
  interface Place {
    taxels: number[];
    outlines: Corner[][];
  }
  type Item = Pin | Region;

  /** What happened, on the time line; seconds since 1970. */
  interface Happening {
    time: number;
    text: string;
  }

  /** What a drawing of the maps is made of. */
  interface Scene {
    frame: Frame;
    sensor: Wire.SensorFacts;
    meanings: import("../web/js/marks.js").MarkTable;
    /** The marks that the layer with the marks shows, and how often they have changed. */
    marks: Uint8Array;
    marksVersion: number;
    badLines: Wire.BadLines;
    badLinesKey: string;
    draft: Corner[] | null;
    trail: import("../web/js/trail.js").Trail;
    selection: import("../web/js/selection.js").Selection;
    picked: Taxel | null;
    smooth: boolean;
    showMarks: boolean;
    showCop: boolean;
  }

  interface Answering {
    (ok: boolean, text: string): void;
  }
}

interface Window {
  uPlot: typeof import("uplot");
  /** For tests: what the page has and shows. */
  taxelView: {
    readonly frames: number;
    readonly lastSequence: number | null;
    readonly connected: boolean;
    shown(): { sequence: number; total_newtons: number | null; unit: string; method: string } | null;
  };
}
