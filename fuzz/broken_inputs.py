"""Broken inputs over all readers and verbs of the program.

    python3 fuzz/broken_inputs.py TAXEL [--runs 10000] [--seed 1] [--first 0] [--keep FOLDER] [--only N] [--verb NAME]

Makes small sound inputs with the program itself (recordings, sensor files, tables, plans, models), breaks one of them in
each run by the seed, and runs a verb on it. Wanted: an exit code and a sentence. Each run is watched: 10 s without a byte is
`silence`, more than 256 MB is `memory`, exit code 101 is `panic`, a signal is `signal`, more than 64 KiB of complaint is
`flood`, failing without a word is `mute`. Files are looked at too: an input that changed is `overwrote`, an output beside an
exit code 1 or 2 is `half`, anything else that stays is `litter`; and where damage must be seen (a recording with checksums)
exit code 0 with other frames than the sound file has is `lie`. Still talking after 40 s is `long`: ended, and not a fault.

At the end: a table of outcomes by verb; the first failing cases are in FOLDER, each with its command line, files and what
was said. `--only N` repeats run N. Ctrl-C ends with the table of what was run. Exit code 1 where anything was a fault.
"""

import argparse
import collections
import hashlib
import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import breakers
from watched import SILENT, feed_fifo, table, watch

MEMORY_MIB = 256
FAULTS = ["panic", "signal", "silence", "memory", "flood", "mute", "overwrote", "half", "litter", "lie"]
WRITES = ["-o", "--output", "--export", "--marks", "--standard-error", "--static-output", "--truth-sensor", "--figure", "--keep"]
FINE = ["0 good", "1 failed", "2 arguments", "3 with losses", "long"]

SENSOR = """format = 1
name = "small"
[array]
rows = 4
columns = 5
pitch_mm = [2.0, 2.0]
taxel_area_mm2 = 5.0
[readout]
topology = "tia-grounded-columns"
v_test_volts = 0.4
r_feedback_ohms = 2000.0
open_loop_gain = 1e5
r_mux_column_ohms = 10.0
r_mux_row_ohms = [10.0, 11.0, 9.0, 10.0]
r_source_ohms = 1.0
[converter]
bits = 16
full_scale_volts = 2.2
inverted = true
offset_volts = 0.0
noise_counts = 3.0
memory = 0.0
scan_order = "row-by-row"
[material]
g_zero_siemens = 1e-6
factor = 8.29e-6
exponent = 0.857
"""
FULL = SENSOR + """gain = "gain.csv"
saturation_load_g = 2500.0
spread = [0.05, 0.05, 0.01]
[material.bend]
ln_load_g = [3.0, 5.0, 7.0]
ln_siemens = [0.0, 0.02, 0.0]
[screen]
dead_rows = [3]
flickering_columns = [4]
low_counts = 10.0
high_counts = 65000.0
repair = true
"""
DYNAMIC = SENSOR + """[material.dynamic]
lag_weight = [0.1, 0.05]
lag_secs = [1.0, 20.0]
play_weight = [0.05]
play_g = [10.0]
period_secs = 0.1
"""
PLAN = """format = 1
title = "small"
sensor = "s.toml"
resamples = 100
frames_per_second = 10
[[experiment]]
kind = "repeatability"
name = "the same again"
trials = "trials.csv"
[[experiment]]
kind = "response"
name = "loads"
trials = "response.csv"
[[experiment]]
kind = "accuracy"
name = "presses"
trials = "experiments.csv"
ranges_g = [0, 100, 300]
[[experiment]]
kind = "accuracy"
name = "frames"
recording = "r.txt"
truth_g = "loads.csv"
"""


