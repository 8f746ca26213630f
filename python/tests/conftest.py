"""What several tests need."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import taxel

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def command() -> Callable[..., str]:
    """Runs the ``taxel`` command, which the module is held against; a missing one is a failure."""
    program = os.environ.get("TAXEL", str(ROOT / "target" / "debug" / "taxel"))
    assert os.access(program, os.X_OK), f"there is no {program}: cargo build -p taxel-cli makes it, TAXEL names another"

    def run(*arguments: object, code: int = 0, errors: bool = False) -> str:
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=300)
        assert done.returncode == code, done.stderr
        return done.stderr if errors else done.stdout

    return run


@pytest.fixture(scope="session", params=["econe", "mat-16x16-cd4067", "mat-32x32-adg732"])
def preset(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="session")
def grip() -> taxel.Simulation:
    """Twenty frames of a hand on the e-Cone, held."""
    return taxel.simulate("econe", pattern="fingers", frames=20, seed=3)


@pytest.fixture(scope="session")
def insole() -> taxel.Sensor:
    """A 16 × 16 mat of which a third of the crossings carries nothing."""
    tables = taxel.Sensor("mat-16x16-cd4067").to_dict()
    there = np.add.outer(np.arange(16), np.arange(16)) % 3 != 0
    tables["array"]["population"] = there.astype(int).tolist()
    return taxel.Sensor(tables)
