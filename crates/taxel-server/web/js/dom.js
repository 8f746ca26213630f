// Parts of the page by their id. One that is missing is an error in the page, and said at once.

/**
 * @template {HTMLElement} T
 * @param {string} id
 * @param {new () => T} kind
 * @returns {T}
 */
function find(id, kind) {
  const element = document.getElementById(id);
  if (!(element instanceof kind)) throw new Error(`the page has no ${kind.name} #${id}`);
  return element;
}

/** @param {string} id */
export const byId = (id) => find(id, HTMLElement);
/** @param {string} id */
export const buttonById = (id) => find(id, HTMLButtonElement);
/** @param {string} id */
export const inputById = (id) => find(id, HTMLInputElement);
/** @param {string} id */
export const selectById = (id) => find(id, HTMLSelectElement);
/** @param {string} id */
export const canvasById = (id) => find(id, HTMLCanvasElement);
/** @param {string} id */
export const dialogById = (id) => find(id, HTMLDialogElement);

/**
 * The first element inside that a selector names.
 * @param {ParentNode} within
 * @param {string} selector
 * @returns {HTMLElement}
 */
export function inside(within, selector) {
  const element = within.querySelector(selector);
  if (!(element instanceof HTMLElement)) throw new Error(`the page has no ${selector}`);
  return element;
}

/**
 * All elements of the page that a selector names.
 * @param {string} selector
 * @returns {NodeListOf<HTMLElement>}
 */
export const all = (selector) => document.querySelectorAll(selector);

/**
 * @param {string} id
 * @param {() => void} action
 */
export function onClick(id, action) {
  byId(id).addEventListener("click", action);
}

/**
 * Text that is the same already is left alone: whoever reads along would hear it again.
 * @param {string | HTMLElement} where an element or its id
 * @param {string} text
 */
export function write(where, text) {
  const element = typeof where === "string" ? byId(where) : where;
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {string} tag
 * @param {string} text
 * @param {string} className
 */
export function made(tag, text, className = "") {
  const element = document.createElement(tag);
  element.textContent = text;
  if (className) element.className = className;
  return element;
}

/**
 * A 2D context. Only a canvas that another kind of context has taken has none.
 * @param {HTMLCanvasElement} canvas
 * @returns {CanvasRenderingContext2D}
 */
export function contextOf(canvas) {
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this canvas cannot be drawn on");
  return context;
}

/** @param {HTMLDialogElement} dialog */
export function openDialog(dialog) {
  // A box gives the focus back to what had it. Where nothing had, it would keep it until the next picture, and swallow
  // the keys until then.
  const { activeElement } = document;
  const nothing = activeElement === null || activeElement === document.body || dialog.contains(activeElement);
  if (nothing) {
    const letGo = () => {
      // That a box was closed is told later; by then it may be open again, with its field in use.
      if (dialog.open) return;
      dialog.removeEventListener("close", letGo);
      const { activeElement } = document;
      if (activeElement instanceof HTMLElement && dialog.contains(activeElement)) activeElement.blur();
    };
    dialog.addEventListener("close", letGo);
  }
  dialog.showModal();
}
