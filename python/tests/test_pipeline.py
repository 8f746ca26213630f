"""Loads: the command's, the truth's, and the same whatever the call looks like."""

from __future__ import annotations

import base64
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import taxel


def test_loads_are_those_that_pressed(preset: str) -> None:
    for seed in (1, 2, 3):
        pressed = taxel.simulate(preset, pattern="blobs", frames=12, seed=seed)
        with pytest.warns(taxel.NoiseOnlyWarning):
            result = taxel.Pipeline(preset).process(pressed.counts, standard_errors=True)
        assert result.noise_counts is not None and result.noise_counts > 0.29
        assert result.loads is not None and result.standard_errors is not None and result.answered.all()
        measured = np.isfinite(result.standard_errors)
        off = np.abs(result.loads - pressed.loads)[measured]
        # Noise alone: the sensor is the one that was drawn from.
        inside = off <= 1.96 * result.standard_errors[measured]
        assert 0.93 < inside.mean() <= 1.0


def test_it_says_what_the_command_says(grip: taxel.Simulation, command: Callable[..., str], tmp_path: Path) -> None:
    np.save(tmp_path / "counts.npy", grip.counts)
    command(
        "compensate", tmp_path / "counts.npy", "--sensor", "econe", "--unit", "N", "-o", tmp_path / "loads.npy", "--marks", tmp_path / "marks.npy",
        "--standard-error", tmp_path / "errors.npy", "--figures", tmp_path / "figures.csv",
    )  # fmt: skip
    pipeline = taxel.Pipeline("econe")
    assert pipeline.look_for_faults(grip.counts) == []
    result = pipeline.process(grip.counts, standard_errors=True)
    assert result.loads is not None and result.standard_errors is not None
    loads = np.load(tmp_path / "loads.npy")
    assert np.abs(result.loads - loads).max() <= 1e-9 * np.abs(loads).max()
    assert (result.marks == np.load(tmp_path / "marks.npy")).all()
    np.testing.assert_allclose(result.standard_errors, np.load(tmp_path / "errors.npy"), rtol=1e-6)
    said = np.genfromtxt(tmp_path / "figures.csv", delimiter=",", names=True)
    np.testing.assert_allclose(result.figures["force_newtons"], said["total_force_N"], rtol=1e-9)
    half = result.figures["force_half_width_newtons"]
    np.testing.assert_allclose(half, said["total_force_half_width_95_N"], rtol=1e-6)
    np.testing.assert_allclose(result.figures["centre_x_mm"], said["centre_column_mm"], rtol=1e-6)


def test_results_do_not_hang_on_how_many_cores_there_are() -> None:
    counts = taxel.simulate("mat-32x32-adg732", pattern="blobs", frames=150, seed=5).counts
    one = taxel.Pipeline("mat-32x32-adg732").process(counts, threads=1)
    for threads in (2, 3):
        pipeline = taxel.Pipeline("mat-32x32-adg732")
        for _ in range(2):
            pipeline.reset()
            result = pipeline.process(counts, threads=threads)
            assert result.loads is not None and one.loads is not None
            assert (result.loads == one.loads).all() and (result.marks == one.marks).all()


def test_one_frame_has_the_shape_of_one(grip: taxel.Simulation) -> None:
    result = taxel.Pipeline("econe").process(grip.counts[0])
    assert result.loads is not None and result.loads.shape == (64, 128) == result.marks.shape
    assert result.figures.rows == 1 and len(result.answered) == 1


def test_frames_one_by_one_and_at_once_are_alike(grip: taxel.Simulation) -> None:
    at_once = taxel.Pipeline("econe").process(grip.counts).loads
    pipeline = taxel.Pipeline("econe")
    one_by_one = np.stack([pipeline.process(frame).loads for frame in grip.counts])  # type: ignore[misc]
    assert at_once is not None
    assert np.abs(at_once - one_by_one).max() < 1e-9 * at_once.max()
    streamed = [r.loads for r in taxel.Pipeline("econe").stream(iter([grip.counts[:9], grip.counts[9:]]))]
    assert np.abs(np.concatenate(streamed) - at_once).max() < 1e-9 * at_once.max()  # type: ignore[arg-type]


