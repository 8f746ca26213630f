"""Other threads run meanwhile, Ctrl-C ends a call, and a process may fork."""

from __future__ import annotations

import concurrent.futures
import contextlib
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import taxel
from taxel._batch import Settings


def sum_of(counts: np.ndarray) -> float:
    loads = taxel.Pipeline("mat-32x32-adg732").process(counts).loads
    assert loads is not None
    return float(loads.sum())


def press_ctrl_c(call: Callable[[], object]) -> None:
    """Does what would go on for long, and presses Ctrl-C meanwhile."""
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    # The first may fall into a destructor, where Python drops it: as a person would, it is pressed once more.
    again = threading.Timer(20.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    again.start()
    with pytest.raises(KeyboardInterrupt):
        call()
    again.cancel()
    timer.join()


@pytest.fixture(scope="module")
def counts() -> np.ndarray:
    return taxel.simulate("mat-32x32-adg732", pattern="blobs", frames=100, seed=8).counts


def test_another_thread_runs_while_frames_are_processed(counts: np.ndarray) -> None:
    many, ended, ticks = np.concatenate([counts] * 10), threading.Event(), 0

    def tick() -> None:
        nonlocal ticks
        while not ended.is_set():
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.monotonic()
    taxel.Pipeline("mat-32x32-adg732").process(many, threads=1)
    took = time.monotonic() - begun
    ended.set()
    thread.join()
    # A call that held the interpreter would let none through.
    assert took > 0.05 and ticks > 10


def test_one_pipeline_may_be_shared_by_threads(counts: np.ndarray) -> None:
    pipeline = taxel.Pipeline("mat-32x32-adg732")
    wanted = pipeline.process(counts).loads
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: pipeline.process(counts).loads, range(8)):
            assert found is not None and wanted is not None
            assert np.abs(found - wanted).max() < 1e-6 * wanted.max()


class Gap:
    """The longest time for which no other thread of Python ran; to be divided by the whole, as clocks differ."""

    def __enter__(self) -> Gap:
        self.longest, self.whole = 0.0, 0.0
        self._ended, self._begun = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        self._begun.wait()
        self._before = time.perf_counter()
        return self

    def _run(self) -> None:
        last = time.perf_counter()
        self._begun.set()
        while not self._ended.is_set():
            now = time.perf_counter()
            self.longest, last = max(self.longest, now - last), now

    def __exit__(self, *_: object) -> None:
        self.whole = time.perf_counter() - self._before
        self._ended.set()
        self._thread.join()


@pytest.fixture
def often() -> Iterator[None]:
    """Threads of Python change places every tenth of a millisecond."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-4)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("ask", ["process", "reset", "look_for_faults", "pickle"])
def test_who_waits_for_a_shared_pipeline_holds_nobody_else(ask: str, counts: np.ndarray) -> None:
    pipeline, many = taxel.Pipeline("mat-32x32-adg732"), np.concatenate([counts] * 40)
    asks = {
        "process": lambda: pipeline.process(counts[0]),
        "reset": pipeline.reset,
        "look_for_faults": lambda: pipeline.look_for_faults(counts),
        "pickle": lambda: pickle.loads(pickle.dumps(pipeline)),
    }
    worker = threading.Thread(target=lambda: pipeline.process(many, threads=1, figures=False))
    worker.start()
    time.sleep(0.05)
    with Gap() as gap:
        asks[ask]()
        worker.join()
    assert gap.longest < 0.5 * gap.whole


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("work", ["names", "tables", "presses", "recording", "sensor", "pipeline"])
def test_python_is_free_while_files_and_arrays_are_gone_through(work: str, counts: np.ndarray, tmp_path: Path) -> None:
    known = taxel.Sensor("econe")
    folder = Settings(str(tmp_path), taxel.Sensor("mat-32x32-adg732")).folder()
    paths = [str(tmp_path / f"{place}.npy") for place in range(2_000)]
    np.save(paths[0], counts[:4])
    entries = [entry for entry, _ in folder.run(paths[:1], 1)] * 2_000
    with taxel.live("sim:econe?fps=max", record=tmp_path / "a.mcap", queue=2) as source:
        source.next(timeout=5)
    many, nowhere = np.concatenate([counts] * 20), np.full(1, 32)
    presses = taxel.Presses(many, np.zeros(1, int), nowhere, nowhere, np.ones(1))

    def refused() -> None:
        with pytest.raises(taxel.ArrayError, match="row 32"):
            taxel.calibrate("mat-32x32-adg732", presses)

    calls: dict[str, Callable[[], object]] = {
        "names": lambda: folder.check_names(paths),
        "tables": lambda: folder.write_tables(entries),
        "presses": refused,
        "recording": lambda: taxel.Sensor(tmp_path / "a.mcap"),
        "sensor": lambda: taxel.Sensor("econe"),
        "pipeline": lambda: taxel.Pipeline(known),
    }
    shares: list[float] = []
    for _ in range(20):
        with Gap() as gap:
            calls[work]()
        shares.append(gap.longest / gap.whole)
    # One that is not disturbed by others on this machine tells; with Python held the whole call is one gap.
    assert min(shares) < 0.5


PLAN = """format = 1
sensor = "mat-32x32-adg732"
resamples = 1000000

