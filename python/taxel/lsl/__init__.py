"""Frames by the lab streaming layer (LSL), and XDF files of its streams: ``pip install pylsl``.

>>> from taxel import lsl
>>> lsl.send(taxel.live("serial:/dev/ttyACM0", "mat.toml"))         # doctest: +SKIP
>>> lsl.record("trial.xdf", seconds=60)                             # doctest: +SKIP

A stream of frames has the type ``Pressure``, a channel a taxel (row by row, labels ``r0c0``, ``r0c1`` …), float32, and in its description
the unit, places in mm, width and height as XDF's conventions for raw video have it, and the whole sensor file under
``desc/taxel/sensor``. Beside it is a stream of type ``Markers``: what happened, and ``marks {…}``, which taxels are not to be trusted.
"""

from ._description import clock, marks_of
from ._inlet import Frames, Inlet, LostError, Markers, Stream, streams
from ._outlet import Outlet, send
from ._record import LostWarning, Recorded, record

__all__ = [
    "Frames",
    "Inlet",
    "LostError",
    "LostWarning",
    "Markers",
    "Outlet",
    "Recorded",
    "Stream",
    "clock",
    "marks_of",
    "record",
    "send",
    "streams",
]
