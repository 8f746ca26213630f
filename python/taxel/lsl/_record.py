"""Streams of the network to a file, as LabRecorder writes it."""

from __future__ import annotations

import contextlib
import os
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._errors import Error, FileError
from ._description import clock
from ._inlet import LostError, Receiver, Stream, resolve, streams
from ._xdf import XdfWriter

_BOUNDARY_SECS = 5.0
_LOOK_SECS = 0.05
_MOST = 256
_MOST_WAITING_BYTES = 256e6


class LostWarning(UserWarning):
    """A stream whose sender went while it was recorded: what came until then is in the file."""


@dataclass(frozen=True)
class Recorded:
    """What was recorded of a stream."""

    stream: Stream
    """Which."""
    samples: int
    """How many samples are in the file."""
    dropped: int
    """How many are not, because the disk was slower."""
    was_lost: bool
    """Whether its sender went before the end."""


class _Track:
    """A stream that is recorded, and what has come of it."""

    def __init__(self, number: int, stream: Stream, timeout: float) -> None:
        self._number = number
        self._receiver = Receiver(stream, "", timeout, max(64, int(_MOST_WAITING_BYTES / (8 * stream.channels))))
        self._count, self._first, self._last, self._offsets = 0, 0.0, 0.0, 0
        self.was_lost = False

    def start(self, timeout: float) -> None:
        """From now on samples come."""
        self._receiver.start(timeout)

    def begin(self, writer: XdfWriter) -> None:
        """Writes what it is."""
        writer.stream_header(self._number, self._receiver.xml)

    def pull(self, writer: XdfWriter) -> None:
        """Writes what has come."""
        while not self.was_lost:
            try:
                found = self._receiver.take(0.0, _MOST)
            except LostError as error:
                self.was_lost = True
                # Whoever called `record`.
                warnings.warn(f"{error.message}; they are recorded", LostWarning, stacklevel=4)
                break
            if not found:
                break
            stamps = np.array([stamp for stamp, _ in found], np.float64)
            writer.samples(self._number, stamps, np.array([sample for _, sample in found]))
            self._first = self._first if self._count else found[0][0]
            self._last = found[-1][0]
            self._count += len(found)
        offsets = self._receiver.offsets
        for measured, offset in offsets[self._offsets :]:
            writer.clock_offset(self._number, measured, offset)
            self._offsets += 1

    def end(self, writer: XdfWriter) -> Recorded:
        """Writes what it came to."""
        offsets = self._receiver.offsets[: self._offsets]
        writer.stream_footer(self._number, self._first, self._last, self._count, offsets)
        return Recorded(self._receiver.stream, self._count, self._receiver.dropped, self.was_lost)

    def close(self) -> None:
        """Stops receiving."""
        self._receiver.close()


def record(
    path: str | os.PathLike[str],
    wanted: Sequence[Stream | str] | None = None,
    *,
    seconds: float | None = None,
    timeout: float = 5.0,
) -> list[Recorded]:
    """Records streams to an XDF file, which ``pyxdf`` and EEGLAB read with the clocks of all streams brought together.

    Parameters
    ----------
    path : path
        Where to (``.xdf``); the file must not exist. Where the program is killed, it is readable up to then.
    wanted : streams or their names, optional
        Which; without it all that are on the network.
    seconds : float, optional
        How long; without it until all senders are gone. Ctrl-C ends it before, with a whole file.
    timeout : float
        Seconds to look for each stream and to open it.

    Returns
    -------
    list of Recorded
        What was recorded of each stream.

    Raises
    ------
    taxel.Error
        No such stream, or none at all.
    taxel.FileError
        A file that is there already, or cannot be written.

    Warns
    -----
    taxel.lsl.LostWarning
        A sender that went before the end; the other streams are recorded on.
    """
    found = streams() if wanted is None else [resolve(one, "Pressure", timeout) for one in wanted]
    if not found:
        raise Error("there is no stream on the network\nhint: is a sender running?")
    tracks: list[_Track] = []
    try:
        # Opened before there is a file: where one cannot be, there is none.
        tracks += (_Track(number, stream, timeout) for number, stream in enumerate(found, start=1))
        # All at once: a sender may begin with the first who receives.
        for track in tracks:
            track.start(timeout)
        with contextlib.closing(XdfWriter(path)) as writer:
            return _recorded(writer, tracks, seconds)
    except FileExistsError:
        raise FileError(f"{os.fspath(path)} is there already\nhint: another name; no recording is replaced") from None
    except OSError as error:
        if isinstance(error, Error):
            raise
        raise FileError(f"cannot write {os.fspath(path)}: {error.strerror or error}") from None
    finally:
        for track in tracks:
            track.close()


def _recorded(writer: XdfWriter, tracks: Sequence[_Track], seconds: float | None) -> list[Recorded]:
    for track in tracks:
        track.begin(writer)
    until = np.inf if seconds is None else clock() + seconds
    bounded_at = clock()
    with contextlib.suppress(KeyboardInterrupt):
        while clock() < until and not all(track.was_lost for track in tracks):
            time.sleep(_LOOK_SECS)
            for track in tracks:
                track.pull(writer)
            if clock() >= bounded_at + _BOUNDARY_SECS:
                writer.boundary()
                bounded_at = clock()
    return [track.end(writer) for track in tracks]
