"""A ROS 2 node for tests. Until it is interrupted it answers in one of several ways, and
then writes what it received as JSON."""

import json
import math
import sys
from types import SimpleNamespace

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, LaserScan, Range

how, out, examples = sys.argv[1:4]
sys.path.insert(0, examples)
from ros2_controller import Controller  # noqa: E402


def ns(stamp):
    return stamp.sec * 1_000_000_000 + stamp.nanosec


class Records(Controller):
    """The example, and everything else that is published."""

    def __init__(self):
        super().__init__()
        self.seen = {name: [] for name in ("clock", "scan", "odom", "imu", "sonar", "map")}
        for kind, topic, name, of in (
            (Clock, "/clock", "clock", lambda m: ns(m.clock)),
            (Odometry, "odom", "odom", self.odom),
            (Imu, "imu", "imu", self.imu),
            (Range, "sonar_0", "sonar", lambda m: [ns(m.header.stamp), self.finite(m.range)]),
        ):
            keep = self.seen[name].append
            self.create_subscription(kind, topic, lambda m, k=keep, of=of: k(of(m)), 1000)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(OccupancyGrid, "map", self.map, kept)
        if how == "plain":
            # The same commands without stamps.
            self.destroy_publisher(self.commands)
            plain = self.create_publisher(Twist, "cmd_vel", 10)
            self.commands = SimpleNamespace(publish=lambda m: plain.publish(m.twist))

    def finite(self, number):
        return number if math.isfinite(number) else None

    def odom(self, m):
        turn, pose, twist = m.pose.pose.orientation, m.pose.pose.position, m.twist.twist
        return [ns(m.header.stamp), pose.x, pose.y, turn.z, turn.w, twist.linear.x, twist.angular.z]

    def imu(self, m):
        accel = m.linear_acceleration
        return [ns(m.header.stamp), m.angular_velocity.z, accel.x, accel.y]

    def map(self, m):
        info = m.info
        corner = [info.origin.position.x, info.origin.position.y]
        self.seen["map"].append([*corner, info.resolution, info.width, list(m.data)])

    def answer(self, scan):
        self.seen["scan"].append([ns(scan.header.stamp), [self.finite(r) for r in scan.ranges]])
        # Falls silent: the run waits in vain.
        if how != "silent" or len(self.seen["scan"]) <= 20:
            super().answer(scan)


class Twists(rclpy.node.Node):
    """Publishes commands by the clock on the wall, each of them once more."""

    def __init__(self):
        super().__init__("twists")
        self.seen = {"sent": 0}
        self.commands = self.create_publisher(Twist, "cmd_vel", 10)
        self.create_timer(0.01, self.send)

    def send(self):
        # As soon as the bridge is there, and then for 50 times.
        if self.commands.get_subscription_count() > 0 and self.seen["sent"] < 50:
            self.seen["sent"] += 1
            command = Twist()
            command.linear.x, command.angular.z = 0.25, 0.5
            self.commands.publish(command)


class Clocks(rclpy.node.Node):
    """Answers each clock, with the number of its answer as the speed in mm/s."""

    def __init__(self):
        super().__init__("clocks")
        self.seen = {"clock": []}
        self.commands = self.create_publisher(TwistStamped, "cmd_vel", 10)
        self.create_subscription(Clock, "/clock", self.answer, 10)

    def answer(self, clock):
        self.seen["clock"].append(ns(clock.clock))
        command = TwistStamped()
        command.header.stamp = clock.clock
        command.twist.linear.x = len(self.seen["clock"]) / 1000
        self.commands.publish(command)


class Poses(rclpy.node.Node):
    """Answers each scan with a pose and its covariance."""

    def __init__(self):
        super().__init__("poses")
        self.seen = {"poses": []}
        self.poses = self.create_publisher(PoseWithCovarianceStamped, "pose", 10)
        self.create_subscription(LaserScan, "scan", self.answer, 10)

    def answer(self, scan):
        pose, k = PoseWithCovarianceStamped(), len(self.seen["poses"])
        x, y, theta = 0.5 * k, 0.25, 0.125 * k
        pose.header.stamp = scan.header.stamp
        pose.pose.pose.position.x, pose.pose.pose.position.y = x, y
        turn = pose.pose.pose.orientation
        turn.z, turn.w = math.sin(theta / 2), math.cos(theta / 2)
        for place, number in {0: 0.04, 1: 0.01, 6: 0.01, 7: 0.09, 35: 0.0025}.items():
            pose.pose.covariance[place] = number
        self.seen["poses"].append([ns(scan.header.stamp), x, y, theta])
        self.poses.publish(pose)


rclpy.init(args=sys.argv)
node = {"twist": Twists, "poses": Poses, "clock": Clocks}.get(how, Records)()
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
with open(out, "w", encoding="utf-8") as file:
    json.dump(node.seen, file)
rclpy.try_shutdown()
