"""Recordings: files of frames, read as far as they are asked for."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, overload

import numpy as np
from numpy.typing import NDArray

from ._errors import Error, FileError
from ._taxel import Reader, Sensor
from ._wiresens import WiReSensReader, is_hdf5

Unit = Literal["counts", "volts", "siemens"]
_CHUNK = 256


@dataclass(frozen=True, eq=False)
class Chunk:
    """Frames of a recording, one after the other."""

    values: NDArray[Any]
    """Frames × rows × columns."""
    marks: NDArray[np.uint8]
    """What the file says of each reading: codes of ``taxel.MARKS``."""
    time: NDArray[np.float64] | None
    """Seconds of the device, where the file knows them."""
    sequence: NDArray[np.uint64]
    """Place of each frame in the recording; those that could not be read are missing."""
    tare: NDArray[np.float64] | None
    """Newtons that were taken off each load while it was recorded, where there was a tare."""
    unit: Unit
    """What the values are."""


def _is_there(path: str | os.PathLike[str]) -> bool:
    """Whether there is such a file; behind a ``#`` may stand which of the sensors in it is meant."""
    file = os.fspath(path)
    return os.path.exists(file) or os.path.isfile(file.rpartition("#")[0])


class _Reads(Protocol):
    """What reads a file, some frames at a time."""

    @property
    def shape(self) -> tuple[int, int]: ...
    def read(self, most: int) -> dict[str, Any] | None: ...
    def skip(self, most: int) -> int: ...
    def events(self) -> list[dict[str, Any]]: ...
    def missing(self) -> list[str]: ...


