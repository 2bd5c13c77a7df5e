"""Writes a bag of a robot on a circle in a room with rosbags: other topics, other frames,
a LiDAR in front of the body, ranges in f32, packed chunks."""

import json
import math
import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
T = STORE.types
BEAMS, RADIUS_M, SPEED_M_S, RATE_HZ, OFFSET_M = 360, 1.5, 0.5, 20, 0.2
ROOM = (-4.0, -3.0, 4.0, 3.0)


def stamp(k: int):
    ns = 1_700_000_000_000_000_000 + k * 1_000_000_000 // RATE_HZ
    return ns, T["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)


def header(time, frame: str):
    return T["std_msgs/msg/Header"](stamp=time, frame_id=frame)


def turned(theta: float):
    return T["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=math.sin(theta / 2), w=math.cos(theta / 2))


def pose(x: float, y: float, theta: float):
    point = T["geometry_msgs/msg/Point"](x=x, y=y, z=0.0)
    return T["geometry_msgs/msg/Pose"](position=point, orientation=turned(theta))


def ranges(x: float, y: float, theta: float, random) -> np.ndarray:
    """Distances to the walls of the room."""
    bearings = theta - math.pi + np.arange(BEAMS) * 2 * math.pi / BEAMS
    with np.errstate(divide="ignore"):
        across = np.where(np.cos(bearings) > 0, ROOM[2] - x, ROOM[0] - x) / np.cos(bearings)
        along = np.where(np.sin(bearings) > 0, ROOM[3] - y, ROOM[1] - y) / np.sin(bearings)
    noise = random.normal(0.0, 0.01, BEAMS)
    return (np.minimum(across, along) + noise).astype(np.float32)


def main(bag: Path) -> int:
    random, scans = np.random.default_rng(5), 0
    writer = Writer(bag, version=8, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    zeros = np.zeros(36)
    vector = lambda x, z: T["geometry_msgs/msg/Vector3"](x=x, y=0.0, z=z)
    with writer:
        kinds = {"/front/scan": "sensor_msgs/msg/LaserScan", "/wheel/odometry": "nav_msgs/msg/Odometry",
                 "/tf_static": "tf2_msgs/msg/TFMessage", "/truth": "geometry_msgs/msg/PoseStamped"}
        topics = {name: writer.add_connection(name, kind, typestore=STORE) for name, kind in kinds.items()}

        def put(name, ns, message):
            writer.write(topics[name], ns, STORE.serialize_cdr(message, kinds[name]))

        ns, time = stamp(0)
        move = T["geometry_msgs/msg/Transform"](translation=vector(OFFSET_M, 0.1), rotation=turned(0.0))
        mount = T["geometry_msgs/msg/TransformStamped"](header=header(time, "base_footprint"), child_frame_id="lidar", transform=move)
        put("/tf_static", ns, T["tf2_msgs/msg/TFMessage"](transforms=[mount]))
        for k in range(40 * RATE_HZ):
            (ns, time), turn = stamp(k), SPEED_M_S / RADIUS_M * k / RATE_HZ
            x, y, theta = RADIUS_M * math.sin(turn), -RADIUS_M * math.cos(turn), turn
            # Wheels that turn 4 % too far.
            at = 1.04 * turn
            odometry = pose(RADIUS_M * math.sin(at), RADIUS_M * (1 - math.cos(at)), at)
            with_covariance = T["geometry_msgs/msg/PoseWithCovariance"](pose=odometry, covariance=zeros)
            twist = T["geometry_msgs/msg/Twist"](linear=vector(SPEED_M_S, 0.0), angular=vector(0.0, SPEED_M_S / RADIUS_M))
            put("/wheel/odometry", ns, T["nav_msgs/msg/Odometry"](
                header=header(time, "odom"), child_frame_id="base_footprint", pose=with_covariance,
                twist=T["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=zeros)))
            put("/truth", ns, T["geometry_msgs/msg/PoseStamped"](header=header(time, "map"), pose=pose(x, y, theta)))
            if k % 4 == 0:
                scans += 1
                at = (x + OFFSET_M * math.cos(theta), y + OFFSET_M * math.sin(theta), theta)
                put("/front/scan", ns, T["sensor_msgs/msg/LaserScan"](
                    header=header(time, "lidar"), angle_min=-math.pi, angle_max=math.pi - 2 * math.pi / BEAMS,
                    angle_increment=2 * math.pi / BEAMS, time_increment=0.0, scan_time=0.2, range_min=0.05,
                    range_max=12.0, ranges=ranges(*at, random), intensities=np.zeros(0, np.float32)))
    return scans


print(json.dumps({"scans": main(Path(sys.argv[1]))}))
