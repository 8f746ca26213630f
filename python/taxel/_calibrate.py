"""From labelled presses to a calibrated sensor."""

from __future__ import annotations

import datetime
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import frames_of
from ._errors import ArrayError
from ._pipeline import sensor_of
from ._table import Table
from ._taxel import Calibration as Compiled
from ._taxel import Sensor
from ._taxel import calibrate as fit


@dataclass(frozen=True, eq=False)
class Presses:
    """Known loads on single taxels, in arrays.

    Parameters
    ----------
    frames : array of frames × rows × columns
        Counts.
    frame, row, column : arrays of whole numbers
        Of each press: its frame and its taxel, from 0.
    load_newtons : array
        Of each press: the load on that taxel, newtons.
    uniform_frames : array of frames × rows × columns, optional
        Counts under the same load on every taxel, which tell how taxels differ from each other.
    uniform_newtons : array, optional
        Of each of them: the load on every taxel, newtons.
    """

    frames: ArrayLike
    frame: ArrayLike
    row: ArrayLike
    column: ArrayLike
    load_newtons: ArrayLike
    uniform_frames: ArrayLike | None = None
    uniform_newtons: ArrayLike = ()


@dataclass(frozen=True)
class _Labelled:
    frames: Any
    frame: Any
    row: Any
    column: Any
    load_newtons: Any
    uniform_frames: Any
    uniform_newtons: Any


@dataclass(frozen=True)
class _Options:
    law: str
    per_line: bool
    fit_gain: bool
    fit_source: bool
    line_resistance: bool
    label_error: float
    folds: int
    date: str
    transpose: bool


