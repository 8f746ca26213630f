"""The circuit both ways, a virtual sensor, and what recordings tell of a real one."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import frames_of
from ._errors import Error
from ._pipeline import sensor_of
from ._taxel import Sensor
from ._taxel import evaluate as evaluate_plan
from ._taxel import identify as identify_recordings
from ._taxel import report as write_report
from ._taxel import scan as scan_frames
from ._taxel import simulate as simulate_frames
from ._taxel import solve as solve_frames


def scan(sensor: Any, siemens: ArrayLike) -> NDArray[np.float64]:
    """What the read-out gives of conductances: the whole circuit with its cross-talk, exactly, without noise.

    Parameters
    ----------
    sensor : Sensor, str, path or dict
        The sensor.
    siemens : array of frames × rows × columns, or of rows × columns
        Conductance of each taxel, siemens.

    Returns
    -------
    array of the same shape
        Output of the read-out, volts.

    Raises
    ------
    taxel.ArrayError
        Another shape, or a conductance that is negative or no number.
    taxel.SensorError
        A switch resistance that is not known yet.
    """
    frames, is_one = frames_of(siemens, "conductances")
    volts = scan_frames(sensor_of(sensor), frames)
    return volts[0] if is_one else volts


def solve(sensor: Any, volts: ArrayLike, method: str = "auto") -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The conductances behind volts: the inverse of ``scan``.

    Parameters
    ----------
    sensor : Sensor, str, path or dict
        The sensor.
    volts : array of frames × rows × columns, or of rows × columns
        Output of the read-out, volts.
    method : str
        ``auto``, ``exact``, ``newton`` or ``raw`` (no compensation).

    Returns
    -------
    siemens : array of the same shape
        Conductance of each taxel, siemens.
    answered : array of bool, one a frame
        Whether the inverse came to one answer.

    Raises
    ------
    taxel.ArrayError
        Another shape, or volts that are no numbers: which frame and taxel.
    taxel.SensorError
        The sensor file lacks what the method needs, as a switch resistance that is not known yet.
    taxel.Error
        No such method, or a model, which finds loads alone.
    KeyboardInterrupt
        Ctrl-C ends it at the next frame.
    """
    frames, is_one = frames_of(volts, "volts")
    siemens, answered = solve_frames(sensor_of(sensor), frames, method)
    return (siemens[0] if is_one else siemens), answered


@dataclass(frozen=True, eq=False)
class Simulation:
    """What a virtual sensor read, and what truly pressed on it."""

    counts: NDArray[Any]
    """Readings: frames × rows × columns."""
    loads: NDArray[np.float64]
    """True loads, newtons: frames × rows × columns."""
    truth: Sensor
    """The sensor that read: the one given, or one drawn about it."""

    def __repr__(self) -> str:
        return f"<taxel.Simulation of {len(self.counts)} frames of {self.truth.name}>"


@dataclass(frozen=True)
class _Drawing:
    pattern: str
    frames: int
    peak_newtons: float | None
    seed: int
    imperfect: bool


