"""A particle filter with a map, in plain numpy.

S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics* (2005): the filter of
Table 4.3 as Monte Carlo localization (Table 8.2), the motion model of Table 5.6
(odometry), the beams' hits and random readings of Table 6.1, and the low variance
sampler of Table 4.4. Particles are (P, 3) arrays of x m, y m, theta rad, world frame.

Departures: a scan's beams are one in six, with a wider σ, because neighbours err
together; beams that met nothing are left out. Between scans the last estimate is
moved by odometry alone. Its generator has a fixed seed, so it repeats itself.
"""

import numpy as np

import rusty

ALPHAS = (0.05, 0.01, 0.02, 0.05)  # Table 5.6: rot/rot, rot/m, m/m, m/rot
HIT_STD_M, RANDOM, EVERY = 0.15, 0.1, 6
MANY, FEW = 4000, 400  # particles while lost, and once they agree


def wrap(angle_rad):
    return np.arctan2(np.sin(angle_rad), np.cos(angle_rad))


def first_particles(rng, start, world):
    """Around the initial pose, or wherever the map has room for the robot."""
    if start.initial_pose is not None:
        return np.array([*start.initial_pose]) + rng.normal(size=(FEW, 3)) * (0.05, 0.05, 0.05)
    x_min, y_min, x_max, y_max = world.bounds
    found = np.empty((0, 3))
    while len(found) < MANY:
        new = rng.uniform((x_min, y_min, -np.pi), (x_max, y_max, np.pi), size=(MANY, 3))
        new = new[world.distance(new[:, :2]) >= start.robot.body_radius_m]
        found = np.concatenate([found, new])
    return found[:MANY]


def move(rng, particles, motion):
    """Table 5.6: turn, drive, turn, each with noise of its own."""
    x, y, turn = motion
    drive = np.hypot(x, y)
    rot1 = np.arctan2(y, x) if drive > 1e-3 else 0.0
    # Driving backwards is no half turn.
    if abs(rot1) > np.pi / 2:
        rot1, drive = wrap(rot1 + np.pi), -drive
    rot2 = wrap(turn - rot1)
    a1, a2, a3, a4 = ALPHAS
    noise = rng.normal(size=(3, len(particles)))
    r1 = rot1 - noise[0] * np.sqrt(a1 * rot1**2 + a2 * drive**2)
    d = drive - noise[1] * np.sqrt(a3 * drive**2 + a4 * (rot1**2 + rot2**2))
    r2 = rot2 - noise[2] * np.sqrt(a1 * rot2**2 + a2 * drive**2)
    theta = particles[:, 2] + r1
    moved = particles + np.stack([d * np.cos(theta), d * np.sin(theta), r1 + r2], axis=1)
    moved[:, 2] = wrap(moved[:, 2])
    return moved


def weigh(particles, ranges, world, lidar):
    """Table 6.1, hits and random readings; the weights sum to 1."""
    seen = ranges[::EVERY]
    met = seen < lidar.range_max_m
    error = (world.scans(particles, lidar, every=EVERY) - seen)[:, met] / HIT_STD_M
    log_weight = np.log((1 - RANDOM) * np.exp(-0.5 * error**2) + RANDOM / 10).sum(axis=1)
    weights = np.exp(log_weight - log_weight.max())
    return weights / weights.sum()


def resample(rng, particles, weights, count):
    """Table 4.4: one random number, evenly spaced pointers."""
    pointers = (rng.uniform() + np.arange(count)) / count
    return particles[np.minimum(np.searchsorted(np.cumsum(weights), pointers), len(weights) - 1)]


def summary(particles):
    """Mean pose, and covariance (3, 3) of the error in its frame."""
    x, y = particles[:, :2].mean(axis=0)
    theta = np.arctan2(np.sin(particles[:, 2]).mean(), np.cos(particles[:, 2]).mean())
    dx, dy = particles[:, 0] - x, particles[:, 1] - y
    c, s = np.cos(theta), np.sin(theta)
    tau = np.stack([c * dx + s * dy, c * dy - s * dx, wrap(particles[:, 2] - theta)])
    covariance = (tau[:, None] * tau[None, :]).mean(axis=2) + np.diag([1e-4, 1e-4, 1e-5])
    return rusty.SE2(x, y, theta), covariance


def main():
    session = rusty.join("particle-filter")
    start, rng = session.start, np.random.default_rng(1)
    world = start.map
    particles = first_particles(rng, start, world)
    mean, covariance = summary(particles)
    since, last = rusty.SE2(), (0, 0)  # the motion since the last scan
    for tick in session:
        since = since.boxplus(rusty.odometry_delta(last, tick.counts, start.robot))
        last = tick.counts
        if tick.ranges is not None:
            particles = move(rng, particles, since)
            weights = weigh(particles, tick.ranges, world, start.lidar)
            spread = 1.0 if len(particles) == FEW else np.sqrt(np.trace(covariance[:2, :2]))
            particles = resample(rng, particles, weights, FEW if spread < 0.3 else len(particles))
            mean, covariance = summary(particles)
            since = rusty.SE2()
        tick.answer(*(mean @ since), covariance=covariance)


if __name__ == "__main__":
    main()
