"""The native half of `rusty.gym`."""

import numpy as np
from numpy.typing import NDArray

class Worlds:
    """Worlds of one scenario, which differ in their seeds."""

    layout: list[tuple[str, list[int], float, float]]
    command_limits: list[float]
    dt_s: float
    ticks: int
    seeds: list[int]
    digests: list[tuple[str, str]]
    def __init__(self, scenario: str, changes: list[str], count: int, threads: int) -> None: ...
    def restart(self, mask: NDArray[np.bool_], seeds: NDArray[np.uint64]) -> None: ...
    def step(self, commands: NDArray[np.float64], skipped: NDArray[np.bool_]) -> None: ...
    def observe(
        self,
        observations: NDArray[np.float32],
        truth: NDArray[np.float64],
        blocked: NDArray[np.bool_],
        ticks: NDArray[np.uint64],
        digests: NDArray[np.uint64],
    ) -> None: ...
