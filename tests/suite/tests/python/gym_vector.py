"""Worlds that are stepped together, compared with one environment each."""

import json

import gymnasium
import numpy as np
from gymnasium.vector import SyncVectorEnv

import rusty.gym

N, STEPS = 5, 400
START = {"x_m": 11.0, "y_m": 3.0, "theta_rad": 0.0}
OPTIONS = {"set": {"ticks": 150, "start": START, "sensors": {"imu": {}}}, "truth": True}


def same(one, other):
    """Whether two results are equal to the bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    one, other = np.asarray(one), np.asarray(other)
    return one.shape == other.shape and (one == other).all()


def results(envs, actions):
    """All that an environment returns, copied; in the middle it is reset without a seed."""
    rows = []
    observation, info = envs.reset(seed=2**64 - N)
    for tick, action in enumerate(actions):
        rows.append([{k: np.array(v) for k, v in part.items()} for part in (observation, info)])
        assert observation in envs.observation_space
        observation, reward, terminated, truncated, info = envs.step(action)
        rows[-1] += [reward.copy(), terminated.copy(), truncated.copy()]
        if tick == STEPS // 2:
            observation, info = envs.reset()
    return rows


generator = np.random.default_rng(1)
# In circles, or straight to a wall, which ends episodes before the ticks do.
speeds = generator.uniform(0.2, 0.6, (STEPS, N))
turns = np.broadcast_to(np.linspace(-2.0, 2.0, N), (STEPS, N))
actions = np.stack([speeds, turns], axis=2).astype(np.float32)
single = results(SyncVectorEnv([lambda: rusty.gym.RustyEnv(**OPTIONS)] * N), actions)
rounds = 0
for more in ({"threads": 1}, {"threads": 3}, {"copy": False}):
    together = results(rusty.gym.RustyVectorEnv(N, **OPTIONS, **more), actions)
    for tick, (one, other) in enumerate(zip(single, together)):
        assert all(same(a, b) for a, b in zip(one, other)), (more, tick, one, other)
    rounds += 1
ends = np.array([row[3:] for row in single])
assert ends[:, 0].any() and ends[:, 1].any(), "both kinds of ends"

envs = gymnasium.make_vec("Rusty-v0", num_envs=N, set={"ticks": 20}, flat=True)
assert isinstance(envs.unwrapped, rusty.gym.RustyVectorEnv)
envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(envs)
observation, _ = envs.reset(seed=[3, 3, 4, 5, 6])
named = rusty.gym.RustyEnv(set={"ticks": 20}).reset(seed=3)[0]
assert (observation[0] == np.concatenate([part.ravel() for part in named.values()])).all()
for tick in range(20):
    observation, _, _, _, info = envs.step(np.full((N, 2), 0.1))
assert (info["episode"]["l"] == 20).all()
assert (observation[0] == observation[1]).all() and (observation[0] != observation[2]).any()
assert len({digest for _, digest in envs.unwrapped.digests}) == N - 1
assert envs.unwrapped.world_seeds == [3, 3, 4, 5, 6]
print(json.dumps({"rounds": rounds, "episodes": int(ends.sum())}))
