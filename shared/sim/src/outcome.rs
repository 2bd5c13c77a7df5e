//! What a tick did to the robot.

/// What a tick did to the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a blocked robot has not moved although its wheels have turned"]
pub enum StepOutcome {
    /// The robot moved along an arc.
    Moved {
        /// Signed length of the arc over the ground, m; slip and radius bias are
        /// in it.
        ds_m: f64,
        /// Signed change of heading, rad, counter-clockwise positive, not wrapped.
        dtheta_rad: f64,
    },
    /// The arc would have touched a wall: the pose stayed as it was, exactly.
    /// The wheels turned nevertheless, and the encoders counted it.
    Blocked,
}
