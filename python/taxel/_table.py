"""A table: columns by name, and what other libraries make of it."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import os

    import pandas
    import polars


# A dict, and no other mapping: of those pandas takes the names alone.
class Table(dict[str, NDArray[Any]]):
    """Columns of equal length, by name: ``pandas.DataFrame(table)`` and ``polars.DataFrame(table)`` take it as it is."""

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return len(next(iter(self.values()), ()))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, dict):
            return NotImplemented
        columns = cast(dict[str, Any], other)
        return list(self) == list(columns) and all(_is_same(column, np.asarray(columns[name])) for name, column in self.items())

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def __repr__(self) -> str:
        return f"<taxel.Table of {self.rows} rows: {', '.join(self)}>"

    def to_pandas(self) -> pandas.DataFrame:
        """As a ``pandas.DataFrame``."""
        import pandas

        return pandas.DataFrame(self)

    def to_polars(self) -> polars.DataFrame:
        """As a ``polars.DataFrame``."""
        import polars

        return polars.DataFrame(dict(self))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Writes it as text, a line a row, NaN as nothing; a file of that name is replaced.

        Raises
        ------
        OSError
            It cannot be written.
        """
        rows = zip(*(column.tolist() for column in self.values()), strict=True)
        with open(path, "w", encoding="utf-8", newline="") as file:
            lines = csv.writer(file, lineterminator="\n")
            lines.writerow(self)
            lines.writerows(["" if value != value else value for value in row] for row in rows)


def _is_same(column: NDArray[Any], other: NDArray[Any]) -> bool:
    """Whether both have the same numbers, or words; numbers that are none are the same."""
    is_real = column.dtype.kind == "f" and other.dtype.kind == "f"
    return np.array_equal(column, other, equal_nan=is_real)
