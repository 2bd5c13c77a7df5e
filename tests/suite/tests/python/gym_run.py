"""Repeats the run of a log in an environment, and compares every frame."""

import json
import sys

import numpy as np

import rusty
import rusty.gym

scenario, path = sys.argv[1:]
log = rusty.read_log(path)
config = log.header["config"]
env = rusty.gym.RustyEnv(scenario, truth=True, set={"ticks": config["ticks"]})
env.reset(seed=config["seed"])
# A script's own commands: those of a log are as the wheels could follow them.
script = config["script"]
commands = log.commands
if script["kind"] == "commands":
    commands = [[one["v_m_s"], one["omega_rad_s"]] for one in script["list"]]
counts, scans, blocked, digests = np.zeros(2, np.int64), 0, [], []
readings = {name: [] for name in ("bumper", "imu", "sonars_m", "doors", "landmarks")}
for tick, command in enumerate(commands):
    observation, _, _, truncated, info = env.step(command)
    assert truncated == (tick + 1 == log.ticks) and info["tick"] == tick + 1
    assert info["time_s"] == log.time_s[tick]
    assert info["truth"].tobytes() == log.truth[tick].tobytes()
    counts += observation["wheel_counts"].astype(np.int64)
    assert (counts == log.encoders[tick]).all()
    assert (observation["command"] == log.commands[tick].astype(np.float32)).all()
    is_new = scans < len(log.scan_ticks) and log.scan_ticks[scans] == tick
    assert observation["scan_is_new"] == [is_new]
    scans += int(is_new)
    assert (observation["ranges_m"] == log.ranges[scans - 1].astype(np.float32)).all()
    for name in readings.keys() & observation.keys():
        readings[name].append(observation[name].tolist())
    blocked.append(info["blocked"])
    digests.append(info["digest"])
assert len(set(digests)) == log.ticks
said = {"world_digest": env.world_digest, "run_digest": env.run_digest, "readings": readings}
print(json.dumps({**said, "frames": log.ticks, "scans": scans, "blocked": blocked}))
