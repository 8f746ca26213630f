"""Pictures by matplotlib."""

from __future__ import annotations

import matplotlib
import numpy as np
import pytest

import taxel

matplotlib.use("Agg")


def test_a_result_becomes_a_picture(grip: taxel.Simulation, insole: taxel.Sensor) -> None:
    result = taxel.Pipeline("econe").process(grip.counts, standard_errors=True, time=np.arange(20.0))
    axes = taxel.plot.heatmap(result)
    assert axes.get_xlabel() == "Across the columns (mm)" and axes.images[0].get_cmap().name == "inferno"
    lines = taxel.plot.over_time(result)
    assert lines.get_xlabel() == "Time (s)" and len(lines.collections) == 1
    pressed = taxel.simulate(insole, pattern="blobs", frames=2)
    absent = taxel.plot.heatmap(taxel.Pipeline(insole).process(pressed.counts), frame=1).images[0].get_array()
    assert absent is not None and np.ma.getmaskarray(np.ma.masked_invalid(absent))[0, 0]
    with pytest.raises(IndexError):
        taxel.plot.heatmap(result, frame=20)
