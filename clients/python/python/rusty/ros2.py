"""Bridge a run to ROS 2: ``python -m rusty.ros2 --run NAME``.

The bridge is a participant. It publishes what its participant may know (clock, scan,
odometry, map, …; never the truth) through the user's own rclpy, and answers ticks with
the commands (as the driver) and the poses (``--pose``) that ROS nodes publish.
``docs/ros2-bridge.md`` lists topics, types and frames.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from bisect import bisect_right
from collections import deque
from typing import Any, Sequence

import numpy as np

from ._ros2_control import serve
from ._ros2_messages import Odometry, Outlets, stamp_ns, tf_type
from ._ros2_node import KINDS, SETTLE_S, Bridge, BridgeError, Received
from ._rusty import SE2, Dropped, RustyError, Session, Tick, join

DONE, FAILED, USAGE, LOST = 0, 1, 2, 3

NO_RCLPY = """\
starting the bridge failed: Python {version}: expected the package {missing}, got none; \
source a ROS 2 installation of this Python (`source /opt/ros/DISTRO/setup.bash`), or for \
tests, with CPython 3.11: pip install "ros-kilted-rclpy[fastrtps]" ros-sensor-msgs \
ros-nav-msgs ros-geometry-msgs ros-rosgraph-msgs"""
KEPT_S = 60.0
"""How long odometry is kept for poses that arrive late, s."""


def parser() -> argparse.ArgumentParser:
    """The options of the bridge. Others, as --run, are those of every participant."""
    described = "Bridge a run to ROS 2. Options of every participant (--run NAME, --name "
    described += "NAME, --wait HOW, …) and `--ros-args … --` are accepted as well."
    options = argparse.ArgumentParser("python -m rusty.ros2", allow_abbrev=False)
    options.description = described
    add = options.add_argument
    add("--control", metavar="RUN",
        help="do not join; offer the services of simulation_interfaces")
    add("--lockstep", nargs="?", const="scan", choices=("scan", "clock"),
        help="wait for an answer to each scan, or to each clock")
    add("--driver", action="store_true", help="expect commands and the role driver")
    add("--cmd-vel", default="cmd_vel", metavar="TOPIC", help="topic of the commands")
    add("--cmd-vel-type", default="auto", choices=("auto", *KINDS),
        help="type of the commands [default: as published]")
    add("--dead-man", type=_count, default=25, metavar="TICKS",
        help="free running: stop after N ticks without a command")
    add("--pose", metavar="TOPIC", help="answer with the poses of this topic, e.g. amcl_pose")
    add("--pose-from-start", action="store_true",
        help="poses are relative to the start of the robot")
    add("--rate", type=_positive, metavar="R", help="free running: at most R times real time")
    add("--wait-for", type=_positive, metavar="SECONDS",
        help="wait for a controller before joining [lockstep: 15]")
    add("--answer-timeout", type=_positive, default=8.0, metavar="SECONDS",
        help="lockstep: time limit of an answer")
    add("--map-cell", type=_positive, default=0.05, metavar="M", help="size of a cell of the map")
    return options


def _positive(text: str) -> float:
    number = float(text)
    if not (number > 0 and math.isfinite(number)):
        raise argparse.ArgumentTypeError(f"expected a number above 0, got {text}")
    return number


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected 1 or more, got {text}")
    return number


class Answers:
    """What the bridge answers: commands and poses from ROS."""

    def __init__(self, bridge: Bridge, session: Session, options: Any) -> None:
        self.bridge, self.start, self.options = bridge, session.start, options
        self.is_driver = self.start.role == "driver"
        self.begun_s = time.monotonic()
        self.command_tick: tuple[Received | None, int] = (None, 0)
        self.history: deque[tuple[int, SE2]] = deque(maxlen=math.ceil(KEPT_S / self.start.dt_s))
        self.anchor: tuple[Received | None, SE2, SE2] = (None, SE2(), SE2())

    def waits(self, tick: Tick) -> bool:
        """Whether the tick waits for an answer from ROS."""
        is_scan = self.options.lockstep == "scan" and tick.ranges is not None
        return is_scan or self.options.lockstep == "clock"

    def await_answer(self, tick: Tick) -> None:
        """Lockstep: waits for all that this tick is to be answered with."""
        bridge, index, stamp = self.bridge, tick.index, stamp_ns(tick)

        def has(received: Received | None) -> bool:
            return received is not None and received.answers(index, stamp)

        def done() -> bool:
            fine = not self.is_driver or has(bridge.command)
            return fine and (self.options.pose is None or has(bridge.pose))

        wanted = " and ".join(
            topic for topic in (self.is_driver and self.options.cmd_vel, self.options.pose) if topic
        )
        what = f"lockstep failed: tick {tick.index}: expected an answer on {wanted} with a stamp"
        what += f" of {tick.time_s:g} s or later"
        remedy = f"a controller answers every {self.options.lockstep}, with its stamp"
        bridge.wait(what, done, self.options.answer_timeout, remedy)

    def answer(self, tick: Tick, odometry: SE2) -> None:
        """Answers a tick with the latest command and pose."""
        self.history.append((stamp_ns(tick), odometry))
        answer: dict[str, Any] = {}
        if self.is_driver:
            answer["command"] = self._command(tick.index)
        pose = self._pose(odometry) if self.start.role != "observer" else None
        if pose is not None:
            (answer["x"], answer["y"], answer["theta"]), answer["covariance"] = pose
        if answer:
            tick.answer(**answer)
        else:
            tick.abstain()

    def pace(self, tick: Tick) -> None:
        """Free running: no faster than --rate."""
        if self.options.rate is not None:
            due_s = self.begun_s + tick.time_s / self.options.rate
            time.sleep(max(0.0, due_s - time.monotonic()))

    def _command(self, index: int) -> tuple[float, float]:
        """The latest command; stop if it is older than the dead man's time."""
        command = self.bridge.command
        if command is not self.command_tick[0]:
            self.command_tick = (command, index)
        is_old = index - self.command_tick[1] >= self.options.dead_man
        if command is None or (is_old and self.options.lockstep is None):
            return (0.0, 0.0)
        value: tuple[float, float] = command.value
        return value

    def _pose(self, odometry: SE2) -> tuple[SE2, Any] | None:
        """The latest pose, carried on by the odometry since its stamp, as the transforms
        from map over odom to base_link do it; and its covariance in the body frame."""
        received = self.bridge.pose
        if received is not None and received is not self.anchor[0]:
            stamps = [stamp for stamp, _ in self.history]
            at = bisect_right(stamps, received.stamp_ns or 0)
            if at > 0:
                pose = received.value[0]
                if self.options.pose_from_start:
                    pose = SE2(*self.start.initial_pose or (0, 0, 0)) * pose
                self.anchor = (received, pose, self.history[at - 1][1])
        anchor, pose, then = self.anchor
        if anchor is None:
            return None
        since = SE2() if then == odometry else then.inverse() * odometry
        return pose * since, carried(*anchor.value, since=since)


