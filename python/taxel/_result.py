"""What frames come to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._taxel import MARKS, Sensor
from ._table import Table

if TYPE_CHECKING:
    import xarray

_UNMEASURED = [MARKS[word] for word in ("open", "stuck", "spike", "flickering", "interpolated", "absent")]


@dataclass(frozen=True, eq=False)
class Result:
    """Loads of frames, and how far to trust them.

    Arrays have the axes frames, rows, columns; of one frame that was given alone, rows and columns.
    """

    sensor: Sensor
    """The sensor that the frames are of."""
    loads: NDArray[Any] | None
    """Loads, newtons. Not cut off at zero: noise about unloaded taxels adds up to nothing. None without a load law."""
    marks: NDArray[np.uint8]
    """How far each number can be trusted: codes of ``taxel.MARKS``, 0 is good."""
    siemens: NDArray[Any] | None
    """Conductances with the cross-talk removed, siemens, where they were asked for or there are no loads."""
    standard_errors: NDArray[Any] | None
    """Standard error of each load, newtons (without a load law of each conductance, siemens); infinite where nothing bounds it."""
    noise_counts: float | None
    """Standard deviation of a reading that the standard errors are found with: of the sensor file, else of the frames themselves,
    else of rounding."""
    half_width_factor: float
    """Half of a load's 95 % interval over its standard error."""
    answered: NDArray[np.bool_]
    """Of each frame, whether the inverse came to one answer; where not, all that was measured is marked unresolved."""
    rounds: NDArray[np.uint32]
    """Rounds of the inverse, each frame."""
    residuals: NDArray[np.float64]
    """What the inverse leaves, a pure number, each frame."""
    time: NDArray[np.float64] | None
    """Time of each frame, seconds."""
    figures: Table
    """Figures over time, a row a frame: force, peak pressure, contact area, centre of pressure, share measured; with standard
    errors also half of their 95 % intervals."""

    @property
    def half_widths(self) -> NDArray[Any] | None:
        """Half of the 95 % interval of each number."""
        return None if self.standard_errors is None else self.half_width_factor * self.standard_errors

    @property
    def kilopascals(self) -> NDArray[Any] | None:
        """Mean pressure on each taxel's area, kPa."""
        return None if self.loads is None else self.loads / self.sensor.taxel_areas_mm2 * 1000.0

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Whether each number stands on a reading of its own."""
        return ~np.isin(self.marks, _UNMEASURED)

    def to_xarray(self) -> xarray.Dataset:
        """As an ``xarray.Dataset`` with coordinates in mm, frames by their time where it is known.

        Axes are ``y`` and ``x``; where the sensor file tells where each taxel lies, ``row`` and ``column``, and ``y`` and ``x`` are of
        every taxel (NaN where there is none).
        """
        import xarray

        down, across = self.sensor.pitch_mm
        rows, columns = self.sensor.shape
        positions = self.sensor.positions_mm
        units = {"units": "mm"}
        plane: tuple[str, str] = ("y", "x") if positions is None else ("row", "column")
        coordinates: dict[str, Any] = {}
        if positions is None:
            coordinates["y"] = ("y", down * np.arange(rows), units)
            coordinates["x"] = ("x", across * np.arange(columns), units)
        else:
            places = np.where(self.sensor.populated[:, :, None], positions.reshape(rows, columns, 2), np.nan)
            coordinates["y"] = (plane, places[:, :, 1], units)
            coordinates["x"] = (plane, places[:, :, 0], units)
        axes = ("frame", *plane)[3 - self.marks.ndim :]
        if self.time is not None and "frame" in axes:
            coordinates["time"] = ("frame", self.time, {"units": "s"})
        values: dict[str, Any] = {"marks": (axes, self.marks)}
        for name, array, unit in (
            ("loads", self.loads, "N"),
            ("siemens", self.siemens, "S"),
            ("standard_errors", self.standard_errors, "S" if self.loads is None else "N"),
        ):
            if array is not None:
                values[name] = (axes, array, {"units": unit})
        return xarray.Dataset(values, coordinates)

    def __repr__(self) -> str:
        frames = 1 if self.marks.ndim == 2 else len(self.marks)
        held = "loads in newtons" if self.loads is not None else "conductances in siemens"
        lost = int(np.size(self.answered) - np.count_nonzero(self.answered))
        unanswered = f"; {lost} without an answer" if lost else ""
        return f"<taxel.Result of {frames} frames of {self.sensor.name}: {held}{unanswered}>"
