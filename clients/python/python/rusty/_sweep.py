"""A sweep in shards on many processes or machines: ``sim-server sweep run`` for each."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any, Callable, Literal, Sequence

from ._launch import LaunchError, RunLost, _end_with_parent, _find_server, _run
from ._rusty import toml_json

__all__ = ["kubernetes_job", "sweep"]

_FINAL = (2, 4)
"""Exit codes that do not change when a shard is tried again: usage and other bits."""


class ShardFailed(LaunchError):
    """A shard failed in a way that may not happen again."""


def sweep(
    manifest: str | os.PathLike[str],
    *,
    engine: Literal["local", "ray", "slurm"] = "local",
    out: str | os.PathLike[str] | None = None,
    table: str | os.PathLike[str] | None = None,
    force: bool = False,
    jobs: int | None = None,
    retries: int = 4,
    address: str | None = None,
    options: Sequence[str] = (),
    server: str | os.PathLike[str] | None = None,
    quiet: bool = True,
) -> list[Path]:
    """Makes the shards of a sweep that are missing, and waits for their end.

    Args:
        manifest: file from ``sim-server sweep plan``.
        engine: "local" (processes on this machine), "ray" (a task for each shard, in
            the session of `ray.init` or in a new one), or "slurm" (an array of jobs;
            the script stays in the folder of the parts).
        out: folder of the parts, which all machines share. Default: the manifest's
            name with ``.parts``.
        table: FILE.parquet or FILE.csv to write in the end with ``sim-server sweep
            merge``, with its drawings. Default: none.
        force: whether an existing table and its drawings are replaced.
        jobs: number of shards at a time with "local". Default: one per processor.
        retries: how often a shard is tried again if its process or machine fails.
            Other bits and other settings fail at once. Slurm itself starts the shards
            of a machine that failed again.
        address: address of a Ray cluster. Default: the one that Ray finds, or a new one
            on this machine.
        options: more ``#SBATCH`` options, such as ``["--partition=short"]``.
        server: the program, under this path on all machines. Default: as in `launch`.
        quiet: print no progress on `sys.stderr`.

    Returns:
        The files of the parts, in the order of the shards.

    Raises:
        LaunchError: a shard or the merge failed; in the server's own words.
        RunLost: the table is written, but in a run something was lost.
        FileExistsError: the table is there already.
        FileNotFoundError: there is no server, manifest or ``sbatch``.
        ValueError: a number is too small, or the table has another ending.
        ModuleNotFoundError: Ray is not installed.
    """
    if retries < 0 or (jobs is not None and jobs < 1):
        raise ValueError(f"retries={retries}, jobs={jobs}: expected at least 0 and at least 1")
    if table is not None:
        if Path(table).suffix.lower() not in (".csv", ".parquet"):
            raise ValueError(f"table={os.fspath(table)!r}: expected FILE.parquet or FILE.csv")
        if Path(table).exists() and not force:
            found = os.fspath(table)
            raise FileExistsError(f"{found} is there already; give another table, or force=True")
    path = Path(manifest).absolute()
    plan = _plan(path)
    folder = path.with_suffix(".parts") if out is None else Path(out).absolute()
    program = _find_server(server)
    words = [program, "sweep", "run", str(path), "--out", str(folder), "--json", "--quiet"]
    parts = [folder / f"part-{plan['digest']}-{index}" for index in range(plan["shards"])]
    commands = [[*words, f"--shard={index}"] for index in range(len(parts))]

    def done(count: int) -> None:
        if not quiet:
            sys.stderr.write(f"{count} of {len(parts)} shards\n")

    if engine == "local":
        _with_processes(commands, jobs or os.cpu_count() or 1, retries, done)
    elif engine == "ray":
        _with_ray(commands, address, retries, done)
    elif engine == "slurm":
        _with_slurm(words, folder, len(parts), options)
    else:
        raise ValueError(f'engine={engine!r}: expected "local", "ray" or "slurm"')
    if table is not None:
        merge = [program, "sweep", "merge", str(path), str(folder), "--out", os.fspath(table)]
        code, _, said = _run(merge + (["--force"] if force else []), quiet)
        if code != 0:
            error = RunLost if code == 3 else LaunchError
            raise error(said.strip(), code)
    return parts


def _plan(manifest: Path) -> dict[str, Any]:
    """The fields of a manifest."""
    plan: dict[str, Any] = json.loads(toml_json(manifest.read_text(encoding="utf-8")))
    if not {"digest", "shards"} <= plan.keys():
        raise ValueError(f"{manifest}: expected a manifest from `sim-server sweep plan`")
    return plan


def _make(words: list[str], started: Callable[[Any], None] = lambda process: None) -> None:
    """Makes a shard; fails with `ShardFailed` where another try may help."""
    process = subprocess.Popen(
        words,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        # Ctrl-C is for this process, which passes it on. A worker that is killed takes
        # its shard with it.
        start_new_session=True,
        preexec_fn=_end_with_parent,
    )
    started(process)
    _, said = process.communicate()
    code = process.returncode
    if code != 0:
        message = said.strip() or f"{shlex.join(words)}: ended by signal {-code}"
        raise (LaunchError if code in _FINAL else ShardFailed)(message, code)


def _with_processes(
    commands: list[list[str]], jobs: int, retries: int, done: Callable[[int], None]
) -> None:
    """Makes the shards, `jobs` at a time."""
    processes: list[subprocess.Popen[str]] = []
    stopped = threading.Event()

    def started(process: subprocess.Popen[str]) -> None:
        processes.append(process)
        if stopped.is_set():
            process.send_signal(signal.SIGINT)

    def attempt(words: list[str]) -> None:
        for left in range(retries, -1, -1):
            try:
                return _make(words, started)
            except ShardFailed:
                if left == 0 or stopped.is_set():
                    raise

    with ThreadPoolExecutor(jobs) as pool:
        try:
            futures = [pool.submit(attempt, words) for words in commands]
            for count, future in enumerate(as_completed(futures), 1):
                future.result()
                done(count)
        except BaseException:
            stopped.set()
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.send_signal(signal.SIGINT)
            raise


def _with_ray(
    commands: list[list[str]], address: str | None, retries: int, done: Callable[[int], None]
) -> None:
    """Makes each shard in a task of Ray, with four tasks per processor in flight."""
    import ray

    if not ray.is_initialized():
        ray.init(address=address, log_to_driver=False)
    task = ray.remote(num_cpus=1, max_retries=retries, retry_exceptions=[ShardFailed])(_make)
    bound = 4 * max(1, int(ray.cluster_resources().get("CPU", 1)))
    left, count = commands[::-1], 0
    flight: dict[Any, list[str]] = {}
    try:
        while left or flight:
            while left and len(flight) < bound:
                words = left.pop()
                flight[task.remote(words)] = words
            ended, _ = ray.wait(list(flight), num_returns=1)
            for reference in ended:
                words = flight.pop(reference)
                ray.get(reference)
                count += 1
                done(count)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None
    except ray.exceptions.WorkerCrashedError as error:
        message = f"{shlex.join(words)}: its worker ended {retries + 1} times: {error}"
        raise ShardFailed(message, 1) from None
    finally:
        for reference in flight:
            ray.cancel(reference, force=True)


def _with_slurm(words: list[str], folder: Path, shards: int, options: Sequence[str]) -> None:
    """Makes each shard in a job of an array of Slurm."""
    folder.mkdir(parents=True, exist_ok=True)
    script = folder / "sweep.sbatch"
    script.write_text(_slurm_script(words, folder, shards, options), encoding="utf-8")
    if shutil.which("sbatch") is None:
        raise FileNotFoundError(
            f"there is no sbatch on the PATH; submit {script} on a machine that has it"
        )
    submit = ["sbatch", "--wait", "--parsable", str(script)]
    code, job, said = _run(submit, quiet=True)
    if code != 0:
        logs = folder / f"slurm-{job.strip()}_I.txt"
        message = f"{shlex.join(submit)} failed: {said.strip()}; see {logs} (I: the shard)"
        raise LaunchError(message, code)


def _slurm_script(words: list[str], folder: Path, shards: int, options: Sequence[str]) -> str:
    fixed = [
        "--job-name=sweep",
        f"--array=0-{shards - 1}",
        "--requeue",
        "--ntasks=1",
        "--cpus-per-task=1",
        "--open-mode=append",
        f"--output={shlex.quote(str(folder))}/slurm-%A_%a.txt",
    ]
    lines = [f"#SBATCH {option}" for option in [*fixed, *options]]
    return "\n".join(
        ["#!/bin/sh", *lines, f'exec {shlex.join(words)} --shard "$SLURM_ARRAY_TASK_ID"', ""]
    )


def kubernetes_job(
    manifest: str | os.PathLike[str],
    *,
    image: str,
    claim: str,
    parallelism: int = 16,
    retries: int = 4,
) -> str:
    """Returns an Indexed Job that makes the shards of a sweep, for ``kubectl create -f -``.

    It is JSON, which YAML includes.

    Args:
        manifest: file from ``sim-server sweep plan``. The pods read a copy with the same
            name from the volume.
        image: image with ``sim-server`` on its PATH.
        claim: name of the volume claim with the manifest; the parts go to a folder
            there.
        parallelism: number of pods at a time.
        retries: how often a shard is tried again, but for wrong usage and other bits.

    Raises:
        ValueError: a number is too small, a name is empty, or the file is no manifest.
    """
    path = Path(manifest)
    plan = _plan(path)
    for name, number, least in (("parallelism", parallelism, 1), ("retries", retries, 0)):
        if number < least:
            raise ValueError(f"{name}={number}: expected at least {least}")
    for name, word in (("image", image), ("claim", claim)):
        if not word.strip():
            raise ValueError(f"{name}={word!r}: expected a name")
    files = [f"/sweep/{name}" for name in (path.name, path.with_suffix(".parts").name)]
    source, parts = map(shlex.quote, files)
    command = f'exec sim-server sweep run {source} --shard "$JOB_COMPLETION_INDEX" --out {parts}'
    container = {
        "name": "shard",
        "image": image,
        "command": ["sh", "-c", command],
        "resources": {"requests": {"cpu": "1"}},
        "volumeMounts": [{"name": "sweep", "mountPath": "/sweep"}],
    }
    volume = {"name": "sweep", "persistentVolumeClaim": {"claimName": claim}}
    pod = {"restartPolicy": "Never", "containers": [container], "volumes": [volume]}
    codes = {"containerName": "shard", "operator": "In", "values": list(_FINAL)}
    final = {"action": "FailIndex", "onExitCodes": codes}
    job = {
        "apiVersion": "batch/v1",
        "kind": "Job",
        "metadata": {"generateName": "sweep-"},
        "spec": {
            "completionMode": "Indexed",
            "completions": plan["shards"],
            "parallelism": min(parallelism, plan["shards"]),
            "backoffLimitPerIndex": retries,
            "podFailurePolicy": {"rules": [final]},
            "template": {"spec": pod},
        },
    }
    return json.dumps(job, indent=2) + "\n"
