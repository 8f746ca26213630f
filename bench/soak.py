"""Runs `taxel live` for a long time with viewers, one of which stalls, and tells what became of it.

    python bench/soak.py TAXEL SECONDS FRAMES_PER_SECOND RECORDING.mcap

A simulated e-Cone under a hand is recorded while two viewers take every frame and a third takes none off its connection
(and comes back whenever it is dropped). Printed at the end: resident memory of the program at six points, the age of
frames at the viewers, and what the program and `taxel info` say of the recording. Python's standard library only.
"""

import base64
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

POINTS = 6


def connect(port, rate, receive_buffer=None):
    """A WebSocket, with the frame rate asked for."""
    link = socket.socket()
    if receive_buffer:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    link.connect(("127.0.0.1", port))
    key = base64.b64encode(os.urandom(16)).decode()
    link.sendall(
        f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    stream = link.makefile("rb")
    assert b"101" in stream.readline()
    while stream.readline() != b"\r\n":
        pass
    say(link, {"do": "rate", "frames_per_second": rate})
    return link, stream


def say(link, message, opcode=1):
    data = message if isinstance(message, bytes) else json.dumps(message).encode()
    mask = os.urandom(4)
    length = bytes([0x80 | len(data)]) if len(data) < 126 else b"\xfe" + struct.pack(">H", len(data))
    link.sendall(bytes([0x80 | opcode]) + length + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(data)))


def take(stream):
    """The next message: opcode and bytes."""
    opcode, length = stream.read(2)
    length &= 0x7F
    if length == 126:
        (length,) = struct.unpack(">H", stream.read(2))
    elif length == 127:
        (length,) = struct.unpack(">Q", stream.read(8))
    return opcode & 0x0F, stream.read(length)


class Viewer(threading.Thread):
    """Takes every frame and answers that it did, as the page does."""

    def __init__(self, port, rate):
        super().__init__(daemon=True)
        self.port, self.rate = port, rate
        self.ages_ms, self.gaps, self.reconnected, self.last = [], 0, 0, None

    def run(self):
        while True:
            try:
                self.follow(*connect(self.port, self.rate))
            except (OSError, ValueError, AssertionError):
                self.reconnected += 1
                self.last = None
                time.sleep(1)

    def follow(self, link, stream):
        while True:
            opcode, data = take(stream)
            if opcode == 9:
                say(link, data, opcode=10)
            elif opcode == 8:
                raise OSError("closed")
            elif opcode == 2:
                sequence, _, host_secs = struct.unpack_from("<Qdd", data, 8)
                self.ages_ms.append(1e3 * (time.time() - host_secs))
                if self.last is not None:
                    self.gaps += max(0, sequence - self.last - 1)
                self.last = sequence
                say(link, {"do": "got", "sequence": sequence})


class Stalled(threading.Thread):
    """Connects and takes nothing; again whenever it was dropped."""

    def __init__(self, port, rate):
        super().__init__(daemon=True)
        self.port, self.rate, self.dropped = port, rate, 0

    def run(self):
        while True:
            try:
                link, _ = connect(self.port, self.rate, receive_buffer=4096)
                while True:
                    time.sleep(5)
                    say(link, {"do": "rate", "frames_per_second": self.rate})
            except (OSError, ValueError, AssertionError):
                self.dropped += 1
                time.sleep(1)


def resident_mb(process):
    with open(f"/proc/{process.pid}/status") as status:
        return int(re.search(r"VmRSS:\s+(\d+)", status.read())[1]) / 1024


def main():
    program, seconds, rate, recording = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    process = subprocess.Popen(
        [program, "live", f"sim:econe?hand&fps={rate:g}", "--listen", f"127.0.0.1:{port}", "--record", recording],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    time.sleep(3)
    viewers = [Viewer(port, rate) for _ in range(2)]
    stalled = Stalled(port, rate)
    for thread in [*viewers, stalled]:
        thread.start()
    begun, memory = time.time(), []
    for point in range(POINTS):
        time.sleep(max(0.0, begun + point * seconds / (POINTS - 1) - time.time()))
        memory.append((time.time() - begun, resident_mb(process)))
        print(f"{memory[-1][0] / 60:6.1f} min  {memory[-1][1]:6.1f} MB", flush=True)
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=120)
    for name, viewer in zip("ab", viewers):
        ages = sorted(viewer.ages_ms)
        at = lambda share: ages[min(len(ages) - 1, int(share * len(ages)))]
        print(
            f"viewer {name}: {len(ages)} frames, {viewer.gaps} not taken, {viewer.reconnected} reconnections; age median "
            f"{at(0.5):.1f} ms, 99 % {at(0.99):.1f} ms, most {ages[-1]:.1f} ms"
        )
    print(f"stalled viewer: dropped {stalled.dropped} times")
    print(f"taxel live, exit code {process.returncode}:\n{said[-2000:]}")
    print(subprocess.run([program, "info", recording], capture_output=True, text=True).stdout[-2000:])


main()
