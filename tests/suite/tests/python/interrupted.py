"""Joins by name as a notebook does, `interrupted.py RUN FILE`, writes the file in
the body of its loop, and is busy there until Ctrl-C."""

import sys
import time

import rusty

for tick in rusty.join("python", run=sys.argv[1]):
    tick.answer(0.0, 0.0, 0.0)
    if tick.index == 3:
        open(sys.argv[2], "w").close()
        while True:
            time.sleep(0.01)
