"""Frames in: from whoever sends them on the network."""

from __future__ import annotations

import contextlib
import threading
from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._errors import ArrayError, Error
from .._taxel import Sensor
from ._description import checked_shape, pylsl, read_description

# How often the clocks are compared.
OFFSET_SECS = 5.0
_LOOK_SECS = 0.2
# How long nothing comes before the sender is looked for, and how often, two seconds each: a computer that goes says nothing.
_SILENT_SECS = 5.0
_LOOKS = 3
# What may wait in the library, seconds, or hundreds of samples of a stream without a rate: the thread empties it.
_LIBRARY_BUFFER = 10


class LostError(Error):
    """A stream whose sender is gone."""


@dataclass(frozen=True)
class Stream:
    """A stream that somebody on the network sends."""

    name: str
    """Its name."""
    type: str
    """What it is of: ``Pressure``, ``Markers``, ``EEG`` …"""
    channels: int
    """How many numbers a sample has."""
    rate: float
    """Nominal samples a second; 0 where they come as they come."""
    host: str
    """The computer that it comes from."""
    info: Any = field(repr=False, compare=False)
    """What pylsl has of it."""


def streams(wait: float = 1.0) -> list[Stream]:
    """Streams that are on the network, by name.

    Parameters
    ----------
    wait : float
        Seconds to look for them.
    """
    found = [_stream(info) for info in pylsl().resolve_streams(wait)]
    return sorted(found, key=lambda stream: (stream.name, stream.type))


def _stream(info: Any) -> Stream:
    return Stream(info.name(), info.type(), info.channel_count(), info.nominal_srate(), info.hostname(), info)


def resolve(wanted: Stream | str | None, kind: str, timeout: float) -> Stream:
    """The stream of this name, or of this kind."""
    if isinstance(wanted, Stream):
        return wanted
    key, value = ("type", kind) if wanted is None else ("name", wanted)
    found = [_stream(info) for info in pylsl().resolve_byprop(key, value, 1, timeout)]
    if not found:
        there = ", ".join(f"{stream.name} ({stream.type})" for stream in streams()) or "none"
        raise Error(f"no stream of {key} {value!r} came up within {timeout:g} s; there are: {there}\nhint: is its sender running?")
    if len(found) > 1:
        hosts = ", ".join(f"{stream.name} of {stream.host}" for stream in found)
        raise Error(f"{len(found)} streams of {key} {value!r}: {hosts}\nhint: give one of taxel.lsl.streams()")
    return found[0]


