// Words that several pages put together. Nothing here knows the page.

/** @param {string} text */
export const capital = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);

/**
 * Files, those that people read first in front.
 * @param {string[]} names
 * @param {{ end: string, text: string }[]} kinds what they are, by the end of their name, in the order in which they are shown
 * @returns {{ name: string, text: string }[]}
 */
export function filesInOrder(names, kinds) {
  /** @param {string} name */
  const place = (name) => {
    const at = kinds.findIndex(({ end }) => name.endsWith(end));
    return at < 0 ? kinds.length : at;
  };
  return [...names].sort((a, b) => place(a) - place(b)).map((name) => ({ name, text: kinds[place(name)]?.text ?? name }));
}
