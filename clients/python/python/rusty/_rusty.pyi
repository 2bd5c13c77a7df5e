"""The native half of the package."""

from collections.abc import Iterator, Sequence
from os import PathLike
from types import TracebackType
from typing import Any, Literal, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
PROTOCOL_VERSION: int
LAYOUT_HASH: int
"""Layout of what lies in shared memory; `sim-server layout` prints the same."""

class RustyError(Exception):
    """What can go wrong with a run or a log."""

class Refused(RustyError):
    """The server said no, in its own words."""

class ServerGone(RustyError):
    """The server ended without announcing the end of the run."""

class Dropped(RustyError):
    """The run goes on without this participant, which was too slow or answered
    what is no answer."""

@final
class Robot:
    """What the maker says of the robot."""

    @property
    def wheel_radius_m(self) -> float:
        """Nominal wheel radius, m."""
    @property
    def track_m(self) -> float:
        """Nominal distance between the wheels' contact points, m."""
    @property
    def ticks_per_rev(self) -> int:
        """Encoder counts per wheel revolution."""
    @property
    def body_radius_m(self) -> float:
        """Radius of the body's disc, m; it is what touches walls."""
    @property
    def wheel_limit_rad_s(self) -> float:
        """Fastest a wheel can turn, rad/s."""

@final
class Lidar:
    """Geometry of the LiDAR's beams, and its figures where they are told."""

    @property
    def beams(self) -> int:
        """Number of beams n."""
    @property
    def bearings_rad(self) -> NDArray[np.float64]:
        """Bearing of each beam in the sensor frame, rad, shape (n,), read-only."""
    @property
    def first_bearing_rad(self) -> float:
        """Bearing of beam 0 in the sensor frame, rad."""
    @property
    def fov_rad(self) -> float:
        """Angle over which the n beams are spread, rad; beam k points along
        first_bearing_rad + fov_rad * k / n."""
    @property
    def range_max_m(self) -> float:
        """Range that a beam reports when nothing came back, m."""
    @property
    def range_std_m(self) -> float | None:
        """Standard deviation of a range at distance 0, m; None: not told, as with all
        figures below."""
    @property
    def range_std_per_m(self) -> float | None:
        """Growth of the standard deviation with the range, m per m; both add in
        squares."""
    @property
    def dropout(self) -> float | None:
        """Probability that a beam returns nothing."""
    @property
    def glass_visible_rad(self) -> float | None:
        """Greatest angle of incidence at which every pane of glass returns every
        beam, rad; beyond it a beam may pass. pi/2: glass is like a wall."""
    @property
    def divergence_rad(self) -> float | None:
        """Full angle of the footprint of a beam, rad."""
    @property
    def sensor_in_body(self) -> tuple[float, float, float]:
        """Pose of the sensor on the body, (x m, y m, theta rad)."""

@final
class Start:
    """What a participant is told before the first tick. What its role may not
    know is None."""

    @property
    def name(self) -> str:
        """Name in the roster."""
    @property
    def role(self) -> str:
        """Role in the roster: "estimator", "driver" or "observer"."""
    @property
    def scenario(self) -> str:
        """Name of the scenario."""
    @property
    def dt_s(self) -> float:
        """Length of a tick, s."""
    @property
    def ticks(self) -> int:
        """How many ticks the run has."""
    @property
    def scan_every(self) -> int:
        """One scan every N ticks; 0: none."""
    @property
    def robot(self) -> Robot:
        """What the maker says of the robot."""
    @property
    def lidar(self) -> Lidar:
        """The LiDAR."""
    @property
    def data_sheet(self) -> str:
        """Whose figures of the sensors these are: "given" (those of the run), "nominal"
        (those of the data sheets) or "hidden" (None)."""
    @property
    def sensors(self) -> dict[str, dict[str, Any]]:
        """The small sensors, as in the ``[sensors]`` of a scenario: what is there, where
        it is mounted, and its noise, where that is told."""
    @property
    def map(self) -> NDArray[np.float64] | None:
        """The walls, m, world frame: rows (x_a, y_a, x_b, y_b), shape (walls, 4),
        read-only; None where the map is hidden."""
    @property
    def materials(self) -> list[str] | None:
        """What the walls are made of, in the map's order: "Wall", "Glass",
        "Door(3)"."""
    @property
    def bounds(self) -> tuple[float, float, float, float] | None:
        """The box that holds the map, m: (x_min, y_min, x_max, y_max)."""
    @property
    def initial_pose(self) -> tuple[float, float, float] | None:
        """Where the robot starts in the world frame, (x m, y m, theta rad); None
        where that is hidden."""

