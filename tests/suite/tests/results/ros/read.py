"""Reads a bag with two programs that are not ours, and prints on what they agree."""

import json
import sys
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader


def plain(value):
    """A message as numbers, texts and lists."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (bytes, bytearray, memoryview)):
        return list(value)
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    fields = getattr(value, "__slots__", None) or getattr(value, "__dataclass_fields__", None)
    if fields:
        # Names of constants are in capitals.
        names = [name for name in fields if "msgtype" not in name and not name.isupper()]
        return {name.lstrip("_"): plain(getattr(value, name)) for name in names}
    return value


def main(bag: Path) -> dict:
    counts = {"rosbags": {}, "mcap": {}}
    decoded, ranges, frames = [], [], {}
    with AnyReader([bag]) as reader:
        for connection, stamp, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            name = connection.topic
            counts["rosbags"][name] = counts["rosbags"].get(name, 0) + 1
            decoded.append((stamp, name, json.dumps(plain(message), sort_keys=True)))
            if name == "/scan":
                ranges += message.ranges.view(np.uint32).tolist()
            if name in ("/tf", "/tf_static"):
                frames.update({t.child_frame_id: t.header.frame_id for t in message.transforms})
    others = []
    with open(next(bag.glob("*.mcap")), "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, record, message in reader.iter_decoded_messages():
            name = channel.topic
            counts["mcap"][name] = counts["mcap"].get(name, 0) + 1
            others.append((record.log_time, name, json.dumps(plain(message), sort_keys=True)))
    different = len(set(decoded) ^ set(others)) + abs(len(decoded) - len(others))
    return {**counts, "different": different, "ranges": ranges, "frames": frames}


print(json.dumps(main(Path(sys.argv[1]))))
