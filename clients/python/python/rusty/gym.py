"""Gymnasium environments: worlds in this process, for those who learn policies.

One environment, or many that are stepped together on all processors::

    import rusty.gym

    envs = rusty.gym.RustyVectorEnv(256, set={"scan_every": 0})
    observations, infos = envs.reset(seed=42)
    observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())

The frames are those of a run with the same seed and commands, to the bit. No run is
near: these worlds are the caller's, and with them everything that is true in them.
"""

from __future__ import annotations

import math
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._scenario import changes_of, scenario_file

try:
    import gymnasium
    from gymnasium.utils import seeding
    from gymnasium.vector import AutoresetMode
    from gymnasium.vector.utils import batch_space
except ImportError as error:
    raise ImportError(
        f"import of rusty.gym failed: expected gymnasium 1.1 or newer, got: {error}; "
        "install it with `pip install 'gymnasium>=1.1'`"
    ) from None
try:
    from ._gym import Worlds
except ImportError as error:
    raise ImportError(
        f"import of rusty.gym failed: expected its native module rusty._gym, got: {error}; "
        "install the wheel rusty_lab_gym, or `pip install ./sim-server/gym` in the repository"
    ) from None

__all__ = ["Distance", "Goal", "RustyEnv", "RustyVectorEnv", "Step"]

_MAX_SEED = (1 << 64) - 1


@dataclass(frozen=True)
class Step:
    """What a tick did in N worlds: rows are worlds. The arrays are valid during the call."""

    observation: dict[str, NDArray[np.float32]]
    """The parts of the observations, (N, ...) each."""
    before: NDArray[np.float64]
    """(N, 3) true poses before the tick, world frame: x m, y m, theta rad."""
    truth: NDArray[np.float64]
    """(N, 3) true poses after the tick."""
    blocked: NDArray[np.bool_]
    """(N,) whether a wall, a person or another robot stopped the robot."""
    time_s: NDArray[np.float64]
    """(N,) time since the start, s."""


#: Rewards (N,) and terminations (N,) of a tick.
Task = Callable[[Step], "tuple[ArrayLike, ArrayLike]"]


@dataclass(frozen=True)
class Distance:
    """Drive far and touch nothing: the reward is the way driven ahead, m. An episode
    ends where the robot is blocked, with a reward of -1."""

    def __call__(self, step: Step) -> tuple[ArrayLike, ArrayLike]:
        way_m, theta_rad = step.truth[:, :2] - step.before[:, :2], step.before[:, 2]
        ahead_m = way_m[:, 0] * np.cos(theta_rad) + way_m[:, 1] * np.sin(theta_rad)
        return np.where(step.blocked, -1.0, ahead_m), step.blocked


@dataclass(frozen=True)
class Goal:
    """Reach a place: the reward is the way by which it is nearer, m, and 1 at the goal,
    where an episode ends. A robot that is blocked gets -0.01 in each tick."""

    x_m: float
    y_m: float
    radius_m: float = 0.3

    def __post_init__(self) -> None:
        if not (math.isfinite(self.x_m) and math.isfinite(self.y_m) and self.radius_m > 0):
            raise ValueError(f"{self!r}: expected finite coordinates and a radius above 0")

    def __call__(self, step: Step) -> tuple[ArrayLike, ArrayLike]:
        goal = np.array([self.x_m, self.y_m])
        before_m, after_m = (
            np.linalg.norm(poses[:, :2] - goal, axis=1) for poses in (step.before, step.truth)
        )
        reached = after_m <= self.radius_m
        return before_m - after_m + 1.0 * reached - 0.01 * step.blocked, reached