class Base:
    """Sound inputs, by name."""

    def __init__(self, taxel, folder):
        self.taxel, self.folder = taxel, folder
        write = lambda name, text: (folder / name).write_text(text)
        parts = "\n".join(r for r in SENSOR.split("[material]")[0].split("\n") if "r_mux" not in r)
        for name, text in {
            "s.toml": SENSOR, "full.toml": FULL, "dynamic.toml": DYNAMIC, "parts.toml": parts,
            "float.toml": SENSOR.replace("tia-grounded-columns", "divider-floating").replace("r_feedback_ohms = 2000.0\nopen_loop_gain = 1e5", "r_pull_down_ohms = 1000.0").replace("inverted = true\n", ""),
            "other.toml": SENSOR.replace("rows = 4", "rows = 6").replace("columns = 5", "columns = 3").replace("[10.0, 11.0, 9.0, 10.0]", "10.0"),
            "gain.csv": "1.0,1.1,0.9,1,1\n" * 4, "plan.toml": PLAN,
            "trials.csv": "recording,row,column,setting,experiment\n" + "".join(f"even.txt,{i % 4},2,{'before' if i % 2 else 'after'},{i}\n" for i in range(8)),
            "points.csv": "".join(f"{n},{0.5 + 0.01 * n}\n" for n in range(12)),
        }.items():
            write(name, text)
        run = self.run
        run("simulate --sensor s.toml --pattern blobs --frames 60 --load-g 600 --period 0.1 --truth loads.csv -o r.csv")
        run("simulate --sensor s.toml --pattern random --frames 60 --load-g 600 --period 0.1 --truth series-loads.csv -o series.csv")
        run("simulate --sensor s.toml --pattern blobs --frames 60 --load-g 600 -o r.txt")
        run("simulate --sensor other.toml --pattern blobs --frames 9 --load-g 600 -o other.txt")
        run("simulate --sensor float.toml --pattern blobs --frames 60 --load-g 600 -o float.txt")
        run("simulate --sensor s.toml --pattern press --frames 40 --presses experiments.csv -o p.txt")
        run("simulate --sensor s.toml --pattern uniform --load-g 50,100,200,400 --frames 8 --presses equilibration.csv -o even.txt")
        run("simulate --sensor s.toml --pattern uniform --load-g 0.01 --frames 30 -o empty.txt")
        for kind in ("npy", "npz"):
            run(f"simulate --sensor s.toml --pattern blobs --frames 60 --load-g 600 -o r.{kind}")
        run("convert r.csv --sensor s.toml -o r.mcap")
        run("convert r.mcap -o r.parquet")
        run("compensate r.txt --sensor s.toml --unit siemens -o siemens.csv")
        run("compensate r.txt --sensor s.toml --unit siemens -o siemens.npy")
        run("dataset --sensor s.toml --presses experiments.csv -o rows.csv")
        run("train paper-mlp --sensor s.toml --presses experiments.csv -o mlp.safetensors --epochs 2 --copies 1")
        run("train row-set --sensor s.toml --presses experiments.csv -o rowset.safetensors --epochs 1 --members 1")
        run("train hybrid --sensor s.toml --presses experiments.csv -o hybrid.safetensors --epochs 1")
        run("model export mlp.safetensors -o mlp.onnx")
        even = [row.split(",") for row in (folder / "equilibration.csv").read_text().split()[1:]]
        write("response.csv", "recording,frame,load_g,row,column\n" + "".join(f"even.txt,{i},{row[-1]},{i % 4},2\n" for i, row in enumerate(even)))
        laws = [(g, 1 / (1e-6 + 8.29e-6 * g ** 0.857)) for g in (5, 10, 20, 40, 80, 120, 200, 300, 450, 600, 800, 1000)]
        write("pairs.csv", "resistance_ohms,load_g\n" + "".join(f"{r:.2f},{g}\n" for g, r in laws))
        rng = random.Random(1)
        frames = [[rng.randrange(200, 60_000) for _ in range(20)] for _ in range(40)]
        (folder / "wire.bin").write_bytes(b"".join(breakers.packet(f, 4, 5, i) for i, f in enumerate(frames)))
        write("frame-lines.log", "".join(",".join(map(str, f)) + "\n" for f in frames))
        write("row-lines.log", "".join(f"{r}," + ",".join(map(str, f[5 * r:5 * r + 5])) + "\n" for f in frames for r in range(4)))
        write("econe.log", "".join("frame\n" + "".join(",".join(map(str, f[5 * r:5 * r + 5])) + ",\n" for r in range(4)) for f in frames))
        (folder / "made.mcap").write_bytes(breakers.mcap_made(random.Random(3), SENSOR.encode(), 4, 5))
        self.files = {p.name: p.read_bytes() for p in folder.iterdir()}
        self.carried = {}
        for name in ("r.mcap", "made.mcap"):
            run(f"recover {name} -o sound-{name}")
            self.carried[name] = carried(folder / f"sound-{name}")
            (folder / f"sound-{name}").unlink(missing_ok=True)
        self.truth = {name: self.frames(name) for name in ("r.mcap", "made.mcap", "r.npz")}

    def run(self, line):
        done = subprocess.run([self.taxel, *shlex.split(line)], cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True)
        if done.returncode not in (0, 3):
            print(f"note: no sound input from `taxel {line}`: {done.stderr.decode(errors='replace').strip()}", file=sys.stderr)
        return done.returncode

    def frames(self, name, folder=None):
        """The counts of a recording, as rows of numbers, without times."""
        with tempfile.TemporaryDirectory(dir=self.folder.parent) as scratch:
            to = Path(scratch) / "frames.txt"
            source = (folder or self.folder) / name
            sensor = [] if name.endswith(".mcap") else ["--sensor", str(self.folder / "s.toml")]
            done = subprocess.run([self.taxel, "convert", str(source), *sensor, "-o", str(to)], stdin=subprocess.DEVNULL, capture_output=True)
            if done.returncode not in (0, 3) or not to.exists():
                return None
            return to.read_text()


