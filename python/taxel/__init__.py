"""Taxel: a cheap resistive pressure-sensor matrix as a calibrated pressure camera.

From raw frames to newtons on every taxel, with the cross-talk removed, and how far to trust each number:

>>> import taxel
>>> grip = taxel.simulate("econe", pattern="hand", frames=100)      # or taxel.read("grip.mcap")
>>> result = taxel.Pipeline("econe").process(grip.counts)
>>> result.loads.shape
(100, 64, 128)
>>> result.figures["force_newtons"].shape
(100,)

In reading order: ``Sensor`` says what the sensor is, ``read`` opens a recording, ``calibrate`` finds what the parts list does not
say, ``Pipeline`` makes loads of frames, ``live`` does it as they come; ``scan`` and ``solve`` are the circuit both ways;
``simulate``, ``identify``, ``evaluate`` and ``report`` go with them; ``measure`` finds forces over time, ``map`` works through an
archive, ``taxel.ray`` on a cluster; ``taxel.lsl`` streams frames over a network; ``taxel.plot`` draws.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from ._batch import map
from ._calibrate import Calibration, Presses, calibrate
from ._circuit import Simulation, evaluate, identify, report, scan, simulate, solve
from ._errors import ArrayError, Error, FileError, NoiseOnlyWarning, SensorError
from ._live import Live, LiveFrame, live
from ._measure import Measurement, measure
from ._pipeline import Pipeline
from ._recording import Chunk, Recording, read
from ._result import Result
from ._table import Table
from ._taxel import MARKS, Sensor, __version__, presets

if TYPE_CHECKING:
    from . import lsl, plot

__all__ = [
    "MARKS",
    "ArrayError",
    "Calibration",
    "Chunk",
    "Error",
    "FileError",
    "Live",
    "LiveFrame",
    "Measurement",
    "NoiseOnlyWarning",
    "Pipeline",
    "Presses",
    "Recording",
    "Result",
    "Sensor",
    "SensorError",
    "Simulation",
    "Table",
    "__version__",
    "calibrate",
    "evaluate",
    "identify",
    "live",
    "lsl",
    "map",
    "measure",
    "plot",
    "presets",
    "read",
    "report",
    "scan",
    "simulate",
    "solve",
]


def __getattr__(name: str) -> object:
    # Imported where they are used: most programs need neither.
    if name in ("lsl", "plot"):
        return import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
