"""Evaluations and reports are the command's."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import taxel

PLAN = """format = 1
title = "Blobs"
sensor = "mat-32x32-adg732"
resamples = 200

[[experiment]]
kind = "accuracy"
name = "Six frames"
recording = "counts.npy"
truth_g = "loads.npy"
methods = ["raw", "auto"]
"""


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    """A plan, and the recording that it names with its true loads."""
    drawn = taxel.simulate("mat-32x32-adg732", pattern="blobs", frames=6, seed=4)
    np.save(tmp_path / "counts.npy", drawn.counts)
    np.save(tmp_path / "loads.npy", drawn.loads / 9.80665e-3)
    file = tmp_path / "plan.toml"
    file.write_text(PLAN)
    return file


def test_an_evaluation_is_the_commands(plan: Path, command: Callable[..., str]) -> None:
    assert taxel.evaluate(plan) == json.loads(command("evaluate", plan, "--json"))


def test_a_report_is_the_commands(plan: Path, command: Callable[..., str], tmp_path: Path) -> None:
    assert taxel.report(plan, tmp_path / "a.html") == str(tmp_path / "a.html")
    command("report", plan, "-o", tmp_path / "b.html")
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_an_identification_is_the_commands(command: Callable[..., str], tmp_path: Path) -> None:
    fingers = taxel.simulate("mat-16x16-cd4067", pattern="fingers", frames=6, seed=2).counts
    even = taxel.simulate("mat-16x16-cd4067", pattern="uniform", frames=2, seed=3).counts
    np.save(tmp_path / "fingers.npy", fingers)
    np.save(tmp_path / "even.npy", even)
    uniform = tmp_path / "uniform.csv"
    uniform.write_text("recording,frame,load_g\neven.npy,0,50\neven.npy,1,50\n")
    recording, options = tmp_path / "fingers.npy", ("--equilibration", uniform, "--json")
    # Of no sensor everything is assumed, and said.
    told = json.loads(command("identify", recording, "--rows", 16, *options))
    assert taxel.identify(recording, rows=16, equilibration=uniform) == told
    assert told["assumed"] and told["standings"][0]["topology"] == "divider-floating"
    known = json.loads(command("identify", recording, "--sensor", "mat-16x16-cd4067", *options))
    assert taxel.identify([recording], "mat-16x16-cd4067", equilibration=uniform) == known
    assert known["assumed"] == []
    with pytest.raises(taxel.FileError, match=r"none\.npy"):
        taxel.identify(tmp_path / "none.npy", rows=16)
    np.save(tmp_path / "still.npy", np.zeros((3, 16, 16), np.uint16))
    with pytest.raises(taxel.Error, match="no taxel of 3 frames"):
        taxel.identify(tmp_path / "still.npy", rows=16)


def test_what_is_no_plan_or_no_page_is_said(plan: Path, tmp_path: Path) -> None:
    with pytest.raises(taxel.Error, match="ends in .html"):
        taxel.report(plan, tmp_path / "a.docx")
    with pytest.raises(taxel.Error, match=r"none\.toml"):
        taxel.evaluate(tmp_path / "none.toml")
    plan.write_text(PLAN.replace("truth_g", "truth"))
    with pytest.raises(taxel.Error, match="truth"):
        taxel.report(plan, tmp_path / "a.html")
    assert not (tmp_path / "a.html").exists()
