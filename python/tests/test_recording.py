"""Recordings of every format, by slices, and broken."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import taxel


@pytest.fixture(scope="module")
def files(grip: taxel.Simulation, command: Callable[..., str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    np.save(folder / "grip.npy", grip.counts)
    for ending in ("txt", "csv", "npz", "mcap", "parquet"):
        command("convert", folder / "grip.npy", "--sensor", "econe", "-o", folder / f"grip.{ending}")
    return folder


@pytest.mark.parametrize("ending", ["txt", "csv", "npy", "npz", "mcap", "parquet"])
def test_every_format_gives_the_same_frames(ending: str, files: Path, grip: taxel.Simulation) -> None:
    carries = ending in ("mcap", "parquet")
    recording = taxel.read(files / f"grip.{ending}", None if carries else "econe")
    assert recording.sensor == taxel.Sensor("econe") and recording.shape == (64, 128)
    # Before anything is kept.
    assert (recording[7] == grip.counts[7]).all() and (recording[-1] == grip.counts[-1]).all()
    assert (recording[3:9:2] == grip.counts[3:9:2]).all() and (recording[-4:] == grip.counts[-4:]).all()
    assert len(recording) == 20 and len(recording[25:30]) == 0
    assert all((a == b).all() for a, b in zip(recording, grip.counts, strict=True))
    # And after.
    assert recording.counts.dtype == np.uint16 and (recording.counts == grip.counts).all()
    assert (recording[7] == grip.counts[7]).all() and (recording.marks == 0).all()
    assert [len(chunk.values) for chunk in recording.chunks(8)] == [8, 8, 4]
    with pytest.raises(IndexError, match="20 frames"):
        recording[20]
    assert recording.missing == []
    assert "20 frames of 64 × 128 counts" in repr(recording)


def test_a_npy_file_is_not_copied(files: Path) -> None:
    recording = taxel.read(files / "grip.npy", "econe")
    assert isinstance(recording.counts, np.memmap)


def test_a_recording_goes_through_a_pipeline(files: Path, grip: taxel.Simulation) -> None:
    wanted = taxel.Pipeline("econe").process(grip.counts)
    recording = taxel.read(files / "grip.mcap")
    found = taxel.Pipeline(recording.sensor).process(recording)
    assert (found.loads == wanted.loads).all()  # type: ignore[union-attr]
    assert found.time is not None and (np.diff(found.time) > 0).all()
    parts = list(taxel.Pipeline(recording.sensor).stream(taxel.read(files / "grip.mcap"), chunk=6))
    assert [len(part.answered) for part in parts] == [6, 6, 6, 2]
    streamed = np.concatenate([part.loads for part in parts])  # type: ignore[misc]
    assert wanted.loads is not None and np.abs(streamed - wanted.loads).max() < 1e-9 * wanted.loads.max()
    assert np.concatenate([part.figures["time_s"] for part in parts]).tolist() == found.figures["time_s"].tolist()


def test_a_recording_takes_what_it_has_none_of_and_no_second(files: Path, grip: taxel.Simulation) -> None:
    pipeline, time, tare = taxel.Pipeline("econe"), np.arange(20.0), np.full((64, 128), 0.01)
    without = taxel.read(files / "grip.txt", "econe")
    found = pipeline.process(without, time=time, tare=tare)
    plain = taxel.Pipeline("econe").process(grip.counts)
    assert found.time is not None and found.time.tolist() == time.tolist()
    np.testing.assert_allclose(found.loads, plain.loads - 0.01, rtol=0, atol=1e-12)  # type: ignore[operator]
    marks = np.zeros(grip.counts.shape, np.uint8)
    marks[:, 5, 7] = taxel.MARKS["stuck"]
    assert (pipeline.process(without, marks=marks).marks[:, 5, 7] == taxel.MARKS["stuck"]).all()
    with pytest.raises(taxel.Error, match="times of its own"):
        pipeline.process(taxel.read(files / "grip.mcap"), time=time)
    with pytest.raises(taxel.Error, match="opened as counts, not as volts"):
        pipeline.process(without, unit="volts")


def tared(path: Path, at: Path, tares: list[tuple[int, float]]) -> None:
    """Copies a recording and says what is taken off its loads, newtons, from which of its frames on: docs/formats.md, Tare."""
    from mcap.reader import make_reader
    from mcap.writer import Writer

    with path.open("rb") as source, at.open("wb") as out:
        reader, writer = make_reader(source), Writer(out, chunk_size=1)
        header = reader.get_header()
        writer.start(header.profile, header.library)
        known: dict[int, int] = {}
        for number, (schema, channel, message) in enumerate(m for m in reader.iter_messages() if m[1].topic == "/taxel/counts"):
            if channel.id not in known:
                kind = 0 if schema is None else writer.register_schema(schema.name, schema.encoding, schema.data)
                known[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, kind, channel.metadata)
            for first, newtons in tares:
                if first == number:
                    loads = [newtons] * 256
                    text = json.dumps({"from_sequence": message.sequence, "unit": "N", "loads": loads, "raw": loads})
                    writer.add_attachment(message.log_time, message.log_time, "taxel/tare", "application/json", text.encode())
            writer.add_message(known[channel.id], message.log_time, message.data, message.publish_time, message.sequence)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        writer.finish()


def test_a_tare_of_a_recording_is_kept_once_where_it_stays(tmp_path: Path, command: Callable[..., str]) -> None:
    counts = taxel.simulate("mat-16x16-cd4067", pattern="hand", frames=30, seed=2).counts
    np.save(tmp_path / "a.npy", counts)
    command("convert", tmp_path / "a.npy", "--sensor", "mat-16x16-cd4067", "-o", tmp_path / "a.mcap")
    plain = taxel.Pipeline("mat-16x16-cd4067").process(counts).loads
    for tares in ([(0, 0.01)], [(0, 0.01), (12, 0.02)], [(7, 0.01)]):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.mcap"
        tared(tmp_path / "a.mcap", path, tares)
        recording = taxel.read(path, "mat-16x16-cd4067")
        wanted = np.zeros(30)
        for first, newtons in tares:
            wanted[first:] = newtons
        assert recording.tare is not None and recording.tare.shape == counts.shape
        assert (recording.tare == wanted[:, None, None]).all()
        assert (recording.tare.strides[0] == 0) == (tares == [(0, 0.01)])
        found = taxel.Pipeline("mat-16x16-cd4067").process(recording)
        np.testing.assert_allclose(found.loads, plain - recording.tare, rtol=0, atol=1e-12)  # type: ignore[operator]
        streamed = taxel.Pipeline("mat-16x16-cd4067").stream(recording, chunk=5)
        np.testing.assert_allclose(np.concatenate([part.loads for part in streamed]), found.loads, rtol=0, atol=1e-9)  # type: ignore[misc,arg-type]
        with pytest.raises(taxel.Error, match="a tare of its own"):
            taxel.Pipeline("mat-16x16-cd4067").process(recording, tare=np.zeros((16, 16)))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of Unix")
@pytest.mark.parametrize("use", ["counts", "one", "length", "chunks"])
def test_a_pipe_is_read_once(use: str, files: Path, grip: taxel.Simulation, tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.txt"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_bytes((files / "grip.txt").read_bytes()))
    writer.start()
    recording = taxel.read(pipe, "econe")
    if use == "chunks":
        read = np.concatenate([chunk.values for chunk in recording.chunks(6)])
        assert (read == grip.counts).all()
        with pytest.raises(taxel.Error, match="read already"):
            recording.load()
    elif use == "one":
        assert (recording[3] == grip.counts[3]).all() and (recording[-1] == grip.counts[-1]).all()
    elif use == "length":
        assert len(recording) == 20
    if use != "chunks":
        assert (recording.counts == grip.counts).all() and recording.missing == [] and recording.events == []
        assert not recording.predicted.any()
    writer.join()


@pytest.mark.parametrize("name", ["none.npy", "none.txt", "none.csv"])
def test_a_recording_without_frames(name: str, tmp_path: Path) -> None:
    if name.endswith("npy"):
        np.save(tmp_path / name, np.empty((0, 16, 16), np.uint16))
    else:
        (tmp_path / name).write_text("")
    with pytest.raises(taxel.FileError, match=name):
        taxel.read(tmp_path / name, "mat-16x16-cd4067").load()


def test_means_of_counts_keep_their_fractions(tmp_path: Path, grip: taxel.Simulation) -> None:
    means = grip.counts[:4].astype(np.float64)
    means[2] += 0.25
    np.save(tmp_path / "means.npz.npy", means)
    recording = taxel.read(tmp_path / "means.npz.npy", "econe")
    assert (recording.counts == means).all()
    assert (recording[2] == means[2]).all()


def test_other_quantities_are_asked_for(tmp_path: Path) -> None:
    siemens = np.random.default_rng(1).uniform(1e-6, 1e-4, (3, 16, 16))
    np.save(tmp_path / "g.npy", siemens)
    recording = taxel.read(tmp_path / "g.npy", "mat-16x16-cd4067", unit="siemens")
    assert (recording.values == siemens).all()
    with pytest.raises(taxel.Error, match="opened as siemens"):
        _ = recording.counts


def test_broken_files_are_refused_in_words(tmp_path: Path, files: Path, command: Callable[..., str]) -> None:
    with pytest.raises(taxel.FileError, match="no such file"):
        taxel.read(tmp_path / "none.mcap")
    with pytest.raises(taxel.Error, match="sensor="):
        taxel.read(files / "grip.txt")
    lines = (files / "grip.txt").read_text().splitlines()
    broken = tmp_path / "broken.txt"
    broken.write_text("\n".join([*lines[:70], lines[70].replace("1", "x", 1), *lines[71:]]))
    with pytest.raises(taxel.FileError) as refused:
        taxel.read(broken, "econe").load()
    assert "broken.txt" in str(refused.value) and "71" in str(refused.value)
    said = command("info", broken, "--sensor", "econe", code=1, errors=True)
    assert said.strip().removeprefix("error: ").replace("--keep-going", "keep_going=True") == str(refused.value)
    kept = taxel.read(broken, "econe", keep_going=True)
    assert len(kept.counts) == 19 and list(kept.load().sequence)[:2] == [0, 2]
    assert len(kept.missing) == 1 and "1 frame" in kept.missing[0]
    with taxel.live("sim:econe?fps=max", record=tmp_path / "long.mcap", queue=2) as source:
        while source.statistics["received"] < 300:
            assert source.next(timeout=5) is not None
    whole = (tmp_path / "long.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(taxel.Error):
        taxel.read(tmp_path / "cut.mcap").load()
    cut = taxel.read(tmp_path / "cut.mcap", "econe", keep_going=True)
    assert 0 < len(cut.counts) < 300 and cut.missing
    (tmp_path / "what.xyz").write_text("1")
    with pytest.raises(taxel.FileError, match=".xyz"):
        taxel.read(tmp_path / "what.xyz", "econe")
    with pytest.raises(taxel.FileError):
        taxel.read(files / "grip.npy", "mat-16x16-cd4067").load()


def test_a_closed_recording_says_so(files: Path) -> None:
    with taxel.read(files / "grip.npy", "econe") as recording:
        assert len(recording) == 20
    pipeline = taxel.Pipeline("econe")
    for use in (
        lambda: recording.counts,
        lambda: recording[0],
        lambda: next(iter(recording)),
        lambda: recording.time,
        lambda: recording.events,
        lambda: recording.missing,
        recording.load,
        lambda: len(recording),
        lambda: pipeline.process(recording),
        lambda: next(pipeline.stream(recording)),
        lambda: pipeline.look_for_faults(recording),
    ):
        with pytest.raises(taxel.Error, match="closed"):
            use()


def test_a_live_recording_has_times_and_events(tmp_path: Path) -> None:
    with taxel.live("sim:mat-16x16-cd4067?fps=200", record=tmp_path / "live.mcap") as source:
        frames = [source.next(timeout=5) for _ in range(10)]
    assert all(frame is not None for frame in frames)
    recording = taxel.read(tmp_path / "live.mcap")
    assert len(recording) >= 10 and recording.time is not None
    assert all({"secs", "kind", "text"} <= set(event) for event in recording.events)
