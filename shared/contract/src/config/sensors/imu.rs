//! The IMU: what its data sheet says.

use serde::{Deserialize, Serialize};

use crate::config::{FieldError, within};

/// An inertial measurement unit at the centre of the body: yaw rate and planar
/// acceleration in every tick, in the units of data sheets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImuConfig {
    /// Angle random walk of the gyroscope, °/√h.
    pub gyro_noise_deg_sqrt_h: f64,
    /// σ of the way that the gyroscope's bias goes within `bias_time_s`, °/h.
    pub gyro_bias_instability_deg_h: f64,
    /// σ of the gyroscope's bias at the start, °/h.
    pub gyro_turn_on_bias_deg_h: f64,
    /// Noise density of the accelerometer, µg/√Hz.
    pub accel_noise_ug_sqrt_hz: f64,
    /// σ of the way that the accelerometer's bias goes within `bias_time_s`, µg.
    pub accel_bias_instability_ug: f64,
    /// σ of the accelerometer's bias at the start, µg.
    pub accel_turn_on_bias_ug: f64,
    /// The time that both figures of instability are for, s.
    pub bias_time_s: f64,
}

impl Default for ImuConfig {
    /// An InvenSense MPU-6000 after its biases are taken out: noise 0.30 °/√h and
    /// 400 µg/√Hz, instability 4.6 °/h and 36 µg in 500 s (data sheet, and the
    /// parameters of Microsoft's AirSim).
    fn default() -> Self {
        Self {
            gyro_noise_deg_sqrt_h: 0.30,
            gyro_bias_instability_deg_h: 4.6,
            gyro_turn_on_bias_deg_h: 0.0,
            accel_noise_ug_sqrt_hz: 400.0,
            accel_bias_instability_ug: 36.0,
            accel_turn_on_bias_ug: 0.0,
            bias_time_s: 500.0,
        }
    }
}

impl ImuConfig {
    /// Checks every field.
    ///
    /// # Errors
    /// [`FieldError`] names the first that cannot be used.
    pub fn check(&self) -> Result<(), FieldError> {
        for (field, value) in [
            ("gyro_noise_deg_sqrt_h", self.gyro_noise_deg_sqrt_h),
            ("gyro_bias_instability_deg_h", self.gyro_bias_instability_deg_h),
            ("gyro_turn_on_bias_deg_h", self.gyro_turn_on_bias_deg_h),
            ("accel_noise_ug_sqrt_hz", self.accel_noise_ug_sqrt_hz),
            ("accel_bias_instability_ug", self.accel_bias_instability_ug),
            ("accel_turn_on_bias_ug", self.accel_turn_on_bias_ug),
        ] {
            within(&format!("sensors.imu.{field}"), value, 0.0, 1e9)?;
        }
        within("sensors.imu.bias_time_s", self.bias_time_s, 1e-3, 1e6)
    }
}
