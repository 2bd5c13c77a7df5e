"""Joins, waits, and says so by a file when it has waited for a while: before the
server knows of a participant, what it says on leaving may be lost with it."""

import sys
import threading

import rusty

session = rusty.join(argv=sys.argv[1:-1])
threading.Timer(0.3, lambda: open(sys.argv[-1], "w").close()).start()
for tick in session:
    tick.answer(0.0, 0.0, 0.0)
