"""Live frames: in time, by asyncio, and the oldest left out where Python is slower."""

from __future__ import annotations

import asyncio
import time
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


def test_asyncio() -> None:
    async def some() -> int:
        seen = 0
        async with taxel.live("sim:mat-16x16-cd4067?fps=200") as source:
            async for _ in source:
                seen += 1
                if seen == 8:
                    break
        return seen

    assert asyncio.run(some()) == 8


def test_a_source_that_cannot_be_is_refused(tmp_path: Path) -> None:
    for address, words in (
        ("serail:/dev/ttyACM0", "serial"),
        ("sim:econe?hnad", "hand"),
        ("serial:/dev/ttyACM0", "sensor"),
        (f"file:{tmp_path / 'none.mcap'}", "none.mcap"),
    ):
        with pytest.raises(taxel.Error, match=words):
            taxel.live(address)
    with pytest.raises(taxel.Error, match="queue 0"):
        taxel.live("sim:econe", queue=0)
    with taxel.live("udp:127.0.0.1:0", "econe") as silent:
        assert silent.next(timeout=0.1) is None