def test_moving_frames_one_by_one_and_in_blocks_differ_by_less_than_noise_hides() -> None:
    counts = taxel.simulate("mat-32x32-adg732", pattern="fingers", frames=200, seed=3).counts
    in_blocks = taxel.Pipeline("mat-32x32-adg732").process(counts)
    pipeline = taxel.Pipeline("mat-32x32-adg732")
    one_by_one = [pipeline.process(frame) for frame in counts]
    assert in_blocks.loads is not None and in_blocks.answered.all()
    off = max(np.abs(block - one.loads).max() for block, one in zip(in_blocks.loads, one_by_one, strict=True))
    # Measured: 1.31e-6.
    assert 1e-9 * in_blocks.loads.max() < off < 1.6e-6 * in_blocks.loads.max()
    assert (in_blocks.marks == np.stack([one.marks for one in one_by_one])).all()


@pytest.mark.parametrize("kind", ["u2", ">u2", "i4", "i8", "u8", "f4", "f8", "f2"])
def test_any_type_of_number_is_the_same_number(kind: str) -> None:
    counts = taxel.simulate("mat-16x16-cd4067", pattern="blobs", frames=3, seed=2).counts
    assert counts.max() < 2048  # what float16 holds exactly
    pipeline = taxel.Pipeline("mat-16x16-cd4067")
    wanted, found = pipeline.process(counts), taxel.Pipeline("mat-16x16-cd4067").process(counts.astype(kind))
    assert (wanted.loads == found.loads).all()  # type: ignore[union-attr]


def test_order_in_memory_does_not_matter(grip: taxel.Simulation) -> None:
    wanted = taxel.Pipeline("econe").process(grip.counts[::2]).loads
    fixed = grip.counts[::2].copy()
    fixed.flags.writeable = False
    assert np.ascontiguousarray(fixed) is fixed
    for same in (np.asfortranarray(grip.counts)[::2], fixed, grip.counts[:, ::-1][:, ::-1][::2], np.ma.asarray(fixed)):
        found = taxel.Pipeline("econe").process(same).loads
        assert (found == wanted).all()  # type: ignore[union-attr]


def test_single_precision_is_asked_for() -> None:
    counts = taxel.simulate("mat-16x16-cd4067", pattern="blobs", frames=3).counts
    with pytest.warns(taxel.NoiseOnlyWarning):
        double, single = (
            taxel.Pipeline("mat-16x16-cd4067").process(counts, dtype=kind, siemens=True, standard_errors=True) for kind in ("f8", "f4")
        )
    for name in ("loads", "siemens", "standard_errors"):
        wide, narrow = getattr(double, name), getattr(single, name)
        assert (wide.dtype, narrow.dtype) == (np.float64, np.float32)
        assert (narrow == wide.astype(np.float32)).all()
    with pytest.raises(taxel.ArrayError, match="float64 or float32"):
        taxel.Pipeline("mat-16x16-cd4067").process(counts, dtype="i4")


def test_volts_and_siemens_go_the_same_way(preset: str) -> None:
    sensor = taxel.Sensor(preset)
    siemens = np.random.default_rng(4).uniform(1e-6, 2e-4, (2, *sensor.shape))
    volts = taxel.scan(sensor, siemens)
    found, answered = taxel.solve(sensor, volts)
    assert answered.all()
    assert np.abs(found - siemens).max() < 1e-6 * siemens.max()
    of_volts = taxel.Pipeline(sensor).process(volts, unit="volts", siemens=True)
    of_siemens = taxel.Pipeline(sensor).process(siemens, unit="siemens")
    assert of_volts.siemens is not None
    assert np.abs(of_volts.siemens - siemens).max() < 1e-6 * siemens.max()
    np.testing.assert_allclose(of_volts.loads, of_siemens.loads, rtol=1e-4, atol=1e-4)  # type: ignore[arg-type]
    assert taxel.scan(sensor, siemens[0]).shape == sensor.shape


def test_an_absent_taxel_is_marked_and_bears_nothing(insole: taxel.Sensor) -> None:
    pressed = taxel.simulate(insole, pattern="blobs", frames=3, seed=7)
    result = taxel.Pipeline(insole).process(pressed.counts)
    assert result.loads is not None
    assert (result.marks[:, ~insole.populated] == taxel.MARKS["absent"]).all()
    assert (result.loads[:, ~insole.populated] == 0.0).all()
    assert (result.measured == insole.populated).all()


