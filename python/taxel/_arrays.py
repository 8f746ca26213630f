"""Arrays of any kind as what the compiled part takes: frames × rows × columns, row by row, native numbers."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import ArrayError

_NATIVE = {np.dtype(kind) for kind in ("u1", "u2", "u4", "i2", "i4", "i8", "f4", "f8")}


def frames_of(array: ArrayLike, what: str = "frames") -> tuple[NDArray[Any], bool]:
    """The frames, and whether there was one alone (rows × columns).

    Nothing is copied that lies row by row already and has a type of its own: copied are Fortran order, steps, foreign byte
    order, and rarer types.
    """
    if isinstance(array, np.ma.MaskedArray) and np.ma.is_masked(cast(Any, array)):
        mask: NDArray[np.bool_] = np.ma.getmaskarray(cast(Any, array))
        masked = int(mask.sum())
        raise ArrayError(
            f"{masked} of {mask.size} numbers of the {what} are masked\n"
            "hint: array.filled(0) gives numbers, and marks=taxel.MARKS['open'] * numpy.ma.getmaskarray(array) says that they are none"
        )
    found = np.asarray(array)
    if found.dtype.kind not in "uif":
        raise ArrayError(
            f"{what} of type {found.dtype}, but whole or real numbers are needed\n"
            "hint: array.astype(numpy.uint16), or numpy.float64"
        )
    if found.ndim not in (2, 3):
        raise ArrayError(
            f"{what} of {found.ndim} axes {found.shape}, but 2 (one frame: rows, columns) or 3 (frames, rows, columns) are needed"
        )
    is_one = found.ndim == 2
    if is_one:
        found = found[np.newaxis]
    if found.dtype not in _NATIVE or not found.dtype.isnative:
        found = found.astype(np.float64)
    return np.ascontiguousarray(found), is_one


def codes_of(marks: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.uint8] | None:
    """Codes of marks for frames of this shape; none where all are good."""
    if marks is None:
        return None
    codes = np.asarray(marks)
    if codes.ndim == 2:
        codes = codes[np.newaxis]
    if codes.shape != shape:
        raise ArrayError(f"marks of shape {codes.shape} for frames of shape {shape}")
    # One number for all of them.
    if codes.size and not any(codes.strides) and codes.flat[0] == 0:
        return None
    if codes.dtype.kind not in "ub" and not (codes.dtype.kind == "i" and (codes.size == 0 or codes.min() >= 0)):
        raise ArrayError(f"marks of type {codes.dtype}, but codes are whole numbers from 0 on\nhint: taxel.MARKS names them")
    if codes.size and codes.max() > 255:
        raise ArrayError(f"a mark of code {codes.max()}\nhint: taxel.MARKS names them")
    return np.ascontiguousarray(codes, dtype=np.uint8)


def times_of(time: ArrayLike | None, frames: int) -> NDArray[np.float64] | None:
    """Seconds, one a frame."""
    if time is None:
        return None
    times = np.ascontiguousarray(time, dtype=np.float64)
    if times.shape != (frames,):
        raise ArrayError(f"times of shape {times.shape} for {frames} frames")
    return times


def tare_of(tare: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.float64] | None:
    """Newtons to take off, for frames of this shape: one for all frames, or one each."""
    if tare is None:
        return None
    zeros = np.asarray(tare, dtype=np.float64)
    if zeros.shape not in (shape, shape[1:]):
        raise ArrayError(f"a tare of shape {zeros.shape} for frames of shape {shape}")
    if zeros.ndim == 2:
        zeros = zeros[np.newaxis]
    elif zeros.strides[0] == 0:
        zeros = zeros[:1]
    if not np.isfinite(zeros).all():
        raise ArrayError("a tare that is no number\nhint: the mean load of frames without load")
    return np.ascontiguousarray(zeros)