[[experiment]]
kind = "accuracy"
name = "Each frame"
recording = "counts.npy"
truth_g = "loads.npy"
methods = ["raw"]
"""


@pytest.fixture
def endless(counts: np.ndarray, tmp_path: Path) -> Path:
    """A recording without an end: whoever reads it ends when told to, or never."""
    path, frame = tmp_path / "endless.txt", "".join(",".join(map(str, row)) + "\n" for row in counts[0].tolist())
    os.mkfifo(path)

    def write() -> None:
        with contextlib.suppress(BrokenPipeError), path.open("w") as pipe:
            while True:
                pipe.write(frame)

    # It ends with the reader.
    threading.Thread(target=write, daemon=True).start()
    return path


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("work", ["presses", "frames to identify", "load", "length", "measure", "faults"])
def test_ctrl_c_ends_reading_without_an_end(work: str, endless: Path, tmp_path: Path) -> None:
    (tmp_path / "presses.csv").write_text("recording,frame,row,column,load_g\nendless.txt,1000000000,3,4,50\n")
    calls = {
        "presses": lambda: taxel.calibrate("mat-32x32-adg732", tmp_path / "presses.csv"),
        "frames to identify": lambda: taxel.identify(endless, "mat-32x32-adg732"),
        "load": lambda: taxel.read(endless, "mat-32x32-adg732").load(),
        "length": lambda: len(taxel.read(endless, "mat-32x32-adg732")),
        "measure": lambda: taxel.measure(endless, sensor="mat-32x32-adg732"),
        "faults": lambda: taxel.Pipeline("mat-32x32-adg732").look_for_faults(taxel.read(endless, "mat-32x32-adg732")),
    }
    press_ctrl_c(calls[work])


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("work", ["evaluate", "report", "identify"])
def test_ctrl_c_ends_arithmetic_of_minutes(work: str, tmp_path: Path) -> None:
    drawn = taxel.simulate("mat-32x32-adg732", pattern="blobs", frames=6, seed=4)
    np.save(tmp_path / "counts.npy", drawn.counts)
    np.save(tmp_path / "loads.npy", drawn.loads / 9.80665e-3)
    np.save(tmp_path / "large.npy", taxel.simulate("econe", pattern="hand", frames=20, seed=1).counts)
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    calls = {
        "evaluate": lambda: taxel.evaluate(plan),
        "report": lambda: taxel.report(plan, tmp_path / "report.html"),
        "identify": lambda: taxel.identify(tmp_path / "large.npy", rows=64),
    }
    press_ctrl_c(calls[work])
    assert not (tmp_path / "report.html").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
@pytest.mark.parametrize("work", ["process", "calibrate", "simulate", "map", "scan", "solve", "live"])
def test_ctrl_c_ends_a_call(work: str, counts: np.ndarray, tmp_path: Path) -> None:
    many = np.broadcast_to(counts, (400, *counts.shape)).reshape(-1, 32, 32)
    rng = np.random.default_rng(3)
    presses = taxel.Presses(
        many[:400], np.arange(400), rng.integers(0, 32, 400), rng.integers(0, 32, 400), rng.uniform(0.5, 5, 400)
    )
    calls = {
        "process": lambda: taxel.Pipeline("mat-32x32-adg732").process(many, standard_errors=True),
        "calibrate": lambda: taxel.calibrate("mat-32x32-adg732", presses, line_resistance=True),
        "simulate": lambda: taxel.simulate("econe", pattern="hand", frames=5_000, seed=1),
        "map": lambda: taxel.map(tmp_path / "many.npy", tmp_path / "out", sensor="mat-32x32-adg732", intervals=True),
        "scan": lambda: taxel.scan("econe", np.full((20_000, 64, 128), 1e-5, np.float32)),
        "solve": lambda: taxel.solve("econe", np.full((5_000, 64, 128), 0.1, np.float32)),
        "live": lambda: taxel.live("udp:127.0.0.1:0", "econe").next(),
    }
    np.save(tmp_path / "many.npy", many)
    press_ctrl_c(calls[work])
    # Nothing of it is left that would stand in the way.
    assert sum_of(counts) > 0.0


@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_a_pipeline_that_ctrl_c_has_ended_begins_anew(counts: np.ndarray) -> None:
    many = np.concatenate([counts] * 400)
    pipeline = taxel.Pipeline("mat-32x32-adg732")
    press_ctrl_c(lambda: pipeline.process(many, standard_errors=True))
    new, again = taxel.Pipeline("mat-32x32-adg732").process(counts[:7]), pipeline.process(counts[:7])
    assert (again.rounds == new.rounds).all() and (again.marks == new.marks).all()
    assert (again.loads == new.loads).all()  # type: ignore[union-attr]


def test_a_pool_of_processes_takes_a_pipeline(counts: np.ndarray) -> None:
    pipeline = taxel.Pipeline("mat-32x32-adg732", repair=True)
    parts = [counts[:40], counts[40:]]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        found = pool.map(pipeline.process, parts)
    for part, result in zip(parts, found, strict=True):
        here = taxel.Pipeline("mat-32x32-adg732", repair=True).process(part)
        assert result.sensor == here.sensor and list(result.figures) == list(here.figures)
        assert result.loads is not None and here.loads is not None and (result.loads == here.loads).all()
        assert (result.marks == here.marks).all()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_begun_after_threads_do_the_same(method: str, counts: np.ndarray) -> None:
    wanted = sum_of(counts)
    context = multiprocessing.get_context(method)
    # Threads of ours that live, too.
    with taxel.live("sim:mat-16x16-cd4067?fps=200") as source, concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        assert source.next(timeout=5) is not None
        assert list(pool.map(sum_of, [counts] * 3)) == [wanted] * 3
        assert source.next(timeout=5) is not None