def test_a_dead_line_is_found_in_all_frames_together(grip: taxel.Simulation) -> None:
    counts = grip.counts.copy()
    counts[:, 30, :] = 0
    pipeline = taxel.Pipeline("econe")
    faults = pipeline.look_for_faults(counts)
    assert len(faults) == 1 and "row 30" in faults[0]
    marks = pipeline.process(counts).marks
    assert (marks[:, 30] == taxel.MARKS["open"]).all() and (marks[:, 29] == 0).all()


def test_marks_that_are_given_are_kept(grip: taxel.Simulation) -> None:
    marks = np.zeros((20, 64, 128), np.uint8)
    marks[3, 5, 7] = taxel.MARKS["stuck"]
    result = taxel.Pipeline("econe").process(grip.counts, marks=marks)
    assert result.marks[3, 5, 7] == taxel.MARKS["stuck"] and result.loads[3, 5, 7] == 0.0  # type: ignore[index]
    repaired = taxel.Pipeline("econe", repair=True).process(grip.counts, marks=marks)
    assert repaired.marks[3, 5, 7] == taxel.MARKS["interpolated"]


def test_a_tare_is_taken_off_loads_and_figures(grip: taxel.Simulation) -> None:
    without = taxel.Pipeline("econe").process(grip.counts)
    zero = np.full((64, 128), 0.001)
    for tare in (zero, np.broadcast_to(zero, grip.counts.shape)):
        found = taxel.Pipeline("econe").process(grip.counts, tare=tare)
        np.testing.assert_allclose(found.loads, without.loads - 0.001, rtol=0, atol=1e-12)  # type: ignore[operator]
        off = without.figures["force_newtons"] - found.figures["force_newtons"]
        np.testing.assert_allclose(off, 0.001 * 64 * 128, rtol=0.01)


# A pipeline of the mat, by newton and with repair, as version 0.1.0 pickled it.
PICKLED = (
    "gASVOQIAAAAAAACMD3RheGVsLl9waXBlbGluZZSMCFBpcGVsaW5llJOUjAhidWlsdGluc5SMB2dldGF0dHKUk5SMBXRheGVslIwGU2Vuc29ylJ"
    "OUjAlmcm9tX3RvbWyUhpRSlFiYAQAAZm9ybWF0ID0gMQpuYW1lID0gIm1hdCAxNngxNiwgQ0Q3NEhDNDA2NyIKClthcnJheV0Kcm93cyA9IDE2"
    "CmNvbHVtbnMgPSAxNgpwaXRjaF9tbSA9IFsxMC4wLCAxMC4wXQp0YXhlbF9hcmVhX21tMiA9IDI1LjAKCltyZWFkb3V0XQp0b3BvbG9neSA9IC"
    "JkaXZpZGVyLWZsb2F0aW5nIgp2X3Rlc3Rfdm9sdHMgPSA1LjAKcl9tdXhfY29sdW1uX29obXMgPSA3MC4wCnJfbXV4X3Jvd19vaG1zID0gNzAu"
    "MApyX3NvdXJjZV9vaG1zID0gMC4wCnJfcHVsbF9kb3duX29obXMgPSAxMDAwLjAKCltjb252ZXJ0ZXJdCmJpdHMgPSAxMApmdWxsX3NjYWxlX3"
    "ZvbHRzID0gNS4wCmludmVydGVkID0gZmFsc2UKClttYXRlcmlhbF0KZ196ZXJvX3NpZW1lbnMgPSAwLjAwMDAwMQpmYWN0b3IgPSAwLjAwMDAw"
    "MgpleHBvbmVudCA9IDAuODUKlIwHcGF0aGxpYpSMCVBvc2l4UGF0aJSTlIwQbWF0LTE2eDE2LWNkNDA2N5SFlFKUhpRSlIwGbmV3dG9ulIiHlF"
    "KULg=="
)


def test_a_pipeline_that_an_older_version_pickled_is_the_same() -> None:
    pipeline = pickle.loads(base64.b64decode(PICKLED))
    assert pipeline.method == "newton"
    assert pipeline.sensor == taxel.Sensor("mat-16x16-cd4067")
    counts = taxel.simulate("mat-16x16-cd4067", pattern="hand", frames=3, seed=1).counts
    wanted = taxel.Pipeline("mat-16x16-cd4067", method="newton", repair=True).process(counts).loads
    assert (pipeline.process(counts).loads == wanted).all()


