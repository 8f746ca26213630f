"""Frames out: to whoever receives them on the network."""

from __future__ import annotations

import socket
import time as system
from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._arrays import codes_of, frames_of, times_of
from .._errors import ArrayError, Error
from .._live import Live
from .._pipeline import Pipeline, sensor_of
from .._recording import Recording
from .._taxel import Sensor
from ._description import buffered_secs, checked_shape, clock, describe, pylsl, text_of_marks

# How often marks are told again, so that a recorder that comes later knows them.
_TOLD_AGAIN_SECS = 10.0
# What was sent goes out in the background.
_LINGER_SECS = 0.3


class Outlet:
    """A stream of frames, and one of markers, that others on the network can receive.

    Parameters
    ----------
    sensor : Sensor, str, path or dict, optional
        The sensor: gives shape, places and what goes into the description. Without it ``shape`` is needed.
    shape : (int, int), optional
        Rows and columns.
    name : str, optional
        The stream's name; the sensor's without it. The markers' is the same with `` marks`` behind it.
    unit : str
        What the numbers are: ``N``, ``counts``, ``S``.
    rate : float
        Nominal frames a second; 0 for frames that come as they come.

    Raises
    ------
    taxel.Error
        There is no ``pylsl``; neither sensor nor shape; a rate below 0.

    Examples
    --------
    >>> from taxel import lsl
    >>> with lsl.Outlet("mat-16x16-cd4067", rate=100.0) as outlet:  # doctest: +SKIP
    ...     outlet.push(loads, marks=marks)
    ...     outlet.mark("stands on one leg")
    """

    def __init__(
        self,
        sensor: Any = None,
        *,
        shape: tuple[int, int] | None = None,
        name: str | None = None,
        unit: str = "N",
        rate: float = 0.0,
    ) -> None:
        lsl = pylsl()
        known = None if sensor is None else sensor_of(sensor)
        self.shape: tuple[int, int] = checked_shape(known, shape)
        self.name: str = name or (known.name if known is not None else "taxel")
        if not 0.0 <= rate < np.inf:
            raise Error(f"rate {rate}, but frames a second are 0 (as they come) or more")
        self._source = f"taxel {socket.gethostname()} {self.name}"
        channels = self.shape[0] * self.shape[1]
        info = lsl.StreamInfo(self.name, "Pressure", channels, rate, lsl.cf_float32, self._source)
        describe(info, known, self.shape, unit)
        self._frames: Any = lsl.StreamOutlet(info, max_buffered=buffered_secs(channels, rate))
        told = lsl.StreamInfo(f"{self.name} marks", "Markers", 1, lsl.IRREGULAR_RATE, lsl.cf_string, f"{self._source} marks")
        self._markers: Any = lsl.StreamOutlet(told)
        self._told: NDArray[np.uint8] = np.zeros(self.shape, np.uint8)
        self._told_at = -np.inf

    def push(self, frames: ArrayLike, time: ArrayLike | None = None, marks: ArrayLike | None = None) -> None:
        """Sends frames.

        Parameters
        ----------
        frames : array of rows × columns, or of frames × rows × columns
            In the outlet's unit; sent as float32.
        time : float, or array of one a frame, optional
            When each was measured, seconds of ``clock()``; without it one frame is of now, and several need it.
        marks : array of the same shape, optional
            Codes of ``taxel.MARKS``; sent as a marker where they change, and again after some seconds.

        Raises
        ------
        taxel.ArrayError
            Another shape, or a number that is none: which frame and taxel.
        """
        array, is_one = frames_of(frames)
        if array.shape[1:] != self.shape:
            raise ArrayError(f"frames of {array.shape[1]} × {array.shape[2]}, but the outlet has {self.shape[0]} × {self.shape[1]}")
        bad = np.argwhere(~np.isfinite(array))
        if len(bad):
            frame, row, column = bad[0]
            raise ArrayError(f"frame {frame}, taxel ({row}, {column}): {array[frame, row, column]}\nhint: say it by marks=")
        if time is None and len(array) > 1:
            raise ArrayError(f"{len(array)} frames without times\nhint: time=, seconds of taxel.lsl.clock()")
        stamps = times_of(np.atleast_1d(clock() if time is None else np.asarray(time, np.float64)), len(array))
        codes = codes_of(marks, array.shape)
        if stamps is None or len(array) == 0:
            return
        if codes is not None:
            for stamp, frame in zip(stamps.tolist(), codes, strict=True):
                self._tell(stamp, frame)
        values = array.reshape(len(array), -1).astype(np.float32)
        self._open(self._frames).push_chunk(values, stamps[0] if is_one else stamps.tolist())

    def mark(self, text: str, time: float | None = None) -> None:
        """Sends a marker: what happened, and when by ``clock()``; now without it."""
        self._open(self._markers).push_sample([text], clock() if time is None else time)

    def wait(self, timeout: float) -> bool:
        """Waits until somebody receives frames; False where nobody does within ``timeout`` seconds."""
        return bool(self._open(self._frames).wait_for_consumers(timeout))

    def close(self) -> None:
        """Ends both streams, once what was sent has had time to go out."""
        if self._frames is not None and (self._frames.have_consumers() or self._markers.have_consumers()):
            system.sleep(_LINGER_SECS)
        self._frames = self._markers = None

    def __enter__(self) -> Outlet:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _tell(self, stamp: float, codes: NDArray[np.uint8]) -> None:
        is_same = bool((codes == self._told).all())
        if is_same and (not codes.any() or stamp < self._told_at + _TOLD_AGAIN_SECS):
            return
        self.mark(text_of_marks(codes), stamp)
        self._told, self._told_at = codes.copy(), stamp

    def _open(self, outlet: Any) -> Any:
        if outlet is None:
            raise Error(f"the outlet {self.name} is closed")
        return outlet


