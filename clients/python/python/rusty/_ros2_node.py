"""The ROS side of the bridge: its node, the thread that receives, and what it received."""

from __future__ import annotations

import math
import sys
import threading
import time
from typing import Any, Callable, NamedTuple

import numpy as np

from ._rusty import SE2, RustyError, wrap_angle

SETTLE_S = 0.5
"""Time in which a controller that is there finds all publishers and is found, s."""
SLICE_S = 0.05
"""How long one wait lasts, s."""

QUIET: dict[str, Any] = {"start_parameter_services": False, "enable_rosout": False}
"""Options of nodes that have no parameters and print what they log."""
KINDS = {"twist": "Twist", "stamped": "TwistStamped"}
"""The message types of a command by the words of --cmd-vel-type."""


class BridgeError(RustyError):
    """The bridge cannot go on; the message is for a person."""


class Received(NamedTuple):
    """A command or a pose, with the time in its header, if it has one, and the tick that
    was published last when it was received."""

    value: Any
    stamp_ns: int | None
    published: int

    def answers(self, index: int, stamp_ns: int) -> bool:
        """Whether it is for a tick: by its stamp, or without one by when it came."""
        return (self.published >= index) if self.stamp_ns is None else (self.stamp_ns >= stamp_ns)


class Bridge:
    """The node, with a thread that receives."""

    def __init__(self, name: str, options: Any) -> None:
        from rclpy.node import Node
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import LaserScan

        self.options = options
        self.node: Any = Node(name, **QUIET)
        self.scan = self.node.create_publisher(LaserScan, "scan", 10)
        self.clock = self.node.create_publisher(Clock, "/clock", 10)
        self.command: Received | None = None
        self.pose: Received | None = None
        self.index = -1
        """The tick that was published last."""
        self.commands: str | None = None
        """The word for the type of commands, once there is a subscription."""
        self._arrived = threading.Condition()
        self._stopping = False
        self._fault: BaseException | None = None
        self._subscribe()
        self._thread = threading.Thread(target=self._receive, name=name, daemon=True)
        self._thread.start()

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

    def _receive(self) -> None:
        """Receives until the bridge closes."""
        from rclpy.executors import SingleThreadedExecutor

        executor = SingleThreadedExecutor()
        executor.add_node(self.node)
        try:
            while not self._stopping:
                executor.spin_once(timeout_sec=SLICE_S)
        except BaseException as fault:  # for the thread that waits
            with self._arrived:
                self._fault = fault
                self._arrived.notify_all()
        finally:
            executor.shutdown()

    def _twist(self, message: Any) -> None:
        self._take(message, None)

    def _twist_stamped(self, message: Any) -> None:
        self._take(message.twist, _ns(message.header.stamp))

    def _take(self, twist: Any, stamp_ns: int | None) -> None:
        command = (twist.linear.x, twist.angular.z)
        if _finite("a command", command):
            with self._arrived:
                self.command = Received(command, stamp_ns, self.index)
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
                self.pose = Received((pose, covariance), stamp_ns, self.index)
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
        """Waits for publishers of all answers and, in lockstep, for a subscriber of what
        they answer to."""
        options = self.options
        needs_commands = options.driver or options.pose is None
        answers = [options.cmd_vel] if needs_commands else []
        answers += [] if options.pose is None else [options.pose]
        asked = {"scan": self.scan, "clock": self.clock}.get(options.lockstep)

        def is_there() -> bool:
            self.look_for_commands()
            if needs_commands and self.commands is None:
                return False
            is_asked = asked is None or asked.get_subscription_count() > 0
            return is_asked and all(self.node.count_publishers(topic) > 0 for topic in answers)

        what = "waiting for a controller failed: expected a publisher of "
        what += " and of ".join(answers)
        if asked is not None:
            what += f" and a subscriber of {asked.topic_name}"
        remedy = "start the controller, or give more time with --wait-for"
        self.wait(what, is_there, limit_s, remedy)

    def close(self) -> None:
        """Ends the thread; the node leaves the graph of ROS with its context."""
        self._stopping = True
        self._thread.join(timeout=5.0)


def _ns(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _finite(what: str, numbers: Any) -> bool:
    """Whether all numbers are finite; prints that a message is ignored if not."""
    fine = all(map(math.isfinite, numbers))
    if not fine:
        print(f"ros2: {what} with a number that is not finite was ignored", file=sys.stderr)
    return fine