def test_a_pickled_pipeline_does_the_same_elsewhere(grip: taxel.Simulation) -> None:
    pipeline = taxel.Pipeline("econe", method="exact", repair=True)
    again = pickle.loads(pickle.dumps(pipeline))
    assert (again.method, again.sensor) == ("exact", pipeline.sensor)
    assert (again.process(grip.counts).loads == pipeline.process(grip.counts).loads).all()


def test_a_pipeline_is_pickled_by_words_alone(tmp_path: Path) -> None:
    """A path of one system cannot be made on another."""
    taxel.Sensor("econe").save(tmp_path / "my own.toml")
    pipeline = taxel.Pipeline(tmp_path / "my own.toml")
    assert b"pathlib" not in pickle.dumps(pipeline)
    assert pickle.loads(pickle.dumps(pipeline)).sensor.file == tmp_path / "my own.toml"


def test_the_inverse_of_a_frame_begins_with_the_answer_before_it() -> None:
    for preset in ("econe", "mat-16x16-cd4067"):
        frame = taxel.simulate(preset, pattern="fingers", seed=3).counts[0]
        pipeline = taxel.Pipeline(preset)
        first, *_, later = (pipeline.process(frame).rounds[0] for _ in range(4))
        pipeline.reset()
        assert later < first == pipeline.process(frame).rounds[0]


def test_what_loads_remember_goes_from_call_to_call() -> None:
    tables = taxel.Sensor("mat-16x16-cd4067").to_dict()
    tables["material"]["dynamic"] = {"lag_weight": [0.2, 0.1], "lag_secs": [0.5, 5.0], "period_secs": 0.05}
    counts = taxel.simulate("mat-16x16-cd4067", pattern="hand", frames=60, seed=6).counts
    time = np.arange(60) / 20.0
    at_once = taxel.Pipeline(tables).process(counts, time=time).loads
    pipeline = taxel.Pipeline(tables)
    parts = [pipeline.process(counts[part], time=time[part]).loads for part in (slice(25), slice(25, 60))]
    begun_anew = taxel.Pipeline(tables).process(counts[25:], time=time[25:]).loads
    assert at_once is not None and begun_anew is not None
    np.testing.assert_allclose(np.concatenate(parts), at_once, rtol=0, atol=1e-9 * at_once.max())  # type: ignore[arg-type]
    assert np.abs(begun_anew - at_once[25:]).max() > 0.02 * at_once.max()


def test_fractions_of_counts_count(grip: taxel.Simulation) -> None:
    whole, half = (taxel.Pipeline("econe").process(grip.counts[:2] + more) for more in (0, 0.5))
    assert whole.loads is not None and half.loads is not None
    heavy = whole.loads > 0.2
    assert (half.loads[heavy] > whole.loads[heavy]).mean() > 0.99 or (half.loads[heavy] < whole.loads[heavy]).mean() > 0.99


def test_what_is_masked_is_refused(grip: taxel.Simulation) -> None:
    masked = np.ma.masked_array(grip.counts, mask=False)
    masked[2, 3, 4:7] = np.ma.masked
    pipeline = taxel.Pipeline("econe")
    with pytest.raises(taxel.ArrayError, match="3 of 163840 numbers of the frames are masked"):
        pipeline.process(masked)
    # As its hint says.
    marks = pipeline.process(masked.filled(0), marks=taxel.MARKS["open"] * np.ma.getmaskarray(masked)).marks
    assert (marks[2, 3, 4:7] == taxel.MARKS["open"]).all() and np.count_nonzero(marks) == 3


def test_who_called_is_warned(grip: taxel.Simulation, tmp_path: Path) -> None:
    np.save(tmp_path / "grip.npy", grip.counts[:2])
    pipeline, recording = taxel.Pipeline("econe"), taxel.read(tmp_path / "grip.npy", "econe")
    for call in (
        lambda: pipeline.process(grip.counts[0], standard_errors=True),
        lambda: pipeline.process(recording, standard_errors=True),
        lambda: next(pipeline.stream(recording, standard_errors=True)),
    ):
        with pytest.warns(taxel.NoiseOnlyWarning) as warned:
            call()
        assert [Path(each.filename).name for each in warned] == ["test_pipeline.py"]