def carried(pose: SE2, covariance: Any, *, since: SE2) -> Any:
    """The covariance of a pose, along the axes of its frame, as an answer has it: in the
    body frame, after the motion `since`. None where it is not positive."""
    if not (np.diag(covariance) > 0).all():
        return None
    step = adjoint(since.inverse()) @ adjoint(SE2(0, 0, -pose.theta))
    moved = step @ covariance @ step.T
    return (moved + moved.T) / 2


def adjoint(motion: SE2) -> Any:
    """Ad of a motion: it moves twists (m, m, rad) from one frame to another."""
    x, y, theta = motion
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s, y], [s, c, -x], [0.0, 0.0, 1.0]])


def bridge_run(options: Any, rest: Sequence[str]) -> None:
    """Joins the run and bridges it to its end."""
    bridge = Bridge(_node_name(rest), options)
    try:
        if options.wait_for is not None:
            bridge.wait_for_peer(options.wait_for)
        with join("ros2", argv=rest) as session:
            _check(session, options)
            _introduce(session)
            _take_part(bridge, session, options)
    finally:
        bridge.close()


def _take_part(bridge: Bridge, session: Session, options: Any) -> None:
    outlets = Outlets(bridge.node, bridge.scan, bridge.clock, session.start, options.map_cell)
    answers, odometry = Answers(bridge, session, options), Odometry(session.start)
    if options.wait_for is not None:
        time.sleep(SETTLE_S)
    for tick in session:
        if tick.index % 16 == 0:
            bridge.look_for_commands()
        odometry.advance(tick)
        bridge.index = tick.index
        outlets.publish(tick, odometry)
        if answers.waits(tick):
            answers.await_answer(tick)
        answers.pace(tick)
        answers.answer(tick, odometry.pose)


