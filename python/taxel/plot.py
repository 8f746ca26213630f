"""Pictures by ``matplotlib`` that look like the command's: inferno, axes in mm, marks outlined."""

# matplotlib leaves some of its own types open.
# pyright: reportUnknownMemberType=false

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ._result import Result
from ._taxel import Sensor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def heatmap(
    values: ArrayLike | Result,
    sensor: Sensor | None = None,
    *,
    frame: int | None = None,
    label: str = "Load (N)",
    most: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """A frame as a picture: loads in colours, lengths in mm; absent taxels are left white, untrusted ones outlined.

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
    """
    import matplotlib.pyplot as plt

    marks = None
    if isinstance(values, Result):
        sensor, shown, marks = values.sensor, *_frame_of(values, frame)
        label = label if values.loads is not None else "Conductance (S)"
    else:
        shown = np.asarray(values, dtype=np.float64)
    down, across = sensor.pitch_mm if sensor is not None else (1.0, 1.0)
    rows, columns = shown.shape
    if sensor is not None:
        shown = np.where(sensor.populated, shown, np.nan)
    if ax is None:
        # As high as the array is beside its colour bar.
        height = 4.6 * rows * down / (columns * across) + 1.0
        _, ax = plt.subplots(layout="constrained", figsize=(6.4, min(max(height, 2.2), 9.0)))
    top = most if most is not None else float(np.nanmax(shown, initial=0.0))
    picture = ax.imshow(
        shown,
        cmap="inferno",
        vmin=0.0,
        vmax=top if top > 0.0 else 1.0,
        extent=(-0.5 * across, (columns - 0.5) * across, (rows - 0.5) * down, -0.5 * down),
        interpolation="nearest",
    )
    if marks is not None:
        _outline(ax, (marks != 0) & (marks != 10), down, across)
    unit = "(mm)" if sensor is not None else "(taxels)"
    ax.set_xlabel(f"Across the columns {unit}")
    ax.set_ylabel(f"Down the rows {unit}")
    # As high as the picture, whatever its shape is.
    beside = ax.inset_axes((1.03, 0.0, 0.035, 1.0))
    ax.figure.colorbar(picture, cax=beside, label=label)
    return ax


def over_time(result: Result, *, ax: Axes | None = None) -> Axes:
    """Total force over time, with its 95 % interval where the result has standard errors."""
    import matplotlib.pyplot as plt

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
    """A picture of the command's on a figure of its own size."""
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
    if frame is None:
        frame = int(np.argmax(values.sum(axis=(1, 2))))
    return values[frame], result.marks[frame]


def _outline(ax: Axes, is_marked: Any, down: float, across: float) -> None:
    """A thin line around every patch of marked taxels."""
    from matplotlib.collections import LineCollection

    padded = np.pad(is_marked, 1)
    lines: list[list[tuple[float, float]]] = []
    for row, column in np.argwhere(padded[1:] != padded[:-1]):
        y = (row - 0.5) * down
        lines.append([((column - 1.5) * across, y), ((column - 0.5) * across, y)])
    for row, column in np.argwhere(padded[:, 1:] != padded[:, :-1]):
        x = (column - 0.5) * across
        lines.append([(x, (row - 1.5) * down), (x, (row - 0.5) * down)])
    ax.add_collection(LineCollection(lines, colors="#35d0ff", linewidths=0.8))