def test_no_frames_are_no_error(preset: str) -> None:
    rows, columns = taxel.Sensor(preset).shape
    nothing = np.empty((0, rows, columns))
    assert taxel.scan(preset, nothing).shape == taxel.solve(preset, nothing)[0].shape == nothing.shape
    assert taxel.simulate(preset, nothing).counts.shape == nothing.shape
    assert taxel.Pipeline(preset).look_for_faults(nothing) == []
    with pytest.raises(taxel.ArrayError, match="without frames"):
        taxel.plot.heatmap(taxel.Pipeline(preset).process(nothing))
    result = taxel.Pipeline(preset).process(np.empty((0, rows, columns)), standard_errors=True)
    assert result.loads is not None and result.loads.shape == (0, rows, columns) == result.marks.shape
    assert result.figures.rows == 0


def test_tables_and_arrays_of_others(grip: taxel.Simulation) -> None:
    time = np.arange(20) / 50.0
    result = taxel.Pipeline("econe").process(grip.counts, time=time)
    frame = result.figures.to_pandas()
    assert list(frame["time_s"]) == list(time) and len(frame) == 20
    assert result.figures.to_polars().shape == frame.shape
    dataset = result.to_xarray()
    assert dataset["loads"].dims == ("frame", "y", "x") and float(dataset["x"][-1]) == 254.0
    assert dataset["loads"].attrs["units"] == "N"
    assert np.shares_memory(np.from_dlpack(result.loads), result.loads)
    assert (dataset["time"] == time).all() and dataset["time"].attrs["units"] == "s"
    np.testing.assert_allclose(result.kilopascals, result.loads / result.sensor.taxel_area_mm2 * 1e3)


def test_coordinates_are_where_the_taxels_lie() -> None:
    tables = taxel.Sensor("mat-16x16-cd4067").to_dict()
    row, column = np.divmod(np.arange(256), 16)
    # Across, then down; rows lean and lie closer towards the heel.
    places = np.stack([10.0 * column + 2.5 * row, 9.0 * row - 0.1 * row**2], axis=1)
    there = np.ones(256, bool)
    there[-3:] = False
    tables["array"]["population"] = there.reshape(16, 16).astype(int).tolist()
    tables["array"]["positions"] = np.column_stack([row, column, places])[there].tolist()
    places[~there] = np.nan
    sensor = taxel.Sensor(tables)
    counts = taxel.simulate(sensor, pattern="blobs", frames=3, seed=1).counts
    dataset = taxel.Pipeline(sensor).process(counts, siemens=True).to_xarray()
    assert dataset["loads"].dims == dataset["siemens"].dims == ("frame", "row", "column")
    np.testing.assert_array_equal(dataset["x"], places[:, 0].reshape(16, 16))
    np.testing.assert_array_equal(dataset["y"], places[:, 1].reshape(16, 16))
    assert dataset["x"].attrs["units"] == dataset["y"].attrs["units"] == "mm"
    # What is asked by place is what lies there.
    loads = dataset["loads"].where((dataset["x"] == places[37, 0]) & (dataset["y"] == places[37, 1]), drop=True)
    assert loads.shape == (3, 1, 1) and (loads.values[:, 0, 0] == dataset["loads"].values[:, 2, 5]).all()
    one = taxel.Pipeline(sensor).process(counts[0]).to_xarray()
    assert one["loads"].dims == ("row", "column") and one["x"].shape == (16, 16)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda c: c.astype(bool), ["bool", "whole or real"]),
        (lambda c: c.astype(complex), ["complex"]),
        (lambda c: c.astype(str), ["whole or real"]),
        (lambda c: c.astype(object), ["object"]),
        (lambda c: c[0, 0], ["1 axes"]),
        (lambda c: c[None], ["4 axes"]),
        (lambda c: c[:, :15], ["15 × 16", "16 × 16"]),
        (lambda c: np.where(np.arange(16) == 3, np.nan, c), ["frame 0, row 0, column 3", "NaN", "marks="]),
        (lambda c: c.astype(int) - 5000, ["frame 0, row 0, column 0", "0 to 1023"]),
        (lambda c: c.astype(int) + 1024, ["frame 0", "0 to 1023", "converter.bits"]),
        (lambda c: np.full(c.shape, np.inf), ["inf", "0 to 1023"]),
    ],
)
def test_bad_frames_are_refused_in_words(make: Callable[[np.ndarray], np.ndarray], words: list[str]) -> None:
    counts = taxel.simulate("mat-16x16-cd4067", pattern="blobs", frames=3).counts
    with pytest.raises(taxel.ArrayError) as refused:
        taxel.Pipeline("mat-16x16-cd4067").process(make(counts))
    for word in words:
        assert word in str(refused.value), refused.value


