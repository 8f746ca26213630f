"""From frames to loads."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._arrays import codes_of, frames_of, tare_of, times_of
from ._errors import ArrayError, Error, NoiseOnlyWarning
from ._recording import Chunk, Recording
from ._result import Result
from ._table import Table
from ._taxel import Pipeline as Compiled
from ._taxel import Sensor

Unit = Literal["counts", "volts", "siemens"]


def sensor_of(source: Any) -> Sensor:
    """A sensor, or what makes one."""
    return source if isinstance(source, Sensor) else Sensor(source)


@dataclass(frozen=True)
class _Wanted:
    dtype: DTypeLike
    siemens: bool
    standard_errors: bool
    figures: bool
    threads: int | None


@dataclass(frozen=True)
class _Beside:
    """What numbers of frames are, and what stands beside them."""

    unit: Unit = "counts"
    marks: ArrayLike | None = None
    time: ArrayLike | None = None
    tare: ArrayLike | None = None


def _beside_own(recording: Recording, chunk: Chunk, given: _Beside) -> _Beside:
    """What stands beside a recording's frames: its own, and what it has none of."""
    if given.unit not in ("counts", chunk.unit):
        raise Error(f"{recording.path} was opened as {chunk.unit}, not as {given.unit}\nhint: taxel.read(path, unit={given.unit!r})")
    marks = codes_of(chunk.marks, chunk.values.shape)
    for what, own, other in (
        ("marks", marks, given.marks),
        ("times", chunk.time, given.time),
        ("a tare", chunk.tare, given.tare),
    ):
        if own is not None and other is not None:
            raise Error(f"{recording.path} has {what} of its own\nhint: process(recording.values, …) takes others")
    return _Beside(
        chunk.unit,
        given.marks if marks is None else marks,
        given.time if chunk.time is None else chunk.time,
        given.tare if chunk.tare is None else chunk.tare,
    )