class Calibration:
    """A fitted sensor, and how good the fit is.

    ``print(calibration)`` says what ``taxel calibrate`` says.
    """

    def __init__(self, inner: Compiled) -> None:
        self._inner = inner
        self.sensor: Sensor = inner.sensor
        """The sensor with the fitted numbers, their origin and their errors."""
        self.report: dict[str, Any] = inner.report
        """All that was found: ``parameters``, ``findings``, ``beliefs``, ``laws``, ``held_out_mean_absolute_g`` …"""

    @property
    def parameters(self) -> dict[str, tuple[float, float | None]]:
        """Each number of the sensor file that was fitted: its value and its standard error (None: held)."""
        return {p["name"]: (p["value"], p["standard_error"]) for p in self.report["parameters"]}

    @property
    def held_out_error_newtons(self) -> float | None:
        """Mean absolute error of presses that the fit did not see, newtons; None where no fit could be made without them."""
        grams = self.report["held_out_mean_absolute_g"]
        return None if grams is None else grams * 9.80665e-3

    @property
    def warnings(self) -> list[str]:
        """What to know before trusting the fit."""
        return self.report["warnings"]

    @property
    def doubts(self) -> list[str]:
        """Reasons not to use the fit as it is; none for a good one."""
        return self.report["doubts"]

    @property
    def residuals(self) -> Table:
        """What is read of each press beside its label, newtons; by fits without it where ``held_out``, then by the fit of all."""
        return Table(self._inner.residuals)

    def to_toml(self) -> str:
        """The text of the sensor file."""
        return self.sensor.to_toml()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the sensor file."""
        self.sensor.save(path)

    def picture(self, format: Literal["png", "svg"] = "png") -> bytes:
        """Residuals, how many their intervals hold, gain of each taxel and load law, as ``taxel calibrate --picture`` draws them."""
        return bytes(self._inner.picture(format))

    def plot(self) -> Any:
        """The picture on a ``matplotlib`` figure."""
        from .plot import show_png

        return show_png(self.picture("png"))

    def _repr_png_(self) -> bytes:
        return self.picture("png")

    def __str__(self) -> str:
        return str(self._inner)

    def __repr__(self) -> str:
        error = self.held_out_error_newtons
        judged = "nothing held out" if error is None else f"{error:.3g} N mean error on held-out presses"
        return f"<taxel.Calibration of {self.sensor.name}: {self.report['presses']} presses, law {self.report['law']}, {judged}>"


def calibrate(
    sensor: Any,
    presses: str | os.PathLike[str] | Presses,
    *,
    equilibration: str | os.PathLike[str] | None = None,
    law: Literal["auto", "power", "saturating", "spline"] = "auto",
    per_line: bool = False,
    fit_gain: bool = False,
    fit_source: bool = False,
    line_resistance: bool = False,
    label_error: float = 0.0,
    folds: int = 5,
    transpose: bool = False,
    date: str | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> Calibration:
    """Fits switch resistances, load law and what else there is to labelled presses.

    Parameters
    ----------
    sensor : Sensor, str, path or dict
        The parts list.
    presses : path or Presses
        A table with recording, frame, row, column (or taxel), load_g; or arrays.
    equilibration : path, optional
        A table of frames under the same load everywhere: recording, frame, load_g. With a table of presses alone; ``Presses`` has
        its own.
    law : {"auto", "power", "saturating", "spline"}
        The load law; ``auto`` takes the one with the least error on held-out presses.
    per_line : bool
        Fit one switch resistance a line, even without uniform loads.
    fit_gain, fit_source : bool
        Fit the amplifier's open-loop gain, the source resistor.
    line_resistance : bool
        Look for resistance along the lines on large arrays as well (minutes).
    label_error : float
        What the labelled loads themselves are off by, a share.
    folds : int
        Folds of the cross-validation by press.
    transpose : bool
        The recordings have rows and columns swapped.
    date : str, optional
        What the sensor file is to say, ISO 8601; today without it.
    progress : callable, optional
        Called with the name of the stage and the share done. What it raises goes to ``sys.unraisablehook``; the fit goes on.

    Returns
    -------
    Calibration
        The fitted sensor, what was found with its errors, residuals in newtons.

    Raises
    ------
    taxel.SensorError
        Too few presses, no circuit that explains them, a press where there is no taxel.
    taxel.FileError, taxel.ArrayError
        What is wrong in the table, the recordings or the arrays, and where.
    KeyboardInterrupt
        Ctrl-C ends it at the next step of the fit.
    """
    options = _Options(
        law=law,
        per_line=per_line,
        fit_gain=fit_gain,
        fit_source=fit_source,
        line_resistance=line_resistance,
        label_error=label_error,
        folds=folds,
        date=date or datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
        transpose=transpose,
    )
    known, table, labelled = sensor_of(sensor), None, None
    if isinstance(presses, Presses):
        if equilibration is not None or transpose:
            raise ArrayError(
                "a table of uniform loads and `transpose` go with a table of presses, not with arrays\n"
                "hint: Presses(…, uniform_frames=…, uniform_newtons=…)"
            )
        labelled = _labelled(presses)
    else:
        table = presses
    return Calibration(fit(known, table, labelled, equilibration, options, progress))


def _labelled(presses: Presses) -> _Labelled:
    def whole(name: str) -> Any:
        array = np.asarray(getattr(presses, name))
        if array.ndim != 1 or array.dtype.kind not in "ui":
            raise ArrayError(f"presses.{name}: shape {array.shape} and type {array.dtype}, but whole numbers in one axis are needed")
        return np.ascontiguousarray(array, dtype=np.int64)

    def real(name: str) -> Any:
        array = np.ascontiguousarray(getattr(presses, name), dtype=np.float64)
        if array.ndim != 1:
            raise ArrayError(f"presses.{name}: shape {array.shape}, but one axis is needed")
        return array

    uniform = presses.uniform_frames
    return _Labelled(
        frames_of(presses.frames)[0],
        whole("frame"),
        whole("row"),
        whole("column"),
        real("load_newtons"),
        None if uniform is None else frames_of(uniform, "uniform_frames")[0],
        real("uniform_newtons"),
    )
