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
