"""The messages of a tick and the topics that carry them: REP 103, 105, 117 and 145."""

from __future__ import annotations

import array
import math
from typing import Any, Callable

import numpy as np

from ._rusty import SE2, Start, Tick, World, odometry_delta


def stamp_ns(tick: Tick) -> int:
    """Time of a tick as in every header, ns."""
    return round(tick.time_s * 1e9)


def set_pose(target: Any, pose: SE2 | tuple[float, float, float]) -> None:
    """Writes a pose of the plane into a Pose."""
    x, y, theta = pose
    target.position.x, target.position.y = x, y
    target.orientation.z, target.orientation.w = math.sin(theta / 2), math.cos(theta / 2)


def transform(parent: str, child: str, pose: tuple[float, float, float], stamp: Any) -> Any:
    """A TransformStamped of the plane."""
    from geometry_msgs.msg import TransformStamped

    message = TransformStamped()
    message.header.stamp, message.header.frame_id = stamp, parent
    message.child_frame_id = child
    move(message, pose)
    return message


def move(message: Any, pose: SE2 | tuple[float, float, float]) -> None:
    """Writes a pose of the plane into a TransformStamped."""
    x, y, theta = pose
    moved = message.transform
    moved.translation.x, moved.translation.y = x, y
    moved.rotation.z, moved.rotation.w = math.sin(theta / 2), math.cos(theta / 2)


def no_return_is_inf(ranges_m: Any, range_max_m: float) -> Any:
    """Ranges as 32-bit numbers, infinite where nothing came back (REP 117)."""
    single = ranges_m.astype(np.float32)
    single[ranges_m >= range_max_m] = np.inf
    return array.array("f", single.tobytes())


def tf_type() -> Any:
    """The type of /tf; None without the package, which is not on the Python registry."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return None
    return TFMessage


def send_to(publisher: Any, message: Any) -> None:
    """Publishes a message, unless no subscriber is there to get it."""
    if publisher.get_subscription_count() > 0:
        publisher.publish(message)


def kept(depth: int = 1) -> Any:
    """The quality of service of what late subscribers must get as well."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    return QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Odometry:
    """Dead reckoning from the encoders since the start, in the frame `odom`."""

    def __init__(self, start: Start) -> None:
        self.robot = start.robot
        self.pose = SE2()
        self.delta = np.zeros(3)
        self.counts = (0, 0)

    def advance(self, tick: Tick) -> None:
        """Moves on to a tick."""
        self.delta = odometry_delta(self.counts, tick.encoders, self.robot)
        self.pose = self.pose.boxplus(self.delta)
        self.counts = tick.encoders


