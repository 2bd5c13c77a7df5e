"""Worlds go through arrays and files without a change; what is none is refused."""

import copy
import math
import pickle
import sys

import numpy as np

import rusty


def refused(kind, words, what):
    try:
        what()
    except kind as error:
        assert words in str(error), error
    else:
        raise AssertionError(f"{words!r} was not refused")


toml, json = sys.argv[1:]
world = rusty.World.builtin("apartment")
assert world.walls.shape == (31, 4) and world.walls.dtype == np.float64
assert "Glass" in world.materials and world.name == "apartment"
again = rusty.World.from_walls(world.walls, bounds=world.bounds, materials=world.materials)
for other in (again, rusty.World.from_file(toml), rusty.World.from_file(json)):
    assert (other.walls == world.walls).all() and other.materials == world.materials
    assert other.bounds == world.bounds
    assert (other.scan((6.0, 4.5, 0.3), {}) == world.scan((6.0, 4.5, 0.3), {})).all()
assert rusty.World.from_walls([[0, 0, 2, 0]]).bounds == (0, -0.5, 2, 0.5)
assert rusty.World.from_walls(np.empty((0, 4))).scan((0, 0, 0), {"beams": 4}).tolist() == [8] * 4
assert math.isinf(rusty.World.builtin("open").raycast((0, 0), 1.0))
assert np.isnan(world.distance([[math.nan, 0]])).all()

pose = rusty.SE2(1, 2, 7)
assert pose.theta == rusty.wrap_angle(7) and [*pose] == np.asarray(pose).tolist()
assert pose == rusty.SE2(1, 2, 7) and hash(pose) == hash(copy.copy(pose)) and pose != (1, 2, 7)
assert pickle.loads(pickle.dumps(pose)) == pose == eval(repr(pose), {"SE2": rusty.SE2})

refused(ValueError, "use open, hallway, apartment, lobby", lambda: rusty.World.builtin("attic"))
refused(ValueError, "walls: an array of shape (n, 4)", lambda: rusty.World.from_walls([[0, 0, 1]]))
refused(ValueError, "wall 1", lambda: rusty.World.from_walls([[0, 0, 1, 1], [0, 0, 0, 0]]))
refused(ValueError, "give one each", lambda: rusty.World.from_walls(world.walls, materials=["Wall"]))
refused(FileNotFoundError, "nowhere.toml", lambda: rusty.World.from_file("nowhere.toml"))
refused(ValueError, "world file (TOML)", lambda: rusty.World.from_file(__file__))
refused(ValueError, "sim-server worlds map.yaml --json", lambda: rusty.World.from_file("map.yaml"))
refused(ValueError, "poses: an array of shape (n, 3)", lambda: world.scans([1, 2, 3], {}))
refused(ValueError, "pose: NaN", lambda: world.scan((math.nan, 0, 0), {}))
refused(ValueError, "poses: NaN", lambda: world.scans([(0, 0, math.nan)], {}))
refused(ValueError, "angle_rad: inf", lambda: world.raycast((0, 0), [0, math.inf]))
refused(ValueError, "range_max_m=-1", lambda: world.raycast((0, 0), 0.0, -1.0))
refused(ValueError, "lidar.beams = 0", lambda: world.scan(pose, {"beams": 0}))
refused(ValueError, "unknown field `beems`", lambda: world.scan(pose, {"beems": 9}))
refused(ValueError, "every = 0", lambda: world.scan(pose, {}, every=0))
refused(TypeError, "give `start.lidar`", lambda: world.scan(pose, 5))
refused(TypeError, "tau: numbers of shape (3,)", lambda: pose.boxplus("north"))
refused(AttributeError, "give `start.robot`", lambda: rusty.odometry_delta((0, 0), (1, 1), None))
refused(AttributeError, "", lambda: setattr(pose, "x", 5.0))
