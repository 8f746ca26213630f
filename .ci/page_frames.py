"""The frames that the viewer's page is given, taken as the page takes them; for checks in Python without a browser."""

import base64
import os
import socket
import struct


def page_frames(host, port, token=None, patience=10):
    """Binary messages of the server's WebSocket, for ever. `OSError` where the link breaks or says nothing for `patience` seconds."""
    query = f"?token={token}" if token else ""
    key = base64.b64encode(os.urandom(16)).decode()
    with socket.create_connection((host, port), timeout=patience) as link:
        link.sendall(
            f"GET /live{query} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        stream = link.makefile("rb")
        if b" 101 " not in stream.readline():
            raise OSError("no WebSocket")
        while stream.readline().strip():
            pass
        while True:
            kind, payload = message(stream)
            if kind == 2:
                yield payload
                # It waits until those on their way have come.
                send(link, 1, b'{"do":"got","sequence":0}')
            elif kind == 9:
                send(link, 10, payload)
            elif kind == 8:
                raise OSError("the server has closed it")


def message(stream):
    head = read(stream, 2)
    length = head[1]
    if length == 126:
        (length,) = struct.unpack(">H", read(stream, 2))
    elif length == 127:
        (length,) = struct.unpack(">Q", read(stream, 8))
    return head[0] & 15, read(stream, length)


def read(stream, count):
    found = stream.read(count)
    if len(found) < count:
        raise OSError("the link has ended")
    return found


def send(link, kind, payload):
    # Clients mask what they send; with zeros it stays what it is.
    link.sendall(bytes([128 | kind, 128 | len(payload), 0, 0, 0, 0]) + payload)