class Outlets:
    """The publishers of a robot. One message of each topic is filled again and again."""

    def __init__(self, node: Any, scan: Any, clock: Any, start: Start, cell_m: float) -> None:
        from builtin_interfaces.msg import Time
        from rosgraph_msgs.msg import Clock

        self.node, self.start = node, start
        self.stamp = Time()
        self.clock = Clock(clock=self.stamp)
        self.scan = self._scan()
        self.sends: list[Callable[[Tick, Odometry], None]] = []
        self.clock_publisher, self.scan_publisher = clock, scan
        statics = [("laser", start.lidar.sensor_in_body)] if start.scan_every else []
        self._odometry()
        if "imu" in start.sensors:
            self._imu()
        for k, mount in enumerate(start.sensors.get("sonar", {}).get("mounts", [])):
            self._sonar(k, start.sensors["sonar"])
            statics.append((f"sonar_{k}", (mount["x_m"], mount["y_m"], mount["theta_rad"])))
        self._transforms(statics)
        if start.map is not None:
            self._map(cell_m)

    def publish(self, tick: Tick, odometry: Odometry) -> None:
        """Publishes a tick: the clock first, so that no node is behind the data, and
        the scan last, so that what it needs is on its way."""
        self.stamp.sec, self.stamp.nanosec = divmod(stamp_ns(tick), 1_000_000_000)
        send_to(self.clock_publisher, self.clock)
        for send in self.sends:
            send(tick, odometry)
        ranges_m = tick.ranges
        if ranges_m is not None:
            self.scan.ranges = no_return_is_inf(ranges_m, self.start.lidar.range_max_m)
            send_to(self.scan_publisher, self.scan)

    def _headed(self, message: Any, frame: str) -> Any:
        """A message with the common stamp."""
        message.header.stamp, message.header.frame_id = self.stamp, frame
        return message

    def _scan(self) -> Any:
        from sensor_msgs.msg import LaserScan

        lidar, scan = self.start.lidar, self._headed(LaserScan(), "laser")
        scan.angle_min = lidar.first_bearing_rad
        scan.angle_increment = lidar.fov_rad / lidar.beams
        scan.angle_max = lidar.first_bearing_rad + (lidar.beams - 1) * scan.angle_increment
        scan.scan_time = self.start.scan_every * self.start.dt_s
        scan.range_max = lidar.range_max_m
        return scan

    def _odometry(self) -> None:
        from nav_msgs.msg import Odometry as Message

        message, dt_s = self._headed(Message(), "odom"), self.start.dt_s
        message.child_frame_id = "base_link"
        publisher = self.node.create_publisher(Message, "odom", 10)
        twist = message.twist.twist

        def send(_: Tick, odometry: Odometry) -> None:
            set_pose(message.pose.pose, odometry.pose)
            twist.linear.x = float(odometry.delta[0]) / dt_s
            twist.angular.z = float(odometry.delta[2]) / dt_s
            send_to(publisher, message)

        self.sends.append(send)

    def _imu(self) -> None:
        from sensor_msgs.msg import Imu

        message = self._headed(Imu(), "base_link")
        # REP 145: no orientation.
        message.orientation_covariance[0] = -1.0
        publisher = self.node.create_publisher(Imu, "imu", 10)

        def send(tick: Tick, _: Odometry) -> None:
            if tick.imu is not None:
                message.angular_velocity.z = tick.imu[0]
                message.linear_acceleration.x, message.linear_acceleration.y = tick.imu[1:]
                send_to(publisher, message)

        self.sends.append(send)

    def _sonar(self, k: int, sheet: dict[str, Any]) -> None:
        from sensor_msgs.msg import Range

        message = self._headed(Range(), f"sonar_{k}")
        message.radiation_type = Range.ULTRASOUND
        message.field_of_view = sheet["aperture_rad"]
        message.max_range = sheet["range_max_m"]
        publisher = self.node.create_publisher(Range, f"sonar_{k}", 10)

        def send(tick: Tick, _: Odometry) -> None:
            if tick.sonars is not None:
                range_m = float(tick.sonars[k])
                message.range = range_m if range_m < sheet["range_max_m"] else math.inf
                send_to(publisher, message)

        self.sends.append(send)

    def _transforms(self, statics: list[tuple[str, tuple[float, float, float]]]) -> None:
        TFMessage = tf_type()
        if TFMessage is None:
            return
        moving = transform("odom", "base_link", (0.0, 0.0, 0.0), self.stamp)
        message = TFMessage(transforms=[moving])
        publisher = self.node.create_publisher(TFMessage, "/tf", 100)
        fixed = [transform("base_link", name, pose, type(self.stamp)()) for name, pose in statics]
        self.node.create_publisher(TFMessage, "/tf_static", kept()).publish(
            TFMessage(transforms=fixed)
        )

        def send(_: Tick, odometry: Odometry) -> None:
            move(moving, odometry.pose)
            send_to(publisher, message)

        self.sends.append(send)

    def _map(self, cell_m: float) -> None:
        from nav_msgs.msg import OccupancyGrid

        message = OccupancyGrid()
        message.header.frame_id = "map"
        x_min, y_min, cells = occupancy(World.from_start(self.start), cell_m)
        message.info.resolution = cell_m
        message.info.height, message.info.width = cells.shape
        set_pose(message.info.origin, (x_min, y_min, 0.0))
        message.data = array.array("b", cells.tobytes())
        self.node.create_publisher(OccupancyGrid, "map", kept()).publish(message)


def occupancy(world: World, cell_m: float) -> tuple[float, float, Any]:
    """The map as a grid: the corner with the least x and y, m, and the cells, row by row
    from there: 100 where a wall may touch the cell, elsewhere 0."""
    x_min, y_min, x_max, y_max = world.bounds
    columns = max(1, math.ceil((x_max - x_min) / cell_m))
    rows = max(1, math.ceil((y_max - y_min) / cell_m))
    x_m = x_min + (np.arange(columns) + 0.5) * cell_m
    cells = np.zeros((rows, columns), dtype=np.int8)
    for row in range(rows):
        middle = np.column_stack([x_m, np.full(columns, y_min + (row + 0.5) * cell_m)])
        cells[row] = np.where(world.distance(middle) <= cell_m * math.sqrt(0.5), 100, 0)
    return x_min, y_min, cells
