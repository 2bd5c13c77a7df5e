//! The IMU: yaw rate and planar acceleration of the body's true motion.
//!
//! Source: R. L. Farrenkopf (1978), in the discrete form of J. L. Crassidis (2006,
//! "Sigma-point Kalman filtering for integrated GPS and inertial navigation"). With
//! white noise of density σ_v and a bias β that is a random walk of density σ_u, and
//! n₁, n₂ ~ N(0, 1), each tick of Δt:
//!
//! * β ← β + σ_u·√Δt·n₁
//! * reading = true + ½(β before + β after) + √(σ_v²/Δt + σ_u²·Δt/12)·n₂
//!
//! so that a change of Δt changes neither density. The figures are those of a data
//! sheet: an angle random walk N in °/√h is σ_v; an instability of B in the time T is
//! σ_u = B/√T, by which the bias has gone B (1 σ) after T (O. J. Woodman, UCAM-CL-TR-696,
//! 2007, section 3.2). The Allan variance of the reading at rest is σ_v²/τ + σ_u²·τ/3.
//!
//! The body's velocity is its displacement in the tick divided by Δt; acceleration
//! ahead is its change from tick to tick, acceleration to the left is v·ω.
//!
//! Departures from a real one: it stands at the centre of the body, has no scale error
//! and no limit, does not measure gravity, and feels no kidnapping. The wheels of this
//! world slip anew in each tick, which shows as acceleration.

use rusty_contract::ImuReading;
use rusty_contract::config::sensors::ImuConfig;

use crate::noise::TickNoise;
use crate::outcome::StepOutcome;

/// Standard gravity, m/s²: what a µg is a millionth of.
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Noise density and random walk of one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// σ of the white noise of a tick.
    white_std: f64,
    /// σ of a step of the bias.
    step_std: f64,
    /// σ of the bias at the start.
    turn_on_std: f64,
    bias: f64,
}

impl Axis {
    /// Densities in the unit of the reading: white ·√s, walk /√s, turn-on.
    fn new(white: f64, walk: f64, turn_on_std: f64, dt_s: f64) -> Self {
        let variance = white * white / dt_s + walk * walk * dt_s / 12.0;
        Self { white_std: variance.sqrt(), step_std: walk * dt_s.sqrt(), turn_on_std, bias: 0.0 }
    }

    fn measured(&mut self, exact: f64, z_walk: f64, z_white: f64) -> f64 {
        let before = self.bias;
        self.bias += self.step_std * z_walk;
        exact + 0.5 * (before + self.bias) + self.white_std * z_white
    }
}

/// An inertial measurement unit and its biases.
#[derive(Clone, Debug)]
pub struct Imu {
    /// Yaw rate, acceleration x, acceleration y.
    axes: [Axis; 3],
    dt_s: f64,
    /// Speed ahead in the tick before, m/s.
    speed_m_s: f64,
    noise: TickNoise,
}

impl Imu {
    /// The unit that `config` describes, read every `dt_s`, before the first tick of
    /// a robot at rest.
    #[must_use]
    pub fn new(config: &ImuConfig, dt_s: f64, seed: u64) -> Self {
        let deg_h = 1f64.to_radians() / 3600.0;
        let ug = 1e-6 * STANDARD_GRAVITY_M_S2;
        let in_time = 1.0 / config.bias_time_s.sqrt();
        let gyro = Axis::new(
            // °/√h is 1/60 of °/√s.
            config.gyro_noise_deg_sqrt_h.to_radians() / 60.0,
            config.gyro_bias_instability_deg_h * deg_h * in_time,
            config.gyro_turn_on_bias_deg_h * deg_h,
            dt_s,
        );
        let accel = Axis::new(
            config.accel_noise_ug_sqrt_hz * ug,
            config.accel_bias_instability_ug * ug * in_time,
            config.accel_turn_on_bias_ug * ug,
            dt_s,
        );
        let axes = [gyro, accel, accel];
        let mut imu = Self { axes, dt_s, speed_m_s: 0.0, noise: TickNoise::imu(seed) };
        imu.restart(seed);
        imu
    }

    /// Back before the first tick, with another seed.
    pub fn restart(&mut self, seed: u64) {
        self.reseed(seed);
        self.speed_m_s = 0.0;
        let z = TickNoise::imu_start(seed).normals::<3>(0);
        for (axis, z) in self.axes.iter_mut().zip(z) {
            axis.bias = axis.turn_on_std * z;
        }
    }

    /// Goes on with the noise of another seed; the biases stay as they are.
    pub fn reseed(&mut self, seed: u64) {
        self.noise = TickNoise::imu(seed);
    }

