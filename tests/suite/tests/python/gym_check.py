"""Gymnasium's own check of environments."""

import json
import warnings

import gymnasium
from gymnasium.utils.env_checker import check_env

import rusty.gym  # It registers Rusty-v0.

sensors = {name: {} for name in ("bumper", "imu", "sonar", "doors", "landmarks")}
rounds = []
for options in (
    {},
    {"truth": True},
    {"flat": True},
    {"set": {"scan_every": 0}, "task": rusty.gym.Goal(8.0, 4.5)},
    {"set": {"sensors": sensors}},
):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(gymnasium.make("Rusty-v0", **options).unwrapped)
    rounds.append({"options": str(options), "warnings": [str(one.message) for one in caught]})
print(json.dumps(rounds))
