// Short messages at the corner: refusals, and what the user asked for and got.

const SHOWN_MS = { good: 3000, bad: 7000 };
const MOST = 4;

export function toast(text, kind = "good") {
  const box = document.getElementById("toasts");
  const element = document.createElement("div");
  element.className = `toast ${kind}`;
  element.textContent = text;
  box.append(element);
  while (box.children.length > MOST) box.firstChild.remove();
  setTimeout(() => element.remove(), SHOWN_MS[kind]);
}
