"""A run log as numpy arrays."""

from __future__ import annotations

import json
import os
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._rusty import World, read_columns

__all__ = ["LogWarning", "RunLog", "read_log"]


class LogWarning(UserWarning):
    """A log lacks its end, or holds something that is not what was written."""


@dataclass(frozen=True, eq=False)
class RunLog:
    """A run: T ticks, S of them with a scan of B beams.

    Rows are ticks, in order; row t is tick t. Poses are of the body in the
    world frame: x m, y m, theta rad in (−π, π].
    """

    path: Path
    """The file it was read from."""
    header: dict[str, Any] = field(repr=False)
    """What the log says of its run: ``config`` (seed, dt_s, robot, lidar, world, …),
    ``roster``, ``source``, ``writer``, as in the log's own JSON."""
    time_s: NDArray[np.float64] = field(repr=False)
    """(T,) time at the end of each tick, s."""
    encoders: NDArray[np.int64] = field(repr=False)
    """(T, 2) cumulative encoder counts, left and right."""
    commands: NDArray[np.float64] = field(repr=False)
    """(T, 2) command applied in each tick, body frame: m/s, rad/s."""
    truth: NDArray[np.float64] | None = field(repr=False)
    """(T, 3) true poses, rows of NaN where the log has none; None if it has no
    truth at all, as a blind one."""
    scan_ticks: NDArray[np.int64] = field(repr=False)
    """(S,) the ticks that have a scan: ``ranges[s]`` was taken at the end of tick
    ``scan_ticks[s]``."""
    ranges: NDArray[np.float64] = field(repr=False)
    """(S, B) ranges, m; shorter scans end in NaN."""
    readings: dict[str, NDArray[np.float64]] = field(repr=False)
    """By small sensor that the robot has, rows that begin with their tick: ``bumper``
    (sectors as bits), ``imu`` (yaw rate rad/s, acceleration ahead and to the left
    m/s²), ``sonars`` (a range m for each), and one row for each thing that was seen:
    ``doors`` (number), ``landmarks`` (id or −1, range m, bearing rad). A reading in
    which nothing was seen is one row of NaN after its tick."""
    answers: dict[str, NDArray[np.float64]] = field(repr=False)
    """By participant, (T, 3) the poses it answered, rows of NaN where it answered none."""
    covariances: dict[str, NDArray[np.float64]] = field(repr=False)
    """By participant that reported any, (T, 3, 3) covariances of the error τ (m, m,
    rad) with truth = answer ⊞ τ; NaN where it reported none."""
    innovations: dict[str, NDArray[np.float64]] = field(repr=False)
    """By participant that reported any, (T, 2): how surprising each tick's measurements
    were, the normalised innovation squared ν' S⁻¹ ν, and how many numbers were
    measured; NaN where it reported none."""
    digest: str
    """Run digest of the ticks that are here, 32 hexadecimal digits."""
    damaged_ticks: NDArray[np.int64] = field(repr=False)
    """Ticks whose checksum fails: their values are suspect."""
    problem: str | None
    """Why this is not all that was written, in words; None if it is."""

    @property
    def complete(self) -> bool:
        """Nothing is missing and nothing is damaged."""
        return self.problem is None

    @property
    def seed(self) -> int | None:
        """The seed; None for a recording, or a log that does not tell it."""
        simulated = self.header["source"]["kind"] in ("simulated", "forked")
        return self.header["config"]["seed"] if simulated else None

    @property
    def scenario(self) -> str:
        """Name of the scenario."""
        name: str = self.header["config"]["scenario"]
        return name

    @property
    def ticks(self) -> int:
        """T: how many ticks are here."""
        return len(self.time_s)

    def world(self) -> World | None:
        """The walls; None if the log hides them."""
        if not self.header["source"].get("world_known", True):
            return None
        return World.from_json(json.dumps(self.header["config"]["world"]))


def read_log(path: str | os.PathLike[str]) -> RunLog:
    """Reads a run log (``run.log``) into arrays.

    A log that was cut or damaged is read as far as it goes, with a `LogWarning`
    that says so; see `RunLog.complete`.

    Raises:
        FileNotFoundError: there is no such file (or another `OSError` for it).
        RustyError: it is no log, or of another version.
    """
    columns = read_columns(path)
    columns["header"] = json.loads(columns["header"])
    log = RunLog(path=Path(path), **columns)
    if log.problem is not None:
        warnings.warn(f"{log.path}: {log.problem}", LogWarning, stacklevel=2)
    return log
