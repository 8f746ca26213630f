"""The compiled part. Its arrays are checked and shaped by the modules beside it."""

import os
from collections.abc import Callable
from typing import Any, Protocol, final

import numpy as np
from numpy.typing import NDArray

_Path = str | os.PathLike[str]

__version__: str
MARKS: dict[str, int]

def presets() -> list[str]:
    """The names of sensors that need no file."""

@final
class Sensor:
    """What a sensor is: its array, its read-out circuit, its converter, and, once calibrated, its load law.

    Parameters
    ----------
    source : str, path or dict
        A sensor file (``.toml``), the name of a preset (``taxel.presets()``), a recording that carries its sensor (``.mcap``,
        ``.parquet``), or a dict with the tables of a sensor file.

    Raises
    ------
    taxel.FileError
        No such file or preset.
    taxel.SensorError
        What it says cannot be: which key, its value, and what was expected.
    """

    def __new__(cls, source: _Path | dict[str, Any]) -> Sensor: ...
    @staticmethod
    def from_toml(text: str, file: _Path = "sensor.toml") -> Sensor:
        """A sensor from the text of a sensor file."""
    @staticmethod
    def from_dict(dict: dict[str, Any]) -> Sensor:
        """A sensor from the tables of a sensor file."""
    @staticmethod
    def carried_by(path: _Path) -> Sensor | None:
        """The sensor that a recording carries; None where it carries none."""
    def to_toml(self) -> str:
        """The text of its sensor file."""
    def to_dict(self) -> dict[str, Any]:
        """The tables of its sensor file."""
    def save(self, path: _Path) -> None:
        """Writes its sensor file; a file of that name is replaced."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def file(self) -> os.PathLike[str]:
        """Where it comes from: a file, or a preset's name."""
    @property
    def rows(self) -> int:
        """Sensed lines."""
    @property
    def columns(self) -> int:
        """Driven lines."""
    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
    @property
    def readout(self) -> str:
        """How the lines that are not selected end, in words."""
    @property
    def pitch_mm(self) -> tuple[float, float]:
        """From one taxel to the next, mm: down the rows and across the columns."""
    @property
    def taxel_area_mm2(self) -> float:
        """What a taxel's load is divided by for its pressure, mm²."""
    @property
    def taxel_areas_mm2(self) -> NDArray[np.float64]:
        """The same of every taxel, rows x columns: on a cone smaller where it is narrow."""
    @property
    def max_count(self) -> float:
        """The largest count that the converter gives."""
    @property
    def has_load_law(self) -> bool:
        """Whether it has a load law, so that frames become newtons."""
    @property
    def has_uncertainty(self) -> bool:
        """Whether it says how far its loads can be trusted beyond noise: a calibration has."""
    @property
    def populated(self) -> NDArray[np.bool_]:
        """Which crossings carry a taxel: bool, rows × columns."""
    @property
    def positions_mm(self) -> NDArray[np.float64] | None:
        """Where each taxel lies, mm, x and y: taxels × 2; None where the array is the regular grid of its pitch."""

class Pipeline:
    def __init__(self, sensor: Sensor, method: str = "auto", repair: bool | None = None) -> None: ...
    @property
    def sensor(self) -> Sensor: ...
    @property
    def method(self) -> str: ...
    @property
    def repair(self) -> bool | None: ...
    def reset(self) -> None: ...
    def look_for_faults(self, frames: NDArray[Any]) -> list[str]: ...
    def process(
        self,
        frames: NDArray[Any],
        unit: str,
        *,
        single: bool,
        siemens: bool,
        standard_errors: bool,
        figures: bool,
        marks: NDArray[np.uint8] | None = None,
        time: NDArray[np.float64] | None = None,
        tare: NDArray[np.float64] | None = None,
        threads: int | None = None,
    ) -> dict[str, Any]: ...

