"""Taxel itself: `taxel calibrate` on the case's presses and uniform loads, then `taxel compensate`.

    taxel_program.py --method auto|exact|newton|raw|hybrid CASE_DIR OUT_DIR

auto is what a user gets who names no method: exact, newton, or the inverse of circuits with diodes. The program is $TAXEL, or
`taxel`. Methods share one calibration where $GHOSTING_CACHE names a folder of the case.
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

from case import decline, folders_of_arguments, read_case, write_answer

PROGRAM = os.environ.get("TAXEL", "taxel")
FINISHED = (0, 3)  # 3: finished, with a doubt that standard error tells
METHOD = sys.argv[sys.argv.index("--method") + 1] if "--method" in sys.argv else None


def taxel(*words):
    """Runs the program; gives back what it printed."""
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    sys.stderr.write(done.stderr)
    if f"no method `{METHOD}`" in done.stderr:
        decline(f"{METHOD} is not for this circuit, as it was calibrated")
    if done.returncode not in FINISHED:
        sys.exit(f"taxel {words[0]}: exit code {done.returncode}: {done.stderr.strip()[-600:]}")
    return done.stdout


def calibrated(case, out):
    """The calibrated sensor file, and the seconds that it took when it was made."""
    cache = Path(os.environ.get("GHOSTING_CACHE", out))
    cache.mkdir(parents=True, exist_ok=True)
    sensor, seconds = cache / "calibrated.toml", cache / "calibrated.seconds"
    if not seconds.exists():
        start = time.perf_counter()
        given = case.folder
        report = taxel(
            "calibrate", "--sensor", given / "sensor.toml", "--presses", given / "presses.csv",
            "--equilibration", given / "uniform.csv", "-o", sensor,
        )  # fmt: skip
        (cache / "calibrated.txt").write_text(report)
        seconds.write_text(str(time.perf_counter() - start))
    return sensor, float(seconds.read_text())


def hybrid(case, sensor, out):
    """A small network on what the circuit leaves; `taxel train` keeps it only where held-out presses gain."""
    model = out / "hybrid.safetensors"
    start = time.perf_counter()
    print(taxel("train", "hybrid", "--sensor", sensor, "--presses", case.folder / "presses.csv", "-o", model))
    return model, time.perf_counter() - start


def compensate(case, sensor, method, out, states_intervals):
    words = ["compensate", case.folder / "counts.npy", "--sensor", sensor, "--unit", "g", "--method", method]
    words += ["--threads", 1, "--json", "-o", out / "found.npy"]
    if states_intervals:
        # Intervals cost time of their own, which a frame without them does not take.
        taxel(*words[:-1], out / "same.npy", "--interval", out / "interval.npy")
    summary = json.loads(taxel(*words))
    half = np.load(out / "interval.npy") if states_intervals else None
    loads = np.load(out / "found.npy")
    return loads.reshape(case.counts.shape), half, 1000 * summary["seconds"] / len(case.counts)


def main():
    folder, out = folders_of_arguments()
    method, case = METHOD, read_case(folder)
    out.mkdir(parents=True, exist_ok=True)
    sensor, setup_s = calibrated(case, out)
    inverts = method in ("auto", "exact", "newton")
    if method == "hybrid":
        method, seconds = hybrid(case, sensor, out)
        setup_s += seconds
    loads, half, ms = compensate(case, sensor, method, out, inverts)
    write_answer(out, loads, ms, setup_s, half)


if __name__ == "__main__":
    main()
