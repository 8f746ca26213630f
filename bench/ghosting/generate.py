"""Draws the cases: what an entry is given, and apart from it the truth.

    python3 generate.py --work WORK [--only NAME ...] [--taxel PROGRAM]

Counts come from `taxel simulate`. Presses, uniform loads and test frames are of one sensor, but of different seeds, so that
no contact of the calibration is a contact of the test. The same cases.toml gives the same files.
"""

import argparse
import csv
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np

from material import siemens_from_grams

HERE = Path(__file__).resolve().parent
PRESSES, UNIFORM, EMPTY, TEST = 10_000, 20_000, 30_000, 40_000  # added to a case's seed, one for each purpose
UNIFORM_REPEATS = 3
PIVOT_G = 100.0  # where laws of other exponents meet, so that none leaves the converter's range


class Simulation(RuntimeError):
    """`taxel simulate` refused."""


def cases_of(file):
    """Every case of the list, complete."""
    spec = tomllib.loads(Path(file).read_text())
    return [{**spec["defaults"], **spec["readouts"][case["topology"]], **case} for case in spec["case"]]


def draw(case, seed, work, taxel):
    """Draws a case with one seed; gives back the folders of the case and of its truth. What is there is kept."""
    name = f"{case['name']}-{seed}"
    given, truth = Path(work) / "cases" / name, Path(work) / "truth" / name
    if (truth / "scored.npy").exists():
        return given, truth
    for folder in (given, truth):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    sensor = _true_sensor(case, seed, truth, taxel)
    (given / "sensor.toml").write_text(_sensor_toml(case, told=True))
    _calibration(case, seed, given, truth, taxel)
    _test_frames(case, seed, given, truth, taxel)
    each = np.split(np.load(truth / "loads.npy"), len(case["patterns"]))
    siemens = [siemens_from_grams(loads, sensor["material"], case["period_s"]) for loads in each]
    np.save(truth / "conductances.npy", np.concatenate(siemens))
    np.save(truth / "scored.npy", _whole_lines(sensor))
    return given, truth


def _true_sensor(case, seed, truth, taxel):
    """The sensor at hand: its law drawn by us, its imperfections by the program."""
    random = np.random.default_rng(seed)
    material = dict(case["material"])
    bend = 0.02 * float(random.standard_normal())
    material["exponent"] += bend
    material["factor"] *= float(np.exp(0.1 * random.standard_normal())) * PIVOT_G**-bend
    nominal = truth / "nominal.toml"
    nominal.write_text(_sensor_toml({**case, "material": material}, told=False))
    words = ["--imperfect", case["imperfect"]] if "imperfect" in case else []
    _simulate(
        taxel, nominal, "uniform", seed, truth / "unused.npy", ["--truth-sensor", truth / "sensor.toml", *words], [0.0]
    )
    for file in (nominal, truth / "unused.npy"):
        file.unlink()
    return tomllib.loads((truth / "sensor.toml").read_text())


def _sensor_toml(case, told):
    """What the owner knows (`told`), or all of it."""
    rows, columns = case["size"]
    readout = {
        "topology": case["topology"],
        **case["readout"],
        "r_mux_column_ohms": case["switch_ohms"],
        "r_mux_row_ohms": case["switch_ohms"],
    }
    converter = dict(case["converter"])
    converter |= {key: case[key] for key in ("noise_counts", "full_scale_volts") if key in case}
    if not told and "line_ohms" in case:
        readout |= {"r_line_row_ohms": case["line_ohms"], "r_line_column_ohms": case["line_ohms"]}
    tables = {
        "array": {"rows": rows, "columns": columns, "pitch_mm": [5.0, 5.0], "taxel_area_mm2": 15.0},
        "readout": readout,
        "converter": converter,
    }
    if "diode" in case:
        tables["readout.diode"] = {"place": "taxel", "part": case["diode"], "temperature_celsius": 25.0}
    if not told:
        tables["material"] = case["material"]
    lines = ["format = 1", f'name = "{case["name"]}"']
    for table, keys in tables.items():
        lines += ["", f"[{table}]", *(f"{key} = {_toml(value)}" for key, value in keys.items())]
    return "\n".join(lines) + "\n"


