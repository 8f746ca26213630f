"""Streams of the lab streaming layer between two processes, and XDF files that pyxdf reads."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyxdf

import taxel
from taxel import lsl
from taxel.lsl._xdf import BOUNDARY, XdfWriter

SENSOR = "mat-16x16-cd4067"


@pytest.fixture(scope="module", autouse=True)
def alone(tmp_path_factory: pytest.TempPathFactory) -> None:
    """On this machine, and apart from whoever else streams on it. The library looks for this once, when it is first used."""
    assert "pylsl" not in sys.modules
    config = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    config.write_text(f"[multicast]\nResolveScope = machine\n[lab]\nSessionID = {uuid.uuid4()}\n[log]\nlevel = -3\n")
    os.environ["LSLAPICFG"] = str(config)


@pytest.fixture
def name() -> str:
    """Of a stream that no other test has."""
    return f"mat {uuid.uuid4().hex[:8]}"


@contextlib.contextmanager
def sender(program: str, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    """Another process that sends."""
    text = f"import sys, time, numpy as np, taxel\nfrom taxel import lsl\n{program}"
    command = [sys.executable, "-c", text, *map(str, arguments)]
    # In a session of its own: whatever ends beside the tests neither stops it nor wakes it.
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        try:
            yield process
            _, told = process.communicate(timeout=30)
            assert process.returncode in (0, -9), told
        finally:
            process.kill()


SEND = "lsl.send(taxel.read(sys.argv[1], sys.argv[2]), name=sys.argv[3], rate=100.0, wait=20.0)"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "hand.npy"
    np.save(path, taxel.simulate(SENSOR, pattern="hand", frames=60, seed=2).counts)
    return path


def test_loads_come_over_whole_and_the_loss_is_said(recording: Path, name: str) -> None:
    wanted = taxel.Pipeline(SENSOR).process(taxel.read(recording, SENSOR)).loads
    assert wanted is not None
    values: list[np.ndarray] = []
    stamps: list[np.ndarray] = []
    with sender(SEND, recording, SENSOR, name), lsl.Inlet(name, timeout=20.0) as inlet:
        assert inlet.shape == (16, 16) and inlet.unit == "N" and inlet.stream.type == "Pressure" and inlet.stream.rate == 100.0
        assert inlet.sensor == taxel.Sensor(SENSOR)
        assert inlet.labels is not None and inlet.labels[:2] == ["r0c0", "r0c1"] and inlet.labels[-1] == "r15c15"
        down, across = taxel.Sensor(SENSOR).pitch_mm
        assert inlet.positions_mm is not None and np.allclose(inlet.positions_mm[17], (across, down))
        with pytest.raises(lsl.LostError, match=f"{name} of .* lost.* 60 samples came until then\nhint: ") as lost:
            for frames in inlet:
                values.append(frames.values)
                stamps.append(frames.time)
        assert isinstance(lost.value, taxel.Error) and inlet.received == 60 and inlet.dropped == 0
        with pytest.raises(lsl.LostError):
            inlet.read()
    found, when = np.concatenate(values), np.concatenate(stamps)
    assert found.dtype == np.float32 and (found == wanted.astype(np.float32)).all()
    assert np.allclose(np.diff(when), 0.01, atol=2e-4) and abs(when[-1] - lsl.clock()) < 10.0


def test_it_is_recorded_and_read_back_by_pyxdf(recording: Path, name: str, tmp_path: Path) -> None:
    program = """
source = np.load(sys.argv[1])
with lsl.Outlet(sys.argv[2], name=sys.argv[3], unit="counts") as outlet:
    marks = np.zeros((16, 16), np.uint8)
    assert outlet.wait(20.0)
    time.sleep(0.5)
    for number, frame in enumerate(source):
        marks[3, 4] = 2 if 20 <= number < 40 else 0
        outlet.push(frame, 1000.0 + 0.01 * number, marks)
        if number == 10:
            outlet.mark("größer", 1000.1)
