"""Kills a recording at random moments and recovers it: nothing but the last second may be lost.

    python bench/kill.py TAXEL TIMES FOLDER

What is lost at the end is the time from the last frame saved to the kill. Needs pyarrow.
"""

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

taxel, times, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
folder.mkdir(parents=True, exist_ok=True)
random.seed(1)
fps, worst, total = 100, 0.0, 0
for turn in range(times):
    run, saved, text = (folder / name for name in ("run.mcap", "saved.mcap", "saved.txt"))
    for file in (run, saved, text):
        file.unlink(missing_ok=True)
    child = subprocess.Popen([taxel, "record", f"sim:econe?hand&fps={fps}", "-o", run], stderr=subprocess.DEVNULL)
    while not run.exists():
        time.sleep(0.001)
    begun = time.time()
    time.sleep(random.uniform(0.3, 3.0))
    child.send_signal(signal.SIGKILL)
    killed = time.time()
    child.wait()
    found = subprocess.run([taxel, "recover", run, "-o", saved], capture_output=True, text=True)
    assert found.returncode in (0, 3), found.stderr
    if ": 0 frames" in found.stderr:
        frames, last = 0, begun
    else:
        subprocess.run([taxel, "convert", saved, "-o", text.with_suffix(".parquet")], check=True, capture_output=True)
        import pyarrow.parquet

        table = pyarrow.parquet.read_table(text.with_suffix(".parquet"), columns=["sequence", "host_time"])
        sequence = table["sequence"].to_pylist()
        frames = len(sequence)
        assert sequence == list(range(frames)), "a frame is missing before the end"
        last = table["host_time"].to_pylist()[-1].timestamp()
    worst = max(worst, killed - last)
    total += frames
    assert killed - last < 1.0, f"turn {turn}: {killed - last:.3f} s lost"
print(f"{times} kills, {total} frames saved, at most {1000 * worst:.0f} ms lost at the end, nothing before it")
