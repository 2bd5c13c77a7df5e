"""The smallest working estimator: wheels to pose (*Modern Robotics*, §13.4)."""

import rusty

session = rusty.join("my-filter")
pose = rusty.SE2(*session.start.initial_pose or (0, 0, 0))
last = (0, 0)
for tick in session:
    pose = pose.boxplus(rusty.odometry_delta(last, tick.encoders, session.start.robot))
    last = tick.encoders
    tick.answer(*pose)
