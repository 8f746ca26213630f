"""Forces of a recording over time."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ._pipeline import sensor_of
from ._table import Table
from ._taxel import measure as _measure

Path = str | os.PathLike[str]


@dataclass(frozen=True, eq=False)
class Measurement:
    """What a recording amounts to."""

    #: A row a frame: ``time_s``, ``total_n`` with ``total_error_n`` (half of its 95 % interval), ``grip_n``, ``peak_kpa``,
    #: ``area_mm2``, ``cop_x_mm``, ``cop_y_mm``, ``measured_share``, and the regions'.
    series: Table
    #: A dict a trial: ``name``, ``from_s``, ``to_s``, ``forces`` (total, grip, regions) with their peaks and plateaus.
    trials: list[dict[str, Any]] = field(repr=False)
    #: What happened to the frames: how many, how many without an answer, what is missing.
    tally: dict[str, Any] = field(repr=False)

    @property
    def is_whole(self) -> bool:
        """Whether no frame was lost, left out, without an answer, or at the end of the converter's range."""
        return bool(self.tally["is_whole"])


def measure(
    recording: Path,
    *,
    sensor: Any = None,
    regions: Path | None = None,
    trials: str = "force",
    trial_force: float | None = None,
    plateau: float = 5.0,
    touched: float = 0.05,
    intervals: bool = True,
    zero: tuple[float, float] | None = None,
    frames_per_second: float | None = None,
    method: str = "auto",
    repair: bool | None = None,
    tare: bool = True,
    transpose: bool = False,
    keep_going: bool = False,
    threads: int | None = None,
) -> Measurement:
    """Measures forces over time, in all, as a grip and by region: what ``taxel measure`` does, with the same numbers.

    Parameters
    ----------
    recording : path
        A recording of counts.
    sensor : Sensor, str, path or dict, optional
        Its sensor; without it the recording brings its own.
    regions : path, "auto" or "phalanges", optional
        A TOML file of named regions, or ``"auto"``: the parts of a hand or of feet, else the contacts, as ``taxel measure --regions auto``
        finds them; ``"phalanges"``: the same with fingers cut at their joints; without it those of the sensor file.
    trials : str
        ``force`` (where it rises and falls), ``marks``, ``whole``, or seconds such as ``2.5..10.5,20..28``.
    trial_force : float, optional
        A trial is where the total force is above this, newtons; without it above a tenth of the largest.
    plateau : float
        Length of the plateau, seconds.
    touched : float
        A taxel counts as touched above this, newtons.
    intervals : bool
        Whether 95 % intervals are found, which is most of the work.
    zero : (float, float), optional
        Seconds since the first frame in which nothing presses: their mean is taken off every taxel.
    frames_per_second : float, optional
        In place of the times that the recording tells, or where it tells none.
    method, repair, tare, transpose, keep_going, threads
        As of ``taxel.map`` and ``taxel.Pipeline``.

    Returns
    -------
    Measurement
        Forces in newtons over time, trials, and what happened to the frames.

    Raises
    ------
    taxel.Error
        A recording that cannot be read, a sensor without a load law, regions or trials that it does not have.
    KeyboardInterrupt
        Ctrl-C ends it at the next frame.
    """
    columns, found, tally = _measure(
        os.fspath(recording),
        None if sensor is None else sensor_of(sensor),
        regions=None if regions is None else os.fspath(regions),
        trials=trials,
        trial_force=trial_force,
        plateau=plateau,
        touched=touched,
        intervals=intervals,
        zero=zero,
        frames_per_second=frames_per_second,
        method=method,
        repair=repair,
        no_tare=not tare,
        transpose=transpose,
        keep_going=keep_going,
        threads=threads,
    )
    table = {name: values.astype(np.int64) if name == "frame" else values for name, values in columns}
    return Measurement(Table(table), json.loads(found), json.loads(tally))