class Case:
    def __init__(self, verb, argv, outputs=(), stdin=None, breakable=None, judge=None):
        self.verb, self.argv, self.outputs, self.stdin = verb, argv, set(outputs), stdin
        self.breakable, self.judge = breakable, judge
        self.broken = ""


RECORDINGS = ["r.txt", "r.csv", "r.npy", "r.npz", "r.mcap", "r.mcap", "made.mcap", "float.txt"]


def recording(rng):
    return rng.choice(RECORDINGS)


def sensor(rng):
    return rng.choice(["s.toml", "s.toml", "full.toml", "dynamic.toml", "float.toml"])


def some(rng, *options):
    """Some of the options, each with its value."""
    return [word for option in options if rng.random() < 0.25 for word in shlex.split(option)]


def info(rng):
    name = recording(rng)
    with_sensor = ["--sensor", sensor(rng)] if rng.random() < 0.5 else ["--rows", "4"] if not name.endswith("mcap") else []
    return Case("info", ["info", name, *with_sensor, *some(rng, "--json", "--keep-going", "--values")])


def compensate(rng):
    name, to = recording(rng), rng.choice(["l.csv", "l.npy", "l.npz", "l.mcap", "l.parquet", "l.txt"])
    method = ["--method", rng.choice(["raw", "exact", "newton", "mlp.safetensors", "rowset.safetensors", "hybrid.safetensors"])] if rng.random() < 0.4 else []
    outputs = {to, "l.marks.csv", "l.marks.npy", "l.marks.npz", "se.csv", "m.csv"}
    unit = rng.choice(["g", "N", "kPa", "volts", "siemens"])
    options = some(rng, "--standard-error se.csv", "--marks m.csv", "--keep-going", "--repair", "--json")
    where = ["-o", to] if rng.random() < 0.8 or options else []
    if rng.random() < 0.15:
        return Case("compensate", ["compensate", "siemens.csv" if rng.random() < 0.5 else "siemens.npy", "--sensor", sensor(rng), "--input-unit", "siemens", *where], outputs)
    return Case("compensate", ["compensate", name, "--sensor", sensor(rng), "--unit", unit, *method, *options, *where], outputs)


def calibrate_presses(rng):
    more = ["--equilibration", "equilibration.csv"] if rng.random() < 0.4 else []
    return Case("calibrate presses", ["calibrate", "--sensor", rng.choice(["parts.toml", "s.toml", "full.toml"]), "--presses", "experiments.csv", *more,
                                      *some(rng, rng.choice(["--law power", "--law spline"]), "--per-line", "--folds 3", "--json", "--fit-source"), "-o", "k.toml"],
                {"k.toml", "k.gain.csv", "k.exponent.csv", "k-gain.csv", "k-exponent.csv"}, breakable=["experiments.csv", "p.txt", "equilibration.csv", "even.txt", "parts.toml"])


def calibrate_pairs(rng):
    return Case("calibrate pairs", ["calibrate", "--sensor", rng.choice(["parts.toml", "s.toml"]), "--pairs", "pairs.csv", *some(rng, "--json", "--folds 3"), "-o", "k.toml"], {"k.toml"})


def calibrate_series(rng):
    return Case("calibrate series", ["calibrate", "--sensor", "s.toml", "--series", rng.choice(["r.csv", "r.mcap", "r.npy"]), "--loads", "loads.csv", "--period", "0.1",
                                     "--lags", "1", "--plays", "1", *some(rng, "--static-output st.toml"), "-o", "k.toml"], {"k.toml", "st.toml"})


def analyse(rng):
    name, to = recording(rng), rng.choice(["a.png", "a.svg"])
    which = rng.choice([["--taxel", "1,2"], ["--taxel", "C1"], ["--row", "2"], ["--column", "1"], ["--region", "0..2,1..3"]])
    with_sensor = ["--sensor", sensor(rng), "--unit", rng.choice(["g", "volts", "siemens"])] if rng.random() < 0.6 else ["--rows", "4"] if not name.endswith("mcap") else []
    export = rng.choice([[], ["--export", "e.csv"], ["--export", "e.xlsx"], ["--export", "e.parquet"]])
    return Case("analyse", ["analyse", name, *which, *with_sensor, *some(rng, "--json", "--keep-going", "--frames-per-second 10"), *export, "-o", to], {to, "e.csv", "e.xlsx", "e.parquet"})