class Receiver:
    """What frames, markers and recordings have in common: a thread takes samples as they come.

    Without it all that waits in the library were gone together with the sender.
    """

    def __init__(self, stream: Stream | str | None, kind: str, timeout: float, queue: int) -> None:
        if queue < 1:
            raise Error(f"queue {queue}\nhint: room for one sample or more is needed")
        self._lsl = pylsl()
        self.stream: Stream = resolve(stream, kind, timeout)
        self.received: int = 0
        self.dropped: int = 0
        # Never opened again in silence: a sender that went is to be seen.
        self._inlet: Any = self._lsl.StreamInlet(self.stream.info, max_buflen=_LIBRARY_BUFFER, recover=False)
        self.is_text: bool = self._inlet.np_dtype is None
        self.offsets: list[tuple[float, float]] = []
        self._waiting: deque[tuple[float, NDArray[Any]]] = deque(maxlen=queue)
        self._came = threading.Condition()
        self._end: Exception | None = None
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name=f"taxel.lsl {self.stream.name}", daemon=True)
        with self._told_of_loss():
            self.xml: str = str(self._inlet.info(timeout).as_xml())
            self._measure_offset(timeout)

    def start(self, timeout: float) -> None:
        """From now on samples come: a sender that waits for somebody who receives begins."""
        with self._told_of_loss():
            self._inlet.open_stream(timeout)
        self._thread.start()

    def take(self, timeout: float, most: int) -> list[tuple[float, NDArray[Any]]]:
        """Samples that have come with their senders' time stamps; the sender's loss only after the last of them."""
        if self._is_closed:
            raise Error(f"{self.stream.name} is closed\nhint: open it anew")
        with self._came:
            self._came.wait_for(lambda: self._waiting or self._end is not None, timeout)
            found = [self._waiting.popleft() for _ in range(min(most, len(self._waiting)))]
        self.received += len(found)
        if not found and self._end is not None:
            raise self._lost(self._end)
        return found

    def close(self) -> None:
        """Stops receiving."""
        self._is_closed = True
        if self._thread.is_alive():
            self._thread.join()
        self._inlet = None

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        silent_since = self._lsl.local_clock()
        try:
            while not self._is_closed:
                # One that is waited for, then what came with it: a loss in between takes nothing along.
                if self._pull(_LOOK_SECS, 1):
                    self._pull(0.0, 64)
                    silent_since = self._lsl.local_clock()
                elif self._lsl.local_clock() > silent_since + _SILENT_SECS:
                    if not self._is_there() and not self._pull(0.0, 64):
                        raise self._lsl.util.LostError("it does not answer any more.")
                    silent_since = self._lsl.local_clock()
                if self._lsl.local_clock() >= self.offsets[-1][0] + self.offsets[-1][1] + OFFSET_SECS:
                    with contextlib.suppress(self._lsl.util.TimeoutError):
                        self._measure_offset(0.0)
        except Exception as error:
            self._stop(error)

    def _is_there(self) -> bool:
        """Whether the sender still answers; a stream may be silent for long."""
        asked = f"uid='{self.stream.info.uid()}'"
        return any(self._is_closed or self._lsl.resolve_bypred(asked, 1, 2.0) for _ in range(_LOOKS))

    def _pull(self, timeout: float, most: int) -> bool:
        values, stamps = self._inlet.pull_chunk(timeout, max_samples=most, as_numpy=True)
        if not len(stamps):
            return False
        with self._came:
            for stamp, sample in zip(stamps.tolist(), values, strict=True):
                self.dropped += len(self._waiting) == self._waiting.maxlen
                self._waiting.append((stamp, sample.copy()))
            self._came.notify_all()
        return True

    def _stop(self, error: Exception) -> None:
        with self._came:
            self._end = error
            self._came.notify_all()

    def _measure_offset(self, timeout: float) -> None:
        offset = float(self._inlet.time_correction(timeout))
        # When it was by the sender's own clock.
        self.offsets.append((self._lsl.local_clock() - offset, offset))

    @contextlib.contextmanager
    def _told_of_loss(self) -> Generator[None]:
        try:
            yield
        except (self._lsl.util.LostError, self._lsl.util.TimeoutError) as error:
            raise self._lost(error) from None

    def _lost(self, error: Exception) -> LostError:
        return LostError(
            f"{self.stream.name} of {self.stream.host}: {error} {self.received} samples came until then\n"
            "hint: once its sender runs again, open it anew"
        )


@dataclass(frozen=True, eq=False)
class Frames:
    """Frames that came."""

    values: NDArray[Any]
    """Frames × rows × columns, in the stream's unit and type of number."""
    time: NDArray[np.float64]
    """When each was measured, seconds of this machine's ``clock()``."""


