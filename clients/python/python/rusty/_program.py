"""What makes a script a participant like any other program: asked to stop, it
leaves the run, and what ends it from outside is a line and not a traceback."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType, TracebackType

from ._rusty import Dropped, Refused, RustyError, ServerGone, _stop_all

_shown = sys.__excepthook__
_watched = False
"""Whether forks are."""


def take_part() -> None:
    """Called when a script joins as its command line says. Whatever the script
    has installed itself stays."""
    global _shown, _watched
    if sys.excepthook is not _show:
        _shown = sys.excepthook
        sys.excepthook = _show
    leave_on_interrupt()
    if threading.current_thread() is threading.main_thread():
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, _terminate)
            if not _watched:
                _watched = True
                os.register_at_fork(before=_hold, after_in_parent=_release, after_in_child=_leave)


def leave_on_interrupt() -> None:
    """Ctrl-C leaves the run wherever it comes, in the loop's body as well. Only
    where Python's own handler is in place."""
    if threading.current_thread() is not threading.main_thread():
        return
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)


_held = threading.local()


def _hold() -> None:
    """A process that is forked takes no part: SIGTERM ends it, as `multiprocessing` expects.
    One that comes before its handler is gone would be lost, so that it waits."""
    _held.mask = None
    if signal.getsignal(signal.SIGTERM) is _terminate:
        _held.mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})


def _release() -> None:
    if _held.mask is not None:
        signal.pthread_sigmask(signal.SIG_SETMASK, _held.mask)


def _leave() -> None:
    if _held.mask is not None:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _release()


def _terminate(number: int, frame: FrameType | None) -> None:
    _stop_all()
    raise SystemExit("stopped on request")


def _interrupt(number: int, frame: FrameType | None) -> None:
    _stop_all()
    signal.default_int_handler(number, frame)


def _show(
    kind: type[BaseException], error: BaseException, traceback: TracebackType | None
) -> None:
    # Who could not join, or was put out, has done nothing in its code that led
    # there. Any other error needs its traceback.
    outside = isinstance(error, (Refused, ServerGone, Dropped))
    if outside or (isinstance(error, RustyError) and getattr(error, "_joining", False)):
        print(f"{os.path.basename(sys.argv[0])}: {error}", file=sys.stderr)
    else:
        _shown(kind, error, traceback)
