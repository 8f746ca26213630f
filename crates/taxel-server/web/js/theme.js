// Light or dark: the system's preference unless the user has chosen. Canvases take their colours from here.

const KEY = "taxel.theme";
const NAMES = ["ground", "panel", "line", "ink", "ink2", "ink3", "accent", "record", "warn", "comp", "raw"];

const prefersDark = matchMedia("(prefers-color-scheme: dark)");

export const theme = { version: 0 };

function read() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) theme[name] = style.getPropertyValue(`--${name}`).trim();
  theme.version += 1;
}

export function isDark() {
  return (document.documentElement.dataset.theme || (prefersDark.matches ? "dark" : "light")) === "dark";
}

export function startTheme(onChange) {
  read();
  prefersDark.addEventListener("change", () => {
    read();
    onChange();
  });
}

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
