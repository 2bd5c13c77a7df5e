"""Tries to see another tick's data: keeps scans and pieces of them, past their
ticks, past the run, and lets go of them in odd orders."""

import gc
import hashlib
import random
import sys
import threading

import numpy as np

import rusty

whole, pieces, recent, ticks, digest = [], [], [], [], hashlib.sha256()


def check(kept):
    """Every array is what it was."""
    for array, was in kept:
        assert array.tobytes() == was, "a scan has changed"


over_frames = copies = 0
session = rusty.join()
for tick in session:
    if tick.index <= 150:
        ticks.append(tick)
    digest.update(repr((tick.index, tick.time_s, tick.encoders, tick.command)).encode())
    if tick.ranges is None:
        tick.abstain()
        continue
    scan = tick.ranges
    digest.update(scan.tobytes())
    assert tick.ranges is scan
    assert scan.shape == (rusty.start.lidar.beams,) and scan.dtype == np.float64
    if type(scan.base).__name__ == "Frame":
        over_frames += 1
    else:
        assert scan.base is None
        copies += 1
    for attempt in (
        # A copy is its owner's, who may make it writable.
        lambda: (scan if scan.base is not None else scan[:]).setflags(write=True),
        lambda: scan[3:].setflags(write=True),
        lambda: scan.__setitem__(0, 1.0),
        lambda: np.copyto(scan, 0.0),
        lambda: memoryview(scan).__setitem__(0, 1.0),
    ):
        try:
            attempt()
        except (ValueError, TypeError):
            pass
        else:
            raise AssertionError("a scan can be written")
    piece = scan[3:7][::-1] if tick.index < 100 else scan.reshape(2, -1)[1][5:]
    if tick.index < 100:
        whole.append((scan, scan.tobytes()))
        pieces.append((piece, piece.tobytes()))
    elif tick.index < 150:
        # Only pieces of pieces; nothing is left that holds the whole.
        pieces.append((piece, piece.tobytes()))
    else:
        # Not for ever: later ones lie over frames again.
        recent = [*recent[-1:], (piece, piece.tobytes())]
    if tick.index == 150:
        check(whole)
        check(pieces)
        for kept in ticks:
            # Each tick holds the scan that it handed out.
            assert kept.ranges is None or kept.ranges.shape == scan.shape
        whole.clear()
        ticks.clear()
        del pieces[1:10], kept
    tick.answer(0.0, 0.0, 0.0)
    del scan, piece, tick, attempt
assert over_frames > 30 and copies > 15, (over_frames, copies)

pieces += recent
del recent
check(pieces)
assert session.ending == "done" and next(session, None) is None
del session
gc.collect()
check(pieces)
threads = [threading.Thread(target=check, args=(pieces,)) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
# Each goes on a separate thread, in some order.
random.Random(7).shuffle(pieces)
while pieces:
    bag = [pieces.pop()]
    thread = threading.Thread(target=lambda bag=bag: (check(bag), bag.clear()))
    thread.start()
    thread.join()
    check(pieces)
print(f"seen {digest.hexdigest()} {over_frames} {copies}", file=sys.stderr)
