"""Figures to Markdown: docs/ghosting.md, and all of them as CSV."""

import csv
import datetime
import os
import subprocess
from statistics import mean, median

# Figure, title, what it says, how it is printed.
TABLES = [
    ("error_g", "Error on loaded taxels, g", "Mean absolute, of the true loads given beside.", "{:.3g}"),
    ("ghost_g", "Largest ghost, g", "The largest load reported on a taxel without one.", "{:.3g}"),
    ("total_share", "Total force, %", "Mean absolute error of each frame's sum, of the true sum.", "{:.2g}"),
    ("ms_per_frame", "Milliseconds a frame", "As each entry tells of itself, one core; setting up is not in it.", "{:.2g}"),
    ("setup_s", "Setting up, s", "Once a sensor: reading the calibration and fitting to it. Methods of one program share it.", "{:.2g}"),
]  # fmt: skip
COLUMNS = [
    "case", "seed", "entry", "loaded", "mean_load_g", "error_g", "error_share", "ghost_g", "ghost_99_g", "total_share", "stated",
    "coverage", "half_g", "siemens_share", "ms_per_frame", "setup_s", "wall_s", "declined", "failed",
]  # fmt: skip
PERCENT = ("total_share", "coverage", "stated", "error_share")


def line(result):
    """One result while the benchmark runs."""
    name = f"{result['case']} {result['seed']} {result['entry']}"
    why = result.get("declined") or result.get("failed")
    if why:
        return f"{name}: {'declined' if 'declined' in result else 'FAILED'}: {why}"
    return (
        f"{name}: error {result['error_g']:.3g} g of {result['mean_load_g']:.3g} g, ghost {result['ghost_g']:.3g} g, "
        f"total {100 * result['total_share']:.2g} %, {result['ms_per_frame']:.2g} ms a frame, {result['wall_s']:.1f} s"
    )


class Found:
    """All results, asked for by case and entry."""

    def __init__(self, results):
        self.results = results

    def of(self, case, entry):
        return [x for x in self.results if (x["case"], x["entry"]) == (case["name"], entry["name"])]

    def values(self, case, entry, figure):
        """One number a seed; None where an entry has none of a seed."""
        values = [result.get(figure) for result in self.of(case, entry)]
        scale = 100 if figure in PERCENT else 1
        return [None if value is None else scale * value for value in values]

    def mean(self, case, entry, figure):
        values = self.values(case, entry, figure)
        return mean(values) if values and None not in values else None

    def cell(self, case, entry, figure, form):
        results = self.of(case, entry)
        if all("declined" in result for result in results):
            return "–"
        failed = sum("failed" in result for result in results)
        values = [value for value in self.values(case, entry, figure) if value is not None]
        if failed:
            return f"failed {failed} of {len(results)}"
        if not values:
            return ""
        text = readable(form, mean(values))
        if len(values) > 1 and max(values) > 1.5 * mean(values):
            text += f" ({readable(form, max(values))})"
        return text


def readable(form, value):
    """The number, without exponents."""
    text = form.format(value)
    return f"{float(text):.0f}" if "e+" in text else text.replace("e-0", "e-")


def tables(results, cases, entries):
    found = Found(results)
    parts = []
    for figure, title, what, form in TABLES:
        parts.append(f"## {title}\n\n{what}\n\n{table(found, cases, entries, figure, form)}")
    parts.insert(3, "## Intervals\n\n" + intervals(found, cases, entries))
    return "\n\n".join(parts)


def table(found, cases, entries, figure, form):
    rows = []
    for case in cases:
        cells = [found.cell(case, entry, figure, form) for entry in entries]
        if figure == "error_g":
            loads = [x["mean_load_g"] for x in found.results if x["case"] == case["name"] and "mean_load_g" in x]
            least = best(found, case, entries)
            cells = [f"**{cell}**" if entry is least else cell for cell, entry in zip(cells, entries, strict=True)]
            cells.insert(0, f"{mean(loads):.0f}" if loads else "")
        rows.append([case["name"], *cells])
    header = ["case", *(["true load"] if figure == "error_g" else []), *(entry["name"] for entry in entries)]
    return markdown(header, rows)


def best(found, case, entries):
    """The entry with the least error on all seeds, or None."""
    known = [(found.mean(case, entry, "error_g"), entry) for entry in entries]
    known = [pair for pair in known if pair[0] is not None]
    # Of those that print alike the first: methods of one program differ in the last digits.
    return min(known, key=lambda pair: float(f"{pair[0]:.3g}"))[1] if known else None


def markdown(header, rows):
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def intervals(found, cases, entries):
    """Coverage of those that state intervals."""
    states = [entry for entry in entries if any("coverage" in x for x in found.results if x["entry"] == entry["name"])]
    if not states:
        return "No entry stated any."
    rows = []
    for case in cases:
        cells = []
        for entry in states:
            cell = found.cell(case, entry, "coverage", "{:.1f}")
            halves, stated = found.values(case, entry, "half_g"), found.mean(case, entry, "stated")
            if halves and None not in halves:
                cell += f" ± {readable('{:.2g}', median(halves))} g"
                if max(halves) > 3 * median(halves):
                    cell += f" (± {readable('{:.2g}', max(halves))} g)"
            if stated is not None and stated < 99.95:
                cell += f", {stated:.1f} % stated"
            cells.append(cell)
        rows.append([case["name"], *cells])
    words = (
        "Share of loaded taxels inside their stated 95 % intervals, %, and the median half-width (of the widest seed, where far off). "
        "Without bounds: not stated."
    )
    return f"{words}\n\n{markdown(['case', *(entry['name'] for entry in states)], rows)}"