def plot(rng):
    name, to = recording(rng), rng.choice(["a.png", "a.svg"])
    which = rng.choice([["--frame", "3"], ["--frames", "0..4"], ["--taxel", "1,2"], ["--row", "1"], []])
    return Case("plot", ["plot", name, "--sensor", sensor(rng), *which, *some(rng, rng.choice(["--raw", "--before-after", "--values"]), "--interpolation nearest"), "-o", to], {to})


def convert(rng):
    name = rng.choice(["r.txt", "r.csv", "r.npy", "r.npz", "r.npz", "r.mcap", "r.mcap", "r.mcap", "made.mcap"])
    to = rng.choice(["o.txt", "o.csv", "o.npy", "o.npz", "o.mcap", "o.parquet"])
    checked = name in ("r.mcap", "made.mcap", "r.npz")
    with_sensor = [] if name.endswith("mcap") and rng.random() < 0.8 else ["--sensor", "s.toml"]
    return Case("convert", ["convert", name, *with_sensor, *some(rng, "--keep-going", "--fps 20"), "-o", to], {to},
                breakable=[name] if rng.random() < 0.85 else None, judge=(name, to) if checked and to != "o.parquet" else None)


def recover(rng):
    name = rng.choice(["r.mcap", "r.mcap", "made.mcap"])
    return Case("recover", ["recover", name, "-o", "o.mcap"], {"o.mcap"}, judge=(name, "o.mcap"))


def replay(rng):
    name = recording(rng)
    return Case("replay", ["replay", name, "--to", rng.choice(["udp:127.0.0.1:9", "-"]), *(["--sensor", "s.toml"] if not name.endswith("mcap") else []), "--speed", "0"])


def selftest(rng):
    return Case("selftest", ["selftest", "--empty", rng.choice(["empty.txt", "r.npy", "r.mcap"]), "--rubbed", recording(rng),
                             "--sensor", sensor(rng), *some(rng, "--json", "-o h.png", "--rate 100")], {"h.png"})


def evaluate(rng):
    verb = rng.choice(["evaluate", "evaluate", "report"])
    return Case(verb, [verb, "plan.toml", *(["-o", "rep.html"] if verb == "report" or rng.random() < 0.3 else [])], {"rep.html"},
                breakable=["plan.toml", "plan.toml", "trials.csv", "response.csv", "experiments.csv", "s.toml", "r.txt", "loads.csv", "even.txt", "p.txt"])


def simulate(rng):
    to = rng.choice(["o.txt", "o.csv", "o.npy", "o.npz"])
    if rng.random() < 0.6:
        return Case("simulate", ["simulate", "--sensor", sensor(rng), "--conductance", rng.choice(["siemens.csv", "siemens.npy"]), "--unit", rng.choice(["volts", "counts"]), "-o", to], {to})
    return Case("simulate", ["simulate", "--sensor", sensor(rng), "--pattern", rng.choice(["hand", "feet", "press", "blobs", "uniform", "random"]), "--frames", "3",
                             *some(rng, "--load-g 100", "--seed 5", "--period 0.1", "--imperfect uneven", "--imperfect beyond", "--truth t.csv", "--truth-sensor ts.toml"), "-o", to],
                {to, "t.csv", "ts.toml", "ts.gain.csv", "ts.exponent.csv", "ts-gain.csv", "ts-exponent.csv"})


def netlist(rng):
    which = rng.choice([["r.txt"], ["--conductance", "siemens.csv"], ["r.npz"], []])
    return Case("netlist", ["netlist", "--sensor", sensor(rng), *which, *some(rng, "--frame 2", "--taxel 1,1", "--scan"), "-o", "n.cir"], {"n.cir"})


def budget(rng):
    return Case("budget", ["budget", sensor(rng), *some(rng, "--frame r.txt:1", "--rate 60", "--full-load 500", "--json"), "--draws", "1"])


def design(rng):
    return Case("design", ["design", "--taxel", "500..3000", "--rows", "8", "--columns", "8", *some(
        rng, "--topology divider-floating", "--switch 70", "--gbw 5MHz", "--bits 12", "--full-scale 3.3", "--rate 50", "--full-load 500g", "--exponent 0.9", "--capacitance 100pF",
        "--taxel-current 1mA", "--headroom 10", "--pitch 3", "--v-test 0.3", "--resistor 1000", "--json"), "-o", "d.toml"], {"d.toml"}, breakable=["argument"])


def rig(rng):
    return Case("rig", ["rig", *rng.choice([["--pressure", "0.2MPa"], ["--load", "132g"], ["--margin", "5g", "--spread", "12g"], ["--shares", "22,5"]]),
                        *some(rng, "--spring 0.2", "--area 5", "--offset 2", "--confidence 90", "--power 90", "--json")], breakable=["argument"])


