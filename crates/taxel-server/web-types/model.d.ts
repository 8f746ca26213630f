// Types of the interactive model.

declare namespace Model {
  /** The numbers of a setting, ohms and volts. */
  interface Numbers {
    openLoopGain: number;
    feedbackOhms: number;
    otherOhms: number;
    taxelOhms: number;
    testVolts: number;
    switchOhms: number;
    sourceOhms: number;
  }

  interface Setting extends Numbers {
    name: string;
    /** 0 to 3. */
    colour: number;
  }

  interface Parameter {
    key: keyof Numbers;
    symbol: string;
    below: string;
    words: string;
    unit: string;
    /** The ends of the slider. */
    min: number;
    max: number;
    log: boolean;
    step?: number;
    zero?: boolean;
  }

  type Quantity = "volts" | "counts" | "drop";

  /** A quantity at N = 0, 1, … */
  interface Curve extends Record<Quantity, number[]> {
    saturates: boolean[];
  }

  interface Curves {
    name: string;
    colour: number;
    circuit: Curve;
    paper: Curve;
  }

  interface Point {
    n: number;
    value: number;
  }

  /** Of readings at the same N; `half` of the 95 % interval of the mean, null for a single reading. */
  interface Summary {
    n: number;
    count: number;
    mean: number;
    half: number | null;
  }

  interface View {
    y: Quantity;
    fromZero: boolean;
    last: number;
    fullScaleVolts: number;
    /** What measured values are. */
    unit: string;
    nCounts: "others" | "pressed";
  }

  interface Shown extends Pick<View, "y" | "fromZero" | "last" | "fullScaleVolts"> {
    curves: Curves[];
    points: Point[];
    summary: Summary[];
    at: number;
  }
}
