"""Answers questions about the plane: JSON in the file that is named, JSON out."""

import json
import sys

import numpy as np

import rusty

with open(sys.argv[1]) as file:
    asked = json.load(file)
world = rusty.World.builtin(asked["world"])
drive = type("Drive", (), asked["drive"])
lidar = asked["lidar"]

said = {"plane": [], "odometry": [], "wrapped": [rusty.wrap_angle(a) for a in asked["angles"]]}
for a, b in zip(asked["poses"], asked["poses"][1:]):
    p, q, tau = rusty.SE2(*a), rusty.SE2(*b), np.array(b)
    moved = [p.boxplus(tau), p.boxplus(b), p.compose(b), p * q, p @ q, p.inverse(), rusty.SE2.exp(tau)]
    said["plane"].append([[*pose] for pose in moved] + [[*p.boxminus(q)], [*p.boxminus(b)], [*p.log()]])
for last, counts in zip(asked["counts"], asked["counts"][1:]):
    said["odometry"].append([*rusty.odometry_delta(tuple(last), tuple(counts), drive)])
x, y, _ = asked["poses"][0]
angles = np.array(asked["angles"])
far = lidar["range_max_m"]
said["rays"] = world.raycast((x, y), angles, far).tolist()
# An array of another shape, and one by one: the same.
assert world.raycast((x, y), angles.reshape(2, -1), far).ravel().tolist() == said["rays"]
assert [world.raycast((x, y), angle, far) for angle in angles] == said["rays"]
poses = np.array(asked["poses"])
said["scans"] = world.scans(poses, lidar).tolist()
assert [world.scan(pose, lidar).tolist() for pose in poses] == said["scans"]
assert world.scan(rusty.SE2(*poses[0]), lidar).tolist() == said["scans"][0]
# Memory in another order, and whole numbers of another kind.
assert world.scans(np.asfortranarray(poses), lidar).tolist() == said["scans"]
some = world.scans(poses, lidar, every=7)
assert (some == np.array(said["scans"])[:, ::7]).all()
said["sixth"] = world.scans(poses, lidar, every=6).tolist()
assert np.allclose(said["sixth"], np.array(said["scans"])[:, ::6], atol=1e-6)
said["distances"] = world.distance(poses[:, :2]).tolist()
json.dump(said, sys.stdout)
