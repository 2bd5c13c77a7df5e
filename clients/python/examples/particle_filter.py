"""A particle filter on a map, in plain numpy.

S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics* (2005): Monte Carlo
localization (Table 8.2) with the odometry motion model (Table 5.6), hits and random
readings of the beam model (Table 6.1), and the low variance sampler (Table 4.4).
Particles are an array (P, 3) of x m, y m, theta rad in the world frame.

Departures: of the beams one in six is used, with a wide sigma, because neighbours
err together; beams that met nothing are left out. Between scans the last estimate
moves by odometry alone. The generator's seed is fixed: the filter repeats itself.
"""

import numpy as np

import rusty

ALPHAS = (0.05, 0.01, 0.02, 0.05)  # Table 5.6, variance from: rot/rot, m/rot, m/m, rot/m
HIT_STD_M, LOST_STD_M, EVERY = 0.15, 0.5, 6
RANDOM = 0.01  # density of a random reading, where that of a perfect hit is 1
MANY, FEW = 50_000, 400  # particles that look for a hidden start, and all others


def wrap(angle_rad):
    return np.arctan2(np.sin(angle_rad), np.cos(angle_rad))


def first_particles(rng, start, world):
    """Around the initial pose, or wherever the map has room for the robot."""
    if start.initial_pose is not None:
        return np.array(start.initial_pose) + rng.normal(size=(FEW, 3)) * 0.05
    x_min, y_min, x_max, y_max = world.bounds
    drawn = rng.uniform((x_min, y_min, -np.pi), (x_max, y_max, np.pi), size=(MANY, 3))
    return drawn[world.distance(drawn[:, :2]) >= start.robot.body_radius_m]


def move(rng, particles, motion):
    """Table 5.6: turn, drive, turn, each with separate noise."""
    x, y, turn = motion
    rot1, drive = (np.arctan2(y, x), np.hypot(x, y)) if np.hypot(x, y) > 1e-3 else (0.0, x)
    if abs(rot1) > np.pi / 2:  # backwards is no half turn
        rot1, drive = wrap(rot1 + np.pi), -drive
    rot2 = wrap(turn - rot1)
    a1, a2, a3, a4 = ALPHAS
    noise = rng.normal(size=(3, len(particles)))
    r1 = rot1 - noise[0] * np.sqrt(a1 * rot1**2 + a2 * drive**2)
    d = drive - noise[1] * np.sqrt(a3 * drive**2 + a4 * (rot1**2 + rot2**2))
    r2 = rot2 - noise[2] * np.sqrt(a1 * rot2**2 + a2 * drive**2)
    heading = particles[:, 2] + r1
    return particles + np.stack([d * np.cos(heading), d * np.sin(heading), r1 + r2], axis=1)


def weigh(particles, ranges, world, lidar, hit_std_m):
    """Table 6.1, hits and random readings; the weights sum to 1."""
    met = ranges[::EVERY] < lidar.range_max_m
    error = (world.scans(particles, lidar, every=EVERY) - ranges[::EVERY])[:, met] / hit_std_m
    log_weight = np.log(np.exp(-0.5 * error**2) + RANDOM).sum(axis=1)
    weights = np.exp(log_weight - log_weight.max())
    return weights / weights.sum()


def resample(rng, particles, weights, count):
    """Table 4.4: one random number, evenly spaced pointers."""
    pointers = (rng.uniform() + np.arange(count)) / count
    return particles[np.minimum(np.searchsorted(np.cumsum(weights), pointers), len(weights) - 1)]


def summary(particles):
    """Mean pose, and covariance (3, 3) of the error along, across and around it."""
    x, y = particles[:, :2].mean(axis=0)
    c, s = np.cos(particles[:, 2]).mean(), np.sin(particles[:, 2]).mean()
    mean = rusty.SE2(x, y, np.arctan2(s, c))
    c, s = np.cos(mean.theta), np.sin(mean.theta)
    dx, dy, turn = particles[:, 0] - x, particles[:, 1] - y, wrap(particles[:, 2] - mean.theta)
    tau = np.stack([c * dx + s * dy, c * dy - s * dx, turn])
    return mean, (tau[:, None] * tau).mean(axis=2) + np.diag([5e-5, 5e-5, 1e-5])


def main():
    session = rusty.join("particle-filter")
    start, rng = session.start, np.random.default_rng(1)
    world = rusty.World.from_start(start)
    particles = first_particles(rng, start, world)
    (mean, covariance), since, last = summary(particles), rusty.SE2(), (0, 0)
    for tick in session:
        since = since.boxplus(rusty.odometry_delta(last, tick.encoders, start.robot))
        last = tick.encoders
        if tick.ranges is not None:
            particles, lost = move(rng, particles, since), len(particles) > FEW
            std_m = LOST_STD_M if lost else HIT_STD_M
            weights = weigh(particles, tick.ranges, world, start.lidar, std_m)
            particles = resample(rng, particles, weights, FEW)
            if lost:  # each that is left stands for the poses around it
                particles = particles + rng.normal(size=(FEW, 3)) * 0.1
            (mean, covariance), since = summary(particles), rusty.SE2()
        seen = particles if tick.ranges is not None else None  # for pages and reports
        tick.answer(*(mean @ since), covariance, belief=seen)


if __name__ == "__main__":
    main()
