"""XDF, the file format of the lab streaming layer: chunks of a length, a tag and what they hold, little-endian."""

from __future__ import annotations

import os
import struct
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

_FILE_HEADER, _STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _BOUNDARY, _STREAM_FOOTER = range(1, 7)
# What a reader of a damaged file looks for.
BOUNDARY = bytes.fromhex("43a546dccbf5410fb30ed5467383cbe4")


class XdfWriter:
    """Writes a file that must not exist yet; what is in it is whole up to the last chunk, also where the program is killed."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._file: BinaryIO = open(path, "xb")  # noqa: SIM115
        self._file.write(b"XDF:")
        now = time.strftime("%Y-%m-%dT%H:%M:%S%z")
        self._chunk(_FILE_HEADER, f'<?xml version="1.0"?><info><version>1.0</version><datetime>{now}</datetime></info>'.encode())

    def stream_header(self, stream: int, xml: str) -> None:
        """What a stream is: its own description. Before its first samples."""
        self._chunk(_STREAM_HEADER, xml.encode(), stream)

    def samples(self, stream: int, stamps: NDArray[np.float64], values: NDArray[Any]) -> None:
        """Samples with a time stamp each, seconds: samples × channels of numbers, or of bytes where a stream is of strings."""
        if len(stamps) == 0:
            return
        if values.dtype == object:
            content = b"".join(
                b"\x08" + struct.pack("<d", stamp) + b"".join(_length(len(value)) + value for value in sample)
                for stamp, sample in zip(stamps, values.tolist(), strict=True)
            )
        else:
            numbers = values.dtype.newbyteorder("<")
            lines = np.empty(len(stamps), [("bytes", "u1"), ("stamp", "<f8"), ("values", numbers, (values.shape[1],))])
            lines["bytes"], lines["stamp"], lines["values"] = 8, stamps, values
            content = lines.tobytes()
        self._chunk(_SAMPLES, _length(len(stamps)) + content, stream)

    def clock_offset(self, stream: int, measured: float, offset: float) -> None:
        """What is to be added to a stream's time stamps, seconds, and when by the stream's own clock that was measured."""
        self._chunk(_CLOCK_OFFSET, struct.pack("<dd", measured, offset), stream)

    def boundary(self) -> None:
        """A place that a reader of a damaged file finds again; all before it is with the system."""
        self._chunk(_BOUNDARY, BOUNDARY)
        self._file.flush()

    def stream_footer(self, stream: int, first: float, last: float, count: int, offsets: Sequence[tuple[float, float]]) -> None:
        """What a stream came to."""
        info = ElementTree.Element("info")
        for key, value in (("first_timestamp", first), ("last_timestamp", last), ("sample_count", count)):
            ElementTree.SubElement(info, key).text = repr(value)
        told = ElementTree.SubElement(info, "clock_offsets")
        for measured, offset in offsets:
            one = ElementTree.SubElement(told, "offset")
            ElementTree.SubElement(one, "time").text = repr(measured)
            ElementTree.SubElement(one, "value").text = repr(offset)
        xml = '<?xml version="1.0"?>' + ElementTree.tostring(info, encoding="unicode")
        self._chunk(_STREAM_FOOTER, xml.encode(), stream)

    def close(self) -> None:
        """Ends the file."""
        self._file.close()

    def _chunk(self, tag: int, content: bytes, stream: int | None = None) -> None:
        head = struct.pack("<H", tag) + (b"" if stream is None else struct.pack("<I", stream))
        self._file.write(_length(len(head) + len(content)) + head + content)


def _length(length: int) -> bytes:
    """A length: how many bytes it has, then these."""
    if length < 1 << 8:
        return struct.pack("<BB", 1, length)
    if length < 1 << 32:
        return struct.pack("<BI", 4, length)
    return struct.pack("<BQ", 8, length)
