"""Files of other programs: read as recordings, their loads as they are."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import taxel

# Beside the tests where they run by themselves.
CUTS = next(folder for folder in [Path(__file__).parent / "exports", *(parent / "testdata" / "exports" for parent in Path(__file__).parents)] if folder.is_dir())


def test_a_tekscan_export_is_a_recording_with_its_sensor():
    recording = taxel.read(CUTS / "fscan.asf")
    assert recording.shape == (60, 21)
    assert recording.sensor is not None
    exported = recording.sensor.to_dict()["exported"]
    assert exported["unit"] == "KPa" and "6.33" in exported["program"]
    assert recording.counts.sum(axis=(1, 2)).tolist() == [35389, 35819, 34574]
    assert recording.time is not None and np.allclose(recording.time, [0, 0.032, 0.064])


@pytest.mark.parametrize(
    "name",
    ["emed.lst", "fscan.asf", "iscan.csv", "pedar.asc#left", "pedar.asc#right", "pliance.asc", "rsscan.txt", "xsensor.csv#left", "zebris.txt"],
)
def test_every_format_of_others_is_what_the_command_reads(name: str, command: Callable[..., str], tmp_path: Path):
    # It says how many frames it had before it was cut.
    is_cut = name.startswith("pedar")
    command("convert", f"{CUTS / name}", "-o", tmp_path / "by-command.npy", code=3 if is_cut else 0)
    recording = taxel.read(f"{CUTS / name}")
    wanted = np.load(tmp_path / "by-command.npy")
    assert len(wanted) > 1 and wanted.max() > 0.0
    np.testing.assert_array_equal(recording.values, wanted)
    np.testing.assert_array_equal(recording[1], wanted[1])
    assert len(recording) == len(wanted) and bool(recording.missing) == is_cut


def test_names_are_in_what_is_written_where_they_are_asked_for(tmp_path: Path):
    for names in (False, True):
        taxel.map(CUTS / "fscan.asf", tmp_path / str(names), with_names=names)
        (loads,) = (tmp_path / str(names)).rglob("*.loads.parquet")
        assert (b"FraserP10" in loads.read_bytes()) == names


def test_its_loads_are_pressure_times_area_and_nobody_knows_their_errors():
    recording = taxel.read(CUTS / "fscan.asf")
    pipeline = taxel.Pipeline(recording.sensor)
    totals = pipeline.process(recording).loads.sum(axis=(1, 2))
    assert np.allclose(totals, [913.2626896, 924.3594416, 892.2304736], atol=1e-9)
    with pytest.raises(taxel.Error, match="nothing tells how far to trust these loads"):
        pipeline.process(recording, standard_errors=True)


def test_one_sensor_of_several_and_raw_counts():
    with pytest.raises(taxel.Error, match="holds 2 sensors: left, right"):
        taxel.read(CUTS / "xsensor.csv")
    left = taxel.read(f"{CUTS / 'xsensor.csv'}#left")
    assert left.shape == (31, 11)
    raw = taxel.read(f"{CUTS / 'fscan.asf'}#raw")
    assert raw.counts.dtype == np.uint16 and raw.counts.max() == 78


def test_measured_beside_what_the_file_tells():
    measured = taxel.measure(CUTS / "emed.lst", trials="whole")
    table = measured.series
    assert np.allclose(table["total_n"], [817.375, 818.625, 816.625], atol=1e-9)
    assert np.allclose(table["reference_n"], [817.38, 818.63, 816.63])
