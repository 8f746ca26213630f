"""The command for a Raspberry Pi under emulation beside the same command here: .ci/arm/check.py TAXEL TAXEL_FOR_ARM RUNNER ...

What both write is the same to 1e-12 of the largest number beside it: a simulated mat, its inverse with intervals, the
grips and tables made of them. Then what a Pi is for: a recording that is killed and recovered, a page served to this machine,
pins scanned. Emulation is a hundred times slower than the processor: all of it is small.
"""

import itertools
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from page_frames import page_frames  # noqa: E402
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
CLOSE = 1e-12
PATIENCE = 120


def say(words):
    print(f"arm: {words}", flush=True)


def run(command, folder, expected=(0,), **more):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=10 * PATIENCE, **more)
    if done.returncode not in expected:
        sys.exit(f"arm: {' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def wait(what, ready, patience=PATIENCE):
    until = time.monotonic() + patience
    while time.monotonic() < until:
        found = ready()
        if found:
            return found
        time.sleep(0.05)
    sys.exit(f"arm: no {what} within {patience} s")


def difference(ours, theirs):
    """The largest difference of the numbers in two texts, as a share of the largest of their line; all else is the same."""
    if NUMBER.sub("#", ours) != NUMBER.sub("#", theirs):
        sys.exit(f"arm: the texts differ in more than numbers:\n{ours[:2000]}\n--\n{theirs[:2000]}")
    if ours == theirs:
        return 0.0
    worst = 0.0
    for line, other in zip(ours.splitlines(), theirs.splitlines()):
        pairs = [(float(a), float(b)) for a, b in zip(NUMBER.findall(line), NUMBER.findall(other))]
        scale = max((abs(a) for a, _ in pairs), default=0) or 1
        worst = max([worst, *(abs(a - b) / scale for a, b in pairs)])
    return worst


# Verbs whose numbers may differ by more, and why.
LOOSER = {"netlist": (1e-10, "a resistance is one over the conductance, here of taxels that carry next to nothing")}


def same_numbers(here, arm, folders):
    """Files that both write from the same input."""
    steps = [
        "simulate --sensor mat-16x16-cd4067 --pattern hand --frames 12 --seed 3 --truth truth.csv -o hand.txt",
        "simulate --sensor mat-16x16-cd4067 --imperfect sheet --pattern blobs --frames 3 --seed 5 -o rough.txt",
        "compensate hand.txt --sensor mat-16x16-cd4067 --unit g -o loads.csv --interval half.csv --figures figures.csv",
        "compensate hand.txt --sensor mat-16x16-cd4067 --method newton --unit siemens -o siemens.csv",
        "measure hand.txt --sensor mat-16x16-cd4067 --frames-per-second 100 -o force.csv",
        "info hand.txt --sensor mat-16x16-cd4067",
        "netlist hand.txt --sensor mat-16x16-cd4067 --frame 3 -o mat.cir",
        "convert hand.txt --sensor mat-16x16-cd4067 --frames-per-second 100 -o hand.mcap",
        "convert hand.mcap -o back.txt",
    ]
    worst, seen = 0.0, set()
    for step in steps:
        begun, verb = time.monotonic(), step.split()[0]
        # What goes to standard error tells how long it took.
        said = [run([*binary, *step.split()], folder).stdout for binary, folder in zip((here, arm), folders)]
        written = {file.name for file in folders[0].iterdir()} - seen
        seen |= written
        texts = [[(folder / name).read_text() for folder in folders] for name in sorted(written) if not name.endswith(".mcap")]
        apart = max(difference(*pair) for pair in [said, *texts])
        allowed, why = LOOSER.get(verb, (CLOSE, ""))
        say(f"{verb}: differs from here by {apart:.1e}{f' ({why})' if why else ''}, {time.monotonic() - begun:.1f} s")
        if not apart <= allowed:
            sys.exit(f"arm: {step}: differs by {apart:.1e}, more than {allowed:.0e}")
        if allowed == CLOSE:
            worst = max(worst, apart)
    return worst


def killed_and_recovered(here, arm, folder):
    """`record`, kill -9, `recover`; what is in it is read here as well."""
    source = "sim:mat-16x16-cd4067?uniform&fps=20"
    child = subprocess.Popen([*arm, "record", source, "-o", "killed.mcap"], cwd=folder, stderr=subprocess.DEVNULL)
    wait("recording of 4 KB", lambda: (folder / "killed.mcap").exists() and (folder / "killed.mcap").stat().st_size > 4096)
    time.sleep(2)
    child.send_signal(signal.SIGKILL)
    child.wait()
    run([*arm, "recover", "killed.mcap", "-o", "whole.mcap"], folder, expected=(0, 3))
    for binary in (here, arm):
        told = run([*binary, "convert", "whole.mcap", "-o", f"{len(binary)}.txt"], folder)
        assert not told.stdout, told
    texts = [(folder / f"{len(binary)}.txt").read_text() for binary in (here, arm)]
    assert texts[0] == texts[1] and texts[0].count("\n") >= 16, "what was recovered reads the same here"
    say(f"record, kill -9, recover: {texts[0].count(chr(10)) // 16} frames, the same here")


def http(port, path, more=""):
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as link:
        link.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{more}Connection: close\r\n\r\n".encode())
        answer = b""
        while part := link.recv(65536):
            answer += part
    return answer


def served(arm, folder):
    """`live` under emulation, looked at from this machine."""
    source = "sim:mat-16x16-cd4067?hand&fps=5"
    child = subprocess.Popen([*arm, "live", source, "--listen", "127.0.0.1:0"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        url = child.stdout.readline().strip()
        port = int(re.search(r":(\d+)", url.removeprefix("http://")).group(1))
        page = http(port, "/")
        assert page.startswith(b"HTTP/1.1 200") and b"<html" in page, page[:200]
        frames = list(itertools.islice(page_frames("127.0.0.1", port, patience=PATIENCE), 5))
        assert len(set(frames)) == 5, "five frames that differ"
        say(f"live: the page and 5 frames of {len(frames[0])} bytes came to this machine")
    finally:
        child.send_signal(signal.SIGTERM)
        code = child.wait(PATIENCE)
    assert code == 0, f"live ended with {code}"


def scanned(arm, folder):
    """`rpi:` on a simulated board: every count is the one of its crossing, and no reading came before lines had settled."""
    counts = [[(37 * row + 11 * column) % 4096 for column in range(16)] for row in range(16)]
    (folder / "counts.txt").write_text("\n".join(",".join(map(str, row)) for row in counts))
    packaging = HERE.parent.parent / "packaging" / "debian"
    told = {
        "BOARD": "16 16 10 20 15",
        "BOARD_ROW_PINS": "5 6 13 19",
        "BOARD_COLUMN_PINS": "17 27 22 23",
        "BOARD_COUNTS": "counts.txt",
        "BOARD_LOG": "board.log",
    }
    board = folder / "board.so"
    run(["aarch64-linux-gnu-gcc", "-O1", "-shared", "-fPIC", "-o", board, HERE / "board.c", "-ldl"], folder)
    # Loaded into the program, not into the emulator, which it would not fit.
    command = [*arm[:-1], "-E", f"LD_PRELOAD={board}", arm[-1], "record", f"rpi:{packaging}/board.toml", "--sensor", f"{packaging}/sensor.toml", "--frames", "3", "-o", "scan.mcap"]
    run(command, folder, env=os.environ | told)
    run([*arm, "convert", "scan.mcap", "-o", "scan.txt"], folder)
    rows = [list(map(int, line.rstrip(",").split(","))) for line in (folder / "scan.txt").read_text().split()]
    assert rows == 3 * counts, f"counts of other crossings: {rows[:2]}"
    log = (folder / "board.log").read_text().split()
    conversions, early, calls = int(log[1]), int(log[3]), int(log[5])
    assert early == 0, f"{early} of {conversions} readings before lines had settled"
    say(f"rpi: {conversions} readings, none before its lines had settled, {calls / conversions:.2f} calls to the pins each")


def main():
    here, arm = [sys.argv[1]], [*sys.argv[3:], sys.argv[2]]
    with tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch) / name for name in ("here", "arm")]
        for folder in folders:
            folder.mkdir()
        version = run([*arm, "--version"], folders[1]).stdout.strip()
        assert version == run([*here, "--version"], folders[0]).stdout.strip()
        worst = same_numbers(here, arm, folders)
        killed_and_recovered(here, arm, folders[1])
        served(arm, folders[1])
        scanned(arm, folders[1])
        say(f"{version} on {os.path.basename(arm[0])}: as here to {worst:.1e}")


main()
