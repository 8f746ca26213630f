"""Pictures by ``matplotlib`` that look like the command's: inferno, axes in mm, marked taxels outlined, hatched and counted."""

# matplotlib leaves some of its own types open.
# pyright: reportUnknownMemberType=false

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import ArrayError, Error
from ._result import Result
from ._taxel import MARKS, Sensor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OUTLINE = "#00e5ff"
_NOT_OUTLINED = (MARKS["good"], MARKS["absent"])


def heatmap(
    values: ArrayLike | Result,
    sensor: Sensor | None = None,
    *,
    frame: int | None = None,
    label: str = "Load (N)",
    most: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """A frame as a picture: loads in colours, lengths in mm; absent taxels are left white, untrusted ones outlined, hatched and counted.

    Where the sensor file tells where each taxel lies, it is drawn there.

    Parameters
    ----------
    values : array of rows × columns, or Result
        What to show.
    sensor : Sensor, optional
        Gives the lengths; a result brings its own.
    frame : int, optional
        Which frame of a result; the heaviest without it.
    label : str
        What the colours are.
    most : float, optional
        The value of the brightest colour: the same for pictures that are to be compared.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        What was drawn on.

    Raises
    ------
    taxel.ArrayError
        No array of rows × columns; another shape than the sensor's; a result without frames.
    IndexError
        A frame that the result does not have.
    """
    import matplotlib.pyplot as plt

    marks = None
    if isinstance(values, Result):
        sensor, shown, marks = values.sensor, *_frame_of(values, frame)
        label = label if values.loads is not None else "Conductance (S)"
    else:
        shown = np.asarray(values, dtype=np.float64)
    if shown.ndim != 2 or shown.size == 0:
        raise ArrayError(f"a picture of an array of shape {shown.shape}, but rows × columns of one frame are needed")
    if sensor is not None:
        if shown.shape != sensor.shape:
            raise ArrayError(f"a picture of {shown.shape[0]} × {shown.shape[1]} numbers, but the sensor has {sensor.rows} × {sensor.columns} taxels")
        shown = np.where(sensor.populated, shown, np.nan)
    is_marked = np.zeros(shown.shape, np.bool_) if marks is None else ~np.isin(marks, _NOT_OUTLINED)
    cells = _Cells.of(sensor, shown.shape)
    if ax is None:
        # As high as the array is beside its colour bar.
        left, right, bottom, top = cells.extent
        height = 4.6 * (bottom - top) / (right - left) + 1.0
        _, ax = plt.subplots(layout="constrained", figsize=(6.4, min(max(height, 2.2), 9.0)))
    brightest = most if most is not None else float(np.nanmax(shown, initial=0.0))
    picture = cells.draw(ax, shown, is_marked)
    picture.set_clim(0.0, brightest if brightest > 0.0 else 1.0)
    unit = "(mm)" if sensor is not None else "(taxels)"
    told = "" if marks is None else _counted(marks)
    ax.set_xlabel(f"Across the columns {unit}" + (f"\nhatched: {told}" if told else ""))
    ax.set_ylabel(f"Down the rows {unit}")
    # As high as the picture, whatever its shape is.
    beside = ax.inset_axes((1.03, 0.0, 0.035, 1.0))
    ax.figure.colorbar(picture, cax=beside, label=label)
    return ax


def over_time(result: Result, *, ax: Axes | None = None) -> Axes:
    """Total force over time, with its 95 % interval where the result has standard errors.

    Parameters
    ----------
    result : Result
        With its figures.
    ax : matplotlib.axes.Axes, optional
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        What was drawn on.

    Raises
    ------
    taxel.Error
        A result without figures.
    """
    import matplotlib.pyplot as plt

    if "force_newtons" not in result.figures:
        raise Error("the result has no figures\nhint: process(…, figures=True), by a sensor with a load law")
    if ax is None:
        _, ax = plt.subplots(layout="constrained")
    force = result.figures["force_newtons"]
    time = result.figures.get("time_s")
    x = np.arange(len(force)) if time is None else time
    ax.plot(x, force, color="#5b2a86")
    if "force_half_width_newtons" in result.figures:
        half = result.figures["force_half_width_newtons"]
        ax.fill_between(x, force - half, force + half, color="#5b2a86", alpha=0.25, linewidth=0, label="95 % interval")
        ax.legend(frameon=False)
    ax.set_xlabel("Frame" if time is None else "Time (s)")
    ax.set_ylabel("Total force (N)")
    # From nothing on: half a force is to look like half of it.
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]) if force.size and np.nanmin(force) < 0.0 else 0.0)
    return ax


