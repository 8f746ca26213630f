// What total force and contact area are uncertain by. It comes twice a second, frames come more often: what is shown beside
// a frame was found for one a little before it, and is shown only where that one carried the same.

/** For how long details are of what is shown, ms. */
export const DETAILS_VALID_MS = 2500;
/** A frame that has stood for so long is shown with its own interval or none, ms: no newer one will come soon. */
const STANDS_MS = 1500;
/** Intervals grow with loads: up to this change of a figure, as a share, what was found before will do. */
const SAME_SHARE = 0.1;

const NOTHING = { half: null, words: "" };

/**
 * What of the view it has to know.
 * @typedef {object} Shown
 * @property {Readonly<{ paused: boolean, newtons: boolean, frameAt: number }>} now
 * @property {(names: "hello"[], tell: () => void) => unknown} on
 */

export class Figures {
  /** @param {Shown} view */
  constructor(view) {
    this.view = view;
    /** Of the last seconds, the newest first: a hand that grips again and again is soon where it has been. */
    /** @type {{ details: Wire.FigureDetails, at: number }[]} */
    this.told = [];
    view.on(["hello"], () => { this.told = []; });
  }

  /** @param {Wire.Details} message */
  take(message) {
    const at = performance.now();
    const kept = this.told.filter((one) => at - one.at <= DETAILS_VALID_MS);
    // Without: conductances, or a server of before this page, which knew no figures.
    this.told = message.figures ? [{ details: message.figures, at }, ...kept] : [];
  }

  /**
   * Half the width of the 95 % interval of a figure as it is shown, newtons or mm²; null: none is to be shown. And what
   * else there is to say of it.
   * @param {"force" | "peak" | "area"} name the peak has none: which taxel is the highest is uncertain too
   * @param {Page.Frame} shown
   * @returns {{ half: number | null, words: string }}
   */
  of(name, shown) {
    const told = this.toldOf(shown);
    if (name === "peak" || told.length === 0) return NOTHING;
    const [newest] = told;
    if (halfOf(name, newest) === null) return { half: null, words: newest.why_unbounded && `No ± now: ${newest.why_unbounded}` };
    const value = name === "force" ? shown.total : shown.area;
    const found = told.find((details) => isNear(name, details, value));
    if (!found) return NOTHING;
    return { half: halfOf(name, found), words: `± is half of the 95 % interval${found.noise_only ? " (noise only: the sensor file has no [uncertainty])" : ""}` };
  }

  /**
   * What may be said beside this frame, the newest first.
   * @param {Page.Frame} shown
   */
  toldOf(shown) {
    const { paused, newtons, frameAt } = this.view.now;
    if (paused || !newtons) return [];
    const now = performance.now();
    const moves = now - frameAt < STANDS_MS;
    const fresh = this.told.filter(({ details, at }) => now - at <= DETAILS_VALID_MS && (moves || details.sequence === shown.sequence));
    return fresh.map(({ details }) => details);
  }
}

/**
 * @param {"force" | "area"} name
 * @param {Wire.FigureDetails} details
 */
function halfOf(name, details) {
  return name === "force" ? details.total_half_width_95_newtons : details.contact_area_half_width_95_mm2;
}

/**
 * Whether the figure was then what it is now.
 * @param {"force" | "area"} name
 * @param {Wire.FigureDetails} details
 * @param {number} value
 */
function isNear(name, details, value) {
  const figure = name === "force" ? details.total_newtons : details.contact_area_mm2;
  const half = halfOf(name, details);
  return half !== null && Math.abs(value - figure) <= Math.max(half, SAME_SHARE * Math.max(Math.abs(value), Math.abs(figure)));
}
