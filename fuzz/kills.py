"""Kills the program at random moments and looks at what lies there afterwards.

    python3 fuzz/kills.py TAXEL [--kills 200] [--seed 1] [--keep FOLDER]

`kill -9` (two of three times), SIGTERM or SIGHUP over `record`, `convert`, `compensate`, `calibrate` and a shell loop over
files as people write it, the whole group of the loop at once. An older output of the name is there half of the time (not .mcap, which is never overwritten). Then:

- what lies under a final name is the older file, untouched, or the new one, whole: the same frames as in a run without a
  kill. Anything else is `half`;
- hidden files beside it: after SIGTERM and SIGHUP `litter`; after `kill -9`, where nobody can tidy, they are counted;
- the same command again ends well and its output is whole, else `blocked`;
- a recording opens, after `taxel recover` where it was killed, without gaps, else `unreadable`; seconds lost are those
  between the kill and the last frame in the file. One without a frame must not stand in the way of the next (`blocked`).
  After SIGTERM and SIGHUP it is whole as it is, with every frame to within a quarter of a second (`lost`).

Exit code 1 where anything of that was found.
"""

import argparse
import collections
import os
import random
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import breakers
from watched import table

SENSOR = """format = 1
[array]
rows = 16
columns = 16
[readout]
topology = "tia-grounded-columns"
v_test_volts = 0.4
r_feedback_ohms = 2000.0
r_mux_column_ohms = 10.0
r_mux_row_ohms = 10.0
[converter]
bits = 16
full_scale_volts = 2.2
inverted = true
[material]
g_zero_siemens = 1e-6
factor = 8.29e-6
exponent = 0.857
"""
SIGNALS = [signal.SIGKILL] * 4 + [signal.SIGTERM, signal.SIGHUP]
JOBS = {
    "convert": ["taxel convert in.csv --sensor s.toml -o out.mcap", "taxel convert in.mcap -o out.parquet", "taxel convert in.mcap -o out.npy", "taxel convert in.mcap -o out.npz",
                "taxel convert in.npy --sensor s.toml -o out.csv"],
    "compensate": ["taxel compensate in.csv --sensor s.toml -o out.csv", "taxel compensate in.npy --sensor s.toml -o out.npy",
                   "taxel compensate in.mcap -o out.csv --standard-error se.csv"],
    "calibrate": ["taxel calibrate --sensor parts.toml --presses experiments.csv -o out.toml"],
    "loop": ["for f in a b c; do [ -f $f.mcap ] || taxel convert $f.csv --sensor s.toml -o $f.mcap || exit; [ -f $f.loads.csv ] || taxel compensate $f.mcap -o $f.loads.csv || exit; done"],
}
OUTPUTS = {"loop": [f + end for f in "abc" for end in (".mcap", ".loads.csv")]}


def shell(line, folder, **more):
    return subprocess.run(["sh", "-c", line], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, env=more.pop("env"), **more)


