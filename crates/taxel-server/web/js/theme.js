// Light or dark: the system's preference unless the user has chosen. Canvases take their colours from here.

const KEY = "taxel.theme";
const NAMES = ["ground", "panel", "line", "ink", "ink2", "ink3", "accent", "record", "warn", "comp", "raw"];

const prefersDark = matchMedia("(prefers-color-scheme: dark)");
// Where these change, the colours are others too.
const CHANGING = [prefersDark, matchMedia("(forced-colors: active)"), matchMedia("(prefers-contrast: more)")];

/** Colours by role, as a canvas takes them. */
export const theme = {
  version: 0, ground: "", panel: "", line: "", ink: "", ink2: "", ink3: "", accent: "", record: "", warn: "", comp: "", raw: "",
};

const colours = /** @type {Record<string, string>} */ (/** @type {unknown} */ (theme));

/**
 * The colour of a role that a page has of its own.
 * @param {string} name
 */
export function colourOf(name) {
  if (!(name in colours)) colours[name] = resolved(name);
  return colours[name];
}

function read() {
  for (const name of new Set([...NAMES, ...Object.keys(colours).filter((name) => name !== "version")])) colours[name] = resolved(name);
  theme.version += 1;
}

/**
 * A colour as rgb(…), also where the style sheet names one of the system's.
 * @param {string} name
 */
function resolved(name) {
  const probe = document.createElement("i");
  // Colours that the system forces are not asked for here, but those that the style sheet chose in their place.
  probe.style.cssText = `display: none; forced-color-adjust: none; color: var(--${name})`;
  document.documentElement.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}

/**
 * Red, green and blue of a colour of the theme, 0 to 1.
 * @param {string} colour
 */
export const partsOf = (colour) => (colour.match(/[\d.]+/g) || []).slice(0, 3).map((part) => Number(part) / 255);

/**
 * A colour of the theme that lets through what is below.
 * @param {string} colour
 * @param {number} share
 */
export function faint(colour, share) {
  const [red, green, blue] = partsOf(colour).map((part) => Math.round(255 * part));
  return `rgb(${red} ${green} ${blue} / ${share})`;
}

export function isDark() {
  return (document.documentElement.dataset.theme || (prefersDark.matches ? "dark" : "light")) === "dark";
}

/** @param {() => void} onChange */
export function startTheme(onChange) {
  read();
  for (const query of CHANGING) {
    query.addEventListener("change", () => {
      read();
      onChange();
    });
  }
}

/** @param {() => void} onChange */
export function toggleTheme(onChange) {
  const next = isDark() ? "light" : "dark";
  document.documentElement.dataset.theme = next;
  try {
    localStorage.setItem(KEY, next);
  } catch (_) {
    // The choice then lasts as long as the page.
  }
  read();
  onChange();
}
