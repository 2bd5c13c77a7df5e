"""Forks with scans at hand: what exists stays what it was in the fork while the
run goes on without it, and what does not exist yet is refused."""

import os
import sys

import rusty

kept, unread, child, scans = [], None, None, 0
pipe_in, pipe_out = os.pipe()


def look():
    """In the fork, after the parent has let go of everything and gone on."""
    os.close(pipe_out)
    while os.read(pipe_in, 1):
        pass
    for array, was in kept:
        assert array.tobytes() == was, "a scan has changed in the fork"
    try:
        unread.ranges
    except RuntimeError as error:
        assert "is a fork" in str(error), error
    else:
        raise AssertionError("a fork reads a frame that nobody keeps")
    assert old.ranges is kept[0][0]
    sys.exit(0)


after = []
for tick in rusty.join():
    if "with a scan" in repr(tick):
        scans += 1
        if scans <= 2:
            kept.append((tick.ranges, tick.ranges.tobytes()))
            assert type(tick.ranges.base).__name__ == "Frame"
            old = tick if scans == 1 else old
        elif scans == 3:
            unread = tick
            child = os.fork()
            if child == 0:
                look()
            os.close(pipe_in)
            kept, unread, old = [], None, None
        else:
            # Two frames are the fork's, one is left for arrays of this process.
            after.append(type(tick.ranges.base).__name__)
            if scans == 6:
                third = tick.ranges
    tick.answer(0.0, 0.0, 0.0)
os.close(pipe_out)
assert os.waitpid(child, 0)[1] == 0, "the fork found something else"
assert after[:3] == ["Frame"] * 3 and set(after[3:]) == {"NoneType"}, after