class Recording:
    """A recording: opened by ``taxel.read``. It is read as far as it is asked for, and kept once all of it was.

    ``len(recording)``, ``recording[7]``, ``recording[10:20]``, ``for frame in recording`` and ``recording.counts`` do what one
    expects of them.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        sensor: Sensor | None,
        unit: Unit,
        transpose: bool,
        keep_going: bool,
    ) -> None:
        self.path: Path = Path(path)
        self._sensor = sensor
        self._unit: Unit = unit
        self._options = (unit, transpose, keep_going)
        self._all: Chunk | None = None
        self._frames: int | None = None
        self._events: list[dict[str, Any]] = []
        self._missing: list[str] = []
        self._was_gone_through = False
        self._closed = False
        # What is a pipe, or a device, can be read once.
        self._is_pipe = self.path.exists() and not self.path.is_file()
        self._is_hdf5 = not self._is_pipe and is_hdf5(path)
        self._pipe: _Reads | None = None
        reader = self._new_reader()
        self._shape = reader.shape
        if self._is_pipe:
            self._pipe = reader

    def _open(self) -> _Reads:
        if self._closed:
            raise Error(f"{self.path}: the recording is closed\nhint: taxel.read opens it again")
        if not self._is_pipe:
            return self._new_reader()
        if self._pipe is None:
            raise Error(f"{self.path} is no file, and was read already\nhint: load() keeps what it reads")
        reader, self._pipe = self._pipe, None
        return reader

    def _new_reader(self) -> _Reads:
        kind = WiReSensReader if self._is_hdf5 else Reader
        return kind(self.path, self._sensor, *self._options)

    @property
    def sensor(self) -> Sensor | None:
        """The sensor: the one that was given, or that the file carries."""
        return self._sensor

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a frame."""
        return self._shape

    def chunks(self, frames: int = _CHUNK) -> Iterator[Chunk]:
        """Goes through the file, some frames at a time, in constant memory."""
        if frames < 1:
            raise Error(f"chunks of {frames} frames")
        if self._all is not None:
            yield from (_cut(self._all, slice(at, at + frames)) for at in range(0, len(self._all.values), frames))
            return
        reader, count = self._open(), 0
        while (found := reader.read(frames)) is not None:
            chunk = self._chunk(found)
            count += len(chunk.values)
            yield chunk
            if len(chunk.values) < frames:
                break
        self._frames = count
        self._events, self._missing = reader.events(), reader.missing()
        self._was_gone_through = True

    def _go_through(self) -> None:
        """Reads to the end without keeping anything: what stands beside the frames is known then."""
        if not self._was_gone_through:
            for _ in self.chunks():
                pass

    def load(self) -> Chunk:
        """Reads all of it, and keeps it."""
        if self._all is None:
            self._all = self._memory_map() or [*self.chunks(2**62), self._empty()][0]
            self._frames = len(self._all.values)
        return self._all

    def close(self) -> None:
        """Lets go of what was read."""
        self._all, self._pipe, self._closed = None, None, True

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def values(self) -> NDArray[Any]:
        """All frames: frames × rows × columns. Counts up to 65535 are ``uint16``; of a ``.npy`` file a map of the file itself."""
        self._check_open()
        return self.load().values

    @property
    def counts(self) -> NDArray[Any]:
        """All frames of counts: frames × rows × columns."""
        if self._unit != "counts":
            raise Error(f"{self.path} was opened as {self._unit}\nhint: `values`")
        return self.values

    @property
    def marks(self) -> NDArray[np.uint8]:
        """What the file says of each reading: codes of ``taxel.MARKS``."""
        self._check_open()
        return self.load().marks

    @property
    def time(self) -> NDArray[np.float64] | None:
        """Seconds of the device, each frame; None where the file knows none."""
        self._check_open()
        return self.load().time

    @property
    def predicted(self) -> NDArray[np.bool_]:
        """Of each frame, whether its recorder made it up or may have made up some of it, as WiReSens does where packets are missing; all
        of such a frame is marked interpolated. False of every other format."""
        self._check_open()
        found = self.load()
        if not self._is_hdf5:
            return np.zeros(len(found.values), np.bool_)
        reader = WiReSensReader(self.path, self._sensor, *self._options)
        return reader.made_up[found.sequence.astype(np.intp)]

    @property
    def tare(self) -> NDArray[np.float64] | None:
        """Newtons that were taken off each load while it was recorded."""
        self._check_open()
        return self.load().tare

    @property
    def events(self) -> list[dict[str, Any]]:
        """What happened meanwhile: marks, tares, the device; dicts of ``secs``, ``kind``, ``text``, ``unix_secs``."""
        self._check_open()
        self._go_through()
        return self._events

    @property
    def missing(self) -> list[str]:
        """What is known to be missing, in words; empty for a whole recording."""
        self._check_open()
        self._go_through()
        return self._missing

    def __len__(self) -> int:
        self._check_open()
        if self._is_pipe:
            self.load()
        if self._frames is None:
            self._frames = self._open().skip(2**62)
        return self._frames

    @overload
    def __getitem__(self, key: int) -> NDArray[Any]: ...
    @overload
    def __getitem__(self, key: slice) -> NDArray[Any]: ...
    def __getitem__(self, key: int | slice) -> NDArray[Any]:
        """Values of one frame, or of several."""
        self._check_open()
        if not isinstance(key, slice) and self._frames is not None and not -self._frames <= key < self._frames:
            raise self._no_frame()
        if self._all is not None:
            return self._all.values[key]
        if isinstance(key, slice):
            if (key.start or 0) >= 0 and key.stop is not None and key.stop >= 0 and (key.step or 1) > 0:
                start = key.start or 0
                return self._part(start, key.stop - start)[:: key.step or 1]
            return self.load().values[key]
        if key < 0:
            key += len(self)
        found = self._part(key, 1) if key >= 0 else ()
        if len(found) == 0:
            raise self._no_frame()
        return found[0]

    def _no_frame(self) -> IndexError:
        return IndexError(f"{self.path} has {len(self)} frames, counted from 0")

    def _part(self, start: int, count: int) -> NDArray[Any]:
        if self._is_pipe:
            return self.load().values[start : start + max(count, 0)]
        reader = self._open()
        if count > 0 and reader.skip(start) == start and (found := reader.read(count)) is not None:
            return found["values"]
        return self._empty().values

    def __iter__(self) -> Iterator[NDArray[Any]]:
        for chunk in self.chunks():
            yield from chunk.values

    def __repr__(self) -> str:
        frames = "" if self._frames is None else f"{self._frames} frames of "
        name = f", sensor {self._sensor.name}" if self._sensor is not None else ""
        return f"<taxel.Recording {self.path}: {frames}{self._shape[0]} × {self._shape[1]} {self._unit}{name}>"

    def _check_open(self) -> None:
        if self._closed:
            self._open()

    def _chunk(self, found: dict[str, Any]) -> Chunk:
        time: NDArray[np.float64] = found["time"]
        return Chunk(
            values=found["values"],
            # Where all are good, a number for all of them.
            marks=found.get("marks", np.broadcast_to(np.uint8(0), found["values"].shape)),
            time=None if np.isnan(time).all() else time,
            sequence=found["sequence"],
            tare=np.broadcast_to(found["tare"], found["values"].shape) if "tare" in found else None,
            unit=self._unit,
        )

    def _empty(self) -> Chunk:
        kind = np.uint16 if self._unit == "counts" else np.float64
        return Chunk(
            values=np.empty((0, *self._shape), kind),
            marks=np.empty((0, *self._shape), np.uint8),
            time=None,
            sequence=np.empty(0, np.uint64),
            tare=None,
            unit=self._unit,
        )

    def _memory_map(self) -> Chunk | None:
        """The file itself as an array, where it is one of frames × rows × columns."""
        unit, transpose, keep_going = self._options
        if self._is_pipe or self.path.suffix.lower() != ".npy" or transpose or keep_going:
            return None
        # Read through once: what is no count is an error, as of every other format.
        self._open().skip(2**62)
        array = np.load(self.path, mmap_mode="r", allow_pickle=False)
        if array.ndim != 3 or array.shape[1:] != self._shape or not array.flags.c_contiguous:
            return None
        return Chunk(
            values=array,
            marks=np.broadcast_to(np.uint8(0), array.shape),
            time=None,
            sequence=np.arange(len(array), dtype=np.uint64),
            tare=None,
            unit=unit,
        )


