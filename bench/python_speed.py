"""The Python module beside the command, numpy and pandas, in turn in one run.

    cargo build --release -p taxel-cli
    pip install ./python pandas
    taxel simulate --sensor econe --pattern hand --frames 2000 --load-g 400 -o hand.txt
    python3 bench/python_speed.py hand.txt target/release/taxel
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy
import pandas
import taxel

RUNS = 7
FRAMES_READ = (200, 1000)
MEMORY = "/dev/shm"


def timed(work):
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def in_turn(ways):
    """Seconds of each way, the ways in turn; after one round that does not count."""
    found = {name: [] for name in ways}
    for _ in range(RUNS + 1):
        for name, way in ways.items():
            found[name].append(way())
    return {name: seconds[1:] for name, seconds in found.items()}


def told(title, found):
    print(f"\n{title}: seconds, median of {RUNS} (least, most)")
    for name, seconds in found.items():
        print(f"  {name:34} {statistics.median(seconds):8.4f}  ({min(seconds):.4f}, {max(seconds):.4f})")


def ratio(found, a, b):
    pairs = [x / y for x, y in zip(found[a], found[b], strict=True)]
    print(f"  {a} / {b}: {statistics.median(pairs):.2f} ({min(pairs):.2f} to {max(pairs):.2f})")


def process(text, program, folder):
    counts = taxel.read(text, "econe").counts
    recording = os.path.join(folder, "hand.npy")
    numpy.save(recording, counts)
    words = [program, "compensate", recording, "--sensor", "econe", "--unit", "N", "--json"]

    def command():
        done = subprocess.run([*words, "-o", os.path.join(folder, "out.npy")], capture_output=True, check=True)
        return json.loads(done.stdout)["seconds"]

    pipeline = taxel.Pipeline("econe")
    found = in_turn({"module": lambda: timed(lambda: pipeline.process(counts)), "command": command})
    told(f"{len(counts)} frames of 64 x 128, counts to loads, marks (command: without its look for faulty lines)", found)
    ratio(found, "module", "command")


def read(text, folder, frames, closing_comma):
    """As the e-Cone writes it, each line closed by a comma, of which pandas makes one more column; or without that comma, as genfromtxt needs
    it."""
    piece = os.path.join(folder, "piece.txt")
    with open(text, encoding="ascii") as file, open(piece, "w", encoding="ascii") as out:
        lines = (line.rstrip(",\n") for line in file)
        kept = (line for line in lines if line.count(",") == 127)
        out.writelines(f"{line}{closing_comma}\n" for line, _ in zip(kept, range(64 * frames)))
    ways = {
        "taxel.read": lambda: timed(lambda: taxel.read(piece, "econe").counts),
        "pandas.read_csv": lambda: timed(lambda: pandas.read_csv(piece, header=None).to_numpy()),
    }
    if not closing_comma and frames == min(FRAMES_READ):
        ways |= {
            "numpy.loadtxt": lambda: timed(lambda: numpy.loadtxt(piece, delimiter=",")),
            "numpy.genfromtxt": lambda: timed(lambda: numpy.genfromtxt(piece, delimiter=",")),
        }
    found = in_turn(ways)
    closed = "closed by commas" if closing_comma else "without commas at their ends"
    told(f"{frames} frames of text, lines {closed}, {os.path.getsize(piece) / 1e6:.1f} MB, to an array", found)
    for other in list(ways)[1:]:
        ratio(found, other, "taxel.read")


def imported(module):
    code = f"import time; t = time.perf_counter(); import {module}; print(time.perf_counter() - t)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    return float(done.stdout)


def main(text, program):
    print(f"numpy {numpy.__version__}, pandas {pandas.__version__}, taxel {taxel.__version__}, {os.cpu_count()} cores")
    # In memory where there is such a folder: what a disk takes is no question here.
    with tempfile.TemporaryDirectory(dir=MEMORY if os.path.isdir(MEMORY) else None) as folder:
        process(text, program, folder)
        for frames in FRAMES_READ:
            for closing_comma in (",", ""):
                read(text, folder, frames, closing_comma)
    found = in_turn({"import taxel": lambda: imported("taxel"), "import numpy": lambda: imported("numpy")})
    told("a new interpreter", found)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
