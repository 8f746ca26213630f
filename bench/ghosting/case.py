"""A case and an answer to it, as files: what README.md calls the format, in one place.

Entries may use this module or not; the contract is the files alone.
"""

import csv
import json
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

NOT_FOR_ME = 77  # an entry's exit code for a case that it was not made for


@dataclass
class Case:
    """What an entry is given; counts, presses, uniform and empty are frames × rows × columns."""

    folder: Path
    sensor: dict
    counts: np.ndarray
    press_frames: np.ndarray
    press_taxels: np.ndarray  # n × 2: row and column of the press with a known load
    press_loads_g: np.ndarray
    uniform_frames: np.ndarray
    uniform_loads_g: np.ndarray
    empty_frames: np.ndarray

    @property
    def topology(self):
        return self.sensor["readout"]["topology"]

    @property
    def shape(self):
        return self.counts.shape[1:]

    def at_presses(self, frames):
        """The value of each labelled taxel in its frame, of frames made from `press_frames`."""
        rows, columns = self.press_taxels.T
        return frames[np.arange(len(frames)), rows, columns]


def read_case(folder):
    folder = Path(folder)
    sensor = tomllib.loads((folder / "sensor.toml").read_text())
    labels = _table(folder / "presses.csv")
    presses, uniform = np.load(folder / "presses.npy"), np.load(folder / "uniform.npy")
    frames = [int(line["frame"]) for line in labels]
    levels = _table(folder / "uniform.csv")
    return Case(
        folder=folder,
        sensor=sensor,
        counts=np.load(folder / "counts.npy"),
        press_frames=presses[frames],
        press_taxels=np.array([[int(line["row"]), int(line["column"])] for line in labels]),
        press_loads_g=np.array([float(line["load_g"]) for line in labels]),
        uniform_frames=uniform[[int(line["frame"]) for line in levels]],
        uniform_loads_g=np.array([float(line["load_g"]) for line in levels]),
        empty_frames=np.load(folder / "empty.npy"),
    )


def _table(file):
    with open(file, newline="") as lines:
        return list(csv.DictReader(lines))


def write_answer(folder, loads_g, ms_per_frame, setup_s=None, half_g=None, siemens=None):
    """Writes what the scorer reads."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    np.save(folder / "loads.npy", loads_g)
    for name, values in (("half", half_g), ("siemens", siemens)):
        if values is not None:
            np.save(folder / f"{name}.npy", values)
    timing = {"ms_per_frame": ms_per_frame}
    if setup_s is not None:
        timing["setup_s"] = setup_s
    (folder / "timing.json").write_text(json.dumps(timing))


def folders_of_arguments():
    """CASE_DIR and OUT_DIR of the command line, which are its last two words."""
    if len(sys.argv) < 3:
        sys.exit(f"usage: {sys.argv[0]} CASE_DIR OUT_DIR")
    return Path(sys.argv[-2]), Path(sys.argv[-1])


def decline(why):
    """Ends an entry on a case that it was not made for."""
    print(why, file=sys.stderr)
    sys.exit(NOT_FOR_ME)
