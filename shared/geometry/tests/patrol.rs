//! The patrol of the chapter without slip: what rounding to counts costs, and
//! what a wheel one percent too large does. The drive, the exponential and the
//! encoders together, against pinned numbers.

use rusty_geometry::{DiffDrive, EncoderTicks, SE2, Twist, odometry_delta, trig};

const DT_S: f64 = 0.1;
const V_M_S: f64 = 0.57;
const RAMP: i32 = 6;

/// The speed of tick `j` of a straight of `n`, ramped at both ends.
fn straight(j: i32, n: i32) -> f64 {
    let q = j.min(n - 1 - j);
    if q < RAMP { V_M_S * f64::from(q + 1) / f64::from(RAMP + 1) } else { V_M_S }
}

/// Two legs and back, with turns to the right on the spot.
fn command(tick: i32) -> Twist {
    const FIRST: i32 = 23;
    const LEG: i32 = 123;
    const PAUSE: i32 = 3;
    const TURN: i32 = 10;
    let forward = |v_m_s| Twist { v_m_s, omega_rad_s: 0.0 };
    if tick < FIRST {
        return forward(straight(tick, FIRST));
    }
    let u = (tick - FIRST) % (PAUSE + TURN + LEG);
    if u < PAUSE {
        Twist::default()
    } else if u < PAUSE + TURN {
        Twist { v_m_s: 0.0, omega_rad_s: -3.1363 }
    } else {
        forward(straight(u - PAUSE - TURN, LEG))
    }
}

/// Drift in metres, heading error in degrees, and the counts after 300 ticks.
fn patrol(right_radius_bias: f64) -> (f64, f64, EncoderTicks) {
    let drive = DiffDrive::rusty();
    let (mut truth, mut reckoned) = (SE2::identity(), SE2::identity());
    let mut angles_rad = [0.0, 0.0];
    let mut ticks = EncoderTicks::default();
    for tick in 0..300 {
        let rates = drive.wheel_rates(command(tick));
        let turned_rad = [rates.left_rad_s * DT_S, rates.right_rad_s * DT_S];
        angles_rad[0] += turned_rad[0];
        angles_rad[1] += turned_rad[1];
        truth = truth.boxplus(&drive.tangent(
            drive.wheel_radius_m * turned_rad[0],
            drive.wheel_radius_m * (1.0 + right_radius_bias) * turned_rad[1],
        ));
        let now = EncoderTicks::from_wheel_angles(angles_rad, drive.ticks_per_rev);
        reckoned = reckoned.boxplus(&odometry_delta(ticks, now, &drive));
        ticks = now;
    }
    let error = reckoned.boxminus(&truth);
    let drift_m = trig::hypot(reckoned.x() - truth.x(), reckoned.y() - truth.y());
    (drift_m, error.z.abs().to_degrees(), ticks)
}

#[test]
fn quantization_only() {
    let (drift_m, heading_deg, ticks) = patrol(0.0);
    assert_eq!((ticks.left, ticks.right), (293_532, 271_723));
    assert!((drift_m - 1.062_004_987_974_054_2e-4).abs() < 1e-12, "{drift_m:e}");
    assert!((heading_deg - 0.008_512_397_770_161_613).abs() < 1e-9, "{heading_deg}");
}

#[test]
fn right_wheel_one_percent_too_large() {
    let (drift_m, heading_deg, ticks) = patrol(0.01);
    assert_eq!((ticks.left, ticks.right), (293_532, 271_723));
    assert!((drift_m - 2.678_329_605_898_544_4).abs() < 1e-10, "{drift_m}");
    assert!((heading_deg - 49.265_017_954_970_61).abs() < 1e-9, "{heading_deg}");
}
