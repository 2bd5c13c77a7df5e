"""The ROS side of the bridge: its nodes, their threads, and what they received."""

from __future__ import annotations

import math
import sys
import threading
import time
from typing import Any, Callable

import numpy as np

from ._rusty import SE2, RustyError, wrap_angle

SETTLE_S = 0.5
"""Time that the other side of a connection gets to know of it as well, s."""
SLICE_S = 0.05
"""How long one wait lasts, s."""

KINDS = {"twist": "Twist", "stamped": "TwistStamped"}
"""The message types of a command by the words of --cmd-vel-type."""


class BridgeError(RustyError):
    """The bridge cannot go on; the message is for a person."""


class Received:
    """A command or a pose, with the time in its header and when it was received."""

    def __init__(self, value: Any, stamp_ns: int | None, publication: int) -> None:
        self.value = value
        self.stamp_ns = stamp_ns
        self.publication = publication

    def answers(self, stamp_ns: int, publication: int) -> bool:
        """Whether it is for the tick with this stamp: by its own stamp, or without one
        by being received after the tick was published."""
        if self.stamp_ns is None:
            return self.publication >= publication
        return self.stamp_ns >= stamp_ns


class Bridge:
    """The node, with a thread that receives."""

    def __init__(self, name: str, options: Any) -> None:
        import rclpy
        from rclpy.node import Node
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import LaserScan

        self._rclpy, self.options = rclpy, options
        quiet = {"start_parameter_services": False, "enable_rosout": False}
        self.node: Any = Node(name, **quiet)
        self.scan = self.node.create_publisher(LaserScan, "scan", 10)
        self.clock = self.node.create_publisher(Clock, "/clock", 10)
        self.command: Received | None = None
        self.pose: Received | None = None
        self.publication = 0
        self.commands: str | None = None
        """The word for the type of commands, once there is a subscription."""
        self._arrived = threading.Condition()
        self._stopping = False
        self._fault: BaseException | None = None
        self._threads: list[threading.Thread] = []
        self._subscribe()
        self._spin(self.node)

    def _subscribe(self) -> None:
        if self.options.pose is not None:
            from geometry_msgs.msg import PoseWithCovarianceStamped

            topic = self.options.pose
            self.node.create_subscription(PoseWithCovarianceStamped, topic, self._posed, 10)
        if self.options.cmd_vel_type != "auto":
            self._subscribe_commands(self.options.cmd_vel_type)

    def _subscribe_commands(self, word: str) -> None:
        """Subscribes to commands of a type. One topic has one type: a participant of DDS
        refuses a second."""
        import geometry_msgs.msg

        kind = getattr(geometry_msgs.msg, KINDS[word])
        heard = self._twist if word == "twist" else self._twist_stamped
        self.node.create_subscription(kind, self.options.cmd_vel, heard, 10)
        self.commands = word

    def look_for_commands(self) -> None:
        """With --cmd-vel-type auto: subscribes once a publisher shows the type."""
        if self.commands is None:
            for info in self.node.get_publishers_info_by_topic(self.options.cmd_vel):
                for word, kind in KINDS.items():
                    if info.topic_type == f"geometry_msgs/msg/{kind}":
                        self._subscribe_commands(word)
                        return

    def _spin(self, node: Any) -> None:
        """Serves a node in a thread until the bridge closes."""
        from rclpy.executors import SingleThreadedExecutor

        executor = SingleThreadedExecutor()
        executor.add_node(node)

        def serve() -> None:
            try:
                while not self._stopping:
                    executor.spin_once(timeout_sec=SLICE_S)
            except BaseException as fault:  # for the thread that waits
                with self._arrived:
                    self._fault = fault
                    self._arrived.notify_all()
            finally:
                executor.shutdown()

        thread = threading.Thread(target=serve, name=node.get_name(), daemon=True)
        self._threads.append(thread)
        thread.start()

    def serve_control(self, run: str) -> bool:
        """Offers the services of `simulation_interfaces`, if that package is there. They
        have a separate thread: a step waits for ticks, which wait for commands."""
        from ._ros2_control import Services

        node = self._rclpy.create_node(
            f"{self.node.get_name()}_control", start_parameter_services=False, enable_rosout=False
        )
        try:
            Services(node, run)
        except ImportError:
            node.destroy_node()
            return False
        self._spin(node)
        return True

    def _twist(self, message: Any) -> None:
        self._take(message, None)

    def _twist_stamped(self, message: Any) -> None:
        self._take(message.twist, _ns(message.header.stamp))

    def _take(self, twist: Any, stamp_ns: int | None) -> None:
        command = (twist.linear.x, twist.angular.z)
        if _finite("a command", command):
            with self._arrived:
                self.command = Received(command, stamp_ns, self.publication)
                self._arrived.notify_all()

    def _posed(self, message: Any) -> None:
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        theta = math.atan2(
            2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2)
        )
        covariance = np.asarray(message.pose.covariance).reshape(6, 6)[np.ix_((0, 1, 5), (0, 1, 5))]
        if _finite("a pose", (place.x, place.y, theta, *covariance.ravel())):
            pose = SE2(place.x, place.y, wrap_angle(theta))
            with self._arrived:
                stamp_ns = _ns(message.header.stamp)
                self.pose = Received((pose, covariance), stamp_ns, self.publication)
                self._arrived.notify_all()

    def wait(self, what: str, done: Callable[[], bool], limit_s: float, remedy: str) -> None:
        """Waits until `done`, which is asked after each message and each slice."""
        deadline = time.monotonic() + limit_s
        with self._arrived:
            while not done():
                if self._fault is not None:
                    raise BridgeError(f"receiving failed: {self._fault!r}") from self._fault
                left_s = deadline - time.monotonic()
                if left_s <= 0:
                    raise BridgeError(f"{what} within {limit_s:g} s, got none; {remedy}")
                self._arrived.wait(min(left_s, SLICE_S))

    def wait_for_peer(self, limit_s: float) -> None:
        """Waits for a publisher of answers and, in lockstep, for a subscriber of what it
        answers to."""
        answer = self.options.pose or self.options.cmd_vel
        asked = {"scan": self.scan, "clock": self.clock}.get(self.options.lockstep)

        def is_there() -> bool:
            self.look_for_commands()
            is_typed = self.options.pose is not None or self.commands is not None
            is_asked = asked is None or asked.get_subscription_count() > 0
            return is_asked and is_typed and self.node.count_publishers(answer) > 0

        what = f"waiting for a controller failed: expected a publisher of {answer}"
        if asked is not None:
            what += f" and a subscriber of {asked.topic_name}"
        remedy = "start the controller, or give more time with --wait-for"
        self.wait(what, is_there, limit_s, remedy)
        time.sleep(SETTLE_S)

    def close(self) -> None:
        """Ends the threads and leaves the graph of ROS."""
        self._stopping = True
        for thread in self._threads:
            thread.join(timeout=5.0)
        self._rclpy.try_shutdown()


def _ns(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _finite(what: str, numbers: Any) -> bool:
    """Whether all numbers are finite; prints that a message is ignored if not."""
    fine = all(map(math.isfinite, numbers))
    if not fine:
        print(f"ros2: {what} with a number that is not finite was ignored", file=sys.stderr)
    return fine
