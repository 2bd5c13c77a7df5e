"""Rewards, ends of episodes, truth and seeds of an environment."""

import json

from rusty.gym import Distance, Goal, RustyEnv


def episode(env):
    """Ticks and sum of rewards of an episode straight ahead; whether it was cut off."""
    env.reset(seed=42)
    ticks, total, terminated, truncated = 0, 0.0, False, False
    while not (terminated or truncated):
        _, reward, terminated, truncated, _ = env.step([0.5, 0.0])
        ticks, total = ticks + 1, total + reward
    return ticks, total, truncated and not terminated


said = {}
goal = RustyEnv(task=Goal(7.0, 4.5))
said["goal_ticks"], said["goal_reward"], cut = episode(goal)
assert not cut
wall = {"start": {"x_m": 11.0, "y_m": 3.0, "theta_rad": 0.0}}
said["distance_ticks"], said["distance_reward"], cut = episode(RustyEnv(set=wall, task=Distance()))
assert not cut
said["truncated_at"], _, cut = episode(RustyEnv(set={"ticks": 20}))
assert cut
for name, truth in (("info", False), ("info_with_truth", True)):
    env = RustyEnv(truth=truth)
    _, first = env.reset(seed=1)
    _, _, _, _, info = env.step([0.1, 0.0])
    assert first.keys() == info.keys()
    said[name] = sorted(info)


def seeds(env):
    """The seeds of three worlds, the last two drawn."""
    env.reset(seed=7)
    first = env.world_seed
    env.reset()
    second = env.world_seed
    env.reset()
    return [first, second, env.world_seed]


one, other = seeds(RustyEnv()), seeds(RustyEnv())
said["reset_seeds"] = [one[0], one == other, len(set(one)) == 3]
print(json.dumps(said))