@final
class Tick:
    """One tick of the world, read where it lies. ``answer`` it; left without an
    answer it abstains when the loop goes on."""

    @property
    def index(self) -> int:
        """Number of the tick, from 0."""
    @property
    def time_s(self) -> float:
        """Time at the end of the tick, s."""
    @property
    def encoders(self) -> tuple[int, int]:
        """Encoder counts since the start, (left, right), at the end of the tick."""
    @property
    def command(self) -> tuple[float, float]:
        """The command applied during the tick, body frame: (v m/s, omega rad/s)."""
    @property
    def ranges(self) -> NDArray[np.float64] | None:
        """The scan taken at the end of the tick: one range for each beam, m, shape
        (beams,), read-only. None on ticks without a scan.

        The array lies over the frame in shared memory, without a copy. Kept past
        its tick it stays what it was, and so does every slice of it, even when
        the session or the server has ended. While 3 such arrays are kept, those of
        later ticks are copies.

        Arrays that exist at an ``os.fork()`` stay what they were in the fork, too:
        for its sake this process keeps their frames until it ends, so that later
        arrays of the session may be copies from then on.

        Raises:
            RuntimeError: when it is first asked for after its tick is over, or in
                a fork of the process that joined.
        """
    @property
    def bumper(self) -> int | None:
        """Sectors of the bumper that touch something, bit k for sector k. None where the
        robot has no bumper."""
    @property
    def imu(self) -> tuple[float, float, float] | None:
        """What the IMU says: (yaw rate rad/s, acceleration ahead m/s^2, acceleration
        to the left m/s^2), body frame. None where the robot has no IMU."""
    @property
    def sonars(self) -> NDArray[np.float64] | None:
        """Range of each sonar, m, shape (sonars,). None on ticks without."""
    @property
    def doors(self) -> list[int] | None:
        """Numbers of the doors that are detected, ascending. None on ticks without a
        reading."""
    @property
    def landmarks(self) -> NDArray[np.float64] | None:
        """The landmarks that are seen, shape (landmarks, 3): id (-1 where it is not
        known), range m, bearing rad in the body frame. None on ticks without a
        reading."""
    def answer(
        self,
        x: float | None = None,
        y: float | None = None,
        theta: float | None = None,
        covariance: ArrayLike | None = None,
        command: tuple[float, float] | None = None,
        innovation: tuple[float, int] | None = None,
        belief: ArrayLike | None = None,
        belief_kind: Literal["particles", "histogram"] = "particles",
        last: bool = False,
    ) -> None:
        """Answers the tick. The answer is the acknowledgement: only when all have
        answered does the next tick happen.

        Args:
            x: believed position of the body in the world frame, m.
            y: the same.
            theta: believed heading, rad, counter-clockwise from the world x axis.
            covariance: of the error tau (m, m, rad) in the tangent space at the
                estimate, truth = estimate [+] tau, so along and across the body:
                shape (3, 3), row by row. None: not reported.
            command: (v m/s, omega rad/s) for the next tick, body frame. It moves
                the robot where this participant is the driver. A command alone is
                an answer as well.
            innovation: (nis, degrees), how surprising this tick's measurements
                were: the normalised innovation squared nu' S^-1 nu, summed over
                the updates of the tick, and how many numbers were measured.
                None: not reported.
            belief: poses that are possible now, shape (N, 3) or (N, 4): x m, y m,
                theta rad, weight. They are shown on the pages and in the reports of
                the run, and are no part of the answer. Not shown on a log.
            last: whether the run ends with this tick, once all have answered it.
                Counts where this participant is the driver.
            belief_kind: "particles", or "histogram" where the poses are the cells
                of a grid.

        Raises:
            ValueError: an invalid number, by name; the tick can be answered
                again.
            RuntimeError: the tick has been answered, or is over.
        """
    def abstain(self) -> None:
        """Says nothing about this tick.

        Raises:
            RuntimeError: the tick has been answered, or is over.
        """

@final
class Session:
    """A part in a run, live or on a log: an iterator of its ticks, and a context
    manager that leaves the run at the end of its block."""

    @property
    def start(self) -> Start:
        """What this participant was told."""
    @property
    def ending(self) -> Literal["done", "interrupted", "aborted"] | None:
        """How the run ended; None before it has, or where the session left
        earlier."""
    def runs(self) -> Iterator[Session]:
        """The run that was joined, then each further run that the server offers to
        this process, as a sweep does: the same session, whose `start` is then that of the
        next run. Make a filter from it anew for each run. Without it a script takes part
        in one run, and the server starts it again for the next.

        Raises, while it is iterated:
            ServerGone: the server has ended.
            RuntimeError: the current run has not ended.
        """
    def close(self) -> None:
        """Leaves the run. Before its end that is a failure to the run."""
    def __iter__(self) -> Iterator[Tick]: ...
    def __next__(self) -> Tick:
        """The next tick. A tick before it that was not answered abstains.

        The interpreter is not held while waiting, and Ctrl-C ends the wait.

        Raises:
            ServerGone: the server ended without announcing the end of the run.
            Dropped: the run goes on without this participant.
            RuntimeError: another thread waits, or this process is a fork of the
                one that joined.
        """
    def __enter__(self) -> Session: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> bool: ...

