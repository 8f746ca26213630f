// The pointer on the maps: reads a taxel, pins it, draws rectangles and lassos, turns the surface.

/** @typedef {import("./tile.js").Tile} Tile */
/** @typedef {import("./orientation.js").Placement} Placement */
/**
 * @typedef {object} Handlers
 * @property {(taxel: Page.Taxel) => void} pick
 * @property {(taxel: Page.Taxel) => void} pin
 * @property {(shape: string, corners: Page.Corner[]) => void} region
 * @property {(corners: Page.Corner[] | null) => void} draft
 * @property {() => void} camera
 */
/** @typedef {{ row: number, column: number }} Spot in taxels, with fractions */
/**
 * @typedef {{ kind: "turn", x: number, y: number } | { kind: "point" }
 *   | { kind: "rectangle" | "lasso", from: Spot, corners: Page.Corner[] }} Drag
 */

const LASSO_STEP = 0.4; // taxels between two corners of a lasso

export class Pointer {
  /**
   * @param {import("./stage.js").Stage} stage
   * @param {import("./settings.js").Settings} settings
   * @param {Handlers} handlers
   */
  constructor(stage, settings, handlers) {
    this.stage = stage;
    this.settings = settings;
    this.handlers = handlers;
    /** @type {Drag | null} */
    this.drag = null;
    for (const tile of Object.values(stage.tiles)) this.listen(tile);
  }

  /** @param {Tile} tile */
  listen(tile) {
    const { canvas } = tile;
    canvas.addEventListener("pointermove", (event) => this.move(tile, event));
    canvas.addEventListener("pointerdown", (event) => this.down(tile, event));
    canvas.addEventListener("pointerup", (event) => this.up(tile, event));
    canvas.addEventListener("pointercancel", () => this.cancel());
    canvas.addEventListener("wheel", (event) => {
      if (!tile.inSurface) return;
      event.preventDefault();
      this.stage.camera.zoom(Math.exp(event.deltaY * 0.0012));
      this.handlers.camera();
    }, { passive: false });
    canvas.addEventListener("dblclick", () => {
      if (!tile.inSurface) return;
      this.stage.camera.reset();
      this.handlers.camera();
    });
  }

  /**
   * @param {Tile} tile
   * @param {Placement} placement
   * @param {MouseEvent} event
   * @returns {Spot}
   */
  spot(tile, placement, event) {
    const box = tile.canvas.getBoundingClientRect();
    return placement.toArray(event.clientX - box.left, event.clientY - box.top);
  }

  /**
   * @param {Placement} placement
   * @param {Spot} spot
   */
  taxel({ layout }, spot) {
    const at = layout.at(spot.column, spot.row);
    return at < 0 ? null : { row: Math.floor(at / layout.lines), column: at % layout.lines };
  }

  /**
   * @param {Tile} tile
   * @param {PointerEvent} event
   */
  down(tile, event) {
    if (event.button !== 0 || !tile.placement) return;
    const spot = this.spot(tile, tile.placement, event);
    const { tool } = this.settings.values;
    if (tile.inSurface) this.drag = { kind: "turn", x: event.clientX, y: event.clientY };
    else if (tool === "point") this.drag = { kind: "point" };
    else this.drag = { kind: tool, from: spot, corners: [[spot.column, spot.row]] };
    tile.canvas.setPointerCapture(event.pointerId);
  }

  /**
   * @param {Tile} tile
   * @param {PointerEvent} event
   */
  move(tile, event) {
    const { drag } = this;
    const { placement } = tile;
    if (!placement) return;
    if (drag && drag.kind === "turn") {
      this.stage.camera.drag(event.clientX - drag.x, event.clientY - drag.y);
      drag.x = event.clientX;
      drag.y = event.clientY;
      this.handlers.camera();
      return;
    }
    if (tile.inSurface) return;
    const spot = this.spot(tile, placement, event);
    const taxel = this.taxel(placement, spot);
    if (taxel) this.handlers.pick(taxel);
    if (!drag || drag.kind === "point") return;
    if (drag.kind === "rectangle") {
      drag.corners = rectangle(drag.from, spot, placement);
    } else {
      const [column, row] = drag.corners[drag.corners.length - 1];
      if (Math.hypot(spot.column - column, spot.row - row) > LASSO_STEP) drag.corners.push([spot.column, spot.row]);
    }
    this.handlers.draft(drag.corners);
  }

  /**
   * @param {Tile} tile
   * @param {PointerEvent} event
   */
  up(tile, event) {
    const { drag } = this;
    const { placement } = tile;
    this.drag = null;
    if (!drag || drag.kind === "turn" || !placement) return;
    if (drag.kind === "point") {
      const taxel = this.taxel(placement, this.spot(tile, placement, event));
      if (taxel) {
        this.handlers.pick(taxel);
        this.handlers.pin(taxel);
      }
      return;
    }
    this.handlers.draft(null);
    if (drag.corners.length > 2) this.handlers.region(drag.kind, drag.corners);
  }

  // Returns whether there was something to cancel.
  cancel() {
    const had = this.drag !== null;
    this.drag = null;
    this.handlers.draft(null);
    return had;
  }
}

/**
 * Whole taxels: the outline then says exactly which ones are in.
 * @param {Spot} from
 * @param {Spot} to
 * @param {Placement} placement
 * @returns {Page.Corner[]}
 */
function rectangle(from, to, { rows, columns }) {
  /**
   * @param {number} value
   * @param {number} most
   */
  const clamp = (value, most) => Math.min(Math.max(value, 0), most);
  const left = Math.floor(clamp(Math.min(from.column, to.column), columns - 1e-3));
  const right = Math.ceil(clamp(Math.max(from.column, to.column), columns));
  const top = Math.floor(clamp(Math.min(from.row, to.row), rows - 1e-3));
  const bottom = Math.ceil(clamp(Math.max(from.row, to.row), rows));
  return [[left, top], [right, top], [right, bottom], [left, bottom]];
}
