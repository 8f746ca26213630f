// Runs before the first paint, so that a chosen theme does not flash the other one.
(function () {
  try {
    const chosen = localStorage.getItem("taxel.theme");
    if (chosen === "dark" || chosen === "light") document.documentElement.dataset.theme = chosen;
  } catch (_) {
    // Storage may be forbidden: the system's preference then applies.
  }
})();
