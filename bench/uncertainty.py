"""Whether 95 % intervals cover, on sensors that the calibration does not know: the tables of docs/uncertainty.md.

    python3 bench/uncertainty.py target/release/taxel --folder drawn mats labels
    python3 bench/uncertainty.py target/release/taxel --folder drawn sets ../shared/twin

`mats`, `labels`: each sensor is drawn from a preset (`taxel simulate --imperfect`), pressed, calibrated by an owner who knows neither
switches nor material, and judged on frames of other contacts. With `labels` all labelled loads are 2 % off besides. `sets`: folders
tier-a, tier-b … with a parts list, recordings and true loads. One line a sensor: mean error of loaded taxels (grams), those inside their
intervals, half-width and error (medians), unloaded taxels outside, mean error of totals, the sheet that was found, the seconds of
processor time of the fit. Needs Python 3.10 and numpy.
"""

import argparse
import pathlib
import re
import resource
import subprocess

import numpy as np

ECONE = (64, 128)
# What is drawn: sensor, shape where it is not the preset's, kind, seeds, presses, whether labels are off.
MATS = [
    ("econe", (24, 24), "sheet", range(31, 37), 100, False),
    ("econe", (24, 24), "beyond", range(31, 36), 100, False),
    ("econe", (32, 48), "sheet", range(31, 33), 100, False),
    ("mat-32x32-adg732", None, "beyond", range(1, 4), 100, False),
    ("mat-32x32-adg732", None, "uneven", range(1, 4), 100, False),
    ("mat-16x16-cd4067", None, "beyond", range(1, 4), 100, False),
    ("mat-16x16-cd4067", None, "uneven", range(1, 7), 100, False),
]
LABELS = [
    ("mat-16x16-cd4067", None, "sheet", (1, 41), 150, True),
    ("mat-32x32-adg732", None, "sheet", range(1, 5), 150, True),
    ("econe", ECONE, "sheet", range(101, 105), 150, True),
]


def run(*words, good=(0,)):
    result = subprocess.run([str(word) for word in words], text=True, capture_output=True)
    if result.returncode not in good:
        raise SystemExit(f"{' '.join(map(str, words))}\nended with {result.returncode}:\n{result.stderr}")
    return result.stdout + result.stderr


def array(file):
    with np.load(file) as all_of_it:
        return next(value for value in (all_of_it[name] for name in all_of_it.files) if value.ndim == 3)


def processor_time():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def preset(sensor, shape, folder):
    """The preset as a file, of another shape where that is asked for."""
    file = pathlib.Path(__file__).parent.parent / f"crates/taxel/src/sensor/presets/{sensor}.toml"
    text = file.read_text()
    if shape:
        text = re.sub(r"(?m)^rows = .*", f"rows = {shape[0]}", text)
        text = re.sub(r"(?m)^columns = .*", f"columns = {shape[1]}", text)
        if shape != ECONE:
            # A part of the cylinder does not close.
            text = re.sub(r"(?ms)^\[array\.geometry\].*?(?=^\[)", "", text)
    (folder / "preset.toml").write_text(text)
    return folder / "preset.toml"


def parts_list(file, folder):
    """What its owner knows: neither switches nor material."""
    text = re.sub(r"(?ms)^\[material\].*?(?=^\[|\Z)", "", file.read_text())
    (folder / "parts.toml").write_text(re.sub(r"(?m)^r_mux.*\n", "", text))
    return folder / "parts.toml"


def bend_labels(file, seed):
    """Loads of a table 2 % off, each by itself (normal)."""
    lines = file.read_text().splitlines()
    column = lines[0].split(",").index("load_g")
    off = 1 + 0.02 * np.random.default_rng(seed).standard_normal(len(lines))
    for i in range(1, len(lines)):
        cells = lines[i].split(",")
        cells[column] = repr(float(float(cells[column]) * off[i]))
        lines[i] = ",".join(cells)
    file.write_text("\n".join(lines) + "\n")


