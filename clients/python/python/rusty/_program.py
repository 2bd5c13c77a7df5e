"""What makes a script a participant like any other program: asked to stop, it
says goodbye, and what ends it from outside is a line and not a traceback."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType, TracebackType

from ._rusty import RustyError, _stop_all

_shown = sys.__excepthook__


def take_part() -> None:
    """Called when a script joins as its command line says. Whatever the script
    has installed itself stays."""
    global _shown
    if sys.excepthook is not _show:
        _shown = sys.excepthook
        sys.excepthook = _show
    if threading.current_thread() is not threading.main_thread():
        return
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _terminate)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)


def _terminate(number: int, frame: FrameType | None) -> None:
    _stop_all()
    raise SystemExit("stopped on request")


def _interrupt(number: int, frame: FrameType | None) -> None:
    _stop_all()
    signal.default_int_handler(number, frame)


def _show(
    kind: type[BaseException], error: BaseException, traceback: TracebackType | None
) -> None:
    # The server's refusal, its end, a log that cannot be read: sentences that
    # need no way there.
    if issubclass(kind, RustyError):
        print(f"{os.path.basename(sys.argv[0])}: {error}", file=sys.stderr)
    else:
        _shown(kind, error, traceback)
