"""Forces over time are those of the command."""

import csv
import json

import numpy as np
import pytest

import taxel

REGIONS = """
[[region]]
name = "left half"
boxes = [[0, 31, 0, 15]]
"""


@pytest.fixture
def hand(tmp_path, command):
    """A recording of a hand on the 32 x 32 mat, with regions."""
    words = "simulate --sensor mat-32x32-adg732 --pattern hand --frames 160 --seed 4 -o"
    command(*words.split(), tmp_path / "hand.txt")
    (tmp_path / "regions.toml").write_text(REGIONS)
    return tmp_path


def test_the_numbers_are_those_of_the_command(hand, command):
    words = "--sensor mat-32x32-adg732 --frames-per-second 100 --json"
    files = ["--regions", hand / "regions.toml", "-o", hand / "f.csv"]
    told = json.loads(command("measure", hand / "hand.txt", *words.split(), *files))
    found = taxel.measure(
        hand / "hand.txt", sensor="mat-32x32-adg732", frames_per_second=100.0, regions=hand / "regions.toml"
    )
    assert found.is_whole and found.trials == told["trials"]
    with open(hand / "f.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(found.series)
    for name, values in found.series.items():
        written = np.array([float(row[name] or "nan") for row in rows])
        np.testing.assert_array_equal(values, written)
    whole, half = found.series["total_n"], found.series["left_half_n"]
    assert 0 < half.max() < whole.max()


def test_what_cannot_be_measured_is_said(hand):
    with pytest.raises(taxel.Error, match="must be force, marks, whole"):
        taxel.measure(hand / "hand.txt", sensor="mat-32x32-adg732", trials="grips")
    with pytest.raises(taxel.Error, match="plateau is 0"):
        taxel.measure(hand / "hand.txt", sensor="mat-32x32-adg732", plateau=0.0)
    with pytest.raises(taxel.Error, match="regions.toml"):
        taxel.measure(hand / "hand.txt", sensor="mat-16x16-cd4067", regions=hand / "regions.toml")


def test_a_cone_has_smaller_taxels_where_it_is_narrow():
    text = taxel.Sensor("mat-32x32-adg732").to_toml()
    cone = text.replace("[readout]", '[array.geometry]\nshape = "cone"\nrings = "rows"\ndiameters_mm = [70.0, 35.0]\n\n[readout]', 1)
    cone = taxel.Sensor.from_toml(cone.replace("pitch_mm = [5.0, 5.0]", "pitch_mm = [6.0, 6.0]"))
    areas = cone.taxel_areas_mm2
    assert areas.shape == (32, 32)
    np.testing.assert_allclose(areas[-1] / areas[0], 0.5)
    result = taxel.Pipeline(cone).process(np.full((1, 32, 32), 60, dtype=np.uint16))
    np.testing.assert_allclose(result.kilopascals, 1000.0 * result.loads / areas)
