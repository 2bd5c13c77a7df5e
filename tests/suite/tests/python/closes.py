"""Closes the session from another thread while the loop waits for a tick."""

import sys
import threading
import time

import rusty

session = rusty.join(argv=sys.argv[1:])
closed = []


def close():
    """When the loop has waited for a while."""
    time.sleep(0.3)
    session.close()
    closed.append(True)


closer = threading.Thread(target=close)
closer.start()
# The run is paused: only closing ends this.
ticks = list(session)
closer.join()
assert closed and ticks == [] and session.ending is None, (closed, ticks)
assert next(session, None) is None
print("closed")
