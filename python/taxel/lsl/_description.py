"""What a stream of the lab streaming layer says of itself, and the library behind it."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._errors import ArrayError, Error
from .._taxel import MARKS, Sensor, __version__

_MARKS_PREFIX = "marks "
_MOST_BUFFERED_BYTES = 256e6


def pylsl() -> Any:
    """The library, loaded when it is first needed: it tells none of its types."""
    try:
        return import_module("pylsl")
    except ModuleNotFoundError as error:
        raise Error(f"taxel.lsl needs {error.name}, which is not installed\nhint: pip install pylsl") from None
    except (ImportError, OSError, RuntimeError) as error:
        first = str(error).splitlines()[0]
        raise Error(
            f"pylsl is here, but its library liblsl cannot be loaded: {first}\n"
            "hint: pip install --force-reinstall pylsl brings one; PYLSL_LIB names another"
        ) from None


def clock() -> float:
    """Seconds of this machine's LSL clock, which time stamps are told in."""
    return float(pylsl().local_clock())


def buffered_secs(channels: int, rate: float) -> int:
    """How much may wait for a slow receiver: six minutes, less where that were more than 256 MB. Without a rate hundreds of frames."""
    frames = _MOST_BUFFERED_BYTES / (4.0 * channels)
    return max(1, min(360, int(frames / rate if rate > 0.0 else frames / 100.0)))


def describe(info: Any, sensor: Sensor | None, shape: tuple[int, int], unit: str) -> None:
    """Writes into a stream's description what its frames are: XDF's conventions for channels and raw video, and the sensor file."""
    desc = info.desc()
    rows, columns = shape
    encoding = desc.append_child("encoding")
    for key, value in (("width", columns), ("height", rows), ("color_channels", 1), ("color_format", "GRAY"), ("codec", "RAW")):
        encoding.append_child_value(key, str(value))
    acquisition = desc.append_child("acquisition")
    acquisition.append_child_value("manufacturer", "Taxel")
    if sensor is not None:
        acquisition.append_child_value("model", sensor.name)
    # Frames that a slow program was too late for are gaps in time: no reader is to draw its time stamps out evenly.
    desc.append_child("synchronization").append_child_value("can_drop_samples", "true")
    places = None if sensor is None else places_mm(sensor)
    there = np.ones(rows * columns, np.bool_) if sensor is None else sensor.populated.ravel()
    channels = desc.append_child("channels")
    for taxel in range(rows * columns):
        channel = channels.append_child("channel")
        channel.append_child_value("label", f"r{taxel // columns}c{taxel % columns}")
        channel.append_child_value("unit", unit)
        channel.append_child_value("type", "Pressure")
        if places is not None:
            location = channel.append_child("location")
            location.append_child_value("X", f"{places[taxel, 0]:g}")
            location.append_child_value("Y", f"{places[taxel, 1]:g}")
        if not there[taxel]:
            channel.append_child_value("absent", "true")
    own = desc.append_child("taxel")
    own.append_child_value("version", __version__)
    if sensor is not None:
        own.append_child_value("sensor", sensor.to_toml())


def places_mm(sensor: Sensor) -> NDArray[np.float64]:
    """Where each taxel lies, mm: taxels × 2 (x across the columns, y down the rows)."""
    if sensor.positions_mm is not None:
        return sensor.positions_mm
    down, across = sensor.pitch_mm
    row, column = np.divmod(np.arange(sensor.rows * sensor.columns), sensor.columns)
    return np.column_stack((across * column, down * row))


@dataclass(frozen=True)
class Description:
    """What a stream's description says of its frames, as far as it does."""

    shape: tuple[int, int] | None
    unit: str | None
    labels: list[str] | None
    positions_mm: NDArray[np.float64] | None
    sensor: Sensor | None


def read_description(xml: str) -> Description:
    """Reads what ``describe`` writes, or as much of it as another's stream has."""
    desc = ElementTree.fromstring(xml).find("desc")
    if desc is None:
        return Description(None, None, None, None, None)
    size = [desc.findtext(f"encoding/{key}", "") for key in ("height", "width")]
    channels = desc.findall("channels/channel")
    labels = [channel.findtext("label", "") for channel in channels]
    units = {channel.findtext("unit", "") for channel in channels}
    places = [[channel.findtext(f"location/{axis}", "nan") for axis in "XY"] for channel in channels]
    try:
        positions = np.array(places, np.float64).reshape(-1, 2)
    except ValueError:
        positions = np.full((1, 2), np.nan)
    toml = desc.findtext("taxel/sensor")
    return Description(
        shape=(int(size[0]), int(size[1])) if all(part.strip().isdecimal() for part in size) else None,
        unit=units.pop() or None if len(units) == 1 else None,
        labels=labels if any(labels) else None,
        positions_mm=positions if len(positions) and np.isfinite(positions).all() else None,
        sensor=Sensor.from_toml(toml) if toml else None,
    )


def text_of_marks(codes: NDArray[np.uint8]) -> str:
    """Marks of a frame as a marker: the word ``marks``, then the taxels of each in JSON."""
    told: dict[str, list[str]] = {}
    words = {code: word for word, code in MARKS.items()}
    for row, column in np.argwhere(codes):
        told.setdefault(words.get(int(codes[row, column]), "unknown"), []).append(f"r{row}c{column}")
    return _MARKS_PREFIX + json.dumps(told)


def marks_of(text: str, shape: tuple[int, int]) -> NDArray[np.uint8] | None:
    """Codes of ``taxel.MARKS`` that a marker tells of, rows × columns; None where the marker is about something else.

    Parameters
    ----------
    text : str
        A marker, as of ``Markers.read``. Its marks hold until the next such marker.
    shape : (int, int)
        Rows and columns.

    Returns
    -------
    array of rows × columns, uint8, or None

    Raises
    ------
    taxel.ArrayError
        A mark of a taxel that is not in this shape, or of a word that is none of ``taxel.MARKS``.

    Examples
    --------
    >>> from taxel import lsl
    >>> lsl.marks_of('marks {"saturated": ["r0c1"]}', (2, 2))
    array([[0, 2],
           [0, 0]], dtype=uint8)
    """
    if not text.startswith(_MARKS_PREFIX):
        return None
    codes = np.zeros(shape, np.uint8)
    try:
        told: dict[str, list[str]] = json.loads(text.removeprefix(_MARKS_PREFIX))
        for word, labels in told.items():
            for label in labels:
                row, column = label.removeprefix("r").split("c")
                codes[int(row), int(column)] = MARKS[word]
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise ArrayError(f"marker {text[:80]!r} for frames of {shape[0]} × {shape[1]} taxels: {error}") from None
    return codes


def checked_shape(sensor: Sensor | None, shape: ArrayLike | None) -> tuple[int, int]:
    """Rows and columns, from the sensor or as they were given."""
    if shape is None:
        if sensor is None:
            raise Error("neither a sensor nor a shape\nhint: shape=(rows, columns)")
        return sensor.shape
    given = tuple(int(part) for part in np.atleast_1d(shape))
    if len(given) != 2 or min(given) < 1:
        raise ArrayError(f"shape {given}\nhint: shape=(rows, columns)")
    if sensor is not None and given != sensor.shape:
        raise ArrayError(f"shape {given}, but the sensor {sensor.name} has {sensor.shape}")
    return given[0], given[1]
