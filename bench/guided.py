"""Guided calibrations of simulated sensors that their parts lists do not know: how many presses, how long, and how good.

    python3 bench/guided.py target/release/taxel --sensor mat-16x16-cd4067 --seeds 1 2 3 --folder guided

Each sensor is drawn from a preset (`taxel simulate --imperfect uneven`, without its broken lines), pressed by the simulated operator,
who errs now and then, and calibrated by the real program in its terminal mode until it says that more presses gain nothing. Then loads
of other contacts are found with the calibrated sensor and compared with the truth. Needs Python 3.10 and numpy.
"""

import argparse
import pathlib
import re
import subprocess
import time

import numpy as np

FRAMES = 20


def run(*words, **options):
    return subprocess.run([str(word) for word in words], check=True, text=True, capture_output=True, **options)


def true_sensor(given, seed, folder):
    """A sensor that differs from its preset by a tenth, line by line and taxel by taxel; no line of it is broken."""
    file = folder / "true.toml"
    run(given.taxel, "simulate", "--sensor", given.sensor, "--pattern", "uniform", "--imperfect", "uneven", "--seed", seed,
        "-o", folder / "unused.npy", "--truth-sensor", file)
    text = re.sub(r"^(dead|flickering)_(rows|columns) = \[[^\]]*\]\n", "", file.read_text(), flags=re.M)
    file.write_text(text)
    return file


def calibrate(given, truth, folder):
    """The whole calibration: seconds, presses, what was said."""
    words = [given.taxel, "calibrate", "--live", f"sim:{truth}?uniform&fps={given.fps}", "--sensor", given.parts, "--terminal",
             "--weights", given.weights, "-o", folder / "calibrated.toml", "--folder", folder / "calibrations"]
    words += ["--even-weights", given.even] if given.even else []
    begun = time.monotonic()
    program = subprocess.Popen([str(word) for word in words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1)
    said = []
    for line in program.stderr:
        said.append(line)
        if "take everything off" in line and len(said) < 4:
            print("", file=program.stdin, flush=True)
        if "`finish` and Enter" in line or f"taken: press {given.most}\n" in line:
            print("finish", file=program.stdin, flush=True)
    code = program.wait()
    (folder / "said.txt").write_text("".join(said))
    presses = sum("taken: press" in line for line in said)
    again = sum("the first time it said" in line for line in said)
    elsewhere = sum("is pressed most, not" in line for line in said)
    return code, time.monotonic() - begun, presses, again, elsewhere


def error(given, truth, sensor, folder):
    """Mean absolute error of loads of contacts that no press was, over loaded taxels, grams."""
    counts, loads = folder / "blobs.npy", folder / "true.npy"
    run(given.taxel, "simulate", "--sensor", truth, "--pattern", "blobs", "--frames", FRAMES, "--seed", 77, "-o", counts, "--truth", loads)
    found = folder / "found.npy"
    subprocess.run([str(w) for w in (given.taxel, "compensate", counts, "--sensor", sensor, "--unit", "g", "-o", found)], capture_output=True)
    found, loads = np.load(found), np.load(loads)
    return np.abs(found - loads)[loads > 0].mean(), loads[loads > 0].mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taxel", type=pathlib.Path)
    parser.add_argument("--sensor", default="mat-16x16-cd4067")
    parser.add_argument("--parts", default=None, help="the parts list; the preset itself unless told")
    parser.add_argument("--weights", default="50,100,200,500")
    parser.add_argument("--even", default="")
    parser.add_argument("--fps", default="50")
    parser.add_argument("--most", type=int, default=40)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("guided"))
    given = parser.parse_args()
    given.parts = given.parts or given.sensor
    print("sensor,seed,exit,seconds,presses,asked_again,elsewhere,error_g,error_by_preset_g,mean_load_g")
    for seed in given.seeds:
        folder = given.folder / f"{pathlib.Path(given.sensor).stem}-{seed}"
        folder.mkdir(parents=True, exist_ok=True)
        truth = true_sensor(given, seed, folder)
        code, seconds, presses, again, elsewhere = calibrate(given, truth, folder)
        after, mean = error(given, truth, folder / "calibrated.toml", folder)
        before, _ = error(given, truth, given.parts, folder)
        print(f"{given.sensor},{seed},{code},{seconds:.0f},{presses},{again},{elsewhere},{after:.2f},{before:.2f},{mean:.0f}", flush=True)


main()
