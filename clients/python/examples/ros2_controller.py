"""A controller for ``python -m rusty.ros2 --lockstep --driver``: away from walls by the scan.

It drives while the nearest return ahead is far enough, and otherwise turns to the side
with more room. It answers each scan once, with the stamp of the scan, so the run waits for
it and repeats. It needs a sourced ROS 2 and nothing of ours.
"""

import math
import sys

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

SPEED_M_S, TURN_RAD_S = 0.4, 1.2
STOP_M, SECTOR_RAD = 0.5, 0.6


class Controller(Node):
    """Answers each scan with a command."""

    def __init__(self):
        super().__init__("controller")
        self.commands = self.create_publisher(TwistStamped, "cmd_vel", 10)
        self.create_subscription(LaserScan, "scan", self.answer, 10)
        self.turn_rad_s = 0.0

    def answer(self, scan):
        """The command for a scan."""
        ahead = self.nearest(scan, -SECTOR_RAD, SECTOR_RAD)
        if ahead > STOP_M:
            self.turn_rad_s = 0.0
        elif self.turn_rad_s == 0.0:
            left = self.nearest(scan, SECTOR_RAD, 2 * SECTOR_RAD)
            right = self.nearest(scan, -2 * SECTOR_RAD, -SECTOR_RAD)
            self.turn_rad_s = TURN_RAD_S if left > right else -TURN_RAD_S
        command = TwistStamped()
        command.header.stamp = scan.header.stamp
        command.twist.linear.x = 0.0 if self.turn_rad_s else SPEED_M_S
        command.twist.angular.z = self.turn_rad_s
        self.commands.publish(command)

    def nearest(self, scan, least_rad, most_rad):
        """The nearest return between two bearings, m; a beam without one is infinite."""
        first = math.ceil((least_rad - scan.angle_min) / scan.angle_increment)
        last = math.floor((most_rad - scan.angle_min) / scan.angle_increment)
        return min(scan.ranges[first : last + 1])


def main():
    """Answers scans until it is interrupted."""
    rclpy.init(args=sys.argv)
    try:
        rclpy.spin(Controller())
    except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