"""
    path = tmp_path / "trial.xdf"
    with sender(program, recording, SENSOR, name), pytest.warns(lsl.LostWarning, match=f"{name}.* of .* lost") as warned:
        told = lsl.record(path, [name, f"{name} marks"], timeout=20.0)
    assert all(warning.filename == __file__ for warning in warned)
    assert [(one.samples, one.dropped, one.was_lost) for one in told] == [(60, 0, True), (3, 0, True)]
    (frames, markers), header = pyxdf.load_xdf(path)
    assert header["info"]["version"] == ["1.0"]
    counts = np.load(recording)
    assert frames["time_series"].dtype == np.float32 and (frames["time_series"].reshape(-1, 16, 16) == counts).all()
    # Clocks of one machine: what is added is microseconds.
    assert np.allclose(frames["time_stamps"], 1000.0 + 0.01 * np.arange(60), atol=5e-3)
    raw = pyxdf.load_xdf(path, synchronize_clocks=False)[0]
    assert (raw[0]["time_stamps"] == 1000.0 + 0.01 * np.arange(60)).all()
    assert [text for (text,) in markers["time_series"]] == ["größer", 'marks {"saturated": ["r3c4"]}', "marks {}"]
    assert (raw[1]["time_stamps"] == [1000.1, 1000.0 + 0.01 * 20, 1000.0 + 0.01 * 40]).all()
    assert lsl.marks_of(markers["time_series"][1][0], (16, 16))[3, 4] == taxel.MARKS["saturated"]  # type: ignore[index]
    check_description(frames)
    footer = frames["footer"]["info"]
    assert footer["sample_count"] == ["60"] and float(footer["last_timestamp"][0]) == 1000.0 + 0.01 * 59
    assert abs(float(footer["clock_offsets"][0]["offset"][0]["value"][0])) < 5e-3


def check_description(frames: dict[str, Any]) -> None:
    info = frames["info"]
    assert (info["type"], info["channel_count"], info["channel_format"]) == (["Pressure"], ["256"], ["float32"])
    desc = info["desc"][0]
    assert desc["encoding"][0]["width"] == ["16"] and desc["encoding"][0]["height"] == ["16"]
    channel = desc["channels"][0]["channel"][18]
    assert (channel["label"], channel["unit"], channel["type"]) == (["r1c2"], ["counts"], ["Pressure"])
    down, across = taxel.Sensor(SENSOR).pitch_mm
    assert [float(channel["location"][0][axis][0]) for axis in "XY"] == [2 * across, down]
    assert taxel.Sensor.from_toml(desc["taxel"][0]["sensor"][0]) == taxel.Sensor(SENSOR)
    assert desc["acquisition"][0]["model"] == [taxel.Sensor(SENSOR).name]


def test_a_sender_that_is_killed_leaves_a_whole_file(name: str, tmp_path: Path) -> None:
    program = """
with lsl.Outlet(shape=(2, 3), name=sys.argv[1], rate=100.0) as outlet:
    while True:
        outlet.push(np.full((2, 3), 7.0))
        time.sleep(0.01)