def crosstalk(rng):
    to = rng.choice(["c.png", "c.svg"])
    return Case("crosstalk", ["crosstalk", *some(rng, "--setting A=1e4,R_k=1000", "--volts-per-count 0.001", "--csv"), "-n", "8", "--points", "points.csv", *(["-o", to] if rng.random() < 0.5 else [])], {to})


def dataset(rng):
    if rng.random() < 0.2:
        return Case("dataset", ["dataset", "--sensor", sensor(rng), "--simulate", "3", "--shard", "2", "-o", "folder"], {"folder"})
    to = rng.choice(["o.csv", "o.npz"])
    return Case("dataset", ["dataset", "--sensor", "s.toml", "--presses", "experiments.csv", *(["--rows", "rows.csv"] if to == "o.csv" and rng.random() < 0.5 else []), "-o", to], {to},
                breakable=["experiments.csv", "p.txt", "rows.csv", "s.toml"])


def train(rng):
    kind = rng.choice([["paper-mlp", "--epochs", "1", "--copies", "1"], ["row-set", "--epochs", "1", "--members", "1"], ["hybrid", "--epochs", "1"]])
    source = rng.choice([["--presses", "experiments.csv"], ["--rows", "rows.csv"]]) if kind[0] != "hybrid" else ["--presses", "experiments.csv"]
    return Case("train", ["train", *kind, "--sensor", "s.toml", *source, *some(rng, "--test-share 0.2", "--check-share 0.2", "--seed 3", "--json"), "-o", "o.safetensors"],
                {"o.safetensors", "o.safetensors.checkpoint"}, breakable=["experiments.csv", "p.txt", "rows.csv", "s.toml"])


def compare(rng):
    sources = ["--presses", "experiments.csv"] if rng.random() < 0.7 else ["--rows", "rows.csv"]
    more = ["r.txt", "--truth", "loads.csv"] if rng.random() < 0.3 else []
    return Case("compare", ["compare", *more, "--sensor", rng.choice(["s.toml", "parts.toml"]), *sources, "--epochs", "1", "--copies", "1", "--without", "paper-mlp", "--without", "row-set",
                            "--without", "hybrid", "-o", "t.csv"], {"t.csv"}, breakable=["experiments.csv", "p.txt", "rows.csv", "s.toml", "r.txt", "loads.csv"])


def model(rng):
    name = rng.choice(["mlp.safetensors", "rowset.safetensors", "hybrid.safetensors"])
    how = rng.randrange(4)
    if how == 0:
        return Case("model show", ["model", "show", name])
    if how == 1:
        return Case("model export", ["model", "export", "mlp.safetensors", "-o", "o.onnx"], {"o.onnx"})
    if how == 2:
        return Case("model import", ["model", "import", "mlp.onnx", "--sensor", "s.toml", "--presses", "experiments.csv", "-o", "o.safetensors"], {"o.safetensors"}, breakable=["mlp.onnx"])
    return Case("model used", ["compensate", "r.txt", "--sensor", "s.toml", "--method", name, "-o", "l.csv"], {"l.csv", "l.marks.csv"}, breakable=[name])


def record(rng):
    name, protocol = rng.choice([("wire.bin", "taxel-1"), ("wire.bin", "taxel-1"), ("frame-lines.log", "lines"), ("row-lines.log", "lines"), ("econe.log", "econe-text")])
    address = "stdin:" + (f"?protocol={protocol}" if rng.random() < 0.5 else "")
    return Case("record stdin", ["record", address, "--sensor", "s.toml", *some(rng, "--loads", "--figures", "--frames 10"), "-o", "o.mcap"], {"o.mcap"}, stdin=name,
                breakable=["stdin", "stdin", "stdin", "stdin", "s.toml"], judge=("wire", "o.mcap") if protocol == "taxel-1" else None)


def record_file(rng):
    name = rng.choice(["r.txt", "r.csv", "r.mcap", "made.mcap", "r.npy"])
    return Case("record file", ["record", f"file:{name}?speed=max", "--sensor", "s.toml", *some(rng, "--loads", "--figures", "--frames 5"), "-o", "o.mcap"], {"o.mcap"}, breakable=[name, name, "s.toml"])


def from_stdin(rng):
    """Text on standard input."""
    verb = rng.choice([["info", "-", "--sensor", "s.toml"], ["compensate", "-", "--sensor", "s.toml", "-o", "l.csv"], ["compensate", "-", "--sensor", "s.toml"],
                       ["simulate", "--sensor", "s.toml", "--conductance", "-"]])
    return Case("text on stdin", verb, {"l.csv", "l.marks.csv"}, stdin="siemens.csv" if verb[0] == "simulate" else "r.txt", breakable=["stdin"])


