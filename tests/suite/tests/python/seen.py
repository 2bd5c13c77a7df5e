"""Prints what can be seen in a log: the digest that `keeps.py` prints of a run."""

import hashlib
import sys

import rusty

digest = hashlib.sha256()
for tick in rusty.join(log=sys.argv[1]):
    digest.update(repr((tick.index, tick.time_s, tick.encoders, tick.command)).encode())
    if tick.ranges is not None:
        digest.update(tick.ranges.tobytes())
print(digest.hexdigest())