def show_png(png: bytes) -> Figure:
    """A picture of the command's on a figure of its own size.

    Parameters
    ----------
    png : bytes
        What stands in a ``.png`` file.

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib.pyplot as plt

    image = plt.imread(io.BytesIO(png))
    height, width = image.shape[:2]
    figure = plt.figure(figsize=(width / 200.0, height / 200.0), dpi=200)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.imshow(image)
    axes.set_axis_off()
    return figure


def _frame_of(result: Result, frame: int | None) -> tuple[Any, Any]:
    values = result.loads if result.loads is not None else result.siemens
    assert values is not None, "a result has loads or conductances"
    if values.ndim == 2:
        return values, result.marks
    if len(values) == 0:
        raise ArrayError("a picture of a result without frames")
    if frame is None:
        frame = int(np.argmax(values.sum(axis=(1, 2))))
    return values[frame], result.marks[frame]


def _counted(marks: NDArray[Any]) -> str:
    """``24 open, 3 saturated``; nothing where every taxel is good."""
    counts = ((word, int(np.count_nonzero(marks == code))) for word, code in MARKS.items() if code not in _NOT_OUTLINED)
    return ", ".join(f"{count} {word}" for word, count in counts if count)


@dataclass(frozen=True)
class _Cells:
    """Where taxels are drawn: in the grid of their lines, or each where it lies."""

    centres: NDArray[np.float64]
    """Rows × columns × (x, y), mm."""
    down: float
    across: float
    is_grid: bool

    @classmethod
    def of(cls, sensor: Sensor | None, shape: tuple[int, ...]) -> _Cells:
        down, across = sensor.pitch_mm if sensor is not None else (1.0, 1.0)
        rows, columns = shape
        positions = None if sensor is None else sensor.positions_mm
        if sensor is None or positions is None:
            grid: NDArray[np.float64] = np.empty((rows, columns, 2))
            grid[:, :, 0], grid[:, :, 1] = across * np.arange(columns), down * np.arange(rows)[:, None]
            return cls(grid, down, across, True)
        places: NDArray[np.float64] = np.full((rows, columns, 2), np.nan)
        places[sensor.populated] = positions.reshape(rows, columns, 2)[sensor.populated]
        # At least half as wide as they are apart, where the pitch says less: as the command draws them.
        wide, high = np.nanmax(places, axis=(0, 1)) - np.nanmin(places, axis=(0, 1))
        apart = 0.5 * float(np.sqrt(wide * high / max(np.count_nonzero(sensor.populated), 1)))
        return cls(places, max(down, apart), max(across, apart), False)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of all that is drawn, mm."""
        half = np.array([self.across, self.down]) / 2.0
        left, top = np.nanmin(self.centres, axis=(0, 1)) - half
        right, bottom = np.nanmax(self.centres, axis=(0, 1)) + half
        return float(left), float(right), float(bottom), float(top)

    def draw(self, ax: Axes, shown: NDArray[np.float64], is_marked: NDArray[np.bool_]) -> Any:
        from matplotlib.collections import PatchCollection

        picture: Any
        if self.is_grid:
            picture = ax.imshow(shown, cmap="inferno", extent=self.extent, interpolation="nearest")
        else:
            is_there = np.isfinite(shown) & np.isfinite(self.centres[:, :, 0])
            picture = PatchCollection(self._squares(is_there), cmap="inferno", edgecolor="none")
            picture.set_array(shown[is_there])
            ax.add_collection(picture)
            ax.set_aspect("equal")
            ax.axis(self.extent)
        if is_marked.any():
            hatched = PatchCollection(self._squares(is_marked), facecolor="none", edgecolor=_OUTLINE, linewidth=0.6, hatch="////")
            ax.add_collection(hatched)
        return picture

    def _squares(self, which: NDArray[np.bool_]) -> list[Any]:
        from matplotlib.patches import Rectangle

        corners = self.centres[which] - np.array([self.across, self.down]) / 2.0
        return [Rectangle((x, y), self.across, self.down) for x, y in corners]