    /// What the unit says of the motion of tick `tick`. To be called in every tick,
    /// since the biases walk.
    pub fn read(&mut self, outcome: StepOutcome, tick: u64) -> ImuReading {
        let (ds_m, dtheta_rad) = match outcome {
            StepOutcome::Moved { ds_m, dtheta_rad } => (ds_m, dtheta_rad),
            StepOutcome::Blocked => (0.0, 0.0),
        };
        let (speed_m_s, yaw_rate_rad_s) = (ds_m / self.dt_s, dtheta_rad / self.dt_s);
        let ahead_m_s2 = (speed_m_s - self.speed_m_s) / self.dt_s;
        self.speed_m_s = speed_m_s;
        let exact = [yaw_rate_rad_s, ahead_m_s2, speed_m_s * yaw_rate_rad_s];
        let z = self.noise.normals::<6>(tick);
        let mut measured = [0.0; 3];
        for (i, axis) in self.axes.iter_mut().enumerate() {
            measured[i] = axis.measured(exact[i], z[2 * i], z[2 * i + 1]);
        }
        let [yaw_rate_rad_s, accel_x_m_s2, accel_y_m_s2] = measured;
        ImuReading { yaw_rate_rad_s, accel_x_m_s2, accel_y_m_s2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: StepOutcome = StepOutcome::Moved { ds_m: 0.0, dtheta_rad: 0.0 };

    fn square(x: f64) -> f64 {
        x * x
    }

    /// No noise at all.
    fn exact() -> ImuConfig {
        ImuConfig {
            gyro_noise_deg_sqrt_h: 0.0,
            gyro_bias_instability_deg_h: 0.0,
            gyro_turn_on_bias_deg_h: 0.0,
            accel_noise_ug_sqrt_hz: 0.0,
            accel_bias_instability_ug: 0.0,
            accel_turn_on_bias_ug: 0.0,
            bias_time_s: 500.0,
        }
    }

    #[test]
    fn without_noise_it_reads_the_motion() {
        let mut imu = Imu::new(&exact(), 0.02, 1);
        let moved = StepOutcome::Moved { ds_m: 0.01, dtheta_rad: 0.02 };
        // From rest to 0.5 m/s in a tick, on an arc of 1 rad/s.
        let first = imu.read(moved, 0);
        assert!((first.yaw_rate_rad_s - 1.0).abs() < 1e-12);
        assert!((first.accel_x_m_s2 - 25.0).abs() < 1e-12);
        assert!((first.accel_y_m_s2 - 0.5).abs() < 1e-12);
        let steady = imu.read(moved, 1);
        assert!(steady.accel_x_m_s2.abs() < 1e-12, "{steady:?}");
        let wall = imu.read(StepOutcome::Blocked, 2);
        assert!((wall.accel_x_m_s2 + 25.0).abs() < 1e-12 && wall.yaw_rate_rad_s == 0.0);
    }

    /// Overlapping Allan deviation of readings every `dt_s` at averaging time
    /// `n`·`dt_s` (IEEE Std 952-2020, annex C).
    fn allan_deviation(angle: &[f64], n: usize, dt_s: f64) -> f64 {
        let tau = n as f64 * dt_s;
        let terms = angle.len() - 2 * n;
        let sum: f64 =
            (0..terms).map(|i| square(angle[i + 2 * n] - 2.0 * angle[i + n] + angle[i])).sum();
        (sum / (2.0 * tau * tau * terms as f64)).sqrt()
    }

    #[test]
    fn six_hours_at_rest_give_back_the_figures_of_the_data_sheet_at_any_rate() {
        // An instability that shows from 5 s on, so that six hours tell it to 5 %.
        let config = ImuConfig {
            gyro_noise_deg_sqrt_h: 0.30,
            gyro_bias_instability_deg_h: 36.0,
            bias_time_s: 9.0,
            ..exact()
        };
        for rate_hz in [50.0, 100.0, 400.0] {
            let dt_s = 1.0 / rate_hz;
            let mut imu = Imu::new(&config, dt_s, 7);
            let ticks = (6.0 * 3600.0 * rate_hz) as u64;
            let mut angle = vec![0.0];
            let mut sum = 0.0;
            for tick in 0..ticks {
                sum += imu.read(REST, tick).yaw_rate_rad_s * dt_s;
                angle.push(sum);
            }
            let at = |tau_s: f64| allan_deviation(&angle, (tau_s * rate_hz) as usize, dt_s);
            // σ²(τ) = N²/τ + K²·τ/3: two times give both figures.
            let (short_s, long_s) = (0.2, 10.0);
            let (a, b) = (square(at(short_s)), square(at(long_s)));
            let determinant = long_s / (3.0 * short_s) - short_s / (3.0 * long_s);
            let white = (a * long_s / 3.0 - b * short_s / 3.0) / determinant;
            let walk = (b / short_s - a / long_s) / determinant;
            let noise_deg_sqrt_h = white.sqrt().to_degrees() * 60.0;
            let instability_deg_h = walk.sqrt().to_degrees() * 3600.0 * 3.0;
            assert!(
                (noise_deg_sqrt_h / 0.30 - 1.0).abs() < 0.05,
                "{rate_hz} Hz: {noise_deg_sqrt_h}"
            );
            assert!(
                (instability_deg_h / 36.0 - 1.0).abs() < 0.05,
                "{rate_hz} Hz: {instability_deg_h}"
            );
        }
    }

    #[test]
    fn biases_at_the_start_and_noise_have_their_size_over_seeds() {
        let config =
            ImuConfig { gyro_turn_on_bias_deg_h: 3600.0, accel_turn_on_bias_ug: 1000.0, ..exact() };
        let readings = (0..4000).map(|seed| Imu::new(&config, 0.02, seed).read(REST, 0));
        let (mut gyro, mut accel) = (0.0, 0.0);
        for reading in readings {
            gyro += square(reading.yaw_rate_rad_s.to_degrees()) / 4000.0;
            accel += square(reading.accel_y_m_s2 / 9.806_65e-3) / 4000.0;
        }
        // χ² with 4000 degrees: 5 % is more than two σ of the variance.
        assert!((gyro - 1.0).abs() < 0.07 && (accel - 1.0).abs() < 0.07, "{gyro} {accel}");
    }

    #[test]
    fn a_restart_is_a_new_unit() {
        let config = ImuConfig { gyro_turn_on_bias_deg_h: 10.0, ..ImuConfig::default() };
        let mut used = Imu::new(&config, 0.02, 1);
        for tick in 0..10 {
            let _ = used.read(StepOutcome::Moved { ds_m: 0.01, dtheta_rad: 0.0 }, tick);
        }
        used.restart(2);
        let mut new = Imu::new(&config, 0.02, 2);
        for tick in 0..5 {
            assert_eq!(used.read(REST, tick), new.read(REST, tick));
        }
    }
}
