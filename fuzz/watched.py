"""Runs a program under watch: how it ended, how long it was silent, how much memory it took.

Used by broken_inputs.py and kills.py; not a command of its own.
"""

import os
import resource
import selectors
import signal
import subprocess
import threading
import time

SILENT = object()  # as standard input: a pipe that stays open and never says anything
KEPT_BYTES = 1 << 20  # of each output stream
ADDRESS_SPACE = 4 << 30  # a runaway allocation ends as an abort of the program, not of the machine


class Ended:
    """One run. `code` is the exit code, negative for a signal, None where it had to be ended."""

    def __init__(self):
        self.code, self.cut, self.peak_mib, self.seconds, self.silence = None, None, 0.0, 0.0, 0.0
        self.out, self.err, self.out_bytes, self.err_bytes = b"", b"", 0, 0

    def outcome(self, memory_mib):
        if self.cut:
            return self.cut
        if self.code in (101, 134, 139):
            return "panic" if self.code == 101 else "signal"
        if self.code < 0:
            return "signal"
        if self.peak_mib > memory_mib:
            return "memory"
        if self.err_bytes > 64 << 10:
            return "flood"
        if self.code in (1, 2) and self.err_bytes == 0:
            return "mute"
        return {0: "0 good", 1: "1 failed", 2: "2 arguments", 3: "3 with losses"}.get(self.code, f"exit {self.code}")


def _limit():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _feed(pieces, pipe, stop):
    try:
        for piece in pieces:
            if stop.is_set():
                break
            pipe.write(piece)
        pipe.close()
    except (OSError, ValueError):
        try:
            pipe.close()
        except OSError:
            pass


def feed_fifo(path, pieces, stop):
    """Opens the named pipe for writing and feeds it; SILENT keeps it open and says nothing."""

    def work():
        # Opened for both, so that opening never waits for a reader; what is written waits in the pipe.
        handle = os.open(path, os.O_RDWR | os.O_NONBLOCK)
        try:
            if pieces is not SILENT:
                for piece in pieces:
                    view = memoryview(piece)
                    while view and not stop.is_set():
                        try:
                            view = view[os.write(handle, view):]
                        except BlockingIOError:
                            time.sleep(0.002)
                    if stop.is_set():
                        return
                time.sleep(0.3)  # a reader that opens after the writer is gone would wait for ever
            else:
                stop.wait()
        finally:
            os.close(handle)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread


def starved_s(pid):
    """Seconds that the process was ready to run and another had the core, of its thread that waited longest."""
    longest = 0
    try:
        for task in os.listdir(f"/proc/{pid}/task"):
            with open(f"/proc/{pid}/task/{task}/schedstat") as file:
                longest = max(longest, int(file.read().split()[1]))
    except (OSError, IndexError, ValueError):
        pass
    return longest / 1e9


def watch(argv, cwd, stdin=None, silence_s=10.0, total_s=40.0, fifo_stop=None):
    """Runs argv to its end; ends it after `silence_s` without a byte ("silence") or `total_s` ("long"). Seconds in which
    other programs had the core are no silence of this one.

    `stdin` is None (nothing), SILENT, or an iterable of byte strings.
    """
    ended, stop = Ended(), threading.Event()
    begin = time.monotonic()
    process = subprocess.Popen(
        argv, cwd=cwd, stdin=subprocess.DEVNULL if stdin is None else subprocess.PIPE,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=_limit, bufsize=0)
    feeder = None
    if stdin is not None and stdin is not SILENT:
        feeder = threading.Thread(target=_feed, args=(stdin, process.stdin, stop), daemon=True)
        feeder.start()
    waits = selectors.DefaultSelector()
    for name, pipe in (("out", process.stdout), ("err", process.stderr)):
        waits.register(pipe, selectors.EVENT_READ, name)
    heard, starved = begin, 0.0
    status = None
    while status is None:
        spoken = False
        for key, _ in waits.select(0.25 if waits.get_map() else 0):
            piece = os.read(key.fileobj.fileno(), 1 << 16)
            if not piece:
                waits.unregister(key.fileobj)
                continue
            spoken = True
            setattr(ended, key.data + "_bytes", getattr(ended, key.data + "_bytes") + len(piece))
            kept = getattr(ended, key.data)
            if len(kept) < KEPT_BYTES:
                setattr(ended, key.data, kept + piece)
        now = time.monotonic()
        if spoken:
            ended.silence = max(ended.silence, now - heard)
            heard, starved = now, starved_s(process.pid)
            if stdin is SILENT and process.stdin and not process.stdin.closed:
                process.stdin.close()
            if fifo_stop is not None:
                fifo_stop.set()
        if not waits.get_map():
            pid, status_now, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                status = status_now
                break
            time.sleep(0.002)
        over = None
        if now - heard > silence_s + 1.5 and now - heard - (starved_s(process.pid) - starved) > silence_s + 1.5:
            over = "silence"
        elif now - begin > total_s + starved_s(process.pid):
            over = "long"
        if over:
            ended.cut = over
            os.kill(process.pid, signal.SIGKILL)
            _, status, usage = os.wait4(process.pid, 0)
    ended.seconds = time.monotonic() - begin
    ended.silence = max(ended.silence, time.monotonic() - heard)
    ended.code = os.waitstatus_to_exitcode(status)
    process.returncode = ended.code
    ended.peak_mib = usage.ru_maxrss / 1024
    stop.set()
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe:
            try:
                pipe.close()
            except OSError:
                pass
    if feeder:
        feeder.join(1)
    waits.close()
    return ended


def table(rows, head):
    """Lines of a table: numbers to the right, the first column to the left."""
    cells = [[str(c) for c in head]] + [[str(c) for c in row] for row in rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    return "\n".join(
        "  ".join(c.ljust(w) if i == 0 else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))).rstrip() for row in cells)
