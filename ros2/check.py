"""Loads by ROS 2 between two processes, over DDS on this computer: what arrives is what `taxel stream` wrote, to the bit.

    cargo build -p taxel-cli && cargo build --manifest-path ros2/Cargo.toml
    python3 ros2/check.py target/debug/taxel ros2/target/debug/taxel-ros2
"""

import json
import struct
import subprocess
import sys
import tempfile
import time

FRAMES = 30
SOURCES = ["sim:mat-16x16-cd4067?hand&fps=20", "sim:econe?hand&fps=20&seed=2", "sim:mat-32x32-adg732?press&fps=50&seed=3"]


def single(value):
    """As a float of four bytes, which pixels are."""
    return None if value is None else struct.unpack("f", struct.pack("f", value))[0]


def main(taxel, ros2):
    for source in SOURCES:
        # Into a file: a pipe that nobody empties would hold the listener up.
        heard = tempfile.TemporaryFile("w+")
        listener = subprocess.Popen([ros2, "--listen", str(FRAMES)], stdout=heard)
        time.sleep(2)
        publisher = subprocess.Popen([ros2], stdin=subprocess.PIPE, text=True)
        time.sleep(4)
        lines = []
        with subprocess.Popen([taxel, "stream", source, "--frames", str(FRAMES)], stdout=subprocess.PIPE, text=True) as stream:
            # As they come: a burst of what was kept is no live source.
            for line in stream.stdout:
                lines.append(line)
                publisher.stdin.write(line)
                publisher.stdin.flush()
        listener.wait(timeout=60)
        publisher.communicate()
        assert (listener.returncode, publisher.returncode) == (0, 0), f"{source}: {listener.returncode}, {publisher.returncode}"
        sent = {round(line["unix_s"] * 1e9): line for line in map(json.loads, lines)}
        assert len(sent) == FRAMES
        numbers, images = {"/taxel/force": 0, "/taxel/loads/image": 0}, 0
        heard.seek(0)
        for line in map(json.loads, heard):
            own = sent[10**9 * line["sec"] + line["nanosec"]]
            if line["topic"] == "/taxel/force":
                assert line["z"] == own["total_n"], (line["z"], own["total_n"])
                numbers[line["topic"]] += 1
            else:
                loads = [single(load) for row in own["loads_n"] for load in row]
                assert (line["encoding"], line["height"], line["width"]) == ("32FC1", len(own["loads_n"]), len(own["loads_n"][0]))
                assert [single(load) for load in line["newtons"]] == loads, source
                numbers[line["topic"]] += len(loads)
                images += 1
        assert numbers["/taxel/force"] == images == FRAMES, (numbers, images)
        print(f"{source}: {numbers} numbers equal")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
