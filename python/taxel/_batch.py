"""An archive of recordings: loads, figures over time, and a row of one table each."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._errors import Error
from ._pipeline import sensor_of
from ._table import Table
from ._taxel import MARKS, Sensor
from ._taxel import Batch as Folder

Path = str | os.PathLike[str]

WORDS = ("sensor", "half_widths_of", "missing", "faulty_lines")
COUNTS = ("frames", "skipped_frames", "unsolved_frames", "ambiguous_frames")
NUMBERS = (
    "duration_s",
    "peak_force_n",
    "peak_force_half_width_n",
    "peak_frame",
    "mean_force_n",
    "mean_force_half_width_n",
    "tare_n",
    "peak_area_mm2",
    "mean_area_mm2",
    "measured_share",
)


@dataclass(frozen=True)
class Settings:
    """What is made of each recording of an archive; can be pickled."""

    out: str
    sensor: Sensor | None
    method: str = "auto"
    loads: str = "parquet"
    intervals: bool = False
    pictures: bool = False
    repair: bool | None = None
    tare: bool = True
    transpose: bool = False
    with_names: bool = False

    def folder(self) -> Folder:
        """What does the work."""
        return Folder(
            self.out,
            self.sensor,
            method=self.method,
            loads=self.loads,
            intervals=self.intervals,
            pictures=self.pictures,
            repair=self.repair,
            no_tare=not self.tare,
            transpose=self.transpose,
            with_names=self.with_names,
        )


def row_of(entry: str) -> dict[str, Any]:
    """The row of an entry: a line of ``summary.csv``."""
    told: dict[str, Any] = json.loads(entry)
    row: dict[str, Any] = told.get("row") or {}
    marks: dict[str, int] = row.get("marks", {})
    cells: dict[str, Any] = {"recording": told["recording"], "status": told["status"]}
    cells.update({name: row.get(name, "") for name in WORDS})
    cells.update({name: int(row.get(name, 0)) for name in COUNTS})
    cells.update({name: _number(row.get(name)) for name in NUMBERS})
    cells.update({f"taxels_{mark.replace('-', '_')}": int(marks.get(mark, 0)) for mark in MARKS if mark != "absent"})
    cells["error"] = told.get("error") or ""
    return cells


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Rows as a table, which has its columns also where there are none."""
    empty = row_of('{"recording": "", "status": ""}')
    return Table({name: _column([row[name] for row in rows], cell) for name, cell in empty.items()})


def _column(cells: list[Any], like: Any) -> Any:
    return np.array(cells, dtype=object if isinstance(like, str) else np.asarray(like).dtype)


def paths_of(recordings: Iterable[Path] | Path) -> list[str]:
    """Paths as text; one alone is a list of one."""
    if isinstance(recordings, (str, os.PathLike)):
        recordings = [recordings]
    return [os.fspath(recording) for recording in recordings]


def map(
    recordings: Iterable[Path] | Path,
    out: Path,
    *,
    sensor: Any = None,
    method: str = "auto",
    loads: str = "parquet",
    intervals: bool = False,
    pictures: bool = False,
    repair: bool | None = None,
    tare: bool = True,
    transpose: bool = False,
    with_names: bool = False,
    workers: int | None = None,
    summary: bool = True,
) -> Table:
    """Works an archive of recordings through, on all cores: what ``taxel batch`` does, with the same files.

    Of each recording, below ``out`` under its own path: loads and marks, figures over time, and an entry with what they were made
    of and with. What is there already of the same recording, program and settings is kept: called again, it goes on where it was
    cut off. ``summary.csv`` and ``manifest.csv`` are written last. Ctrl-C leaves what is done.

    Parameters
    ----------
    recordings : paths
        Recordings of counts: ``.mcap``, ``.parquet``, ``.txt``, ``.csv``, ``.npy``, ``.npz``.
    out : path
        The folder; it is made if it is not there.
    sensor : Sensor, str, path or dict, optional
        The sensor of all; without it each recording brings its own.
    method : str
        ``auto``, ``exact``, ``newton``, ``raw``, or the file of a trained model.
    loads : str
        What loads and marks are written as: ``parquet``, ``mcap``, or ``none``.
    intervals : bool
        Whether every frame's figures get their 95 % intervals, and not the heaviest frame's alone: many times the work.
    pictures : bool
        Whether the frame with the largest force is drawn (``.png``).
    repair : bool, optional
        Whether what was not measured is replaced; without it as the sensor file says.
    tare : bool
        Whether a recording's tare is taken off.
    transpose : bool
        Whether the recordings have rows and columns swapped.
    with_names : bool
        Whether what headers of other programs' files say of persons, and names of files, is kept in what is written.
    workers : int, optional
        Threads; without it as many as there are cores. Results are the same.
    summary : bool
        Whether ``summary.csv`` and ``manifest.csv`` are written; not where several programs share the folder. Once all of them have
        ended, a call for all recordings writes them.

    Returns
    -------
    Table
        A row a recording, in their order: ``recording``, ``status`` (``done``, ``incomplete``, ``broken``), forces in newtons,
        areas in mm², half-widths of 95 % intervals, frames that are missing, taxels by mark, ``error``. One that is broken does
        not stop the others.

    Raises
    ------
    taxel.Error
        Two recordings that would be written under one name; an unknown option; a folder that cannot be written.
    taxel.SensorError
        A sensor whose loads cannot be found.
    KeyboardInterrupt
        Ctrl-C ends it at the next frame; what is done stays.
    """
    settings = Settings(
        os.fspath(out),
        None if sensor is None else sensor_of(sensor),
        method,
        loads,
        intervals,
        pictures,
        repair,
        tare,
        transpose,
        with_names,
    )
    if workers is not None and workers < 1:
        raise Error(f"{workers} workers\nhint: without `workers`, there are as many as cores")
    entries = settings.folder().run(paths_of(recordings), workers, summary)
    return table_of([row_of(entry) for entry, _ in entries])