class Inlet(Receiver):
    """Frames of a stream, of Taxel's or another's: ``read`` them, or iterate, in a ``with`` block.

    Parameters
    ----------
    stream : Stream or str, optional
        Which, or its name; without it one of type ``Pressure``.
    shape : (int, int), optional
        Rows and columns of a stream that does not tell them; its channels are then taken row by row.
    timeout : float
        Seconds to look for it and to open it.
    queue : int
        Frames that may wait to be read; the oldest are left out, and counted, where Python is slower.

    Attributes
    ----------
    stream : Stream
        Where frames come from.
    received, dropped : int
        How many were read, and how many left out.
    shape : (int, int)
        Rows and columns.
    unit : str or None
        What the numbers are, where the stream says it.
    labels : list of str or None
        A name a channel.
    positions_mm : array of taxels × 2, or None
        Where each taxel lies, mm, x and y.
    sensor : Sensor or None
        The sensor, of a stream of Taxel's.

    Raises
    ------
    taxel.Error
        No such stream, or one of another shape: both numbers.
    taxel.lsl.LostError
        Its sender is gone: from ``read``, and from iterating.

    Examples
    --------
    >>> from taxel import lsl
    >>> with lsl.Inlet("forearm") as inlet:                         # doctest: +SKIP
    ...     frames = inlet.read()
    >>> frames.values.shape, frames.time.shape                      # doctest: +SKIP
    ((1, 16, 16), (1,))
    """

    def __init__(
        self,
        stream: Stream | str | None = None,
        *,
        shape: tuple[int, int] | None = None,
        timeout: float = 5.0,
        queue: int = 1024,
    ) -> None:
        super().__init__(stream, "Pressure", timeout, queue)
        self._understand(shape)
        self.start(timeout)

    def _understand(self, given: tuple[int, int] | None) -> None:
        told = read_description(self.xml)
        channels = self.stream.channels
        if self.is_text:
            raise Error(f"{self.stream.name} is of strings, not of numbers\nhint: taxel.lsl.Markers reads it")
        found = given or told.shape
        if found is None:
            raise Error(f"{self.stream.name} does not tell the shape of its {channels} channels\nhint: shape=(rows, columns)")
        self.shape: tuple[int, int] = checked_shape(None, found)
        if self.shape[0] * self.shape[1] != channels:
            raise ArrayError(
                f"{self.shape[0]} × {self.shape[1]} are {self.shape[0] * self.shape[1]} taxels, but {self.stream.name} has {channels} "
                "channels\nhint: shape=(rows, columns)"
            )
        self.unit: str | None = told.unit
        self.labels: list[str] | None = told.labels
        self.sensor: Sensor | None = told.sensor
        has_places = told.positions_mm is not None and len(told.positions_mm) == channels
        self.positions_mm: NDArray[np.float64] | None = told.positions_mm if has_places else None

    def read(self, timeout: float = 1.0, most: int = 64) -> Frames:
        """Frames that have come: at least one, but none where none came within ``timeout`` seconds; ``most`` at a time."""
        found = self.take(timeout, most)
        kind = self._inlet.np_dtype
        values = np.array([sample for _, sample in found], kind).reshape(-1, *self.shape)
        return Frames(values, np.array([stamp for stamp, _ in found], np.float64) + self.offsets[-1][1])

    def __iter__(self) -> Iterator[Frames]:
        while not self._is_closed:
            frames = self.read()
            if len(frames.time):
                yield frames

    def __enter__(self) -> Inlet:
        return self


class Markers(Receiver):
    """Markers of a stream of strings, in a ``with`` block.

    Parameters
    ----------
    stream : Stream or str, optional
        Which, or its name (an outlet's, with `` marks`` behind it); without it one of type ``Markers``.
    timeout : float
        Seconds to look for it and to open it.

    Raises
    ------
    taxel.Error
        No such stream, or one of numbers.
    taxel.lsl.LostError
        Its sender is gone: from ``read``.
    """

    def __init__(self, stream: Stream | str | None = None, *, timeout: float = 5.0) -> None:
        super().__init__(stream, "Markers", timeout, 65536)
        if not self.is_text or self.stream.channels != 1:
            raise Error(f"{self.stream.name} ({self.stream.type}) is no stream of one string\nhint: taxel.lsl.Inlet reads numbers")
        self.start(timeout)

    def read(self, timeout: float = 1.0, most: int = 64) -> list[tuple[float, str]]:
        """Markers that have come, each with its time, seconds of this machine's ``clock()``; ``marks_of`` reads those of taxels."""
        offset = self.offsets[-1][1]
        return [(stamp + offset, bytes(sample[0]).decode(errors="replace")) for stamp, sample in self.take(timeout, most)]

    def __enter__(self) -> Markers:
        return self
