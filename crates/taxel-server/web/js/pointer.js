// The pointer on the maps: reads a taxel, pins it, draws rectangles and lassos, turns the surface.

const LASSO_STEP = 0.4; // taxels between two corners of a lasso

export class Pointer {
  // handlers: pick(taxel), pin(taxel), region(shape, corners), draft(corners or null), camera()
  constructor(stage, settings, handlers) {
    this.stage = stage;
    this.settings = settings;
    this.handlers = handlers;
    this.drag = null;
    for (const tile of Object.values(stage.tiles)) this.listen(tile);
  }

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

  spot(tile, event) {
    const box = tile.canvas.getBoundingClientRect();
    return tile.placement.toArray(event.clientX - box.left, event.clientY - box.top);
  }

  taxel(tile, spot) {
    const row = Math.floor(spot.row);
    const column = Math.floor(spot.column);
    const { rows, columns } = tile.placement;
    return row >= 0 && row < rows && column >= 0 && column < columns ? { row, column } : null;
  }

  down(tile, event) {
    if (event.button !== 0 || !tile.placement) return;
    const spot = this.spot(tile, event);
    const { tool } = this.settings.values;
    if (tile.inSurface) this.drag = { kind: "turn", x: event.clientX, y: event.clientY };
    else if (tool === "point") this.drag = { kind: "point" };
    else this.drag = { kind: tool, from: spot, corners: [[spot.column, spot.row]] };
    tile.canvas.setPointerCapture(event.pointerId);
  }

  move(tile, event) {
    if (!tile.placement) return;
    if (this.drag && this.drag.kind === "turn") {
      this.stage.camera.drag(event.clientX - this.drag.x, event.clientY - this.drag.y);
      this.drag.x = event.clientX;
      this.drag.y = event.clientY;
      this.handlers.camera();
      return;
    }
    if (tile.inSurface) return;
    const spot = this.spot(tile, event);
    const taxel = this.taxel(tile, spot);
    if (taxel) this.handlers.pick(taxel);
    if (!this.drag || this.drag.kind === "point") return;
    if (this.drag.kind === "rectangle") {
      this.drag.corners = rectangle(this.drag.from, spot, tile.placement);
    } else {
      const [column, row] = this.drag.corners[this.drag.corners.length - 1];
      if (Math.hypot(spot.column - column, spot.row - row) > LASSO_STEP) this.drag.corners.push([spot.column, spot.row]);
    }
    this.handlers.draft(this.drag.corners);
  }

  up(tile, event) {
    const { drag } = this;
    this.drag = null;
    if (!drag || drag.kind === "turn") return;
    if (drag.kind === "point") {
      const taxel = this.taxel(tile, this.spot(tile, event));
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

// Whole taxels: the outline then says exactly which ones are in.
function rectangle(from, to, { rows, columns }) {
  const clamp = (value, most) => Math.min(Math.max(value, 0), most);
  const left = Math.floor(clamp(Math.min(from.column, to.column), columns - 1e-3));
  const right = Math.ceil(clamp(Math.max(from.column, to.column), columns));
  const top = Math.floor(clamp(Math.min(from.row, to.row), rows - 1e-3));
  const bottom = Math.ceil(clamp(Math.max(from.row, to.row), rows));
  return [[left, top], [right, top], [right, bottom], [left, bottom]];
}