def join(
    name: str | None = None,
    *,
    run: str | None = None,
    log: str | PathLike[str] | None = None,
    out: str | PathLike[str] | None = None,
    wait: Literal["balanced", "spin", "block"] = "balanced",
    join_timeout: float = 20.0,
    argv: Sequence[str] | None = None,
) -> Session:
    """Joins a run, or opens a log; iterate over what it returns.

    With neither ``run`` nor ``log`` the command line says which, as a launcher
    writes it: ``--run NAME --name NAME --wait HOW --launcher PID``, or by hand
    ``--run NAME`` or ``--log PATH``; ``--help`` lists all. ``out``, ``wait`` and
    ``join_timeout`` are then the command line's, too: given here they count for
    nothing. The script is then a program that takes part: asked to stop (SIGTERM,
    Ctrl-C) it leaves the run, and it prints one line, not a traceback, if it could
    not join, was dropped, or the server has ended. With ``run``, Ctrl-C in the main
    thread leaves the run as well. Signal handlers and an excepthook that a program has set stay
    as they are.

    Args:
        name: name in the roster, unless the command line has ``--name``. Default:
            the script's name.
        run: the run to join.
        log: work on this log instead, without a server.
        out: with ``log``: write the answers to this file as CSV.
        wait: look for ticks for up to 400 microseconds before sleeping
            ("balanced"), never sleep ("spin"), or sleep at once ("block").
        join_timeout: how long to wait for the run to appear, s.
        argv: read these arguments instead of ``sys.argv[1:]``, for a script with
            other arguments.

    Raises:
        Refused: the server says no.
        RustyError: there is no such run or log, or it cannot be used.
        ValueError: an argument that cannot be used.
        SystemExit: the command line asks for help, or cannot be used.
    """

def _before_fork() -> None: ...
def _last_start() -> Start: ...
def _leave_all() -> None: ...
def _stop_all() -> None: ...

# The plane, for models of robot and sensor: the geometry's own functions, bit for
# bit. Nothing here knows any noise.

