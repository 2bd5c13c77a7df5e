"""What environments refuse, by name: kind of the exception, and message."""

import json
import os

import numpy as np

from rusty.gym import RustyEnv, RustyVectorEnv

said = {}


def refused(name, function, *args, **options):
    """Notes what a call raises."""
    try:
        function(*args, **options)
    except Exception as error:
        said[name] = [type(error).__name__, str(error)]


refused("scenario", RustyEnv, "apartmnt")
refused("field", RustyEnv, set={"lidar": {"beems": 3}})
refused("world_file", RustyEnv, set={"world_file": "absent.toml"})
refused("count", RustyVectorEnv, 0)
refused("threads", RustyVectorEnv, 3, threads=0)
refused("not_reset", RustyEnv().step, [0.0, 0.0])
envs = RustyVectorEnv(3, threads=2)
refused("seed", envs.reset, seed=2**64 - 2)
refused("seeds", envs.reset, seed=[1, 2])
envs.reset(seed=1)
refused("nan", envs.step, [[0.5, 0.0], [0.5, np.nan], [0.0, 0.0]])
said["ticks_after"] = envs.step(np.zeros((3, 2)))[-1]["tick"].tolist()
refused("shape", envs.step, [[0.5, 0.0], [0.5, 0.0]])


def seeds_after(refuse):
    """The seeds after the ends of three episodes, with or without a refused action."""
    short = RustyVectorEnv(3, set={"ticks": 1})
    short.reset(seed=1)
    short.step(np.zeros((3, 2)))
    if refuse:
        refused("at_end", short.step, np.zeros((2, 2)))
    short.step(np.zeros((3, 2)))
    return short.world_seeds


said["same_seeds"] = seeds_after(True) == seeds_after(False)
task = RustyVectorEnv(3, task=lambda step: (1.0, step.blocked))
task.reset(seed=1)
refused("task", task.step, np.zeros((3, 2)))
# Room for all of a crowd depends on the seed.
crowd = None
for people in range(1, 200):
    try:
        crowd = RustyEnv("hallway", set={"seed": 0, "crowd": {"people": people}})
    except ValueError:
        break
for seed in range(1, 200):
    refused("crowd", crowd.reset, seed=seed)
    if "crowd" in said:
        break
read, write = os.pipe()
child = os.fork()
if child == 0:
    refused("fork", envs.step, np.zeros((3, 2)))
    os.write(write, json.dumps(said.get("fork")).encode())
    os._exit(0)
os.close(write)
with open(read) as pipe:
    said["fork"] = json.loads(pipe.read())
os.waitpid(child, 0)
print(json.dumps(said))