class Batch:
    def __init__(
        self,
        folder: str,
        sensor: Sensor | None,
        *,
        method: str,
        loads: str,
        intervals: bool,
        pictures: bool,
        repair: bool | None,
        no_tare: bool,
        transpose: bool,
        with_names: bool,
    ) -> None: ...
    def run(
        self, recordings: list[str], threads: int | None = None, tables: bool = False
    ) -> list[tuple[str, bool]]: ...
    def check_names(self, recordings: list[str]) -> None: ...
    def write_tables(self, entries: list[str]) -> None: ...

def measure(
    recording: str,
    sensor: Sensor | None,
    *,
    regions: str | None,
    trials: str,
    trial_force: float | None,
    plateau: float,
    touched: float,
    intervals: bool,
    zero: tuple[float, float] | None,
    frames_per_second: float | None,
    method: str,
    repair: bool | None,
    no_tare: bool,
    transpose: bool,
    keep_going: bool,
    threads: int | None,
) -> tuple[list[tuple[str, NDArray[np.float64]]], str, str]: ...

class Reader:
    def __init__(self, path: _Path, sensor: Sensor | None, unit: str, transpose: bool, keep_going: bool) -> None: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    def read(self, most: int) -> dict[str, Any] | None: ...
    def skip(self, most: int) -> int: ...
    def events(self) -> list[dict[str, Any]]: ...
    def missing(self) -> list[str]: ...

class _Labelled(Protocol):
    @property
    def frames(self) -> NDArray[Any]: ...
    @property
    def frame(self) -> NDArray[np.int64]: ...
    @property
    def row(self) -> NDArray[np.int64]: ...
    @property
    def column(self) -> NDArray[np.int64]: ...
    @property
    def load_newtons(self) -> NDArray[np.float64]: ...
    @property
    def uniform_frames(self) -> NDArray[Any] | None: ...
    @property
    def uniform_newtons(self) -> NDArray[np.float64]: ...

class _Options(Protocol):
    @property
    def law(self) -> str: ...
    @property
    def per_line(self) -> bool: ...
    @property
    def fit_gain(self) -> bool: ...
    @property
    def fit_source(self) -> bool: ...
    @property
    def line_resistance(self) -> bool: ...
    @property
    def label_error(self) -> float: ...
    @property
    def folds(self) -> int: ...
    @property
    def date(self) -> str: ...
    @property
    def transpose(self) -> bool: ...

class Calibration:
    @property
    def sensor(self) -> Sensor: ...
    @property
    def report(self) -> dict[str, Any]: ...
    @property
    def residuals(self) -> dict[str, NDArray[Any]]: ...
    def picture(self, format: str) -> bytes: ...

def calibrate(
    sensor: Sensor,
    table: _Path | None,
    labelled: _Labelled | None,
    equilibration: _Path | None,
    options: _Options,
    progress: Callable[[str, float], object] | None,
) -> Calibration: ...

class Stream:
    def __init__(self, address: str, sensor: Sensor | None, method: str, queue: int, record: _Path | None) -> None: ...
    @property
    def sensor(self) -> Sensor: ...
    def next(self, timeout: float | None = None) -> dict[str, Any] | None: ...
    def has_ended(self) -> bool: ...
    def state(self) -> str: ...
    def statistics(self) -> dict[str, Any]: ...
    def close(self) -> None: ...

def scan(sensor: Sensor, siemens: NDArray[Any]) -> NDArray[np.float64]: ...
def solve(sensor: Sensor, volts: NDArray[Any], method: str) -> tuple[NDArray[np.float64], NDArray[np.bool_]]: ...

class _Drawing(Protocol):
    @property
    def pattern(self) -> str: ...
    @property
    def frames(self) -> int: ...
    @property
    def peak_newtons(self) -> float | None: ...
    @property
    def seed(self) -> int: ...
    @property
    def imperfect(self) -> bool: ...

def simulate(sensor: Sensor, loads: NDArray[Any] | None, drawing: _Drawing) -> dict[str, Any]: ...
def identify(
    recordings: list[_Path],
    sensor: Sensor | None,
    rows: int | None,
    equilibration: _Path | None,
    transpose: bool,
) -> dict[str, Any]: ...
def evaluate(plan: _Path) -> dict[str, Any]: ...
def report(plan: _Path, output: _Path) -> None: ...