RECIPES = [(info, 8), (compensate, 14), (calibrate_presses, 6), (calibrate_pairs, 4), (calibrate_series, 3), (analyse, 6), (plot, 6), (convert, 10), (recover, 10), (replay, 4),
           (selftest, 4), (evaluate, 6), (simulate, 4), (netlist, 3), (budget, 3), (design, 2), (rig, 1), (crosstalk, 2), (dataset, 3), (train, 3), (compare, 1), (model, 6),
           (record, 9), (record_file, 3), (from_stdin, 3)]


def wanted(case, base):
    """Names of the inputs that the case reads, with what they name in turn."""
    found, todo = [], [word.split("?")[0].removeprefix("file:").split(":")[0] for word in case.argv]
    while todo:
        name = todo.pop()
        if name in base.files and name not in found and name not in case.outputs:
            found.append(name)
            text = base.files[name]
            if name in ("plan.toml", "trials.csv", "response.csv", "experiments.csv", "equilibration.csv", "full.toml"):
                todo += [w.decode() for w in set(re.findall(rb"[a-z-]+\.(?:txt|csv|toml)", text))]
    return found


def break_bytes(rng, name, data, base):
    """(what was done, the broken bytes or pieces)"""
    kind = name.rsplit(".", 1)[-1]
    if rng.random() < 0.03:
        other = rng.choice(list(base.files))
        return f"holds {other}", base.files[other]
    if rng.random() < 0.003:
        return "huge_line", breakers.huge_line(rng, data)
    ways = {
        "txt": [breakers.lines, breakers.cells], "csv": [breakers.lines, breakers.cells, breakers.cells, breakers.column], "log": [breakers.lines, breakers.cells],
        "toml": [breakers.toml, breakers.toml, breakers.cells, breakers.lines], "npy": [breakers.npy_header], "npz": [breakers.npz], "mcap": [breakers.mcap],
        "safetensors": [breakers.safetensors], "onnx": [breakers.onnx], "bin": [breakers.packets, breakers.forged],
    }.get(kind, [breakers.flips])
    how = rng.choice(ways) if rng.random() < 0.6 else rng.choice(breakers.BYTES)
    return how.__name__, how(rng, data)


