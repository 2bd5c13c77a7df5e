"""A whole run from a script or a notebook: ``sim-server launch`` as a process."""

from __future__ import annotations

import base64
import ctypes
import html
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from importlib import metadata
from pathlib import Path
from typing import IO, Any, Literal, Mapping, Sequence

from ._log import RunLog, read_log
from ._rusty import RustyError
from ._scenario import changes_of, scenario_file

__all__ = ["LaunchError", "Record", "Run", "RunLost", "launch"]

_LOST = 3
"""The exit code of a run that finished, but lost something."""
_PATIENCE_S = 15.0
"""How long the server may take to end a run that is to stop."""
_LIBC = ctypes.CDLL(None)
_PR_SET_PDEATHSIG = 1


class LaunchError(RustyError):
    """The server did not run the scenario to its end; the message is its own."""

    def __init__(self, message: str, exit_code: int, run: Run | None = None) -> None:
        super().__init__(message)
        self.exit_code = exit_code
        """The server's: 1 failed, 2 wrong usage, 3 something was lost; negative: a signal."""
        self.run = run
        """What there is of the run, if it began."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions keep the message alone to be made of again.
        return type(self), (str(self), self.exit_code, self.run)


class RunLost(LaunchError):
    """The run finished, but a participant, data or its end was lost."""


class Record(dict[str, Any]):
    """A dictionary whose entries can also be had as attributes."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            known = ", ".join(self)
            raise AttributeError(f"there is no {name!r} here; there are: {known}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


    def _repr_html_(self) -> str:
        """A table, for notebooks."""
        rows = ((html.escape(key), html.escape(_shown(value))) for key, value in self.items())
        cells = (f"<tr><th>{key}</th><td>{value}</td></tr>" for key, value in rows)
        return f"<table>{''.join(cells)}</table>"


def _shown(value: Any) -> str:
    """A value of a report on one line."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_shown(part)}" for key, part in value.items())
    return "–" if value is None else str(value)


class Run:
    """A run that was made, as the server reports it."""

    def __init__(self, report: dict[str, Any], exit_code: int) -> None:
        self.report = report
        """The whole document that ``sim-server launch --json`` printed."""
        self.exit_code = exit_code
        """The server's: 0, or 3 if something was lost."""
        self.robots: list[Run] = [self]
        """The runs of all robots of the scenario, this one first."""

    @property
    def scores(self) -> list[Record]:
        """One per estimator, in roster order: ``run.scores[0].ate_rmse_m``."""
        scores: list[Record] = self.report["scores"]
        return scores

    def score(self, name: str) -> Record:
        """The scores of one estimator; `KeyError` names those there are."""
        for score in self.scores:
            if score["name"] == name:
                return score
        raise KeyError(f"no scores of {name!r}; there are: {[s['name'] for s in self.scores]}")

    @property
    def digest(self) -> str:
        """Run digest, 32 hexadecimal digits: equal runs have equal ones."""
        digest: str = self.report["digest"]
        return digest

    @property
    def seed(self) -> int | None:
        """The seed of all noise."""
        seed: int | None = self.report["seed"]
        return seed

    @property
    def ticks(self) -> int:
        """Ticks that are complete."""
        ticks: int = self.report["ticks"]
        return ticks

    @property
    def losses(self) -> list[Record]:
        """Who was lost: name, kind and detail."""
        losses: list[Record] = self.report["losses"]
        return losses

    @property
    def log_path(self) -> Path | None:
        """The log's file; None without a logger."""
        path = self.report["log"]
        return None if path is None else Path(path)

    @property
    def pictures(self) -> list[Path]:
        """The pictures' files."""
        return [Path(path) for path in self.report["pictures"]]

    def log(self) -> RunLog:
        """Reads the log; see `read_log`."""
        if self.log_path is None:
            raise FileNotFoundError("this run has no log: there was no logger in its roster")
        return read_log(self.log_path)

    def __repr__(self) -> str:
        seed = "no seed" if self.seed is None else f"seed {self.seed}"
        first = f"<Run {self.report['run']}: {seed}, {self.ticks} ticks, {self.report['ended']}"
        errors = ((s["name"], s.get("ate_rmse_m")) for s in self.scores)
        words = (f"{n} ATE {e:.3f} m" if e is not None else f"{n} unscored" for n, e in errors)
        return "; ".join([first, *words]) + ">"

    def _repr_html_(self) -> str:
        """Scores and picture, for notebooks."""
        heads = {"name": "", "ate_rmse_m": "ATE rmse, m", "final_position_error_m": "at the end, m"}
        rows = [f"<tr>{''.join(f'<th>{head}</th>' for head in heads.values())}</tr>"]
        for score in self.scores:
            cells = (html.escape(_shown(score.get(key))) for key in heads)
            rows.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
        parts = [f"<p>{html.escape(repr(self))}<br>digest <code>{self.digest}</code></p>"]
        parts.append(f"<table>{''.join(rows)}</table>")
        for path in self.pictures:
            if path.suffix == ".svg" and path.is_file():
                data = base64.b64encode(path.read_bytes()).decode("ascii")
                kind = "image/svg+xml;base64"
                parts.append(f'<img alt="The run from above" src="data:{kind},{data}">')
        return "".join(parts)


def launch(
    scenario: str | os.PathLike[str] | Mapping[str, Any] = "apartment",
    *,
    seed: int | Literal["random"] | None = None,
    ticks: int | None = None,
    set: Mapping[str, Any] | None = None,
    add: Mapping[str, str | Sequence[str | os.PathLike[str]] | None] | None = None,
    without: Sequence[str] = (),
    out: str | os.PathLike[str] | None = None,
    run: str | None = None,
    force: bool = False,
    pace: str | float | None = None,
    server: str | os.PathLike[str] | None = None,
    allow_loss: bool = False,
    quiet: bool = True,
) -> Run:
    """Runs a scenario with all its participants, and waits for its end.

    Everything happens in processes of their own, as with ``sim-server launch``;
    nothing of the world is in this one.

    Args:
        scenario: name of a built-in scenario, a scenario file, or a scenario as a
            dictionary (keys as in the file; its paths are relative to the current
            folder).
        seed: seed of all noise; "random" draws one of 64 bits. Default: the scenario's.
        ticks: number of ticks. Default: the scenario's.
        set: fields to change, ``{"robot.slip_std": 0.05, "lidar": {"beams": 360}}``.
        add: estimators to add by name: the command that starts each, as text or as
            a list of words (``[sys.executable, "my_filter.py"]`` is this Python), or
            None if it is started by hand.
        without: participants to leave out, by name.
        out: folder for log, scores and pictures. Default: ``runs/NAME``.
        run: name of the run. Default: the scenario's and a random ending.
        force: replace the folder of a run that is over. Default: such a folder is
            refused, as is one that holds other files.
        pace: "max", "real", or a factor such as 2.5. Default: as fast as it goes.
        server: the program. Default: the ``sim-server`` that the package was installed
            with, else the one on the PATH, else ``target/release/sim-server`` in the
            current folder or one above it.
        allow_loss: return a run that finished but lost something (a participant,
            data, its end) instead of raising `RunLost`: see `Run.losses` and
            ``run.report["remarks"]``.
        quiet: show nothing; otherwise what the server says goes to `sys.stderr`.

    Returns:
        The run; of a scenario with several robots that of the first one, with all of them in
        ``run.robots``.

    Raises:
        LaunchError: the run failed; in the server's own words.
        RunLost: the run finished, but lost something.
        FileNotFoundError: there is no server.
        KeyboardInterrupt: Ctrl-C. It stops the run and waits until nothing is left
            of it; a second one does not wait for the participants.
    """
    program = _find_server(server)
    with tempfile.TemporaryDirectory(prefix="rusty-launch-") as folder:
        words = [program, "launch", scenario_file(scenario, folder), "--json"]
        folder_out = None if out is None else os.fspath(out)
        options = {"seed": seed, "ticks": ticks, "out": folder_out, "run": run, "pace": pace}
        words += [f"--{name}={value}" for name, value in options.items() if value is not None]
        words += [f"--set={change}" for change in changes_of(set)]
        words += [f"--add={_added(name, command)}" for name, command in (add or {}).items()]
        names = [without] if isinstance(without, str) else without
        words += [f"--without={name}" for name in names]
        words += ["--force"] if force else []
        code, printed, said = _run(words, quiet)
    return _outcome(code, printed, said, allow_loss)


def _outcome(code: int, printed: str, said: str, allow_loss: bool) -> Run:
    """The run, or the exception that goes with it."""
    try:
        document = json.loads(printed, object_hook=Record)
        reports = document if isinstance(document, list) else [document]
        robots = [Run(report, code) for report in reports]
        made: Run | None = robots[0]
        robots[0].robots = robots
    except ValueError:
        made = None
    if made is not None and (code == 0 or (code == _LOST and allow_loss)):
        return made
    lines = said.strip().splitlines()
    if made is not None:
        # The first lines are the runs'; a participant that was lost is both told and remarked.
        lines = lines[len(made.robots) :]
        for robot in made.robots:
            for remark in robot.report["remarks"]:
                if remark.split(": ", 1)[-1] not in "\n".join(lines):
                    lines.append(remark)
            if robot.report["log"] is not None:
                lines.append(f"its log: {robot.report['log']}")
    if not lines:
        lines = [f"ended by signal {-code}" if code < 0 else f"exit code {code}, without a word"]
    message = "\n".join(lines)
    error = RunLost if code == _LOST else LaunchError
    raise error(message, code, made)


def _find_server(server: str | os.PathLike[str] | None) -> str:
    """The program to run, as a path."""
    if server is not None:
        named = shutil.which(os.fspath(server))
        if named is None:
            raise FileNotFoundError(f"server: {os.fspath(server)!r} is no program that can be run")
        return os.path.abspath(named)
    installed = _installed_server() or shutil.which("sim-server")
    if installed is not None:
        return installed
    here = Path.cwd()
    for folder in (here, *here.parents):
        built = folder / "target" / "release" / "sim-server"
        if os.access(built, os.X_OK):
            return str(built)
    raise FileNotFoundError(
        "sim-server is neither on the PATH nor in target/release here or above: build it "
        "(`cargo build --release` in the repository) and give its path with server="
    )


def _installed_server() -> str | None:
    """The program that came with this package, if it is from a wheel that has it."""
    try:
        files = metadata.files("rusty-lab") or []
    except metadata.PackageNotFoundError:
        return None
    paths = (str(file.locate()) for file in files if file.name == "sim-server")
    return next((path for path in paths if os.access(path, os.X_OK)), None)


def _added(name: str, command: str | Sequence[str | os.PathLike[str]] | None) -> str:
    """An estimator as ``--add`` has it."""
    if command is None:
        return name
    if not isinstance(command, str):
        command = shlex.join(os.fspath(word) for word in command)
    return f"{name}={command}"


def _run(words: list[str], quiet: bool) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of the server."""
    said: list[str] = []

    def listen(pipe: IO[str]) -> None:
        for line in pipe:
            said.append(line)
            if not quiet:
                sys.stderr.write(line)

    # In a separate session: Ctrl-C on a terminal would reach it a second time.
    # It ends with this thread, which waits for it.
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    server = subprocess.Popen(
        words,
        stdin=subprocess.DEVNULL,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
        preexec_fn=_end_with_parent,
        **pipes,  # type: ignore[call-overload]
    )
    listener = threading.Thread(target=listen, args=(server.stderr,), daemon=True)
    try:
        listener.start()
        assert server.stdout is not None
        printed = server.stdout.read()
        code = server.wait()
    except BaseException:
        _stop(server)
        raise
    finally:
        listener.join(timeout=1.0)
        for pipe in (server.stdout, server.stderr):
            if pipe is not None:
                pipe.close()
    return code, printed, "".join(said)


def _end_with_parent() -> None:
    """In a new process: asks for SIGTERM when the thread that started it ends."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _stop(server: "subprocess.Popen[str]") -> None:
    """Ends the run as Ctrl-C on the server's own terminal would."""
    # Asked a second time it waits for no participant, but still sweeps.
    for ask in (signal.SIGINT, signal.SIGINT, signal.SIGKILL):
        server.send_signal(ask)
        try:
            server.wait(timeout=_PATIENCE_S)
            return
        except (subprocess.TimeoutExpired, KeyboardInterrupt):
            continue