def send(
    source: Live | Recording | ArrayLike,
    sensor: Any = None,
    *,
    name: str | None = None,
    unit: Literal["N", "counts", "S"] = "N",
    rate: float = 0.0,
    speed: float = 1.0,
    method: str = "auto",
    wait: float | None = None,
) -> int:
    """Sends a source of frames until it ends; Ctrl-C ends it before.

    Parameters
    ----------
    source : Live, Recording, or array of frames × rows × columns
        ``taxel.live(…)``: loads, by the time that they arrived. A recording: its loads as fast as it was, with its events as
        markers. An array: its numbers as they are, ``rate`` a second.
    sensor : Sensor, str, path or dict, optional
        Of an array, or of a recording that brings none.
    name : str, optional
        The stream's name.
    unit : {"N", "counts", "S"}
        What a recording is sent as: loads, readings, conductances. What an array holds. Live frames are ``N`` or ``S``.
    rate : float
        Frames a second; needed where neither the frames nor the recording have times, else told to receivers alone.
    speed : float
        How many times as fast as it was.
    method : str
        How loads of a recording are found, as of ``Pipeline``.
    wait : float, optional
        Begin only once somebody receives; an error where nobody does within so many seconds.

    Returns
    -------
    int
        How many frames were sent.

    Raises
    ------
    taxel.Error
        A sensor without a load law for ``N``, no rate, nobody who receives.
    """
    if not 0.0 < speed < np.inf:
        raise Error(f"speed {speed}, but more than 0 is needed")
    if isinstance(source, (Live, Recording)):
        known = source.sensor if sensor is None else sensor_of(sensor)
        shape = None if known is not None else source.shape if isinstance(source, Recording) else None
    else:
        known = None if sensor is None else sensor_of(sensor)
        array, _ = frames_of(source)
        source, shape = array, (array.shape[1], array.shape[2])
    if unit != "counts" and not isinstance(source, np.ndarray):
        if known is None:
            raise Error(f"{source!r} has no sensor, so that its counts cannot be {unit}\nhint: sensor=, or unit='counts'")
        if unit == "N" and not known.has_load_law:
            raise Error(f"the sensor {known.name} has no load law\nhint: taxel.calibrate finds one; unit='S' sends conductances")
    sent = 0
    with Outlet(known, shape=shape, name=name, unit=unit, rate=rate) as outlet:
        if wait is not None and not outlet.wait(wait):
            raise Error(f"nobody received {outlet.name} within {wait:g} s\nhint: wait=, or a receiver on this network")
        if isinstance(source, Live):
            pieces = _arriving(source, unit)
        elif isinstance(source, Recording):
            pieces = _paced(_recorded(source, known, unit, method), rate, speed, source.events, outlet)
        else:
            pieces = _paced(((source[at : at + 1], None, None) for at in range(len(source))), rate, speed, [], outlet)
        for values, stamp, codes in pieces:
            outlet.push(values, stamp, codes)
            sent += 1
    return sent


_Piece = tuple[NDArray[Any], NDArray[np.float64] | None, NDArray[np.uint8] | None]


def _arriving(source: Live, unit: str) -> Iterator[tuple[NDArray[Any], float, NDArray[np.uint8]]]:
    """Live frames with the time that they arrived, by LSL's clock."""
    for frame in source:
        values = {"N": frame.loads, "S": frame.siemens}.get(unit)
        if values is None:
            raise Error(f"live frames have no {unit}\nhint: unit='N', or 'S' without a load law")
        yield values, clock() - max(0.0, system.time() - frame.unix_secs), frame.marks


def _recorded(source: Recording, sensor: Sensor | None, unit: str, method: str) -> Iterator[_Piece]:
    """A recording's frames as what they are to be sent as, some at a time."""
    if unit == "counts":
        for chunk in source.chunks(64):
            if chunk.unit != "counts":
                raise Error(f"{source.path} was opened as {chunk.unit}\nhint: unit='N', or 'S' for conductances")
            yield chunk.values, chunk.time, chunk.marks
        return
    for result in Pipeline(sensor, method).stream(source, chunk=64, siemens=unit == "S", figures=False):
        values = result.loads if unit == "N" else result.siemens
        assert values is not None, "asked for"
        yield values, result.time, result.marks


def _paced(
    pieces: Iterator[_Piece], rate: float, speed: float, events: Sequence[dict[str, Any]], outlet: Outlet
) -> Iterator[tuple[NDArray[Any], float, NDArray[np.uint8] | None]]:
    """One frame after the other when its time comes, and events between them."""
    waiting = sorted(events, key=lambda event: float(event["secs"]))
    begin = first = number = None
    for values, times, marks in pieces:
        if times is None and rate <= 0.0:
            raise Error("neither the frames nor the recording tell when they were\nhint: rate=, frames a second")
        for at in range(len(values)):
            number = 0 if number is None else number + 1
            secs = number / rate if times is None else float(times[at])
            if begin is None or first is None:
                begin, first = clock(), secs
            while waiting and float(waiting[0]["secs"]) <= secs:
                event = waiting.pop(0)
                outlet.mark(f"{event['kind']}: {event['text']}", begin + (float(event["secs"]) - first) / speed)
            stamp = begin + (secs - first) / speed
            system.sleep(max(0.0, stamp - clock()))
            yield values[at], stamp, None if marks is None else marks[at]
    for event in waiting:
        if begin is not None and first is not None:
            outlet.mark(f"{event['kind']}: {event['text']}", begin + (float(event["secs"]) - first) / speed)