def _check(session: Session, options: Any) -> None:
    """Refuses a role or a run that cannot do what the options ask for."""
    start = session.start
    failed = f"joining as {start.name!r} failed"
    if options.driver and start.role != "driver":
        raise BridgeError(f"{failed}: expected the role driver, got {start.role}; "
                          'give the participant role = "driver" in the scenario')
    if options.lockstep is not None and start.role != "driver" and options.pose is None:
        raise BridgeError(f"{failed}: --lockstep: expected a driver or --pose, got the role "
                          f"{start.role}; there is no answer to wait for")
    if options.lockstep == "scan" and start.scan_every == 0:
        raise BridgeError(f"{failed}: --lockstep scan: expected scans, got a run without; "
                          "give --lockstep clock")


def _introduce(session: Session) -> None:
    start = session.start
    pose = ", ".join(f"{number:g}" for number in start.initial_pose or ()) or "hidden"
    print(f"{start.name}: {start.role} in {start.scenario}, initial pose {pose}", file=sys.stderr)
    if tf_type() is None:
        print(f"{start.name}: no package tf2_msgs: no /tf and /tf_static", file=sys.stderr)


def _node_name(rest: Sequence[str]) -> str:
    """The name of the participant, as ROS allows it."""
    words = iter(rest)
    name = next((next(words, None) for word in words if word == "--name"), None) or "ros2"
    name = "".join(c if c.isalnum() else "_" for c in name)
    return name if name[0].isalpha() else f"_{name}"


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the bridge; returns the exit code."""
    argv = sys.argv if argv is None else argv
    if "-h" in argv or "--help" in argv:
        parser().parse_args(["--help"])
    try:
        import geometry_msgs.msg  # noqa: F401
        import nav_msgs.msg  # noqa: F401
        import rclpy
        import rosgraph_msgs.msg  # noqa: F401
        import sensor_msgs.msg  # noqa: F401
        from rclpy.signals import SignalHandlerOptions
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:3]))
        missing = error.name or str(error)
        print(f"ros2: {NO_RCLPY.format(version=version, missing=missing)}", file=sys.stderr)
        return FAILED
    try:
        options, rest = parser().parse_known_args(rclpy.utilities.remove_ros_args(argv)[1:])
        # Signals are Python's and the package's, so that Ctrl-C leaves the run.
        rclpy.init(args=list(argv), signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        print(f"ros2: starting ROS 2 failed: {error}", file=sys.stderr)
        return USAGE
    if options.lockstep is not None and options.wait_for is None:
        options.wait_for = 15.0
    try:
        if options.control is not None:
            serve(options.control)
        else:
            bridge_run(options, rest)
    except KeyboardInterrupt:
        return LOST
    except (RustyError, OSError) as error:
        print(f"ros2: {error}", file=sys.stderr)
        return LOST if isinstance(error, Dropped) else FAILED
    finally:
        rclpy.try_shutdown()
    return DONE


if __name__ == "__main__":
    sys.exit(main())
