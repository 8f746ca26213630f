"""A sensor while it reads."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._errors import Error
from ._pipeline import sensor_of
from ._taxel import Sensor, Stream


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """A frame that was solved a moment ago."""

    number: int
    """Its number among those that were solved; a gap says how many Python was too slow for."""
    unix_secs: float
    """When it arrived, seconds since 1970."""
    device_secs: float | None
    """The device's own time, seconds."""
    loads: NDArray[np.float64] | None
    """Loads, newtons: rows × columns; None without a load law."""
    siemens: NDArray[np.float64] | None
    """Conductances, siemens: rows × columns."""
    marks: NDArray[np.uint8]
    """Codes of ``taxel.MARKS``."""
    answered: bool
    """Whether the inverse came to one answer."""
    force_newtons: float
    """Sum of the loads, newtons."""


class Live:
    """A source of frames: iterate over it, in a ``with`` or ``async with`` block. See ``taxel.live``.

    It is open from the start: where opening takes long, ``await asyncio.to_thread(taxel.live, …)`` keeps an event loop free.
    """

    def __init__(
        self,
        address: str,
        sensor: Sensor | None,
        method: str,
        queue: int,
        record: str | os.PathLike[str] | None,
    ) -> None:
        self._stream = Stream(address, sensor, method, queue, record)

    @property
    def sensor(self) -> Sensor:
        """The sensor."""
        return self._stream.sensor

    @property
    def state(self) -> str:
        """How the source stands, in words."""
        return self._stream.state()

    @property
    def statistics(self) -> dict[str, Any]:
        """Numbers of frames: ``received``; ``lost``, ``corrupt`` and ``repeated`` on the way; ``left_out`` (the inverse was slower);
        ``solved``; of these ``dropped`` (Python was slower) and ``waiting``. ``troubles`` on the way, in words. They stay when it is closed.
        """
        return self._stream.statistics()

    def next(self, timeout: float | None = None) -> LiveFrame | None:
        """The next frame.

        Parameters
        ----------
        timeout : float, optional
            Seconds to wait; without it until there is one.

        Returns
        -------
        LiveFrame or None
            None at the end, or when none came in time.

        Raises
        ------
        taxel.Error
            A timeout that is negative or no number.
        KeyboardInterrupt
            Ctrl-C ends the waiting; the source goes on.
        """
        found = self._stream.next(timeout)
        return None if found is None else LiveFrame(**found)

    def close(self) -> None:
        """Ends it; a recording is whole when this returns."""
        self._stream.close()

    def __iter__(self) -> Iterator[LiveFrame]:
        while (frame := self.next()) is not None:
            yield frame

    async def __aiter__(self) -> AsyncIterator[LiveFrame]:
        while True:
            # Asked first: what came before the end is there by then.
            has_ended = self._stream.has_ended()
            frame = await _elsewhere(lambda: self.next(0.2))
            if frame is not None:
                yield frame
            elif has_ended:
                return

    def __enter__(self) -> Live:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    async def __aenter__(self) -> Live:
        return self

    async def __aexit__(self, *_: object) -> None:
        await _elsewhere(self.close)


T = TypeVar("T")


async def _elsewhere(call: Callable[[], T]) -> T:
    """On a thread of its own."""
    # Imported by who needs it: it takes as long as half of this package.
    import asyncio

    return await asyncio.to_thread(call)


def live(
    address: str,
    sensor: Any = None,
    *,
    method: str = "auto",
    queue: int = 8,
    record: str | os.PathLike[str] | None = None,
) -> Live:
    """Frames of a sensor as they come, loads in newtons.

    Where Python takes longer than a frame lasts, the oldest that wait are left out and counted; a recording has them all.

    Parameters
    ----------
    address : str
        ``serial:/dev/ttyACM0?baud=2000000``, ``udp:0.0.0.0:9000``, ``tcp:…``, ``sim:econe?hand``, ``file:grip.mcap`` …, as
        ``taxel live`` takes it.
    sensor : Sensor, str, path or dict, optional
        The sensor; a simulated one and a recording bring theirs.
    method : str
        How loads are found, as of ``Pipeline``.
    queue : int
        Frames that may wait.
    record : path, optional
        Record the counts meanwhile (``.mcap``); the file must not exist.

    Returns
    -------
    Live
        To iterate over, in a ``with`` or ``async with`` block. A cable that is pulled ends nothing: it is opened again when it is back.

    Raises
    ------
    taxel.Error
        An address that is none, a device that cannot be opened, no room in the queue, a sensor that nothing tells.
    taxel.FileError
        A recording that is there already, or cannot be written.
    taxel.SensorError
        The sensor file lacks what the method needs.

    Examples
    --------
    >>> import taxel
    >>> with taxel.live("sim:econe?hand") as source:
    ...     frame = source.next()
    >>> frame.loads.shape
    (64, 128)
    """
    known = None if sensor is None else sensor_of(sensor)
    if queue < 1:
        raise Error(f"queue {queue}\nhint: room for one frame or more is needed")
    return Live(address, known, method, queue, record)