class Kills:
    def __init__(self, args, base):
        self.args, self.base = args, base
        self.env = dict(os.environ, PATH=f"{base / 'bin'}:{os.environ['PATH']}")
        (base / "bin").mkdir()
        (base / "bin" / "taxel").symlink_to(args.taxel)
        self.inputs = base / "inputs"
        self.inputs.mkdir()
        (self.inputs / "s.toml").write_text(SENSOR)
        (self.inputs / "parts.toml").write_text("\n".join(r for r in SENSOR.split("[material]")[0].split("\n") if "r_mux" not in r))
        for line in ["taxel simulate --sensor s.toml --pattern hand --frames 1000 -o in.csv", "taxel simulate --sensor s.toml --pattern hand --frames 1000 -o in.npy",
                     "taxel convert in.csv --sensor s.toml -o in.mcap", "taxel simulate --sensor s.toml --pattern press --frames 60 --presses experiments.csv -o p.txt"]:
            done = shell(line, self.inputs, env=self.env)
            if done.returncode not in (0, 3):
                sys.exit(f"{line}: {done.stderr.decode()}")
        for name in "abc":
            shutil.copy(self.inputs / "in.csv", self.inputs / f"{name}.csv")
        self.sound = {}

    def outputs(self, verb, folder):
        return [n for n in os.listdir(folder) if n not in os.listdir(self.inputs)]

    def reference(self, verb, line):
        """Outputs and seconds of a run that nobody kills."""
        if line not in self.sound:
            folder = self.fresh()
            begin = time.monotonic()
            done = shell(line, folder, env=self.env)
            seconds = time.monotonic() - begin
            made = {n: (folder / n).read_bytes() for n in self.outputs(verb, folder)}
            if done.returncode not in (0, 3) or not made:
                print(f"note: `{line}` ends with {done.returncode} by itself: {done.stderr.decode(errors='replace').strip()[-300:]}", file=sys.stderr)
            self.sound[line] = (seconds, made, done.returncode)
        return self.sound[line]

    def fresh(self):
        folder = Path(tempfile.mkdtemp(prefix="run-", dir=self.base))
        for path in self.inputs.iterdir():
            os.link(path, folder / path.name)
        return folder

    def whole(self, name, folder, made):
        """Whether the output is that of a run without a kill."""
        data = (folder / name).read_bytes()
        if data == made[name]:
            return True
        strip = lambda text: b"\n".join(r for r in text.split(b"\n") if not r.startswith(b"date"))
        if name.endswith(".toml"):
            return strip(data) == strip(made[name])
        if name.endswith(".mcap"):  # may bear the time of day
            (folder / ".sound.mcap").write_bytes(made[name])
            read = []
            for file in (name, ".sound.mcap"):
                done = shell(f"taxel convert {file} -o .read.txt && cat .read.txt && rm .read.txt", folder, env=self.env)
                read.append((done.returncode, done.stdout))
            (folder / ".sound.mcap").unlink()
            return read[0] == read[1] and read[0][0] == 0
        return len(data) == len(made[name]) and name.endswith(".parquet")

    def begin(self, line, folder):
        return subprocess.Popen(["sh", "-c", line if line.startswith("for") else "exec " + line], cwd=folder, env=self.env, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                start_new_session=True)

    def kill(self, process, what):
        try:
            os.killpg(process.pid, what)
        except ProcessLookupError:
            pass
        try:
            said = process.communicate(timeout=20)[1]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None, process.communicate()[1]
        return process.returncode, said

    def job(self, rng, verb, what):
        """One kill of a command with outputs; words of what was found."""
        line = rng.choice(JOBS[verb])
        seconds, made, sound_code = self.reference(verb, line)
        folder, found = self.fresh(), []
        old = {}
        if rng.random() < 0.5 and verb != "loop":
            for name in made:
                if name.endswith(".mcap"):  # recordings are never overwritten
                    continue
                old[name] = b"an older file\n"
                (folder / name).write_bytes(old[name])
        process = self.begin(line, folder)
        time.sleep(rng.uniform(0, 1.05 * seconds))
        code, said = self.kill(process, what)
        if code is None:
            found.append("deaf")
        elif code in (0, 3):
            found.append("done before")
        for name in made:
            if not (folder / name).exists():
                if name in old:
                    found.append("half")  # the older file is gone
            elif old.get(name) == (folder / name).read_bytes():
                pass
            elif not self.whole(name, folder, made):
                found.append("half")
        stray = [n for n in self.outputs(verb, folder) if n not in made]
        if stray:
            found.append("left" if what == signal.SIGKILL else "litter")
        if verb != "loop":
            for name in made:
                if name.endswith(".mcap") and "half" not in found:
                    (folder / name).unlink(missing_ok=True)
        again = shell(line, folder, env=self.env)
        if again.returncode != sound_code or not all((folder / n).exists() and self.whole(n, folder, made) for n in made):
            found.append("blocked")
            said += again.stderr
        if stray and any((folder / n).exists() for n in stray):
            found.append("left after the next run")
        return line, folder, found, f"{stray}\n{said.decode(errors='replace')}", None

    def recording(self, rng, what):
        rate = rng.choice([50, 200, 1000])
        source = rng.choice([f"sim:mat-16x16-cd4067?hand&fps={rate}", f"sim:econe?hand&fps={min(rate, 200)}"])
        line = f"taxel record '{source}' {rng.choice(['', '--loads', '--figures --loads'])} -o run.mcap"
        folder, found, lost = self.fresh(), [], None
        process = self.begin(line, folder)
        wait = rng.choice([rng.uniform(0, 0.2), rng.uniform(0.2, 2.5)])
        time.sleep(wait)
        now = time.time()
        code, said = self.kill(process, what)
        if code is None:
            found.append("deaf")
        run = folder / "run.mcap"
        name = "run.mcap"
        if what == signal.SIGKILL:
            frames = 0
            if run.exists():
                done = shell("taxel recover run.mcap -o whole.mcap", folder, env=self.env)
                said += done.stderr
                name = "whole.mcap"
                if not (folder / name).exists() or done.returncode not in (0, 1, 3):
                    name = None
        else:
            # early signals come before there is a handler, or before the first frame
            if code not in (0, 3) and wait > 0.3:
                found.append("lost")
            if not run.exists():
                name = None
        if name and (folder / name).exists():
            done = shell(f"taxel info {name} --json", folder, env=self.env)
            said += done.stderr
            ends = [struct.unpack_from("<Q", c, 8)[0] for op, c in breakers.mcap_records((folder / name).read_bytes()) if op == breakers.CHUNK]
            if done.returncode == 3:
                found.append("gaps" if b"gap" in done.stdout + done.stderr or b"lost" in done.stdout else "info 3")
            elif done.returncode != 0:
                found.append("no frame" if b"no frames" in done.stderr else "unreadable")
            if ends:
                lost = max(0.0, now - max(ends) / 1e9)
                if what != signal.SIGKILL and lost > 0.25:
                    found.append("lost")
        elif what == signal.SIGKILL and run.exists():
            found.append("no frame")
        elif wait > 0.6:
            found.append("no file")
        if "no frame" in found or "unreadable" in found:
            again = shell(line + " --frames 3", folder, env=self.env, timeout=30)
            said += again.stderr
            if again.returncode not in (0, 3):
                found.append("blocked")
        stray = [n for n in self.outputs("record", folder) if n not in ("run.mcap", "whole.mcap")]
        if stray:
            found.append("left" if what == signal.SIGKILL else "litter")
        return line, folder, found, f"{stray} killed after {wait:.2f} s, code {code}\n{said.decode(errors='replace')}", lost