def test_rows_and_columns_swapped_are_told(grip: taxel.Simulation) -> None:
    with pytest.raises(taxel.ArrayError, match="swapped"):
        taxel.Pipeline("econe").process(grip.counts.transpose(0, 2, 1))


def test_options_that_cannot_be_are_refused(grip: taxel.Simulation) -> None:
    pipeline = taxel.Pipeline("econe")
    for options, words in (
        ({"unit": "ohms"}, "counts, volts or siemens"),
        ({"threads": 0}, "threads 0"),
        ({"marks": np.zeros((3, 64, 128))}, "marks of shape"),
        ({"marks": np.full(grip.counts.shape, 77)}, "codes from 0 to 11, not 77"),
        ({"marks": np.full(grip.counts.shape, -1)}, "codes are whole numbers"),
        ({"time": np.arange(3)}, "times of shape"),
        ({"tare": np.zeros((64, 127))}, "a tare of shape"),
        ({"tare": np.full((64, 128), np.nan)}, "no number"),
        ({"tare": np.zeros((3, 64, 128))}, "a tare of shape"),
    ):
        with pytest.raises(taxel.Error, match=words):
            pipeline.process(grip.counts, **options)  # type: ignore[arg-type]
    with pytest.raises(taxel.Error, match="seed -1"):
        taxel.simulate("econe", seed=-1)
    with pytest.raises(taxel.Error, match="no method `newtown`"):
        taxel.Pipeline("econe", method="newtown")
    tables = taxel.Sensor("econe").to_dict()
    del tables["readout"]["r_mux_row_ohms"]
    with pytest.raises(taxel.SensorError, match="r_mux_row_ohms"):
        taxel.Pipeline(tables)


GROWTH = """
import numpy as np, taxel
def peak() -> int:
    # Not getrusage: its peak is that of the parent to begin with.
    with open("/proc/self/status") as status:
        return next(1024 * int(line.split()[1]) for line in status if line.startswith("VmHWM"))
counts = taxel.simulate("mat-32x32-adg732", pattern="blobs", frames=100).counts[:, :8, :8]
tables = taxel.Sensor("mat-32x32-adg732").to_dict()
tables["array"].update(rows=8, columns=8)
many = np.broadcast_to(counts, (1000, *counts.shape)).reshape(-1, 8, 8)
pipeline = taxel.Pipeline(tables)
# Threads and their memory are there before.
pipeline.process(many[:1000], dtype="f4", figures=False)
before = peak()
result = pipeline.process(many, dtype="f4", figures=False)
assert result.loads.shape == many.shape and result.answered.all()
grown = peak() - before
print(grown / sum(array.nbytes for array in (result.loads, result.marks, result.answered, result.rounds, result.residuals)))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="peaks of memory as Linux tells them")
def test_a_hundred_thousand_frames_in_one_call_take_the_memory_of_their_results() -> None:
    grown = subprocess.run([sys.executable, "-c", GROWTH], capture_output=True, text=True, check=True, timeout=600).stdout
    # Measured: 1.00, 33.4 MB.
    assert 0.9 < float(grown) < 1.29


SCARCE = """
import resource, numpy as np, taxel
pipeline = taxel.Pipeline("econe")
counts = np.zeros((4000, 64, 128), np.uint16)
pipeline.process(counts[:100])
with open("/proc/self/statm") as statm:
    there = int(statm.read().split()[0]) * resource.getpagesize()
# Loads take 262 MB, marks 33.
resource.setrlimit(resource.RLIMIT_AS, (there + 200_000_000, resource.RLIM_INFINITY))
try:
    pipeline.process(counts)
except MemoryError as error:
    print(error)
# And it goes on.
resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
assert pipeline.process(counts).loads.shape == counts.shape
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="a limit of memory as Linux keeps it")
def test_what_does_not_fit_in_memory_is_told() -> None:
    done = subprocess.run([sys.executable, "-c", SCARCE], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("250 MiB for the result cannot be had\nhint: Pipeline.stream"), done.stdout
