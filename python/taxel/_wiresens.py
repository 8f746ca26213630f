"""HDF5 files that the recorder of WiReSens writes, by ``h5py``: ``pip install h5py``.

Of ``pressure`` (frames × select wires × read wires), ``ts`` (seconds since 1970) and ``predCount`` the first ``frame_count`` rows are
data: the recorder makes room for 1024 at a time, and does not count the row that it wrote last. Where a sender leaves packets out (its
intermittent mode) the recorder extrapolates them, and counts in ``predCount`` how many it has made up so far.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import Error, FileError
from ._taxel import MARKS, Sensor

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_DATASETS = {"pressure": 3, "ts": 1, "predCount": 1, "frame_count": 1}
_HINT = (
    "hint: of HDF5 what WiReSens records is read: pressure (frames, select wires, read wires), ts, predCount, frame_count; "
    "taxel.Pipeline takes arrays of any file"
)
_AT_ONCE = 256
# A packet has 16 bits a reading.
_MOST_COUNTS = 65535


def is_hdf5(path: str | os.PathLike[str]) -> bool:
    """Whether a file says that it is HDF5."""
    try:
        with open(path, "rb") as file:
            return file.read(len(_SIGNATURE)) == _SIGNATURE
    except OSError:
        return False


class WiReSensReader:
    """A file of WiReSens, read frame by frame: what ``Recording`` asks of a reader."""

    def __init__(
        self, path: str | os.PathLike[str], sensor: Sensor | None, unit: str, transpose: bool, keep_going: bool
    ) -> None:
        self._path, self._transpose, self._keep_going = os.fspath(path), transpose, keep_going
        if unit != "counts":
            raise Error(f"{self._path}: a file of WiReSens holds counts, not {unit}\nhint: unit='counts'")
        self._data = _opened(self._path)
        self._missing: list[str] = []
        self._left_out = 0
        self._next = 0
        self._frames = self._count_frames()
        rows, columns = self._data["pressure"].shape[1:]
        self.shape: tuple[int, int] = (columns, rows) if transpose else (rows, columns)
        if sensor is not None and sensor.shape != self.shape:
            swapped = sensor.shape == self.shape[::-1]
            hint = f"transpose={not transpose}" if swapped else "the sensor file of this mat"
            raise FileError(
                f"{self._path}: frames of {self.shape[0]} × {self.shape[1]}, but the sensor {sensor.name} has "
                f"{sensor.rows} × {sensor.columns}\nhint: {hint}"
            )
        self._time: NDArray[np.float64] = np.asarray(self._data["ts"][: self._frames], np.float64)
        self._made_up = self._find_made_up()

    @property
    def made_up(self) -> NDArray[np.bool_]:
        """Of each frame of the file, whether any of it may have been extrapolated by the recorder."""
        return self._made_up

    def read(self, most: int) -> dict[str, Any] | None:
        """The next frames; None at the end."""
        parts: list[tuple[NDArray[np.intp], NDArray[Any]]] = []
        while most > 0 and self._next < self._frames:
            begin, end = self._next, min(self._next + most, self._frames)
            self._next = end
            values: NDArray[Any] = self._data["pressure"][begin:end]
            is_bad = ~(np.isfinite(self._time[begin:end]) & (self._time[begin:end] > 0.0))
            is_bad |= ((values < 0) | (values > _MOST_COUNTS)).any(axis=(1, 2))
            if is_bad.any() and not self._keep_going:
                raise self._wrong(begin + int(np.argmax(is_bad)))
            good = np.flatnonzero(~is_bad)
            self._left_out += len(values) - len(good)
            most -= len(good)
            parts.append((begin + good, values[good]))
        places = np.concatenate([part[0] for part in parts]) if parts else np.empty(0, np.intp)
        return self._found(places, np.concatenate([part[1] for part in parts])) if len(places) else None

    def skip(self, most: int) -> int:
        """Leaves frames out, and says how many there were."""
        count = 0
        while count < most and (found := self.read(min(most - count, _AT_ONCE))) is not None:
            count += len(found["values"])
        return count

    def events(self) -> list[dict[str, Any]]:
        """None are known."""
        return []

    def missing(self) -> list[str]:
        """What is known to be missing, in words."""
        frames = "1 frame" if self._left_out == 1 else f"{self._left_out} frames"
        return self._missing + ([f"{frames} that cannot be read"] if self._left_out else [])

    def _found(self, places: NDArray[np.intp], values: NDArray[Any]) -> dict[str, Any]:
        counts = np.ascontiguousarray((values.swapaxes(1, 2) if self._transpose else values).astype(np.uint16))
        marks = np.zeros(counts.shape, np.uint8)
        marks[self._made_up[places]] = MARKS["interpolated"]
        return {"values": counts, "marks": marks, "time": self._time[places], "sequence": places.astype(np.uint64)}

    def _count_frames(self) -> int:
        frames = int(self._data["frame_count"][0])
        if frames < 0:
            raise FileError(f"{self._path}: frame_count is {frames}, but 0 or more are needed\n{_HINT}")
        for name in ("pressure", "ts", "predCount"):
            there = len(self._data[name])
            if there >= frames:
                continue
            text = f"frame_count is {frames}, but {name} has {there} rows"
            if not self._keep_going:
                raise FileError(f"{self._path}: {text}\nhint: the file was cut; keep_going=True reads what is there")
            self._missing.append(text)
        return min(frames, *(len(self._data[name]) for name in ("pressure", "ts", "predCount")))

    def _find_made_up(self) -> NDArray[np.bool_]:
        so_far: NDArray[np.float64] = np.asarray(self._data["predCount"][: self._frames], np.float64)
        more = np.diff(so_far, prepend=0.0)
        is_wrong = ~np.isfinite(so_far) | ~(more >= 0.0)
        if is_wrong.any():
            at = int(np.argmax(is_wrong))
            before = so_far[at - 1] if at else 0.0
            raise FileError(
                f"{self._path}: frame {at}: predCount goes from {before:g} to {so_far[at]:g}, but it counts up\n"
                "hint: without it nothing tells which frames were measured"
            )
        made_up = more > 0.0
        # A packet may reach into the next frame, and the file does not tell where packets end.
        made_up[1:] |= more[:-1] > 0.0
        return made_up

    def _wrong(self, frame: int) -> FileError:
        where = f"{self._path}: frame {frame}"
        if not self._time[frame] > 0.0:
            return FileError(
                f"{where}: ts is {self._time[frame]:g}, but seconds since 1970 are more than 0, as where it was never written\n"
                f"hint: frame_count is {self._frames}; keep_going=True leaves such frames out"
            )
        values = self._data["pressure"][frame]
        row, column = np.argwhere((values < 0) | (values > _MOST_COUNTS))[0]
        return FileError(
            f"{where}: pressure[{row}, {column}] is {values[row, column]}, but counts are 0 to {_MOST_COUNTS}\n"
            "hint: keep_going=True leaves such frames out"
        )


def _opened(path: str) -> dict[str, Any]:
    """The data of a file, none of it read yet."""
    try:
        h5py: Any = import_module("h5py")
    except ModuleNotFoundError as error:
        raise Error(f"{path} is HDF5, for which {error.name} is needed, which is not installed\nhint: pip install h5py") from None
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise FileError(f"cannot read {path}: {error}\nhint: the recorder that writes it must have ended") from None
    data: dict[str, Any] = {}
    for name, axes in _DATASETS.items():
        found = file.get(name)
        if not isinstance(found, h5py.Dataset):
            there = ", ".join(sorted(file)) or "nothing"
            raise FileError(f"{path} has no {name}, but {there}\n{_HINT}")
        if found.ndim != axes or found.dtype.kind not in ("uif" if name in ("ts", "predCount") else "ui"):
            what = "numbers" if name in ("ts", "predCount") else "whole numbers"
            raise FileError(f"{path}: {name} is {found.dtype} of shape {found.shape}, but {what} of {axes} axes are needed\n{_HINT}")
        data[name] = found
    if len(data["frame_count"]) != 1:
        raise FileError(f"{path}: frame_count has {len(data['frame_count'])} numbers, but 1 is needed\n{_HINT}")
    return data

