"""A table: columns by name, and what other libraries make of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import polars


class Table(Mapping[str, NDArray[Any]]):
    """Columns of equal length, by name: ``pandas.DataFrame(table)`` and ``polars.DataFrame(table)`` take it as it is."""

    def __init__(self, columns: Mapping[str, NDArray[Any]]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(next(iter(self._columns.values()), ()))

    def __repr__(self) -> str:
        return f"<taxel.Table of {self.rows} rows: {', '.join(self._columns)}>"

    def to_pandas(self) -> pandas.DataFrame:
        """As a ``pandas.DataFrame``."""
        import pandas

        return pandas.DataFrame(self._columns)

    def to_polars(self) -> polars.DataFrame:
        """As a ``polars.DataFrame``."""
        import polars

        return polars.DataFrame(self._columns)

    def to_csv(self, path: str) -> None:
        """Writes it as text, a line a row; a file of that name is replaced."""
        lines = zip(*(column.tolist() for column in self._columns.values()), strict=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(",".join(self._columns) + "\n")
            for line in lines:
                file.write(",".join("" if value != value else str(value) for value in line) + "\n")


def concatenated(tables: list[Table]) -> Table:
    """The rows of all, one after the other."""
    return Table({name: np.concatenate([table[name] for table in tables]) for name in tables[0]})