"""
    path = tmp_path / "trial.xdf"
    with sender(program, name) as process, lsl.Inlet(name, timeout=20.0) as inlet:
        assert len(inlet.read(timeout=5.0).time) and inlet.sensor is None and inlet.positions_mm is None
        threading.Timer(2.0, process.kill).start()
        with pytest.warns(lsl.LostWarning):
            told = lsl.record(path, [inlet.stream], seconds=30.0)
        with pytest.raises(lsl.LostError):
            for _ in inlet:
                pass
    assert told[0].was_lost and told[0].samples > 20
    ((stream,), _) = pyxdf.load_xdf(path)
    assert len(stream["time_stamps"]) == told[0].samples and (stream["time_series"] == 7.0).all()
    with pytest.raises(taxel.FileError, match=r"trial.xdf is there already"), lsl.Outlet(shape=(2, 3), name=name) as outlet:
        assert outlet.shape == (2, 3)
        lsl.record(path, [name], seconds=0.1)
    with pytest.raises(taxel.Error, match=f"no stream of name '{name}' came up within 0.2 s; there are: none\nhint"):
        lsl.record(tmp_path / "none.xdf", [name], timeout=0.2)
    assert not (tmp_path / "none.xdf").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for another process here")
def test_ctrl_c_ends_a_recording_with_a_whole_file(name: str, tmp_path: Path) -> None:
    path = tmp_path / "trial.xdf"
    with lsl.Outlet(shape=(2, 3), name=name) as outlet:
        # Python leaves Ctrl-C ignored where it was so before: in the background of a shell.
        program = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
lsl.record(sys.argv[1], [sys.argv[2]], timeout=20.0)
"""
        with sender(program, path, name) as process:
            assert outlet.wait(20.0)
            time.sleep(0.5)
            for number in range(50):
                outlet.push(np.full((2, 3), float(number)))
                time.sleep(0.01)
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
        assert process.returncode == 0
    ((stream,), _) = pyxdf.load_xdf(path)
    assert (stream["time_series"][:, 0] == np.arange(50)).all() and stream["footer"]["info"]["sample_count"] == ["50"]


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no SIGSTOP here")
def test_a_sender_that_falls_silent_is_told_from_one_that_is_gone(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taxel.lsl._inlet._SILENT_SECS", 0.3)
    monkeypatch.setattr("taxel.lsl._inlet._LOOKS", 2)
    program = """
with lsl.Outlet(shape=(2, 3), name=sys.argv[1]) as outlet:
    outlet.wait(20.0)
    outlet.push(np.ones((2, 3)))
    time.sleep(60.0)
"""
    with sender(program, name) as process, lsl.Inlet(name, timeout=20.0) as inlet:
        assert len(inlet.read(timeout=5.0).time) == 1
        # It says nothing, but it is there.
        assert len(inlet.read(timeout=3.0).time) == 0
        # As a computer whose cable is pulled: nobody closes the connection.
        process.send_signal(signal.SIGSTOP)
        with pytest.raises(lsl.LostError, match="does not answer any more. 1 samples"):
            inlet.read(timeout=15.0)
        process.kill()


def test_live_frames_and_events_of_a_recording(name: str, tmp_path: Path) -> None:
    path = tmp_path / "live.mcap"
    with taxel.live(f"sim:{SENSOR}?fps=100", record=path) as source:
        sending = threading.Thread(target=lsl.send, args=(source,), kwargs={"name": name})
        sending.start()
        with lsl.Inlet(name, timeout=20.0) as inlet:
            found = [inlet.read(timeout=5.0) for _ in range(10)]
            # Before anything ends: when it came, by this machine's clock.
            assert all(len(frames.time) for frames in found) and 0.0 <= lsl.clock() - found[-1].time[-1] < 1.0
            assert (np.diff(np.concatenate([frames.time for frames in found])) > 0).all()
        source.close()
        sending.join(10.0)
        assert not sending.is_alive()
    recording = taxel.read(path)
    events = [f"{event['kind']}: {event['text']}" for event in recording.events]
    sending = threading.Thread(
        target=lsl.send, args=(recording,), kwargs={"name": name, "unit": "counts", "speed": 4.0, "wait": 20.0}
    )
    sending.start()
    # The sender begins with whoever receives frames.
    with lsl.Markers(f"{name} marks", timeout=20.0) as markers, lsl.Inlet(name, timeout=20.0) as inlet:
        assert inlet.unit == "counts"
        values: list[np.ndarray] = []
        with pytest.raises(lsl.LostError):
            for frames in inlet:
                values.append(frames.values)
        assert (np.concatenate(values) == recording.counts).all()
        assert events and [text for _, text in markers.read(most=1000)] == events
    sending.join(10.0)


def test_streams_of_others_are_read_with_a_shape(name: str) -> None:
    import pylsl

    info = pylsl.StreamInfo(name, "FSR", 6, 0, pylsl.cf_int16, name)
    outlet = pylsl.StreamOutlet(info)
    with pytest.raises(taxel.Error, match="does not tell the shape of its 6 channels\nhint: shape="):
        lsl.Inlet(name)
    with pytest.raises(taxel.ArrayError, match="2 × 2 are 4 taxels, but .* has 6 channels"):
        lsl.Inlet(name, shape=(2, 2))
    with pytest.raises(taxel.Error, match=r"\(FSR\) is no stream of one string"):
        lsl.Markers(name)
    with lsl.Inlet(name, shape=(2, 3), queue=2) as inlet:
        assert inlet.unit is None and inlet.labels is None and inlet.sensor is None
        assert len(inlet.read(timeout=0.05).time) == 0
        for number in range(5):
            outlet.push_sample([number, 1, 2, 3, 4, -5], pylsl.local_clock())
        until = time.monotonic() + 10.0
        while inlet.dropped < 3 and time.monotonic() < until:
            time.sleep(0.01)
        frames = inlet.read()
        assert frames.values.dtype == np.int16 and frames.values[:, 0, 0].tolist() == [3, 4] and frames.values[0, 1, 2] == -5
    with pytest.raises(taxel.Error, match="is closed"):
        inlet.read()
    texts = pylsl.StreamOutlet(pylsl.StreamInfo(f"{name} texts", "Markers", 1, 0, pylsl.cf_string, f"{name} texts"))
    with pytest.raises(taxel.Error, match="of strings, not of numbers"):
        lsl.Inlet(f"{name} texts")
    assert {stream.name for stream in lsl.streams()} == {name, f"{name} texts"}
    del outlet, texts


def test_what_cannot_be_sent_is_refused(recording: Path, name: str) -> None:
    with lsl.Outlet(SENSOR, name=name) as outlet:
        for frames, words in (
            (np.zeros((8, 8)), "8 × 8, but the outlet has 16 × 16"),
            (np.where(np.arange(256).reshape(16, 16) == 35, np.nan, 0.0), r"frame 0, taxel \(2, 3\): nan"),
            (np.zeros((2, 16, 16)), "2 frames without times"),
        ):
            with pytest.raises(taxel.ArrayError, match=words):
                outlet.push(frames)
        assert not outlet.wait(0.05)
    with pytest.raises(taxel.Error, match="is closed"):
        outlet.mark("late")
    with pytest.raises(taxel.Error, match="neither a sensor nor a shape"):
        lsl.Outlet()
    with pytest.raises(taxel.ArrayError, match=r"shape \(2, 3\), but the sensor .* has \(16, 16\)"):
        lsl.Outlet(SENSOR, shape=(2, 3))
    with pytest.raises(taxel.Error, match="rate -1"):
        lsl.Outlet(shape=(2, 3), rate=-1.0)
    counts = np.load(recording)
    with pytest.raises(taxel.Error, match="hint: rate="):
        lsl.send(counts, name=name)
    with pytest.raises(taxel.Error, match="nobody received .* within 0.1 s"):
        lsl.send(counts, name=name, rate=100.0, wait=0.1)
    tables = taxel.Sensor(SENSOR).to_dict()
    del tables["material"]
    with pytest.raises(taxel.Error, match="no load law\nhint: .*unit='S'"):
        lsl.send(taxel.read(recording, tables), name=name)
    with pytest.raises(taxel.Error, match="speed 0"):
        lsl.send(counts, name=name, rate=100.0, speed=0.0)


def test_marks_go_there_and_back() -> None:
    codes = np.random.default_rng(1).integers(0, len(taxel.MARKS), (5, 7)).astype(np.uint8)
    from taxel.lsl._description import text_of_marks

    found = lsl.marks_of(text_of_marks(codes), (5, 7))
    assert found is not None and (found == codes).all()
    assert lsl.marks_of("mark: stands", (5, 7)) is None
    for text in ('marks {"open": ["r9c0"]}', 'marks {"what": ["r0c0"]}', "marks [", 'marks {"open": ["x"]}'):
        with pytest.raises(taxel.ArrayError, match="marker"):
            lsl.marks_of(text, (5, 7))


@pytest.mark.parametrize("kind", ["int8", "int16", "int32", "int64", "float32", "double64"])
def test_pyxdf_reads_every_type_of_number(kind: str, tmp_path: Path) -> None:
    numbers = np.dtype("float64" if kind == "double64" else kind)
    values = np.arange(-600, 600).astype(numbers).reshape(-1, 3)
    stamps = np.cumsum(np.random.default_rng(3).uniform(0.001, 0.1, len(values)))
    writer = XdfWriter(tmp_path / "a.xdf")
    about = f"<channel_count>3</channel_count><nominal_srate>0</nominal_srate><channel_format>{kind}</channel_format>"
    writer.stream_header(5, f"<?xml version='1.0'?><info><name>a</name><type>b</type>{about}<desc/></info>")
    writer.samples(5, stamps[:300], values[:300])
    writer.boundary()
    writer.samples(5, stamps[300:], values[300:])
    writer.clock_offset(5, 1.0, 0.25)
    writer.stream_footer(5, stamps[0], stamps[-1], len(stamps), [(1.0, 0.25)])
    writer.close()
    ((stream,), _) = pyxdf.load_xdf(tmp_path / "a.xdf")
    assert stream["time_series"].dtype == numbers and (stream["time_series"] == values).all()
    assert np.allclose(stream["time_stamps"], stamps + 0.25, rtol=0.0, atol=1e-12)
    # What a killed recorder leaves: all up to the last whole chunk.
    whole = (tmp_path / "a.xdf").read_bytes()
    (tmp_path / "cut.xdf").write_bytes(whole[: whole.index(BOUNDARY) + len(BOUNDARY) + 100])
    ((cut,), _) = pyxdf.load_xdf(tmp_path / "cut.xdf")
    assert (cut["time_series"] == values[:300]).all()


def test_lengths_have_as_many_bytes_as_they_need() -> None:
    from taxel.lsl._xdf import _length

    assert [_length(n)[0] for n in (0, 255, 256, 2**32 - 1, 2**32)] == [1, 1, 4, 4, 8]
    assert _length(2**32) == b"\x08\0\0\0\0\x01\0\0\0"


def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(taxel.Error, match="pylsl, which is not installed\nhint: pip install pylsl"):
        lsl.streams()

    def fails(_: str) -> None:
        raise RuntimeError("LSL binary library file was not found.\nmore")

    monkeypatch.setattr("taxel.lsl._description.import_module", fails)
    with pytest.raises(taxel.Error, match="liblsl cannot be loaded: LSL binary library file was not found.\nhint: "):
        lsl.clock()