@final
class SE2:
    """A pose or a motion of the plane: metres, metres, radians.

    Read as a pose it is the place of a body's frame in the world frame. Tangent
    vectors are arrays (3,) of (rho_x m, rho_y m, theta rad) in the body frame. It
    is immutable and unpacks like a tuple: ``x, y, theta = pose``.

    Source: J. Sola, J. Deray, D. Atchuthan, *A micro Lie theory for state
    estimation in robotics* (arXiv:1812.01537).
    """

    def __new__(cls, x: float = 0.0, y: float = 0.0, theta: float = 0.0) -> SE2:
        """The angle is wrapped to (-pi, pi]. Nothing is refused: NaN stays NaN."""
    @property
    def x(self) -> float:
        """World x of the origin, m."""
    @property
    def y(self) -> float:
        """World y of the origin, m."""
    @property
    def theta(self) -> float:
        """Heading, rad in (-pi, pi], counter-clockwise from the world x axis."""
    @staticmethod
    def exp(tau: Sequence[float] | NDArray[np.float64]) -> SE2:
        """The motion that the constant twist `tau` (m, m, rad) makes in one unit of
        time."""
    def log(self) -> NDArray[np.float64]:
        """The shortest constant twist, shape (3,), whose `exp` this is."""
    def boxplus(self, tau: Sequence[float] | NDArray[np.float64]) -> SE2:
        """``self [+] tau``: moved by the twist `tau` (m, m, rad) in the body frame."""
    def boxminus(self, other: SE2 | Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
        """``self [-] other``: the twist, shape (3,), in the frame of `other`, with
        ``other.boxplus(twist) == self`` up to rounding."""
    def compose(self, other: SE2 | Sequence[float] | NDArray[np.float64]) -> SE2:
        """With `self` the pose of a frame B in A and `other` the pose of C in B, the
        pose of C in A. Written ``self * other`` or ``self @ other``, too."""
    def inverse(self) -> SE2:
        """The motion that undoes this one."""
    def __mul__(self, other: SE2, /) -> SE2: ...
    def __matmul__(self, other: SE2, /) -> SE2: ...
    def __rmul__(self, other: SE2, /) -> SE2: ...
    def __rmatmul__(self, other: SE2, /) -> SE2: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __iter__(self) -> Iterator[float]: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> float: ...
    def __getnewargs__(self) -> tuple[float, float, float]: ...

def wrap_angle(theta_rad: float) -> float:
    """The angle in (-pi, pi] that differs from `theta_rad` by whole turns. One that
    is there already keeps its bits; NaN and infinities give NaN."""

def odometry_delta(
    last_counts: tuple[int, int], counts: tuple[int, int], drive: Robot
) -> NDArray[np.float64]:
    """The twist (ds m, 0, dtheta rad), shape (3,), between two readings of the
    encoders, for ``pose.boxplus(...)``.

    Args:
        last_counts: (left, right), as `Tick.encoders` has them.
        counts: the same, later.
        drive: `Start.robot`, or anything with its `wheel_radius_m`, `track_m` and
            `ticks_per_rev`.
    """

@final
class World:
    """A checked, immutable world: straight walls in the plane, in a search tree.

    Lengths are metres, angles radians, in the world frame.
    """

    @staticmethod
    def builtin(name: str) -> World:
        """A built-in world, such as "apartment"; `sim-server worlds` lists all."""
    @staticmethod
    def from_file(path: str | PathLike[str]) -> World:
        """The world in a file: TOML or, with the ending .json, JSON.

        A map of ROS (.yaml) or a drawing (.svg) is converted by
        `sim-server worlds FILE --json`.

        Raises:
            OSError: the file cannot be read.
            ValueError: it is no world that can be used, with wall and remedy.
        """
    @staticmethod
    def from_json(text: str) -> World:
        """The world in JSON text: `name`, `bounds` and `walls`, each with `a` [x, y],
        `b` [x, y] and `material`."""
    @staticmethod
    def from_start(start: Start) -> World:
        """The map that a participant was given.

        Raises:
            ValueError: the map is hidden from it.
        """
    @staticmethod
    def from_walls(
        walls: ArrayLike,
        *,
        bounds: tuple[float, float, float, float] | None = None,
        materials: Sequence[str] | None = None,
        name: str = "walls",
    ) -> World:
        """A world of walls.

        Args:
            walls: shape (N, 4): x and y of one end, x and y of the other, m.
            bounds: (x_min, y_min, x_max, y_max), m. Default: those of the walls.
            materials: N of "Wall", "Glass" or "Door(3)". Default: all "Wall".
            name: a short name.

        Raises:
            ValueError: a wall that cannot be used, with its index and the remedy;
                ends that almost meet another wall are refused, too.
        """
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def walls(self) -> NDArray[np.float64]:
        """A new array, shape (N, 4): x and y of one end, x and y of the other, m."""
    @property
    def materials(self) -> list[str]:
        """What each wall is made of: "Wall", "Glass" or "Door(3)"."""
    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, y_min, x_max, y_max), m. They stop neither a ray nor a body."""
    @overload
    def raycast(
        self, origin: Sequence[float], angle_rad: float, range_max_m: float = ...
    ) -> float: ...
    @overload
    def raycast(
        self, origin: Sequence[float], angle_rad: ArrayLike, range_max_m: float = ...
    ) -> NDArray[np.float64]:
        """How far rays go before they meet a wall, m.

        Args:
            origin: (x, y), m, world frame.
            angle_rad: direction from the world x axis: a number, or an array of any
                shape, which the result then has.
            range_max_m: the result where nothing is met before. Default: infinite.
        """
    def scan(
        self,
        pose: SE2 | Sequence[float] | NDArray[np.float64],
        lidar: Lidar | dict[str, Any],
        *,
        every: int = 1,
    ) -> NDArray[np.float64]:
        """What the LiDAR of a robot at `pose` would see without noise: ranges, m,
        shape (B,); its `range_max_m` where a beam meets nothing.

        Args:
            pose: the body's in the world frame.
            lidar: `Start.lidar`, or a dictionary like the ``[lidar]`` of a scenario.
            every: cast only beams 0, every, 2 every, ...: those of
                ``tick.ranges[::every]``, to the last digits of their directions.
        """
    def scans(
        self, poses: ArrayLike, lidar: Lidar | dict[str, Any], *, every: int = 1
    ) -> NDArray[np.float64]:
        """`scan` from many poses, shape (P, 3), at once: ranges, m, shape (P, B).

        A particle filter's model of the LiDAR. The interpreter is not held meanwhile.
        """
    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Distance from each of `points`, shape (P, 2), to the nearest wall, m, shape
        (P,): infinite in an open world, NaN for a point that is not finite.

        For likelihood fields; and a body of radius r has room where it is at least r.
        """

# What `rusty.read_log` and `rusty.launch` are made of.

def read_columns(path: str | PathLike[str]) -> dict[str, Any]: ...
def toml_document(json: str) -> str: ...
def toml_value(json: str) -> str: ...
def toml_json(toml: str) -> str: ...

# What `rusty.ros2` sends to the server of its run.

def control(run: str, request: str, timeout_s: float) -> str: ...
