"""How fast numpy reads a slice of the recording that `read_speed` makes, for the ratio.

    cargo run --release -p taxel-io --example read_speed folder
    python3 bench/text_read.py folder/read_speed.txt
"""

import io
import sys
import time

import numpy

LINES = 64 * 20


def main(path):
    with open(path, encoding="ascii") as file:
        text = "".join(line.rstrip(",\n") + "\n" for line, _ in zip(file, range(LINES)))
    megabytes = len(text) / 1e6
    print(f"{LINES} lines, {megabytes:.2f} MB, numpy {numpy.__version__}")
    for read in (numpy.genfromtxt, numpy.loadtxt):
        best = float("inf")
        for _ in range(3):
            start = time.perf_counter()
            array = read(io.StringIO(text), delimiter=",")
            best = min(best, time.perf_counter() - start)
        assert array.shape == (LINES, 128), array.shape
        print(f"{read.__name__:12} {megabytes / best:7.1f} MB/s (best of 3)")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
