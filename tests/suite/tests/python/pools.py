"""A pool of workers at each tick: they end when it does, and the run goes on."""

import multiprocessing

import rusty

context = multiprocessing.get_context("fork")
for tick in rusty.join():
    with context.Pool(4) as pool:
        assert pool.map(abs, [-1, -2]) == [1, 2]
    tick.answer(0.0, 0.0, 0.0)
