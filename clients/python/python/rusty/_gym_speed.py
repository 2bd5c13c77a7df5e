"""``python -m rusty.gym``: measures the steps of a second on this machine."""

from __future__ import annotations

import argparse
import json
import os
import time

import numpy as np

from .gym import RustyVectorEnv


def main() -> None:
    """Prints steps per second without and with scans."""
    parser = argparse.ArgumentParser(
        prog="python -m rusty.gym",
        description="Measure the steps of environments per second, without and with scans. "
        "Actions are drawn before; resets of worlds whose episode has ended are included.",
    )
    parser.add_argument("scenario", nargs="?", default="apartment", help="name or file")
    parser.add_argument("--num-envs", type=int, default=1024, metavar="N", help="worlds [1024]")
    parser.add_argument("--threads", type=int, metavar="N", help="threads [one per processor]")
    parser.add_argument("--seconds", type=float, default=2.0, metavar="S", help="of each [2]")
    parser.add_argument("--json", action="store_true", help="print a document")
    args = parser.parse_args()
    try:
        rates = {
            name: _steps_per_s(args, {} if scans else {"scan_every": 0})
            for name, scans in (("without_scans", False), ("with_scans", True))
        }
    except (ValueError, OSError) as error:
        parser.error(str(error))
    if args.json:
        print(json.dumps({"num_envs": args.num_envs, "cpus": os.cpu_count(), "steps_per_s": rates}))
        return
    print(f"{args.scenario}, {args.num_envs} environments, steps per second")
    for name, rate in rates.items():
        print(f"{name.replace('_', ' '):<14} {rate:>12,.0f}")


def _steps_per_s(args: argparse.Namespace, changes: dict[str, int]) -> float:
    envs = RustyVectorEnv(
        args.num_envs, args.scenario, set=changes, threads=args.threads, flat=True
    )
    envs.reset(seed=0)
    envs.action_space.seed(0)
    # Ahead, so that the robot goes from room to room and to walls.
    actions = [np.abs(envs.action_space.sample()) for _ in range(16)]
    steps, start = 0, time.perf_counter()
    while time.perf_counter() - start < args.seconds:
        for action in actions:
            envs.step(action)
        steps += len(actions)
    elapsed_s = time.perf_counter() - start
    return steps * envs.num_envs / elapsed_s


if __name__ == "__main__":
    main()
