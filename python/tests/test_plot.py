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
    with pytest.raises(taxel.Error, match="no figures"):
        taxel.plot.over_time(taxel.Pipeline("econe").process(grip.counts, figures=False))
    with pytest.raises(taxel.ArrayError, match="10 × 10 numbers, but the sensor has 64 × 128"):
        taxel.plot.heatmap(np.zeros((10, 10)), result.sensor)


def test_marked_taxels_are_hatched_and_counted(grip: taxel.Simulation) -> None:
    marks = np.zeros(grip.counts.shape, np.uint8)
    marks[:, 5, 7:9], marks[:, 9, 9] = taxel.MARKS["stuck"], taxel.MARKS["open"]
    axes = taxel.plot.heatmap(taxel.Pipeline("econe").process(grip.counts, marks=marks), frame=3)
    assert axes.get_xlabel() == "Across the columns (mm)\nhatched: 1 open, 2 stuck"
    (hatched,) = axes.collections
    assert len(hatched.get_paths()) == 3 and hatched.get_hatch()
    assert hatched.get_paths()[0].get_extents().bounds == (13.0, 9.0, 2.0, 2.0)


def test_taxels_are_drawn_where_they_lie() -> None:
    tables = taxel.Sensor("mat-16x16-cd4067").to_dict()
    row, column = np.divmod(np.arange(256), 16)
    there = np.arange(256) < 250
    places = np.stack([10.0 * column + 3.0 * row, 9.0 * row], axis=1)
    tables["array"]["population"] = there.reshape(16, 16).astype(int).tolist()
    tables["array"]["positions"] = np.column_stack([row, column, places])[there].tolist()
    pressed = taxel.simulate(tables, pattern="blobs", frames=1, seed=1)
    result = taxel.Pipeline(tables).process(pressed.counts)
    drawn = taxel.plot.heatmap(result).collections[0]
    assert len(drawn.get_paths()) == 250
    corners = np.array([path.get_extents().min for path in drawn.get_paths()])
    np.testing.assert_allclose(corners + 5.0, places[there])
    values = drawn.get_array()
    assert values is not None and result.loads is not None
    np.testing.assert_allclose(values, result.loads[0].reshape(-1)[there])
