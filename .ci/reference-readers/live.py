"""Frames that taxel serves to Foxglove while a recording is played, read by a WebSocket client and Foxglove's schemas."""

import json
import re
import struct
import subprocess

import numpy as np
from foxglove_schemas_protobuf import Grid_pb2, RawImage_pb2
from websockets.sync.client import connect

CELL = np.dtype({"names": ["newtons", "mark"], "formats": ["<f4", "u1"], "offsets": [0, 4], "itemsize": 5})
TOPICS = ["/taxel/loads", "/taxel/loads/image", "/taxel/figures"]


def received(url, count):
    """So many messages of each topic, by topic: pairs of time and payload."""
    found = {topic: [] for topic in TOPICS}
    with connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None) as client:
        channels = {}
        while len(channels) < len(TOPICS):
            message = client.recv(timeout=20)
            told = json.loads(message) if isinstance(message, str) else {}
            channels |= {channel["id"]: channel for channel in told.get("channels", [])}
        named = {channel["topic"]: channel["schemaName"] for channel in channels.values()}
        assert named == dict(zip(TOPICS, ["foxglove.Grid", "foxglove.RawImage", "taxel.FrameFigures"])), named
        wanted = [{"id": number, "channelId": number} for number in channels]
        client.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
        while min(map(len, found.values())) < count:
            message = client.recv(timeout=20)
            if isinstance(message, bytes) and message[0] == 1:
                channel, at = struct.unpack("<IQ", message[1:13])
                found[channels[channel]["topic"]].append((at, message[13:]))
    return found


def served(taxel, words, count=12):
    """What `taxel WORDS` serves: frames of newtons and marks, the same as images, the figures; by time, the ones that all have."""
    run = subprocess.Popen(
        [taxel, *words.split(), "--listen=127.0.0.1:0", "--foxglove=127.0.0.1:0"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    try:
        said = []
        while not (match := re.search(r"ws://\S+", said[-1] if said else "")):
            said.append(run.stderr.readline())
            assert said[-1], f"taxel {words}: {said}"
        found = received(match[0], count)
    finally:
        run.kill()
        run.communicate()
    grids = {at: Grid_pb2.Grid.FromString(data) for at, data in found[TOPICS[0]]}
    images = {at: RawImage_pb2.RawImage.FromString(data) for at, data in found[TOPICS[1]]}
    figures = {at: json.loads(data) for at, data in found[TOPICS[2]]}
    times = sorted(grids.keys() & images.keys() & figures.keys())
    for at in times:
        assert grids[at].timestamp.ToNanoseconds() == at == images[at].timestamp.ToNanoseconds()
    return [grids[at] for at in times], [images[at] for at in times], [figures[at] for at in times]
