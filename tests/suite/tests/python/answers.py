"""Says what is no answer, answers twice, late, and from elsewhere."""

import os
import sys
import threading
import time

import numpy as np

import rusty


def refused(kind, words, attempt):
    """The attempt raises this, with these words."""
    try:
        attempt()
    except kind as error:
        assert words in str(error), error
    else:
        raise AssertionError(f"not refused: {words}")


nan, before, seen, gone, spun = float("nan"), None, False, 0, 0
beside_done = threading.Event()


def spin():
    """Counts for as long as it is let."""
    global spun
    while not beside_done.is_set():
        spun += 1
        time.sleep(0)


beside = threading.Thread(target=spin)
beside.start()
refused(AttributeError, "no attribute 'begin'", lambda: rusty.begin)
refused(RuntimeError, "call rusty.join() first", lambda: rusty.start)
refused(AttributeError, "call rusty.join() first", lambda: rusty.start)
assert not hasattr(rusty, "start")
exec("from rusty import *", {})
with rusty.join() as session:
    start = rusty.start
    assert start is session.start and start.name == "python" and start.role == "estimator"
    assert start.map.shape[1] == 4 and len(start.materials) == len(start.map)
    assert not start.map.flags.writeable and start.initial_pose == (6.0, 4.5, 0.0)
    assert start.lidar.bearings_rad[90] == 0.0 and start.robot.track_m == 0.16
    for tick in session:
        n = tick.index
        assert repr(tick).startswith(f"<rusty.Tick {n} at ")
        refused(ValueError, f"tick {n}: estimate x_m is NaN", lambda: tick.answer(nan, 0, 0))
        refused(ValueError, "command omega_rad_s is inf", lambda: tick.answer(0, 0, 0, command=(0, float("inf"))))
        refused(ValueError, "covariance[0][1] is NaN", lambda: tick.answer(0, 0, 0, [[1, nan, 0]] * 3))
        refused(ValueError, "covariance[1][1] is -1", lambda: tick.answer(0, 0, 0, np.diag([1, -1, 1])))
        refused(ValueError, "shape (2, 2)", lambda: tick.answer(0, 0, 0, np.eye(2)))
        refused(ValueError, "numbers of shape (3, 3)", lambda: tick.answer(0, 0, 0, "wide"))
        refused(TypeError, "all three", lambda: tick.answer(1.0, 2.0))
        refused(TypeError, "or abstain()", lambda: tick.answer())
        refused(TypeError, "needs its pose", lambda: tick.answer(covariance=np.eye(3)))
        refused(ValueError, "belief has the shape (2, 2)", lambda: tick.answer(0, 0, 0, belief=np.eye(2)))
        refused(ValueError, "numbers of shape (N, 3)", lambda: tick.answer(0, 0, 0, belief="wide"))
        refused(ValueError, "belief_kind", lambda: tick.answer(0, 0, 0, belief=[[0, 0, 0]], belief_kind="cloud"))
        refused(ValueError, "innovation nis", lambda: tick.answer(0, 0, 0, innovation=(-1.0, 2)))
        if before is not None:
            refused(RuntimeError, f"tick {n - 1} cannot be answered", lambda: before.answer(0, 0, 0))
            if "with a scan" in repr(before) and not seen:
                refused(RuntimeError, "its scan has gone", lambda: before.ranges)
                gone += 1
        before, seen = tick, n < 40 and tick.ranges is not None
        if seen:
            # A fork has no part in the run, whatever it does with what it has.
            child = os.fork()
            if child == 0:
                refused(RuntimeError, "cannot be answered", lambda: tick.answer(9, 9, 9))
                refused(RuntimeError, "is a fork", lambda: next(session))
                session.close()
                del tick, before
                sys.exit(0)
            assert os.waitpid(child, 0)[1] == 0
        if n % 4 == 0:
            covariance = np.array([[1, 0.5, 0], [0.5, 2, 0], [0, 0, 3]], dtype=np.float32)
            given = {"covariance": covariance.T, "command": (0.5, 0.25), "innovation": (2.5, 4)}
            tick.answer(np.float64(n), -1.5, 0.25, **given)
        elif n % 4 == 1:
            other = threading.Thread(target=lambda: tick.answer(command=(0.1, n)))
            other.start()
            other.join()
        elif n % 4 == 2:
            continue
        else:
            tick.abstain()
        refused(RuntimeError, "it was answered", lambda: tick.answer(0, 0, 0))
refused(RuntimeError, "cannot be answered", lambda: before.answer(0, 0, 0))
assert gone > 2
beside_done.set()
beside.join()
assert spun > 100, "nobody else runs while a tick is waited for"
