"""Dead reckoning: wheels to pose, and nothing else.

x̂ₜ = x̂ₜ₋₁ ⊞ (Δs, 0, Δθ), with Δs and Δθ from the encoder counts (K. Lynch,
F. Park, *Modern Robotics*, §13.4). The arithmetic is that of the Rust client:
both give the same bits. No covariance: it has no belief about its error.
"""

import rusty

session = rusty.join("my-filter")
pose = rusty.SE2(*session.start.initial_pose or (0, 0, 0))
last = (0, 0)
for tick in session:
    pose = pose.boxplus(rusty.odometry_delta(last, tick.counts, session.start.robot))
    last = tick.counts
    tick.answer(*pose)