FAULTS = ["half", "litter", "blocked", "unreadable", "deaf", "lost", "gaps", "no file", "info 3"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("taxel")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--keep", type=Path, default=None)
    args = parser.parse_args()
    args.taxel = str(Path(args.taxel).resolve())
    args.keep = args.keep or Path(tempfile.mkdtemp(prefix="kills-"))
    args.keep.mkdir(parents=True, exist_ok=True)
    counts, losses, kept = collections.Counter(), collections.defaultdict(list), collections.Counter()
    with tempfile.TemporaryDirectory(prefix="kills-") as base:
        kills = Kills(args, Path(base))
        for i in range(args.kills):
            rng = random.Random(f"{args.seed}/{i}")
            verb = ["record", "convert", "compensate", "record", "calibrate", "loop"][i % 6]
            what = rng.choice(SIGNALS)
            line, folder, found, said, lost = kills.recording(rng, what) if verb == "record" else kills.job(rng, verb, what)
            row = (verb, what.name)
            counts[row, "kills"] += 1
            for word in set(found):
                counts[row, word] += 1
            if lost is not None:
                losses[row].append(lost)
            bad = [w for w in found if w in FAULTS]
            if bad and kept[verb, bad[0]] < 3:
                kept[verb, bad[0]] += 1
                place = args.keep / f"{bad[0].replace(' ', '-')}-{verb}-{i}"
                shutil.rmtree(place, ignore_errors=True)
                place.mkdir()
                for path in folder.iterdir():
                    if path.name not in os.listdir(kills.inputs) and path.stat().st_size < 50 << 20:
                        shutil.copy(path, place / path.name)
                (place / "case.txt").write_text(f"kill {i}: {what.name}: {', '.join(found)}\n{line}\n{said}\n")
                print(f"{', '.join(found)}: kill {i}, {what.name}: {line} [{place.name}]", flush=True)
            shutil.rmtree(folder, ignore_errors=True)
    words = ["kills", "done before", "no frame", "left", "left after the next run", *FAULTS]
    words = [w for w in words if w in ("kills", "half", "blocked", "unreadable", "litter") or any(n == w for (_, n) in counts)]
    rows = []
    for row in sorted({r for r, _ in counts}):
        lost = sorted(losses[row])
        rows.append([f"{row[0]} {row[1]}"] + [counts[row, w] for w in words] + ([f"{lost[len(lost) // 2]:.2f}", f"{lost[-1]:.2f}"] if lost else ["", ""]))
    rows.append(["all"] + [sum(counts[r, w] for r in {r for r, _ in counts}) for w in words] + ["", ""])
    print(table(rows, ["verb, signal", *words, "s lost, median", "at most"]))
    faults = sum(n for (_, w), n in counts.items() if w in FAULTS)
    print(f"{args.kills} kills by seed {args.seed}; {faults} faults" + (f", kept in {args.keep}" if faults else ""))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
