"""A calibration by arrays is the command's by files, and says what it cannot do."""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest

import taxel

mpl.use("Agg")


@pytest.fixture(scope="module")
def files(command: Callable[..., str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("presses")
    command(
        "simulate", "--sensor", "mat-16x16-cd4067", "--pattern", "press", "--frames", 60, "--seed", 2,
        "--presses", folder / "presses.csv", "-o", folder / "presses.npy",
    )  # fmt: skip
    tables = taxel.Sensor("mat-16x16-cd4067").to_dict()
    for key in ("r_mux_row_ohms", "r_mux_column_ohms"):
        tables["readout"].pop(key, None)
    tables.pop("material", None)
    taxel.Sensor(tables).save(folder / "parts.toml")
    return folder


def presses_of(files: Path) -> taxel.Presses:
    table = np.genfromtxt(files / "presses.csv", delimiter=",", names=True, dtype=None, encoding=None)
    return taxel.Presses(
        frames=np.load(files / "presses.npy"),
        frame=table["frame"],
        row=table["row"],
        column=table["column"],
        load_newtons=table["load_g"] * 9.80665e-3,
    )


def test_arrays_and_tables_give_what_the_command_gives(files: Path, command: Callable[..., str]) -> None:
    said: list[tuple[str, float]] = []
    of_table = taxel.calibrate(
        files / "parts.toml", files / "presses.csv", progress=lambda stage, share: said.append((stage, share))
    )
    of_arrays = taxel.calibrate(files / "parts.toml", presses_of(files))
    told = json.loads(
        command("calibrate", "--sensor", files / "parts.toml", "--presses", files / "presses.csv", "-o", files / "by-command.toml", "--json")
    )
    by_command = taxel.Sensor(files / "by-command.toml").to_dict()
    for found in (of_table, of_arrays):
        tables = found.sensor.to_dict()
        for table in ("readout", "material", "uncertainty"):
            assert flat(tables[table]) == pytest.approx(flat(by_command[table]), rel=1e-6)
    assert said and all(0.0 <= share <= 1.0 for _, share in said)
    assert str(of_table).startswith("fitted")
    error = of_table.held_out_error_newtons
    assert error is not None and 0.0 < error < 0.2
    residuals = of_table.residuals
    assert residuals.rows == residuals["held_out"].sum() * 2
    inside = np.abs(residuals["estimate_newtons"] - residuals["load_newtons"]) <= residuals["half_width_95_newtons"]
    assert inside.mean() > 0.85
    assert of_table.picture("png")[:4] == b"\x89PNG" and of_table.picture("svg")[:4] == b"<svg"
    (picture,) = of_table.plot().axes[0].images
    assert picture.get_array().shape == plt.imread(io.BytesIO(of_table.picture("png"))).shape
    assert of_table._repr_png_() == of_table.picture("png")
    assert of_table.doubts == told["doubts"] == [] and of_table.warnings == told["warnings"]
    by_name = {each["name"]: (each["value"], each["standard_error"]) for each in told["parameters"]}
    assert of_table.parameters.keys() == by_name.keys()
    for name, (value, standard_error) in of_table.parameters.items():
        assert value == pytest.approx(by_name[name][0], rel=1e-6)
        assert standard_error == (None if by_name[name][1] is None else pytest.approx(by_name[name][1], rel=1e-4))
    of_table.save(files / "saved.toml")
    assert taxel.Sensor(files / "saved.toml") == of_table.sensor
    assert taxel.Sensor.from_toml(of_table.to_toml()) == of_table.sensor
    assert "60 presses" in repr(of_table)


def test_uniform_loads_in_arrays_are_those_of_a_table(files: Path) -> None:
    truth = "mat-16x16-cd4067"
    newtons = np.repeat([0.2, 0.5, 1.0, 2.0], 3)
    drawn = taxel.simulate(truth, np.broadcast_to(newtons[:, None, None], (12, 16, 16)), seed=5, imperfect=True)
    np.save(files / "even.npy", drawn.counts)
    lines = [f"even.npy,{frame},{load / 9.80665e-3!r}" for frame, load in enumerate(newtons.tolist())]
    (files / "even.csv").write_text("\n".join(["recording,frame,load_g", *lines, ""]))
    good = presses_of(files)
    of_table = taxel.calibrate(files / "parts.toml", files / "presses.csv", equilibration=files / "even.csv")
    with_arrays = taxel.Presses(**vars(good) | {"uniform_frames": drawn.counts, "uniform_newtons": newtons})
    of_arrays = taxel.calibrate(files / "parts.toml", with_arrays)
    tables = [found.sensor.to_dict()["material"] for found in (of_table, of_arrays)]
    assert flat(tables[0]) == pytest.approx(flat(tables[1]), rel=1e-9)
    # They tell something.
    alone = taxel.calibrate(files / "parts.toml", good).sensor.to_dict()["material"]
    assert flat(alone) != pytest.approx(flat(tables[0]), rel=1e-4)
    assert of_arrays.held_out_error_newtons == pytest.approx(of_table.held_out_error_newtons, rel=1e-9)


def test_a_progress_that_fails_does_not_lose_a_fit_and_is_told(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda what: told.append(what.exc_value))

    def progress(stage: str, share: float) -> None:
        raise RuntimeError(stage)

    assert taxel.calibrate(files / "parts.toml", presses_of(files), law="power", progress=progress).doubts == []
    assert told and all(isinstance(error, RuntimeError) for error in told)


def flat(table: dict[str, object]) -> dict[str, float]:
    return {key: value for key, value in table.items() if isinstance(value, float)}


def test_what_cannot_be_calibrated_is_told(files: Path, tmp_path: Path) -> None:
    good = presses_of(files)

    def presses(**changed: object) -> taxel.Presses:
        return taxel.Presses(**{**vars(good), **changed})  # type: ignore[arg-type]

    for wrong, words in (
        ({"row": np.full(60, 16)}, "row 16, but there are 16"),
        ({"row": np.full(60, -1)}, "row -1"),
        ({"frame": np.full(60, 600)}, "frame 600, but there are 60"),
        ({"load_newtons": np.full(60, -1.0)}, "-1 N is none"),
        ({"load_newtons": np.full(60, np.nan)}, "NaN N is none"),
        ({"load_newtons": np.ones(59)}, "60 columns and 59 loads"),
        ({"row": np.full(60, 1.5)}, "presses.row"),
        ({"uniform_frames": good.frames}, "60 uniform frames and 0 loads"),
        ({"uniform_frames": np.asarray(good.frames)[:, 1:], "uniform_newtons": np.ones(60)}, "15 × 16"),
        ({"uniform_frames": good.frames, "uniform_newtons": np.full(60, -1.0)}, "uniform frame 0: -1 N"),
        ({"load_newtons": np.ones((60, 1))}, "one axis"),
        ({name: getattr(good, name)[:2] for name in ("frame", "row", "column", "load_newtons")}, "press"),
    ):
        with pytest.raises(taxel.Error, match=words):
            taxel.calibrate(files / "parts.toml", presses(**wrong))
    with pytest.raises(taxel.FileError, match="none.csv"):
        taxel.calibrate(files / "parts.toml", tmp_path / "none.csv")
    for options, words in (({"law": "cubic"}, "cubic"), ({"folds": 1}, "1 folds"), ({"label_error": 0.7}, "0.7")):
        with pytest.raises(taxel.Error, match=words):
            taxel.calibrate(files / "parts.toml", good, **options)  # type: ignore[arg-type]
    with pytest.raises(taxel.ArrayError, match="equil|uniform"):
        taxel.calibrate(files / "parts.toml", good, equilibration=files / "presses.csv")