def endless(rng):
    """Up to 32 MB that never make a frame, or make frames for ever."""
    unit = rng.choice([b"A", b"1,", b"\0", b"\n", b"0,0,0,0,0\n", b"1,2,3,4,5,", b"9", b"\xff", b"frame\n", b"7"])
    piece = unit * ((1 << 16) // len(unit))
    return f"endless {unit!r}", (piece for _ in range(rng.choice([64, 512])))


def pieces(rng, data):
    """The bytes of a device in pieces of any size."""
    at = 0
    size = rng.choice([1 << 16, 1000, 61])
    while at < len(data):
        yield data[at:at + size]
        at += size


def make(rng, base, verb):
    """A case, its files by name, what standard input gets, and named pipes."""
    recipes = [r for r in RECIPES if verb is None or verb in r[0].__name__]
    case = rng.choices([r for r, _ in recipes], [w for _, w in recipes])[0](rng)
    names = wanted(case, base)
    files, fifos, stdin = {name: base.files[name] for name in names}, {}, None
    case.exact = True  # judged by the frames of the sound file
    target = rng.choice([n for n in case.breakable if n in names or n in ("stdin", "argument")] if case.breakable else names or ["argument"])
    dice = rng.random()
    if case.stdin:
        stdin = pieces(rng, base.files[case.stdin])
    if target == "stdin" and dice < 0.002:
        case.broken, stdin = "stdin is silent", SILENT
    elif target == "stdin" and dice < 0.05:
        said, stdin = endless(rng)
        case.broken, case.exact = said, False
    elif target == "stdin":
        said, data = break_bytes(rng, case.stdin, base.files[case.stdin], base)
        case.broken, stdin = f"stdin: {said}", pieces(rng, data) if isinstance(data, bytes) else data
        case.exact = said in ("flips", "packets", "filled", "removed", "moved")
    elif dice < 0.09 or target == "argument":
        spots = [i for i, w in enumerate(case.argv) if i and re.match(r"^-?[0-9]", w)] or [len(case.argv) - 1]
        spots = [i for i in spots if case.argv[i - 1] not in ("--epochs", "--copies", "--members", "--simulate") and not (case.verb == "simulate" and case.argv[i - 1] == "--frames")] or [len(case.argv) - 1]
        at = rng.choice(spots)
        word = rng.choice(breakers.NASTY + breakers.WORDS + ["1e-300MPa", "1..", "0..4294967296", "5..1", "C99999999999", "0,0,0"]).replace("\0", "")
        if case.argv[at] in case.outputs:
            case.outputs.add(word)
        elif rng.random() < 0.05:
            word = rng.choice(["/dev/zero", "/dev/null", "/dev/full"])  # to read; never where an output is named
        if case.argv[at] in case.outputs and "/" in word and not word.startswith(("nowhere", "../nowhere")):
            word = "x"
        case.broken, case.argv[at], case.exact = f"argument {at}", word, False
    elif dice < 0.11 and case.outputs and names:
        at = [i for i, w in enumerate(case.argv) if w in case.outputs]
        if at:
            case.broken, case.argv[rng.choice(at)] = "an output is an input", rng.choice(names)
        case.exact = False
    elif dice < 0.13 and target in case.argv:
        other = "x." + rng.choice(["txt", "csv", "npy", "npz", "mcap", "toml", "parquet", "safetensors", "onnx", "", "MCAP", "html"])
        files[other] = files.pop(target)
        case.argv[case.argv.index(target)] = other
        case.broken, case.exact = f"{target} as {other}", False
    elif dice < 0.135:
        case.broken, case.exact = f"{target} is a pipe", False
        del files[target]
        fifos[target] = SILENT if rng.random() < 0.05 else [base.files[target]]
    elif dice < 0.14:
        case.broken, case.exact = f"{target} is missing or a folder", False
        files[target] = None if rng.random() < 0.5 else "folder"
    else:
        said, files[target] = break_bytes(rng, target, files[target], base)
        case.broken = f"{target}: {said}"
        names_it = case.judge and target == case.judge[0] and not said.startswith("holds") and said not in ("npz", "huge_line")
        case.exact = bool(names_it)
    return case, files, fifos, stdin


def write(folder, files):
    for name, data in files.items():
        to = folder / name
        if data is None:
            continue
        if data == "folder":
            to.mkdir()
        elif isinstance(data, bytes):
            to.write_bytes(data)
        else:
            with to.open("wb") as file:
                file.writelines(data)


def prints(folder):
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            with path.open("rb") as file:
                found[str(path.relative_to(folder))] = hashlib.file_digest(file, "md5").hexdigest()
        else:
            found[str(path.relative_to(folder))] = "other"
    return found


def judged(case, base, folder, before, ended):
    """A fault in what the run left behind, or None."""
    after = prints(folder)
    changed = [name for name, was in before.items() if after.get(name) != was]
    if changed:
        return "overwrote", f"the input {changed[0]} is not what it was"
    new = [name for name in after if name not in before]
    litter = [name for name in new if name.split("/")[0] not in case.outputs]
    if litter:
        return "litter", f"left {', '.join(litter[:5])}"
    if ended.code in (1, 2):
        half = [name for name in new if not name.endswith(".checkpoint")]
        if half:
            return "half", f"exit code {ended.code}, but there is {', '.join(half[:5])}"
    if ended.code == 0 and case.judge and case.exact and (folder / case.judge[1]).exists():
        source, to = case.judge
        got = base.frames(to, folder)
        if source == "wire":
            sent = base.wire_frames()
            n = (got or "").count("\n") // 4
            if "--frames" not in case.argv and (got is None or got not in sent):
                return "lie", f"exit code 0, but the {n} frames are not those that were sent"
        elif got != base.truth[source]:
            return "lie", f"exit code 0, but other frames: {(got or '').count(chr(10)) // 4} of {base.truth[source].count(chr(10)) // 4}"
        elif case.verb == "recover" and carried(folder / to) != base.carried[source]:
            return "lie", "exit code 0, but the sensor file is another"
    return None


def carried(path):
    """The sensor file in a recording, or None."""
    found = {content for op, content in breakers.mcap_records(path.read_bytes()) if op == breakers.METADATA and b"sensor_toml" in content}
    texts = {content.split(b"sensor_toml", 1)[1][4:].split(b"exponent = 0.857")[0] for content in found}
    return texts.pop() if len(texts) == 1 else None


def wire_frames(base):
    """All frames that wire.bin holds, as text; what is recorded from a sound stream is a stretch of it."""
    return "".join(r + "\n" for r in base.files["econe.log"].decode().split("\n") if r and r != "frame")


def keep(to, i, case, files, outcome, why, ended, folder, stdin_copy):
    name = re.sub(r"[^A-Za-z0-9]+", "-", f"{outcome}-{case.verb}-{i}")
    place = to / name
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(folder, place / "after", ignore=lambda where, names: [n for n in names if not (Path(where) / n).is_file() and not (Path(where) / n).is_dir()])
    (place / "before").mkdir()
    for name, data in files.items():
        if isinstance(data, bytes):
            (place / "before" / name).write_bytes(data)
    if stdin_copy is not None:
        (place / "before" / "stdin").write_bytes(stdin_copy)
    (place / "case.txt").write_text(
        f"run {i}: {outcome}: {why}\nbroken: {case.broken}\ntaxel {shlex.join(case.argv)}{' < stdin' if case.stdin else ''}\n"
        f"exit code {ended.code}, {ended.seconds:.2f} s, silent for {ended.silence:.2f} s, {ended.peak_mib:.0f} MB\n--- standard error\n{ended.err[-4000:].decode(errors='replace')}\n"
        f"--- standard output\n{ended.out[-1000:].decode(errors='replace')}\n", errors="replace")
    return place


def one(i, args, base, folder):
    """Makes, runs and judges run i: (case, outcome, why, ended, keep it)."""
    rng = random.Random(f"{args.seed}/{i}")
    case, files, fifos, stdin = make(rng, base, args.verb)
    write(folder, files)
    stop = threading.Event()
    for name, feed in fifos.items():
        os.mkfifo(folder / name)
        feed_fifo(str(folder / name), feed, stop)
    before = prints(folder)
    copy = None
    if stdin is not None and stdin is not SILENT and not case.broken.startswith("endless"):
        copy = b"".join(stdin)
        stdin = pieces(random.Random(i), copy)
    argv = [word.replace("\0", "") for word in case.argv]
    for flag, word in zip(argv, argv[1:]):
        if flag in WRITES and (word.startswith("/") or "../" in word and not word.startswith("../nowhere/")):
            raise SystemExit(f"run {i} would write outside of its folder: {word}")
    ended = watch([args.taxel, *argv], folder, stdin, fifo_stop=stop)
    stop.set()
    outcome, why = ended.outcome(MEMORY_MIB), ""
    if outcome in FINE and outcome != "long":
        bad = judged(case, base, folder, before, ended)
        if bad:
            outcome, why = bad
    return case, files, outcome, why, ended, copy


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taxel")
    parser.add_argument("--runs", type=int, default=10_000)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--first", type=int, default=0, help="begin with this run")
    parser.add_argument("--keep", type=Path, default=None)
    parser.add_argument("--only", type=int, default=None)
    parser.add_argument("--verb", default=None, help="only recipes whose name holds this")
    args = parser.parse_args()
    args.taxel = str(Path(args.taxel).resolve())
    args.keep = args.keep or Path(tempfile.mkdtemp(prefix="broken-inputs-"))
    args.keep.mkdir(parents=True, exist_ok=True)
    counts, seen, worst = collections.Counter(), collections.Counter(), collections.defaultdict(float)
    begin = time.monotonic()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it otherwise
    with tempfile.TemporaryDirectory(prefix="broken-") as scratch:
        (Path(scratch) / "base").mkdir()
        base = Base(args.taxel, Path(scratch) / "base")
        base.wire_frames = lambda text=wire_frames(base): text
        for i in [args.only] if args.only is not None else range(args.first, args.runs):
            folder = Path(scratch) / "run"
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            try:
                case, files, outcome, why, ended, copy = one(i, args, base, folder)
            except KeyboardInterrupt:
                break
            counts[case.verb, outcome] += 1
            worst["memory", case.verb] = max(worst["memory", case.verb], ended.peak_mib)
            worst["silence", case.verb] = max(worst["silence", case.verb], ended.silence)
            at = re.search(rb"panicked at ([^\n]*)", ended.err)
            alike = (outcome, case.verb, at.group(1) if at else why[:30])
            if args.only is not None or (outcome in FAULTS + ["long"] and seen[alike] < 3):
                place = keep(args.keep, i, case, files, outcome, why, ended, folder, copy)
                print(f"{outcome}: run {i}, {case.broken}: taxel {shlex.join(case.argv)[:300]}: {why or (at.group(0).decode() if at else '')} [{place.name}]", flush=True)
            seen[alike] += outcome in FAULTS + ["long"]
            if (i + 1) % 500 == 0:
                print(f"{i + 1} runs, {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
    verbs = sorted({verb for verb, _ in counts})
    used = [o for o in FINE + FAULTS if any(counts[v, o] for v in verbs) or o in ("panic", "signal", "silence", "memory")] + sorted({o for _, o in counts} - set(FINE + FAULTS))
    rows = [[v] + [counts[v, o] for o in used] + [f"{worst['memory', v]:.0f}", f"{worst['silence', v]:.1f}"] for v in verbs]
    rows.append(["all"] + [sum(counts[v, o] for v in verbs) for o in used] + [f"{max(worst['memory', v] for v in verbs):.0f}", f"{max(worst['silence', v] for v in verbs):.1f}"])
    print(table(rows, ["verb", *used, "MB at most", "s silent at most"]))
    faults = sum(n for (_, o), n in counts.items() if o not in FINE)
    print(f"{sum(counts.values())} runs by seed {args.seed} in {time.monotonic() - begin:.0f} s; {faults} faults" + (f", kept in {args.keep}" if faults else ""))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