def not_best(results, cases, entries):
    """Where this repository's program loses, fails, is far off, or states intervals that do not hold."""
    found = Found(results)
    ours = [entry for entry in entries if entry.get("ours")]
    lines = []
    for case in cases:
        least = best(found, case, entries)
        mine = best(found, case, ours)
        if mine is None:
            lines.append(f"- `{case['name']}`: no answer of ours on all seeds.")
        elif not least.get("ours"):
            error, other = (found.mean(case, entry, "error_g") for entry in (mine, least))
            lines.append(f"- `{case['name']}`: {mine['name']} {error:.3g} g, {least['name']} {other:.3g} g.")
        elif found.mean(case, mine, "error_share") > 5:
            share = found.mean(case, mine, "error_share")
            lines.append(f"- `{case['name']}`: the best is {mine['name']}, and still {share:.0f} % of the mean load off.")
        if mine is not None:
            lines += beaten(found, case, mine, entries, "ghost_g", "ghosts", "g")
            lines += beaten(found, case, mine, entries, "total_share", "totals off by", "%")
            lines += uncovered(found, case, mine)
        for entry in ours:
            lines += failures(found, case, entry)
    return "\n".join(lines) or "Nowhere in these cases."


def beaten(found, case, mine, entries, figure, word, unit):
    """Where another entry of about the same error has less than half of the ghosts, or of what totals are off by."""
    own, error = found.mean(case, mine, figure), found.mean(case, mine, "error_g")
    others = [entry for entry in entries if not entry.get("ours") and found.mean(case, entry, "error_g") is not None]
    others = [entry for entry in others if found.mean(case, entry, "error_g") < 2 * error]
    least = min(others, key=lambda entry: found.mean(case, entry, figure), default=None)
    if least is None or found.mean(case, least, figure) > own / 2:
        return []
    other = found.mean(case, least, figure)
    return [f"- `{case['name']}`, {word}: {mine['name']} {own:.3g} {unit}, {least['name']} {other:.3g} {unit}."]


def failures(found, case, entry):
    return [f"- `{x['case']}`, seed {x['seed']}, {x['entry']}: {x['failed']}" for x in found.of(case, entry) if "failed" in x]


def uncovered(found, case, entry):
    values = [value for value in found.values(case, entry, "coverage") if value is not None]
    lines = []
    if values and min(values) < 90:
        told = ", ".join(f"{value:.0f}" for value in values)
        lines.append(f"- `{case['name']}`: 95 % intervals of {entry['name']} hold {told} % of the loads.")
    halves = [value for value in found.values(case, entry, "half_g") if value is not None]
    if halves and max(halves) > found.mean(case, entry, "mean_load_g"):
        told = ", ".join(readable("{:.2g}", value) for value in halves)
        lines.append(f"- `{case['name']}`: 95 % intervals of {entry['name']} are ± {told} g, so wide that one says nothing.")
    return lines


def write(results, cases, entries, root):
    """docs/ghosting.md and bench/runs/DATE-ghosting.csv."""
    today = datetime.date.today().isoformat()
    runs = root / "bench" / "runs" / f"{today}-ghosting.csv"
    with open(runs, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: rounded(result.get(key)) for key in COLUMNS} for result in results)
    document = root / "docs" / "ghosting.md"
    document.write_text(page(results, cases, entries, today, runs, root))
    print(f"wrote {document} and {runs}")


def rounded(value):
    if isinstance(value, str):
        return value.splitlines()[-1]
    return f"{value:.6g}" if isinstance(value, float) else value


def page(results, cases, entries, today, runs, root):
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=root, capture_output=True, text=True).stdout.strip()
    seeds = sorted({result["seed"] for result in results})
    return f"""# A benchmark of cross-talk removal

<!-- Written by bench/ghosting/run.py --write. Do not edit: run it again. -->

{today}, commit {commit}, {os.cpu_count()} shared cores, one of them used. Every number is the mean of {len(seeds)} draws (seeds
{", ".join(map(str, seeds))}); the worst of them stands in brackets where it is more than half as much again. –: not made for this
case. The cases, the format, the entries and how to enter: [bench/ghosting](../bench/ghosting/README.md). All figures by
seed: [{runs.name}](../bench/runs/{runs.name}). Everything is simulated, and by the program that is among the entries: who
undoes the same circuit that made the counts has an advantage that a real mat does not give. In the ideal cases R_eq, two steps and nodal
fixed point are told the true switches by the sensor file and keep them; `taxel calibrate` fits them again. On uneven, beyond and sheet cases all entries but
ours take taxels to be alike, and most of what they err by there is taxels that differ: [bench/ghosting](../bench/ghosting/README.md#what-is-drawn) says how much.

## Where ours is not best, or not good

{not_best(results, cases, entries)}

{tables(results, cases, entries)}
"""
