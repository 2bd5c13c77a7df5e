"""Take part in a run of Rusty's laboratory from Python.

A filter is a loop that answers ticks::

    import rusty

    for tick in rusty.join("my-filter"):
        tick.answer(x, y, theta)  # optional: covariance=, command=, innovation=

The answer is the acknowledgement: the next tick happens when everyone has
answered this one. A tick left without an answer abstains when the loop goes on.
``rusty.start`` is what this participant was told: time step, robot, LiDAR, and
map and initial pose where they are given.

What leaves the loop before the run is over (``break``, ``sys.exit``, an
exception) is this client's own failure to the run, and the server learns of it
at once. Ctrl-C is no failure: the run is told that this client leaves. A process
that its server launched leaves
its traceback in the run's folder, in ``<name>.txt``. In a notebook a traceback
keeps the loop's session, so that the run waits for it until its time is over;
there write ``with rusty.join(run="lab") as session: ...``, which leaves at once.
"""

from __future__ import annotations

import atexit as _atexit
import os as _os
import typing as _typing

from ._launch import LaunchError, Record, Run, RunLost, launch
from ._log import LogWarning, RunLog, read_log
from ._rusty import (
    LAYOUT_HASH,
    PROTOCOL_VERSION,
    SE2,
    Dropped,
    Lidar,
    Refused,
    Robot,
    RustyError,
    ServerGone,
    Session,
    Start,
    Tick,
    World,
    __version__,
    _before_fork,
    _last_start,
    _leave_all,
    join,
    odometry_delta,
    wrap_angle,
)
from ._sweep import kubernetes_job, sweep

if _typing.TYPE_CHECKING:
    #: The start of the session that joined last.
    start: Start

__all__ = [
    "LAYOUT_HASH",
    "PROTOCOL_VERSION",
    "SE2",
    "Dropped",
    "LaunchError",
    "Lidar",
    "LogWarning",
    "Record",
    "Refused",
    "Robot",
    "Run",
    "RunLog",
    "RunLost",
    "RustyError",
    "ServerGone",
    "Session",
    "Start",
    "Tick",
    "World",
    "__version__",
    "join",
    "kubernetes_job",
    "launch",
    "odometry_delta",
    "read_log",
    "sweep",
    "wrap_angle",
]

# A session that something still refers to when the interpreter ends, a
# traceback or a global, must not leave its run waiting.
_atexit.register(_leave_all)
# A fork has the arrays over frames as well, and must find in them what was there.
_os.register_at_fork(before=_before_fork)


class _NotJoined(RuntimeError, AttributeError):
    """There is no ``rusty.start`` yet; so ``hasattr`` says that, too."""


def __getattr__(name: str) -> object:
    """``rusty.start``: the start of the session that joined last."""
    if name == "start":
        try:
            return _last_start()
        except RuntimeError as error:
            raise _NotJoined(str(error)) from None
    raise AttributeError(f"module 'rusty' has no attribute {name!r}")
