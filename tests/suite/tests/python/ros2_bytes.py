"""Reads messages (a line each: type and bytes in hexadecimal) with rclpy, writes them
again, and prints how many have the same bytes. Between the fields rclpy leaves what was in
memory: a byte that means nothing to it may differ."""

import importlib
import json
import sys

from rclpy.serialization import deserialize_message, serialize_message


def is_padding(data, at, message):
    changed = data[:at] + bytes([data[at] ^ 0xFF]) + data[at + 1 :]
    return deserialize_message(changed, type(message)) == message


same, different = 0, []
for line in open(sys.argv[1]):
    name, text = line.split()
    package, _, kind = name.split("/")
    message_type = getattr(importlib.import_module(f"{package}.msg"), kind)
    data = bytes.fromhex(text)
    message = deserialize_message(data, message_type)
    again = serialize_message(message)
    others = [at for at, byte in enumerate(data) if at < len(again) and again[at] != byte]
    if len(again) == len(data) and all(is_padding(data, at, message) for at in others):
        same += 1
    elif name not in different:
        different.append(name)
print(json.dumps({"same": same, "different": different}))
