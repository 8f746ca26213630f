"""What a sensor is, and what is said of one that cannot be."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import taxel


def test_a_preset_says_what_it_is(preset: str) -> None:
    sensor = taxel.Sensor(preset)
    assert sensor.shape == (sensor.rows, sensor.columns)
    assert sensor.has_load_law and not sensor.has_uncertainty
    text = repr(sensor)
    assert f"{sensor.rows} × {sensor.columns} taxels" in text and sensor.readout in text
    assert sensor.populated.shape == sensor.shape and sensor.populated.all()
    assert sensor.positions_mm is None


def test_text_dict_pickle_and_file_are_the_same_sensor(preset: str, tmp_path: Path) -> None:
    sensor = taxel.Sensor(preset)
    file = tmp_path / "sensor.toml"
    sensor.save(file)
    assert taxel.Sensor(file) == taxel.Sensor(str(file)) == sensor
    assert taxel.Sensor(sensor.to_dict()) == sensor
    assert taxel.Sensor.from_toml(sensor.to_toml()) == sensor
    assert pickle.loads(pickle.dumps(sensor)) == sensor
    assert hash(pickle.loads(pickle.dumps(sensor))) == hash(sensor)


def test_an_insole_says_where_its_taxels_are(insole: taxel.Sensor) -> None:
    assert insole.populated.sum() == 170
    assert not insole.populated[0, 0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"array": {"rows": 0}}, ["array.rows", "0"]),
        ({"readout": {"topology": "divider-flaoting"}}, ["divider-floating"]),
        ({"readout": {"v_test_volts": -1.0}}, ["readout.v_test_volts", "-1"]),
        ({"converter": {"bits": 99}}, ["converter.bits", "99"]),
    ],
)
def test_a_sensor_that_cannot_be_is_refused_in_words(change: dict[str, dict[str, object]], words: list[str]) -> None:
    tables = taxel.Sensor("mat-16x16-cd4067").to_dict()
    for table, keys in change.items():
        tables[table].update(keys)
    with pytest.raises(taxel.SensorError) as refused:
        taxel.Sensor(tables)
    assert isinstance(refused.value, ValueError)
    for word in words:
        assert word in str(refused.value)


def test_a_missing_file_is_an_error_of_files(tmp_path: Path) -> None:
    with pytest.raises(taxel.FileError) as refused:
        taxel.Sensor(tmp_path / "none.toml")
    assert isinstance(refused.value, OSError) and "none.toml" in str(refused.value)
    with pytest.raises(taxel.FileError, match="known: econe"):
        taxel.Sensor("ecomb")
    with pytest.raises(TypeError):
        taxel.Sensor(7)  # type: ignore[arg-type]


def test_errors_keep_message_and_hint_through_a_pickle() -> None:
    error = taxel.SensorError("what is wrong\nhint: what to do")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is taxel.SensorError
    assert (again.message, again.hint, str(again)) == ("what is wrong", "what to do", str(error))


def test_marks_have_the_codes_of_the_documents() -> None:
    assert taxel.MARKS["good"] == 0 and taxel.MARKS["absent"] == 10
    assert sorted(taxel.MARKS.values()) == list(range(len(taxel.MARKS)))
    assert np.uint8(max(taxel.MARKS.values())) == max(taxel.MARKS.values())