def _toml(value):
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _calibration(case, seed, given, truth, taxel):
    sensor = truth / "sensor.toml"
    frames = ["--frames", case["presses"], *_stuck(case)]
    _simulate(
        taxel, sensor, "press", seed + PRESSES, given / "presses.npy",
        [*frames, "--presses", given / "presses.csv"], [case["peak_g"]],
    )  # fmt: skip
    _drop_dead(given / "presses.csv", sensor)
    levels = case["uniform_g"]
    _simulate(
        taxel, sensor, "uniform", seed + UNIFORM, given / "uniform.npy",
        ["--frames", UNIFORM_REPEATS * len(levels), "--presses", given / "uniform.csv", *_stuck(case)], levels,
    )  # fmt: skip
    _simulate(taxel, sensor, "uniform", seed + EMPTY, given / "empty.npy", ["--frames", UNIFORM_REPEATS, *_stuck(case)], [0.0])


def _stuck(case):
    return ["--stuck", case["stuck"]] if "stuck" in case else []


def _drop_dead(table, sensor):
    """Takes out labels on dead lines: whoever presses there sees at once that nothing answers."""
    screen = tomllib.loads(Path(sensor).read_text()).get("screen", {})
    with open(table, newline="") as lines:
        header, *labels = list(csv.reader(lines))
    row, column = header.index("row"), header.index("column")
    dead_rows, dead_columns = screen.get("dead_rows", []), screen.get("dead_columns", [])
    kept = [x for x in labels if int(x[row]) not in dead_rows and int(x[column]) not in dead_columns]
    with open(table, "w", newline="") as lines:
        csv.writer(lines, lineterminator="\n").writerows([header, *kept])


def _test_frames(case, seed, given, truth, taxel):
    """A share of the frames of each pattern, in one recording."""
    counts, loads = [], []
    share = case["frames"] // len(case["patterns"])
    for number, pattern in enumerate(case["patterns"]):
        files = truth / "counts.npy", truth / "loads.npy"
        words = ["--frames", share, "--truth", files[1], "--period", case["period_s"], *_stuck(case)]
        _simulate(taxel, truth / "sensor.toml", pattern, seed + TEST + 1000 * number, files[0], words, [case["peak_g"]])
        counts.append(np.load(files[0]))
        loads.append(np.load(files[1]))
    np.save(given / "counts.npy", np.concatenate(counts))
    np.save(truth / "loads.npy", np.concatenate(loads))
    (truth / "counts.npy").unlink()


def _whole_lines(sensor):
    """Taxels that are judged: not on dead lines, nor on lines that come and go, of which nobody can know the load."""
    scored = np.ones((sensor["array"]["rows"], sensor["array"]["columns"]), bool)
    screen = sensor.get("screen", {})
    scored[screen.get("dead_rows", []) + screen.get("flickering_rows", [])] = False
    scored[:, screen.get("dead_columns", []) + screen.get("flickering_columns", [])] = False
    return scored


def _simulate(taxel, sensor, pattern, seed, output, words, loads_g):
    command = [taxel, "simulate", "--sensor", sensor, "--pattern", pattern, "--seed", seed, "-o", output]
    command += ["--load-g", ",".join(map(str, loads_g)), *words]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        raise Simulation(f"{pattern} of {sensor}, exit code {done.returncode}: {done.stderr.strip()}")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--work", required=True, help="where the cases go")
    arguments.add_argument("--cases", default=HERE / "cases.toml", help="the list of cases")
    arguments.add_argument("--only", nargs="*", help="names of cases; all of them without it")
    arguments.add_argument("--taxel", default="taxel", help="the program")
    given = arguments.parse_args()
    for case in cases_of(given.cases):
        if not given.only or case["name"] in given.only:
            for seed in case["seeds"]:
                print(draw(case, seed, given.work, given.taxel)[0])


if __name__ == "__main__":
    try:
        main()
    except (Simulation, OSError) as error:
        sys.exit(f"generate.py: {error}")
