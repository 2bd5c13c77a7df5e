"""Joins, says so by a file, and waits."""

import sys

import rusty

session = rusty.join(argv=sys.argv[1:-1])
open(sys.argv[-1], "w").close()
for tick in session:
    tick.answer(0.0, 0.0, 0.0)
