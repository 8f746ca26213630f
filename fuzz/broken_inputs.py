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
import sys
import tempfile
import threading
import time
from pathlib import Path

import breakers
import wire
from sound_inputs import Base, carried, wire_frames
from verbs import RECIPES
from watched import SILENT, feed_fifo, table, watch

MEMORY_MIB = 256
FAULTS = ["panic", "signal", "silence", "memory", "flood", "mute", "overwrote", "half", "litter", "lie"]
WRITES = ["-o", "--output", "--export", "--marks", "--standard-error", "--static-output", "--truth-sensor", "--figure", "--keep"]
FINE = ["0 good", "1 failed", "2 arguments", "3 with losses", "long"]


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
        "safetensors": [breakers.safetensors], "onnx": [breakers.onnx], "bin": [wire.packets, wire.forged],
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
