"""Sound inputs, made with the program itself: what broken_inputs.py breaks. Not a command of its own."""

import random
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import breakers
import wire

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


def carried(path):
    """The sensor file in a recording, or None."""
    found = {content for op, content in breakers.mcap_records(path.read_bytes()) if op == breakers.METADATA and b"sensor_toml" in content}
    texts = {content.split(b"sensor_toml", 1)[1][4:].split(b"exponent = 0.857")[0] for content in found}
    return texts.pop() if len(texts) == 1 else None


def wire_frames(base):
    """All frames that wire.bin holds, as text; what is recorded from a sound stream is a stretch of it."""
    return "".join(r + "\n" for r in base.files["econe.log"].decode().split("\n") if r and r != "frame")


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
        (folder / "wire.bin").write_bytes(b"".join(wire.packet(f, 4, 5, i) for i, f in enumerate(frames)))
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