class Pipeline:
    """From frames of counts to loads in newtons: screen, converter, inverse of the circuit, load law, spread.

    Frames are a stream: the inverse of each begins with the answer before it, the screen learns the baseline as it goes, and a
    load law with creep remembers. A call of more than 32 frames is shared out to all cores, in blocks that begin anew, so that its
    results do not hang on how many cores there are. Other threads of Python run meanwhile; Ctrl-C ends a call.

    Parameters
    ----------
    sensor : Sensor, str, path or dict
        The sensor, or what ``Sensor`` makes one of.
    method : str
        How loads are found: ``auto`` (what suits the read-out), ``exact``, ``newton``, ``raw`` (no compensation), or the file of a
        model that ``taxel train`` wrote.
    repair : bool, optional
        Replace what was not measured by the median of its neighbours, and mark it interpolated; as the sensor file says where it
        is left out.

    Raises
    ------
    taxel.SensorError
        The sensor file lacks what the method needs, which ``taxel.calibrate`` finds.

    Examples
    --------
    >>> import taxel
    >>> grip = taxel.simulate("econe", pattern="blobs", frames=3, seed=1)
    >>> pipeline = taxel.Pipeline("econe")
    >>> result = pipeline.process(grip.counts)
    >>> result.loads.shape
    (3, 64, 128)
    >>> bool(abs(result.loads.sum() / grip.loads.sum() - 1) < 0.01)
    True
    """

    def __init__(self, sensor: Any, method: str = "auto", repair: bool | None = None) -> None:
        self._inner = Compiled(sensor_of(sensor), method, repair)

    @property
    def sensor(self) -> Sensor:
        """The sensor."""
        return self._inner.sensor

    @property
    def method(self) -> str:
        """How loads are found."""
        return self._inner.method

    def __repr__(self) -> str:
        return f"taxel.Pipeline({self.sensor!r}, method={self.method!r})"

    def __reduce__(self) -> tuple[type[Pipeline], tuple[Sensor, str, bool | None]]:
        """Pickled without its stream: the copy begins anew, with the lines that the sensor file declares."""
        return type(self), (self.sensor, self.method, self._inner.repair)

    def reset(self) -> None:
        """Forgets the frames before: the next one is the first."""
        self._inner.reset()

    def look_for_faults(self, frames: ArrayLike | Recording) -> list[str]:
        """Looks for dead, shorted and flickering lines in all frames together; what it finds holds from then on.

        Parameters
        ----------
        frames : array of frames × rows × columns, or Recording
            Counts.

        Returns
        -------
        list of str
            Each fault in words.

        Raises
        ------
        taxel.ArrayError
            Frames as ``process`` does not take them.
        KeyboardInterrupt
            Ctrl-C ends it; what was known of faults stays.
        """
        counts = frames.counts if isinstance(frames, Recording) else frames
        return self._inner.look_for_faults(frames_of(counts)[0])

    def process(
        self,
        frames: ArrayLike | Recording,
        *,
        unit: Unit = "counts",
        marks: ArrayLike | None = None,
        time: ArrayLike | None = None,
        tare: ArrayLike | None = None,
        dtype: DTypeLike = np.float64,
        siemens: bool = False,
        standard_errors: bool = False,
        figures: bool = True,
        threads: int | None = None,
    ) -> Result:
        """Loads of frames.

        Parameters
        ----------
        frames : array of frames × rows × columns, or of rows × columns, or Recording
            Counts, of any type of number; means of several readings may have fractions.
        unit : {"counts", "volts", "siemens"}
            What the numbers are. A recording knows it itself.
        marks : array of the same shape, optional
            Codes of ``taxel.MARKS`` of what is known to be wrong; 0 is good. For a recording without marks of its own.
        time : array, optional
            Seconds, one a frame: what a load law with creep needs. For a recording without times of its own.
        tare : array of rows × columns, or of frames × rows × columns, optional
            Newtons to take off each load. For a recording without a tare of its own.
        dtype : {numpy.float64, numpy.float32}
            Type of the results; the work is done in float64.
        siemens : bool
            Return conductances as well.
        standard_errors : bool
            Return standard errors as well, and half of the 95 % intervals of figures. Takes several times as long. Beyond the
            noise of the readings they know what a calibration has told; without one, ``taxel.NoiseOnlyWarning`` says so.
        figures : bool
            Return figures over time.
        threads : int, optional
            How many cores; all without it.

        Returns
        -------
        Result
            Loads in newtons, marks, and what else was asked for, in the shape of the frames.

        Raises
        ------
        taxel.ArrayError
            Frames of another shape or type, masked, NaN, negative counts, counts above the converter's largest: which frame and
            taxel. Frames before it are part of the stream then; ``reset`` forgets them.
        taxel.Error
            Another unit; standard errors by a method without an inverse; fewer threads than 1; marks, times or a tare for a
            recording that has its own.
        MemoryError
            The result does not fit: ``stream`` goes through a recording in constant memory.
        KeyboardInterrupt
            Ctrl-C ends it at the next frame.
        """
        wanted = _Wanted(dtype, siemens, standard_errors, figures, threads)
        self._warn_of_noise_only(wanted)
        beside = _Beside(unit, marks, time, tare)
        if isinstance(frames, Recording):
            chunk = frames.load()
            return self._process(chunk.values, _beside_own(frames, chunk, beside), wanted)
        return self._process(frames, beside, wanted)

    def stream(
        self,
        frames: Recording | Iterable[ArrayLike],
        *,
        chunk: int = 256,
        dtype: DTypeLike = np.float64,
        siemens: bool = False,
        standard_errors: bool = False,
        figures: bool = True,
        threads: int | None = None,
    ) -> Iterator[Result]:
        """Goes through a recording in constant memory, some frames at a time.

        Parameters
        ----------
        frames : Recording, or iterable of arrays
            A recording, or arrays of counts as they come.
        chunk : int
            Frames of a recording at a time.
        dtype, siemens, standard_errors, figures, threads
            As of ``process``.

        Yields
        ------
        Result
            Of each piece: loads in newtons, marks, figures.

        Raises
        ------
        taxel.FileError
            What is wrong in the recording, once it is come to: frame, line, both numbers.
        taxel.ArrayError, taxel.Error, KeyboardInterrupt
            As of ``process``.
        """
        wanted = _Wanted(dtype, siemens, standard_errors, figures, threads)
        self._warn_of_noise_only(wanted)
        if isinstance(frames, Recording):
            for piece in frames.chunks(chunk):
                yield self._process(piece.values, _Beside(piece.unit, piece.marks, piece.time, piece.tare), wanted)
            return
        for array in frames:
            yield self._process(array, _Beside(), wanted)

    def _warn_of_noise_only(self, wanted: _Wanted) -> None:
        if wanted.standard_errors and not self.sensor.has_uncertainty:
            warnings.warn(
                "noise only: the sensor has no [uncertainty], which taxel.calibrate finds, so that standard errors are too small",
                NoiseOnlyWarning,
                # Whoever called the method that warns.
                stacklevel=3,
            )

    def _process(self, frames: ArrayLike, beside: _Beside, wanted: _Wanted) -> Result:
        array, is_one = frames_of(frames)
        single = np.dtype(wanted.dtype)
        if single not in (np.dtype(np.float32), np.dtype(np.float64)):
            raise ArrayError(f"dtype {single}, but results are float64 or float32")
        if wanted.threads is not None and wanted.threads < 1:
            raise Error(f"threads {wanted.threads}, but 1 or more are needed")
        times = times_of(beside.time, len(array))
        found = self._inner.process(
            array,
            beside.unit,
            single=single == np.dtype(np.float32),
            siemens=wanted.siemens,
            standard_errors=wanted.standard_errors,
            figures=wanted.figures,
            marks=codes_of(beside.marks, array.shape),
            time=times,
            tare=tare_of(beside.tare, array.shape),
            threads=wanted.threads,
        )
        return self._result(found, array.shape[1:] if is_one else array.shape, times)

    def _result(self, found: dict[str, Any], shape: tuple[int, ...], time: NDArray[np.float64] | None) -> Result:
        def shaped(name: str) -> NDArray[Any] | None:
            return found[name].reshape(shape) if name in found else None

        columns: dict[str, NDArray[Any]] = {"time_s": time} if time is not None else {}
        columns.update(found.get("figures", {}))
        return Result(
            sensor=self.sensor,
            loads=shaped("loads"),
            marks=found["marks"].reshape(shape),
            siemens=shaped("siemens"),
            standard_errors=shaped("standard_errors"),
            noise_counts=found["noise_counts"],
            half_width_factor=found["factor_95"],
            answered=found["answered"],
            rounds=found["rounds"],
            residuals=found["residuals"],
            time=time,
            figures=Table(columns),
        )
