"""A calibration by arrays is the command's by files, and says what it cannot do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import taxel


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
    command("calibrate", "--sensor", files / "parts.toml", "--presses", files / "presses.csv", "-o", files / "by-command.toml")
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
    assert of_table.plot().axes
    assert "60 presses" in repr(of_table)


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