def draw(given, what, seed, folder):
    """Recordings of a sensor that is drawn; its parts list, presses, uniform loads, and frames to judge by with their loads."""
    sensor, shape, kind, _, presses, labels_are_off = what
    file = preset(sensor, shape, folder)
    real = ["simulate", "--sensor", file, "--imperfect", kind, "--seed", seed]
    run(given.taxel, *real, "--pattern", "press", "--frames", presses, "--presses", folder / "presses.csv", "-o", folder / "presses.txt")
    run(given.taxel, *real, "--pattern", "uniform", "--load-g", "50,150,300", "--frames", 12, "--presses", folder / "uniform.csv",
        "-o", folder / "uniform.txt")
    run(given.taxel, *real, "--pattern", "blobs", "--load-g", 600, "--frames", 12, "--truth", folder / "loads.csv", "-o", folder / "blobs.txt")
    if labels_are_off:
        bend_labels(folder / "presses.csv", seed)
        bend_labels(folder / "uniform.csv", 1000 + seed)
    return parts_list(file, folder), folder / "presses.csv", folder / "uniform.csv", [("", folder / "blobs.txt", folder / "loads.csv")]


def calibrate(given, parts, presses, uniform, folder):
    """The calibrated file, the sheet in it, and the fit's seconds of processor time."""
    before, calibrated = processor_time(), folder / "calibrated.toml"
    run(given.taxel, "calibrate", "--sensor", parts, "--presses", presses, "--equilibration", uniform, "-o", calibrated)
    sheet = re.search(r"(?ms)^\[material\.sheet\](.*?)(?=^\[|\Z)", calibrated.read_text())
    found = "none"
    if sheet:
        ohms = float(re.search(r"(?m)^resistance_ohms = (\S+)", sheet[1])[1])
        found = f"{ohms / 1000:.1f} kOhm"
    return calibrated, found, processor_time() - before


def judge(given, calibrated, recording, truth, folder):
    """Errors of single taxels and of totals, against every true load."""
    out = {name: folder / f"{name}.npz" for name in ("loads", "half", "marks")}
    run(given.taxel, "compensate", recording, "--sensor", calibrated, "--unit", "g", "-o", out["loads"], "--interval", out["half"],
        "--marks", out["marks"], good=(0, 3))
    loads, half, marks = (array(out[name]) for name in ("loads", "half", "marks"))
    true = np.loadtxt(truth, delimiter=",").reshape(loads.shape)
    good = marks == 0
    loaded, unloaded, off = (true > 0) & good, (true == 0) & good, np.abs(loads - true)
    told = (true * good).sum((1, 2)) > 0
    total = np.where(good, loads, 0).sum((1, 2))[told] / np.where(good, true, 0).sum((1, 2))[told] - 1
    return (f"{off[loaded].mean():.3f} g, {100 * (off <= half)[loaded].mean():.1f} % inside, half-width {np.median(half[loaded]):.3g} g, "
            f"error {np.median(off[loaded]):.3g} g, {100 * (off > half)[unloaded].mean():.2f} % unloaded outside, total {100 * total.mean():+.2f} %")


def one(given, name, parts, presses, uniform, judged_by, folder):
    calibrated, sheet, seconds = calibrate(given, parts, presses, uniform, folder)
    for which, recording, truth in judged_by:
        said = judge(given, calibrated, recording, truth, folder)
        print(f"{name}{which}: {said}; sheet {sheet}; {seconds:.0f} s", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taxel", type=pathlib.Path)
    parser.add_argument("what", nargs="+", help="mats, labels, or sets FOLDER")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("drawn"))
    parser.add_argument("--only", default="", help="those whose name has this in it")
    given = parser.parse_args()
    given.taxel = given.taxel.resolve()
    words = list(given.what)
    while words:
        word = words.pop(0)
        if word == "sets":
            root = pathlib.Path(words.pop(0))
            for sets in sorted(root.glob("tier-*")):
                if given.only not in sets.name or not (sets / "validation-load-g.csv").exists():
                    continue
                folder = given.folder / sets.name
                folder.mkdir(parents=True, exist_ok=True)
                same_day = [(", the same day", sets / "same-day.txt", sets / "same-day-load-g.csv")] if (sets / "same-day.txt").exists() else []
                later = ", a later day" if same_day else ""
                one(given, sets.name, sets / "sensor.toml", sets / "experiments.csv", sets / "equilibration.csv",
                    [*same_day, (later, sets / "validation.txt", sets / "validation-load-g.csv")], folder)
            continue
        for what in {"mats": MATS, "labels": LABELS}[word]:
            for seed in what[3]:
                shape = f" {what[1][0]}x{what[1][1]}" if what[1] else ""
                name = f"{what[0]}{shape} {what[2]} {seed}{', labels 2 % off' if what[5] else ''}"
                if given.only not in name:
                    continue
                folder = given.folder / re.sub(r"\W+", "-", name)
                folder.mkdir(parents=True, exist_ok=True)
                one(given, name, *draw(given, what, seed, folder), folder)


if __name__ == "__main__":
    main()