def _cut(chunk: Chunk, part: slice) -> Chunk:
    return Chunk(
        values=chunk.values[part],
        marks=chunk.marks[part],
        time=None if chunk.time is None else chunk.time[part],
        sequence=chunk.sequence[part],
        tare=None if chunk.tare is None else chunk.tare[part],
        unit=chunk.unit,
    )


def read(
    path: str | os.PathLike[str],
    sensor: Any = None,
    *,
    unit: Unit = "counts",
    transpose: bool = False,
    keep_going: bool = False,
) -> Recording:
    """Opens a recording.

    Parameters
    ----------
    path : str or path
        ``.txt``, ``.csv``, ``.npy``, ``.npz``, ``.mcap``, ``.parquet``; HDF5 of WiReSens, known by its first bytes (needs ``h5py``); what
        Tekscan, RSscan, zebris, XSENSOR, novel and others export, known by its content: of several sensors one is named behind a
        ``#``, as in ``walk.csv#left``. A pipe is read once: ``load`` keeps what comes.
    sensor : Sensor, str, path or dict, optional
        What it is of. Recordings of ``.mcap`` and ``.parquet`` bring their own; text needs one.
    unit : {"counts", "volts", "siemens"}
        What its numbers are.
    transpose : bool
        The file has rows and columns swapped.
    keep_going : bool
        Leave out frames that cannot be read, and of a damaged file give what is whole; ``missing`` tells what is not.

    Returns
    -------
    Recording
        Open; its frames are read as they are asked for.

    Raises
    ------
    taxel.FileError
        No such file, or what is wrong in it: frame, line, both numbers.
    taxel.Error
        Nothing tells the shape of its frames; HDF5 without ``h5py``.

    Examples
    --------
    >>> recording = taxel.read("grip.mcap")                       # doctest: +SKIP
    >>> recording.counts.shape, recording.time[-1]                # doctest: +SKIP
    """
    if unit not in ("counts", "volts", "siemens"):
        raise Error(f"unit {unit!r}\nhint: counts, volts or siemens")
    if not _is_there(path):
        raise FileError(f"cannot open {os.fspath(path)}: no such file")
    if sensor is None:
        sensor = _carried(path)
    elif not isinstance(sensor, Sensor):
        sensor = Sensor(sensor)
    return Recording(path, sensor, unit, transpose, keep_going)


def _carried(path: str | os.PathLike[str]) -> Sensor | None:
    return Sensor.carried_by(path)
