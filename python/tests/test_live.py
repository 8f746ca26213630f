"""Live frames: in time, by asyncio, and the oldest left out where Python is slower."""

from __future__ import annotations

import asyncio
import os
import struct
import sys
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

import taxel


def test_frames_come_with_loads_and_numbers() -> None:
    with taxel.live("sim:econe?fingers&fps=100") as source:
        frames = [frame for frame, _ in zip(source, range(15), strict=False)]
        assert source.sensor == taxel.Sensor("econe")
    numbers = [frame.number for frame in frames]
    assert numbers == sorted(set(numbers))
    for frame in frames:
        assert frame.loads is not None and frame.loads.shape == (64, 128) and frame.answered
        good = np.isin(frame.marks, (0, taxel.MARKS["saturated"], taxel.MARKS["unresolved"]))
        assert frame.force_newtons == pytest.approx(frame.loads[good].sum(), rel=0.02)
    assert source.next() is None and source.state == "closed"


def test_the_oldest_are_left_out_and_counted() -> None:
    with taxel.live("sim:mat-16x16-cd4067?fps=300", queue=4) as source:
        first = source.next()
        time.sleep(0.5)
        then = [source.next() for _ in range(4)]
        statistics = source.statistics
    assert first is not None and then[0] is not None and then[-1] is not None
    assert statistics["dropped"] > 20 and statistics["solved"] > statistics["dropped"]
    assert then[0].number - first.number > 20


def test_a_source_that_ends_is_read_to_its_end(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((30, 16, 16), np.uint16))
    with taxel.live(f"file:{tmp_path / 'a.npy'}?speed=max", "mat-16x16-cd4067", queue=100) as source:
        assert sum(1 for _ in source) == 30


def test_frames_that_are_solved_after_the_source_has_ended_come_too(tmp_path: Path) -> None:
    """Each takes longer than the source is asked whether it has ended."""
    tables = taxel.Sensor("mat-32x32-adg732").to_dict()
    tables["readout"].update(r_line_row_ohms=50.0, r_line_column_ohms=50.0)
    slow = taxel.Sensor(tables)
    np.save(tmp_path / "a.npy", taxel.simulate(slow, pattern="blobs", frames=12, seed=2).counts)
    address = f"file:{tmp_path / 'a.npy'}?speed=max"

    async def many(source: taxel.Live) -> int:
        seen = 0
        async with source:
            async for _ in source:
                seen += 1
        return seen

    with taxel.live(address, slow, queue=100) as source:
        assert sum(1 for _ in source) == 12
    assert asyncio.run(many(taxel.live(address, slow, queue=100))) == 12


def packet(number: int, counts: np.ndarray) -> bytes:
    """A frame of 10-bit counts as docs/formats.md (taxel-1) has it."""
    rows, columns = counts.shape
    bits = counts.reshape(-1, 1).astype(np.uint16) >> np.arange(10, dtype=np.uint16) & 1
    head = struct.pack("<BBHIQHH", 1, 10, 7, number, 10_000 * number, rows, columns)
    whole = head + np.packbits(bits.astype(np.uint8), bitorder="little").tobytes()
    whole += struct.pack("<I", zlib.crc32(whole))
    stuffed, pieces = bytearray(b"\0"), whole.split(b"\0")
    for place, piece in enumerate(pieces):
        while len(piece) >= 254:
            stuffed += b"\xff" + piece[:254]
            piece = piece[254:]
            if not piece and place == len(pieces) - 1:
                break
        else:
            stuffed += bytes([len(piece) + 1]) + piece
    return bytes(stuffed) + b"\0"


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals of Unix")
def test_frames_come_over_a_serial_port(tmp_path: Path) -> None:
    import tty

    counts = taxel.simulate("mat-16x16-cd4067", pattern="hand", frames=12, seed=5).counts
    wanted = taxel.Pipeline("mat-16x16-cd4067").process(counts).loads
    board, port = os.openpty()
    tty.setraw(port)
    frames: list[taxel.LiveFrame] = []
    try:
        with taxel.live(f"serial:{os.ttyname(port)}?baud=115200", "mat-16x16-cd4067", queue=64, record=tmp_path / "a.mcap") as source:
            for number in [*range(4), *range(6, 12)]:
                # Noise of a cable between two of them.
                os.write(board, packet(number, counts[number]) + (b"\x01noise\0" if number == 8 else b""))
                found = source.next(timeout=30)
                assert found is not None
                frames.append(found)
            # They are told every so often.
            while (statistics := source.statistics)["received"] < 10:
                time.sleep(0.01)
    finally:
        os.close(board)
        os.close(port)
    assert statistics["received"] == 10 and statistics["dropped"] == 0
    assert (statistics["lost"], statistics["corrupt"], statistics["repeated"]) == (2, 1, 0)
    # Closed, it still knows.
    assert source.statistics == statistics | {"waiting": 0}
    troubles = " ".join(statistics["troubles"])
    assert "2 lost" in troubles and "1 corrupt" in troubles, troubles
    sent = np.delete(np.arange(12), [4, 5])
    assert wanted is not None
    for number, frame in zip(sent, frames, strict=True):
        assert frame.device_secs == pytest.approx(0.01 * number) and frame.loads is not None
        np.testing.assert_allclose(frame.loads, wanted[number], rtol=0, atol=1e-6 * wanted.max())
    recorded = taxel.read(tmp_path / "a.mcap")
    assert (recorded.counts == counts[sent]).all() and recorded.missing


def test_asyncio() -> None:
    async def some() -> tuple[int, int]:
        seen, turns = 0, 0

        async def others() -> None:
            nonlocal turns
            while True:
                await asyncio.sleep(0.001)
                turns += 1

        other = asyncio.create_task(others())
        async with taxel.live("sim:mat-16x16-cd4067?fps=20") as source:
            async for _ in source:
                seen += 1
                if seen == 8:
                    break
        other.cancel()
        return seen, turns

    seen, turns = asyncio.run(some())
    # The loop was free while no frame came.
    assert seen == 8 < turns


def test_asyncio_can_be_told_to_end() -> None:
    async def waits(source: taxel.Live) -> None:
        async with source:
            async for _ in source:
                pass

    async def some() -> str:
        source = taxel.live("udp:127.0.0.1:0", "econe")
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(waits(source), 0.3)
        return source.state

    assert asyncio.run(some()) == "closed"


def test_a_source_that_cannot_be_is_refused(tmp_path: Path) -> None:
    for address, words in (
        ("serail:/dev/ttyACM0", "serial"),
        ("sim:econe?hnad", "hand"),
        ("serial:/dev/ttyACM0", "sensor"),
        (f"file:{tmp_path / 'none.mcap'}", "none.mcap"),
    ):
        with pytest.raises(taxel.Error, match=words):
            taxel.live(address)
    for queue in (0, -1):
        with pytest.raises(taxel.Error, match=f"queue {queue}"):
            taxel.live("sim:econe", queue=queue)
    with taxel.live("udp:127.0.0.1:0", "econe") as silent:
        assert silent.next(timeout=0.1) is None
        for timeout in (-1.0, float("nan")):
            with pytest.raises(taxel.Error, match="a timeout of (-1|NaN) s"):
                silent.next(timeout=timeout)
