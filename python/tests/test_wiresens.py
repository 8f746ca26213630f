"""HDF5 of WiReSens: rows that are data, frames that were made up, and broken files."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import taxel

SENSOR = "mat-16x16-cd4067"
ROOM = 1024


def write(path: Path, counts: np.ndarray, made_up: np.ndarray | None = None, **change: Any) -> Path:
    """What the recorder writes: arrays with room for more than there is; a value of None leaves one out."""
    frames = len(counts)
    room = -(-max(frames, 1) // ROOM) * ROOM
    packets = np.zeros(frames) if made_up is None else made_up
    data: dict[str, Any] = {
        "pressure": np.zeros((room, *counts.shape[1:]), np.int32),
        "ts": np.zeros(room),
        "predCount": np.zeros(room),
        "frame_count": np.array([frames], np.uint32),
    }
    data["pressure"][:frames] = counts
    data["ts"][:frames] = 1_790_000_000.0 + 0.02 * np.arange(frames)
    data["predCount"][:frames] = np.cumsum(packets)
    with h5py.File(path, "w") as file:
        for name, value in (data | change).items():
            if value is not None:
                file.create_dataset(name, data=value, maxshape=(None, *np.shape(value)[1:]), chunks=True)
    return path


@pytest.fixture(scope="module")
def counts() -> np.ndarray:
    return taxel.simulate(SENSOR, pattern="hand", frames=40, seed=4).counts


def test_only_rows_that_are_data_are_read(counts: np.ndarray, tmp_path: Path) -> None:
    recording = taxel.read(write(tmp_path / "mat.hdf5", counts), SENSOR)
    assert (recording[7] == counts[7]).all() and (recording[-1] == counts[-1]).all()
    assert len(recording) == 40 and recording.shape == (16, 16)
    assert recording.counts.dtype == np.uint16 and (recording.counts == counts).all()
    assert recording.time is not None and recording.time[0] == 1_790_000_000.0 and np.allclose(np.diff(recording.time), 0.02, atol=1e-6)
    assert (recording.marks == 0).all() and not recording.predicted.any() and recording.missing == [] and recording.events == []
    assert [len(chunk.values) for chunk in recording.chunks(16)] == [16, 16, 8]
    found = taxel.Pipeline(SENSOR).process(recording)
    assert (found.loads == taxel.Pipeline(SENSOR).process(counts).loads).all()  # type: ignore[union-attr]
    # Known by what is in it, not by its name; more than one block of room.
    many = taxel.read(write(tmp_path / "mat.dat", np.tile(counts, (30, 1, 1))))
    assert len(many.counts) == 1200 and (many[1199] == counts[-1]).all()


def test_frames_that_were_made_up_are_never_measured(counts: np.ndarray, tmp_path: Path) -> None:
    packets = np.zeros(40)
    packets[[10, 11, 30]] = (1, 3, 2)
    recording = taxel.read(write(tmp_path / "mat.hdf5", counts, packets), SENSOR)
    # A packet may reach into the frame after it.
    wanted = np.isin(np.arange(40), (10, 11, 12, 30, 31))
    assert recording.predicted.dtype == np.bool_ and (recording.predicted == wanted).all()
    assert (recording.marks[wanted] == taxel.MARKS["interpolated"]).all() and (recording.marks[~wanted] == 0).all()
    result = taxel.Pipeline(SENSOR).process(recording)
    assert not result.measured[wanted].any() and result.measured[~wanted].any()
    assert (result.figures["measured_share"][wanted] == 0).all()
    parts = np.concatenate([chunk.marks for chunk in recording.chunks(7)])
    assert (parts == recording.marks).all()


def test_wires_may_be_swapped(tmp_path: Path) -> None:
    frames = np.arange(3 * 8 * 4).reshape(3, 8, 4)
    path = write(tmp_path / "mat.hdf5", frames)
    assert taxel.read(path).shape == (8, 4)
    swapped = taxel.read(path, transpose=True)
    assert swapped.shape == (4, 8) and (swapped.counts == frames.swapaxes(1, 2)).all()
    tables = taxel.Sensor(SENSOR).to_dict()
    tables["array"] |= {"rows": 4, "columns": 8}
    with pytest.raises(taxel.FileError, match=r"8 × 4, but the sensor .* 4 × 8\nhint: transpose=True"):
        taxel.read(path, taxel.Sensor(tables))
    assert taxel.read(path, taxel.Sensor(tables), transpose=True).counts.shape == (3, 4, 8)
    with pytest.raises(taxel.FileError, match=r"8 × 4, but the sensor .* 16 × 16\nhint: the sensor file"):
        taxel.read(path, SENSOR)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda n: {"frame_count": np.array([2000], np.uint32)}, "frame_count is 2000, but pressure has 1024 rows"),
        (lambda n: {"predCount": np.zeros(20)}, "frame_count is 40, but predCount has 20 rows"),
        (lambda n: {"frame_count": np.array([41], np.uint32)}, "frame 40: ts is 0"),
        (lambda n: {"ts": np.where(np.arange(ROOM) == 9, np.nan, 1.0)}, "frame 9: ts is nan"),
        (lambda n: {"pressure": with_value(n, -4)}, r"frame 5: pressure\[3, 2\] is -4, but counts are 0 to 65535"),
        (lambda n: {"pressure": with_value(n, 70_000)}, r"frame 5: pressure\[3, 2\] is 70000, but"),
        (lambda n: {"predCount": np.where(np.arange(ROOM) < 9, 5.0, 3.0)}, "frame 9: predCount goes from 5 to 3"),
        (lambda n: {"predCount": None}, "has no predCount, but frame_count, pressure, ts"),
        (lambda n: {"pressure": np.zeros((ROOM, 256), np.int32)}, r"pressure is int32 of shape \(1024, 256\)"),
        (lambda n: {"pressure": n.astype(np.float32)}, "pressure is float32 of shape"),
        (lambda n: {"frame_count": np.array([-2])}, "frame_count is -2, but"),
        (lambda n: {"frame_count": np.array([40.0])}, "frame_count is float64 of shape"),
        (lambda n: {"frame_count": np.zeros(3, np.uint32)}, "frame_count has 3 numbers, but 1"),
    ],
)
def test_broken_files_are_refused_in_words(
    change: Callable[[np.ndarray], dict[str, Any]], words: str, counts: np.ndarray, tmp_path: Path
) -> None:
    path = write(tmp_path / "mat.hdf5", counts, **change(counts))
    with pytest.raises(taxel.FileError, match=words) as refused:
        taxel.read(path, SENSOR).load()
    assert "mat.hdf5" in refused.value.message and refused.value.hint


def with_value(counts: np.ndarray, value: int) -> np.ndarray:
    changed = counts.astype(np.int32)
    changed[5, 3, 2] = value
    return changed


def test_what_is_whole_can_be_had(counts: np.ndarray, tmp_path: Path) -> None:
    path = write(tmp_path / "mat.hdf5", counts, pressure=with_value(counts, -1), predCount=np.zeros(30))
    recording = taxel.read(path, SENSOR, keep_going=True)
    assert len(recording) == 29 and list(recording.load().sequence)[4:7] == [4, 6, 7]
    assert len(recording.predicted) == 29
    assert recording.missing == ["frame_count is 40, but predCount has 30 rows", "1 frame that cannot be read"]
    assert len(taxel.read(write(tmp_path / "none.hdf5", counts[:0]), SENSOR).counts) == 0


def test_a_file_that_is_cut_says_so(counts: np.ndarray, tmp_path: Path) -> None:
    whole = write(tmp_path / "mat.hdf5", counts).read_bytes()
    (tmp_path / "cut.hdf5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(taxel.FileError, match=r"cut.hdf5: .*truncated"):
        taxel.read(tmp_path / "cut.hdf5", SENSOR)
    with pytest.raises(taxel.Error, match="holds counts, not siemens"):
        taxel.read(tmp_path / "mat.hdf5", SENSOR, unit="siemens")


def test_without_h5py_it_says_what_to_install(counts: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "mat.hdf5", counts)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(taxel.Error, match="h5py is needed.*\nhint: pip install h5py"):
        taxel.read(path, SENSOR)