class _Worlds:
    """N worlds, their arrays and their spaces."""

    def __init__(
        self,
        scenario: str | os.PathLike[str] | Mapping[str, Any],
        changes: Mapping[str, Any] | None,
        task: Task,
        flat: bool,
        count: int,
        threads: int,
    ) -> None:
        if not callable(task):
            raise TypeError(f"task {task!r}: expected a function of Step, such as Goal(5.0, 4.5)")
        with tempfile.TemporaryDirectory(prefix="rusty-gym-") as folder:
            words = [*changes_of(changes)]
            self.native = Worlds(scenario_file(scenario, folder), words, count, threads)
        self.task, self.flat, self.count = task, flat, count
        self.dt_s, self.ticks = self.native.dt_s, self.native.ticks
        boxes: dict[str, gymnasium.spaces.Box] = {}
        self.parts: dict[str, tuple[slice, tuple[int, ...]]] = {}
        end = 0
        for name, shape, low, high in self.native.layout:
            boxes[name] = gymnasium.spaces.Box(low, high, tuple(shape), np.float32)
            self.parts[name] = (slice(end, end + int(np.prod(shape))), tuple(shape))
            end = self.parts[name][0].stop
        self.observation_space: gymnasium.Space[Any] = gymnasium.spaces.Dict([*boxes.items()])
        if flat:
            lows, highs = (
                np.concatenate([getattr(box, side).ravel() for box in boxes.values()])
                for side in ("low", "high")
            )
            self.observation_space = gymnasium.spaces.Box(lows, highs, dtype=np.float32)
        limits = np.array(self.native.command_limits, np.float32)
        self.action_space = gymnasium.spaces.Box(-limits, limits, dtype=np.float32)
        self.rows = np.zeros((count, end), np.float32)
        self.before, self.truth = np.zeros((count, 3)), np.zeros((count, 3))
        self.blocked = np.zeros(count, np.bool_)
        self.tick, self.digest = np.zeros(count, np.uint64), np.zeros(count, np.uint64)
        self.is_started = False

    def restart(self, seeds: Mapping[int, int]) -> None:
        """Puts worlds back before their first tick, by index, each with its seed."""
        mask, array = np.zeros(self.count, np.bool_), np.zeros(self.count, np.uint64)
        for index, seed in seeds.items():
            if not 0 <= seed <= _MAX_SEED:
                raise ValueError(f"reset failed: expected a seed from 0 to 2**64 - 1, got {seed}")
            mask[index], array[index] = True, seed
        self.native.restart(mask, array)
        self.is_started = True
        self._observe()

    def commands(self, actions: Any, skipped: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Returns the actions as commands (N, 2), checked for worlds that are not skipped."""
        if not self.is_started:
            raise RuntimeError("step failed: expected worlds that were reset; call reset() first")
        # Numbers of 64 bits keep them all, so that commands of a log can be repeated.
        commands = np.ascontiguousarray(actions, np.float64)
        if commands.shape != (self.count, 2):
            raise ValueError(
                f"step failed: expected actions (v_m_s, omega_rad_s) of shape ({self.count}, 2), "
                f"got {commands.shape}"
            )
        for index in np.flatnonzero(~skipped & ~np.isfinite(commands).all(axis=1)):
            raise ValueError(
                f"step failed: action of environment {index}: expected finite v_m_s and "
                f"omega_rad_s, got {commands[index].tolist()}; check the policy's output"
            )
        return commands

    def step(
        self, commands: NDArray[np.float64], skipped: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_]]:
        """Makes a tick in worlds that are not skipped; returns rewards, terminations and
        truncations."""
        self.native.step(commands, skipped)
        self.before, self.truth = self.truth, self.before
        self._observe()
        time_s = self.tick.astype(np.float64) * self.dt_s
        step = Step(self._named(self.rows), self.before, self.truth, self.blocked, time_s)
        results = self.task(step)
        rewards, terminated = np.array(results[0], np.float64), np.array(results[1], np.bool_)
        for name, array in (("rewards", rewards), ("terminations", terminated)):
            if array.shape != (self.count,):
                raise ValueError(
                    f"step failed: task {self.task!r}: expected {name} of shape ({self.count},), "
                    f"got {array.shape}; a task is given rows for all worlds at once"
                )
        rewards[skipped], terminated[skipped] = 0.0, False
        return rewards, terminated, self.tick >= self.ticks

    def _observe(self) -> None:
        self.native.observe(self.rows, self.truth, self.blocked, self.tick, self.digest)

    def _named(self, rows: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
        """The parts of rows (..., width), as views."""
        return {
            name: rows[..., part].reshape(rows.shape[:-1] + shape)
            for name, (part, shape) in self.parts.items()
        }

    def observations(self, rows: NDArray[np.float32]) -> Any:
        return rows if self.flat else self._named(rows)


def _drawn(generator: np.random.Generator) -> int:
    return int(generator.integers(_MAX_SEED, dtype=np.uint64, endpoint=True))


class RustyEnv(gymnasium.Env[Any, Any]):
    """One world of a scenario. An action is a command of one tick.

    Args:
        scenario: name, file or dictionary, as for `rusty.launch`. Its script and its
            participants take no part.
        set: fields to change, as for `rusty.launch`.
        task: gives rewards and terminations: a function of `Step`.
        truth: put the true pose and ``blocked`` into ``info``.
        flat: observations are one array with all parts in their order.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        scenario: str | os.PathLike[str] | Mapping[str, Any] = "apartment",
        *,
        set: Mapping[str, Any] | None = None,
        task: Task = Distance(),
        truth: bool = False,
        flat: bool = False,
    ) -> None:
        self._worlds, self._truth = _Worlds(scenario, set, task, flat, 1, 1), truth
        self.observation_space = self._worlds.observation_space
        self.action_space = self._worlds.action_space
        self._no_world = np.zeros(1, np.bool_)

    @property
    def world_seed(self) -> int:
        """The seed of the world: that of a run with the same frames."""
        seed: int = self._worlds.native.seeds[0]
        return seed

    @property
    def run_digest(self) -> str:
        """The digest of a run with these frames, in which no participant answers."""
        digest: str = self._worlds.native.digests[0][0]
        return digest

    @property
    def world_digest(self) -> str:
        """The digest of frames and truths, which a run has with any participants."""
        digest: str = self._worlds.native.digests[0][1]
        return digest

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Puts the world back before its first tick. Its seed is `seed`, else one that is
        drawn from those before it."""
        super().reset(seed=seed, options=options)
        self._worlds.restart({0: _drawn(self.np_random) if seed is None else seed})
        return self._observation(), self._info()

    def step(self, action: ArrayLike) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Makes a tick with the command (v_m_s, omega_rad_s)."""
        commands = self._worlds.commands([action], self._no_world)
        rewards, terminated, truncated = self._worlds.step(commands, self._no_world)
        outcome = float(rewards[0]), bool(terminated[0]), bool(truncated[0])
        return (self._observation(), *outcome, self._info())

    def _observation(self) -> Any:
        return self._worlds.observations(self._worlds.rows[0].copy())

    def _info(self) -> dict[str, Any]:
        worlds, tick = self._worlds, int(self._worlds.tick[0])
        info = {"tick": tick, "time_s": tick * worlds.dt_s, "digest": worlds.digest[0]}
        if self._truth:
            info |= {"truth": worlds.truth[0].copy(), "blocked": bool(worlds.blocked[0])}
        return info


class RustyVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """N worlds of a scenario, stepped together: each as a `RustyEnv` with its seed. The
    step after the end of an episode resets its world and does not use its action.

    Args:
        num_envs: number of worlds N.
        threads: number of threads. Default: one for each processor. Results do not
            depend on it.
        copy: return new arrays; otherwise the next step overwrites the observations.

    The others are those of `RustyEnv`.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        scenario: str | os.PathLike[str] | Mapping[str, Any] = "apartment",
        *,
        set: Mapping[str, Any] | None = None,
        task: Task = Distance(),
        truth: bool = False,
        flat: bool = False,
        threads: int | None = None,
        copy: bool = True,
    ) -> None:
        threads = (os.cpu_count() or 1) if threads is None else threads
        self._worlds, self._truth = _Worlds(scenario, set, task, flat, num_envs, threads), truth
        self.num_envs, self._copy = num_envs, copy
        self.single_observation_space = self._worlds.observation_space
        self.single_action_space = self._worlds.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._generators: list[np.random.Generator] = []
        self._all, self._done = np.ones(num_envs, np.bool_), np.zeros(num_envs, np.bool_)

    @property
    def world_seeds(self) -> list[int]:
        """The seed of each world: that of a run with the same frames."""
        seeds: list[int] = self._worlds.native.seeds
        return seeds

    @property
    def digests(self) -> list[tuple[str, str]]:
        """``run_digest`` and ``world_digest`` of each world, see `RustyEnv`."""
        digests: list[tuple[str, str]] = self._worlds.native.digests
        return digests

    def reset(
        self,
        *,
        seed: int | Sequence[int] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Puts all worlds back before their first tick. World k has the seed `seed` + k, or
        the k-th of a list, else one that is drawn from those before it."""
        if isinstance(seed, (int, np.integer)):
            super().reset(seed=int(seed))
            seed = range(int(seed), int(seed) + self.num_envs)
        if seed is not None and len(seed) != self.num_envs:
            raise ValueError(f"reset failed: expected {self.num_envs} seeds, got {len(seed)}")
        if seed is not None or not self._generators:
            seeds = [None] * self.num_envs if seed is None else map(int, seed)
            self._generators = [seeding.np_random(one)[0] for one in seeds]
        chosen = map(_drawn, self._generators) if seed is None else map(int, seed)
        self._worlds.restart(dict(enumerate(chosen)))
        self._done = ~self._all
        return self._observations(), self._infos()

    def step(
        self, actions: ArrayLike
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Makes a tick in each world with the commands (v_m_s, omega_rad_s), (N, 2)."""
        worlds, restarted = self._worlds, self._done
        commands = worlds.commands(actions, restarted)
        if restarted.any():
            indices = np.flatnonzero(restarted).tolist()
            worlds.restart({index: _drawn(self._generators[index]) for index in indices})
        rewards, terminated, truncated = worlds.step(commands, restarted)
        self._done = terminated | truncated
        return self._observations(), rewards, terminated, truncated, self._infos()

    def _observations(self) -> Any:
        rows = self._worlds.rows
        return self._worlds.observations(rows.copy() if self._copy else rows)

    def _infos(self) -> dict[str, Any]:
        worlds = self._worlds
        infos: dict[str, Any] = {"tick": worlds.tick.astype(np.int64)}
        infos |= {"time_s": infos["tick"] * worlds.dt_s, "digest": worlds.digest.copy()}
        if self._truth:
            infos |= {"truth": worlds.truth.copy(), "blocked": worlds.blocked.copy()}
        # Gymnasium marks the worlds that have an entry.
        return infos | {f"_{name}": self._all for name in infos}


if "Rusty-v0" not in gymnasium.registry:
    gymnasium.register(
        "Rusty-v0",
        entry_point="rusty.gym:RustyEnv",
        vector_entry_point="rusty.gym:RustyVectorEnv",
    )

if __name__ == "__main__":
    from rusty._gym_speed import main

    main()
