"""Leaves the run at tick 7, in the way its first argument says."""

import sys

import rusty

how, rest = sys.argv[1], sys.argv[2:]


def work(session):
    """Answers six ticks."""
    for tick in session:
        if tick.index == 7:
            if how == "raise" or how == "kept":
                raise ValueError("boom at seven")
            if how == "log":
                rusty.read_log(__file__)
            if how == "break":
                break
            if how == "exit":
                sys.exit(0)
        tick.answer(0.0, 0.0, 0.0)


session = rusty.join(argv=rest)
if how == "kept":
    # Something refers to it when the interpreter ends.
    work(session)
else:
    holder = [session]
    del session
    work(holder.pop())