def simulate(
    sensor: Any,
    loads: ArrayLike | None = None,
    *,
    pattern: str = "hand",
    frames: int = 1,
    peak_newtons: float | None = None,
    seed: int = 0,
    imperfect: bool = False,
) -> Simulation:
    """Reads loads with a virtual sensor: material, circuit, noise and converter. The same seed gives the same readings.

    Parameters
    ----------
    sensor : Sensor, str, path or dict
        The sensor; it needs a load law.
    loads : array of frames × rows × columns, or of rows × columns, optional
        What presses, newtons; without it a pattern does.
    pattern : {"hand", "grip", "regrip", "fingers", "feet", "uniform", "random", "blobs", "press"}
        What presses.
    frames : int
        Frames of the pattern.
    peak_newtons : float, optional
        The highest load of the pattern on a taxel.
    seed : int
        Of everything that is drawn.
    imperfect : bool
        Read with a sensor whose switches, taxels and amplifier differ from the file's as those of real sensors do: ``truth``.

    Returns
    -------
    Simulation
        Counts, true loads in newtons, and the sensor that read.

    Raises
    ------
    taxel.ArrayError
        Loads of another shape, negative or no numbers: which frame and taxel.
    taxel.SensorError
        A sensor without a load law, or a switch resistance that is not known yet.
    taxel.Error
        No such pattern; fewer frames than 0; a peak that is not above 0; a seed below 0.
    MemoryError
        The frames do not fit.
    KeyboardInterrupt
        Ctrl-C ends it at the next frame.
    """
    given = None if loads is None else frames_of(loads, "loads")[0]
    known = sensor_of(sensor)
    if frames < 0:
        raise Error(f"{frames} frames, but 0 or more are needed")
    if not 0 <= seed < 2**64:
        raise Error(f"seed {seed}, but it is a whole number from 0 to 2^64 - 1")
    found = simulate_frames(known, given, _Drawing(pattern, frames, peak_newtons, seed, imperfect))
    counts = found["counts"].reshape(-1, *known.shape)
    if known.max_count <= 65535:
        counts = counts.astype(np.uint16)
    return Simulation(counts, found["loads_newtons"].reshape(-1, *known.shape), found["truth"])


def identify(
    recordings: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    sensor: Any = None,
    *,
    rows: int | None = None,
    equilibration: str | os.PathLike[str] | None = None,
    transpose: bool = False,
) -> dict[str, Any]:
    """Which read-out explains recordings of unknown loads: what ``taxel identify --json`` says, as a dict.

    Parameters
    ----------
    recordings : path, or list of paths
        Recordings under any loads.
    sensor : Sensor, str, path or dict, optional
        What is known.
    rows : int, optional
        Rows of a frame, where neither the sensor nor the recordings say.
    equilibration : path, optional
        A table of uniform loads.
    transpose : bool
        The recordings have rows and columns swapped.

    Returns
    -------
    dict
        ``verdict``, ``standings`` (each read-out with what it takes to tell the readings by it, nats, and its numbers in ohms and volts),
        ``assumed`` for want of a sensor …

    Raises
    ------
    taxel.Error
        A recording without frames, or that does not say how many rows a frame has; frames that show no load.
    taxel.FileError
        A file that cannot be read: which, where, and what stands there.
    KeyboardInterrupt
        Ctrl-C ends it.
    """
    files = [recordings] if isinstance(recordings, (str, os.PathLike)) else list(recordings)
    known = None if sensor is None else sensor_of(sensor)
    return identify_recordings(files, known, rows, equilibration, transpose)


def evaluate(plan: str | os.PathLike[str]) -> dict[str, Any]:
    """How good a sensor is, by a plan and its recordings: what ``taxel evaluate --json`` says, as a dict.

    Parameters
    ----------
    plan : path
        A plan (``docs/evaluate.md``).

    Returns
    -------
    dict
        ``title``, ``about``, ``sections`` with their tables: figures with their intervals, in the units that the tables name.

    Raises
    ------
    taxel.Error
        What the plan, or a file that it names, cannot be: which, where, and a hint.
    KeyboardInterrupt
        Ctrl-C ends it at the next frame, or draw of an interval.
    """
    return evaluate_plan(plan)


def report(plan: str | os.PathLike[str], output: str | os.PathLike[str] = "report.html") -> str:
    """Writes an evaluation as one page to publish: what ``taxel report`` writes, byte for byte.

    Parameters
    ----------
    plan : path
        A plan (``docs/evaluate.md``).
    output : path
        Where to write it (``.html``).

    Returns
    -------
    str
        The path.

    Raises
    ------
    taxel.Error
        As of ``evaluate``; a page of another ending, or that cannot be written.
    KeyboardInterrupt
        As of ``evaluate``; nothing is written then.
    """
    name = os.fspath(output)
    if not name.lower().endswith((".html", ".htm")):
        raise Error(f"{name}: a page ends in .html\nhint: a browser prints it as .pdf, and so does `taxel report`")
    write_report(plan, name)
    return name
