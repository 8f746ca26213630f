"""A table is what other libraries take for one, and what stands in its cells comes back."""

from __future__ import annotations

import csv
import pickle
from pathlib import Path

import numpy as np
import pandas
import polars
import pytest

import taxel

WORDS = ["plain", "a,b", 'the "left" one', "two\nlines"]


@pytest.fixture
def table() -> taxel.Table:
    return taxel.Table(
        {"name": np.array(WORDS, object), "force": np.array([1.5, np.nan, -0.25, 1e-300]), "frames": np.array([0, 1, 2, 2**40])}
    )


def test_others_take_it_as_it_is(table: taxel.Table) -> None:
    for frame in (pandas.DataFrame(table), table.to_pandas()):
        assert list(frame.columns) == list(table) and frame["name"].tolist() == WORDS
        assert frame["frames"].tolist() == table["frames"].tolist() and frame["force"].isna().tolist() == [False, True, False, False]
    for frame in (polars.DataFrame(table), table.to_polars()):
        assert frame.columns == list(table) and frame["name"].to_list() == WORDS and frame["frames"].to_list() == table["frames"].tolist()


def test_a_written_cell_is_read_as_it_was(table: taxel.Table, tmp_path: Path) -> None:
    table.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == WORDS and [int(row["frames"]) for row in rows] == table["frames"].tolist()
    assert rows[1]["force"] == "" and [float(row["force"]) for row in rows[:1] + rows[2:]] == [1.5, -0.25, 1e-300]


def test_tables_of_the_same_cells_are_equal(table: taxel.Table) -> None:
    same = taxel.Table({name: column.copy() for name, column in table.items()})
    assert table == same == pickle.loads(pickle.dumps(table)) and table.rows == 4
    assert not table != same
    same["force"][0] = 1.6
    assert table != same
    assert table != taxel.Table({name: table[name] for name in reversed(table)})
    assert table != taxel.Table({}) and taxel.Table({}).rows == 0
    assert table == dict(table) and table != list(table)
