"""What can go wrong, in words: what, where, both numbers, and a hint."""

from __future__ import annotations


class Error(Exception):
    """Anything that Taxel refuses.

    Attributes
    ----------
    message : str
        What is wrong, and where.
    hint : str or None
        What to do about it.
    """

    def __init__(self, text: str) -> None:
        super().__init__(text)
        message, _, hint = text.partition("\nhint: ")
        self.message: str = message
        self.hint: str | None = hint or None

    def __str__(self) -> str:
        return f"{self.message}\nhint: {self.hint}" if self.hint else self.message

    def __reduce__(self) -> tuple[type[Error], tuple[str]]:
        return type(self), (str(self),)


class ArrayError(Error, ValueError):
    """An array of the wrong shape, type or content."""


class NoiseOnlyWarning(UserWarning):
    """Standard errors that know nothing but the noise of readings: no calibration has told what the model leaves unexplained."""


class FileError(Error, OSError):
    """A file that cannot be read or written, or what stands in it."""


class SensorError(Error, ValueError):
    """What a sensor file says cannot be, or is not enough for what was asked."""
