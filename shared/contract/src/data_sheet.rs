//! Data sheets: what a participant is told of the sensors of its robot.
//!
//! The geometry of a sensor (mounting, field of view, greatest range, number of beams,
//! rate, model) is always told. Its figures (noise, dropout, rates, glass) are the true
//! ones of the run, those of a data sheet, or not told: see [`DataSheet`]. A data sheet
//! is the default of the sensor's configuration, whatever the world really does.
//!
//! A sheet has the geometry of its sensor, and an `Option` for each figure. That every
//! field of a configuration is in one of the two lists is checked by the compiler.

use rusty_geometry::{Fan, SE2};
use serde::{Deserialize, Serialize};

use crate::config::sensors::{
    BumperConfig, DoorSensorConfig, Identity, ImuConfig, LandmarkSensorConfig, SonarConfig,
    SonarModel,
};
use crate::config::{LidarConfig, Sensors};

/// Figures of its sensors that a participant is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DataSheet {
    /// The true figures of this run.
    Given,
    /// The defaults of each sensor, whatever the world does. Of a recording: the
    /// figures that its log has.
    #[default]
    Nominal,
    /// None.
    Hidden,
}

impl DataSheet {
    /// The word used in files and messages.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Nominal => "nominal",
            Self::Hidden => "hidden",
        }
    }
}

impl std::fmt::Display for DataSheet {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

impl std::str::FromStr for DataSheet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Given, Self::Nominal, Self::Hidden]
            .into_iter()
            .find(|sheet| sheet.word() == text)
            .ok_or_else(|| format!("{text:?} is no data sheet; use given, nominal or hidden"))
    }
}

/// Defines the sheet of a sensor: its geometry, and an option for each figure.
macro_rules! sheet {
    ($(#[$doc:meta])* $sheet:ident of $config:ident {
        geometry { $($known:ident: $kind:ty),* } figures { $($figure:ident),* }
    }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct $sheet {
            $(#[doc = concat!("As [`", stringify!($config), "::", stringify!($known), "`].")]
            pub $known: $kind,)*
            $(#[doc = concat!("As [`", stringify!($config), "::", stringify!($figure), "`]; `None`: not told.")]
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub $figure: Option<f64>,)*
        }

        impl $sheet {
            /// Returns what `sheet` tells of a sensor with this configuration.
            #[must_use]
            pub fn new(config: &$config, sheet: DataSheet) -> Self {
                let nominal = $config::default();
                let told = |given: f64, nominal: f64| match sheet {
                    DataSheet::Given => Some(given),
                    DataSheet::Nominal => Some(nominal),
                    DataSheet::Hidden => None,
                };
                Self {
                    $($known: config.$known.clone(),)*
                    $($figure: told(config.$figure, nominal.$figure),)*
                }
            }

            /// Returns the configuration that a participant believes in: the figures that
            /// it is not told are those of `assumed`.
            #[must_use]
            pub fn believed(&self, assumed: &$config) -> $config {
                $config {
                    $($known: self.$known.clone(),)*
                    $($figure: self.$figure.unwrap_or(assumed.$figure),)*
                }
            }
        }

        impl From<$config> for $sheet {
            /// Tells the true figures.
            fn from(config: $config) -> Self {
                Self::new(&config, DataSheet::Given)
            }
        }
    };
}

sheet! {
    /// What a participant is told of the LiDAR.
    #[derive(Copy)]
    LidarSheet of LidarConfig {
        geometry {
            beams: u32, first_bearing_rad: f64, fov_rad: f64, range_max_m: f64,
            sensor_in_body: SE2
        }
        figures { range_std_m, range_std_per_m, dropout, glass_visible_rad, divergence_rad }
    }
}

sheet! {
    /// What a participant is told of the IMU.
    #[derive(Copy)]
    ImuSheet of ImuConfig {
        geometry {}
        figures {
            gyro_noise_deg_sqrt_h, gyro_bias_instability_deg_h, gyro_turn_on_bias_deg_h,
            accel_noise_ug_sqrt_hz, accel_bias_instability_ug, accel_turn_on_bias_ug, bias_time_s
        }
    }
}

sheet! {
    /// What a participant is told of the sonars.
    SonarSheet of SonarConfig {
        geometry {
            mounts: Vec<SE2>, aperture_rad: f64, range_max_m: f64, model: SonarModel, every: u64
        }
        figures { range_std_m, dropout }
    }
}

sheet! {
    /// What a participant is told of the door detector.
    #[derive(Copy)]
    DoorSensorSheet of DoorSensorConfig {
        geometry { range_max_m: f64, fov_rad: f64, every: u64 }
        figures { hit_rate, false_alarm_rate }
    }
}

sheet! {
    /// What a participant is told of the landmark sensor.
    #[derive(Copy)]
    LandmarkSensorSheet of LandmarkSensorConfig {
        geometry { range_max_m: f64, fov_rad: f64, identity: Identity, every: u64 }
        figures { range_std_m, bearing_std_rad, dropout }
    }
}

impl LidarSheet {
    /// The beams.
    #[must_use]
    pub fn fan(&self) -> Fan {
        let Self { first_bearing_rad, fov_rad, beams, .. } = *self;
        Fan { first_bearing_rad, fov_rad, beams }
    }

    /// Bearing φ_k of beam `k` in the sensor frame, rad.
    #[must_use]
    pub fn bearing_rad(&self, k: u32) -> f64 {
        self.fan().bearing_rad(k)
    }
}

/// What a participant is told of the small sensors; `None`: the robot does not have it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorSheets {
    /// Contact sectors of the body; they have no figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bumper: Option<BumperConfig>,
    /// Yaw rate and acceleration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imu: Option<ImuSheet>,
    /// Ultrasonic range sensors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sonar: Option<SonarSheet>,
    /// Detector of doors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doors: Option<DoorSensorSheet>,
    /// Range and bearing to landmarks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub landmarks: Option<LandmarkSensorSheet>,
}

impl SensorSheets {
    /// Returns what `sheet` tells of these sensors.
    #[must_use]
    pub fn new(sensors: &Sensors, sheet: DataSheet) -> Self {
        let Sensors { bumper, imu, sonar, doors, landmarks } = sensors;
        Self {
            bumper: *bumper,
            imu: imu.as_ref().map(|config| ImuSheet::new(config, sheet)),
            sonar: sonar.as_ref().map(|config| SonarSheet::new(config, sheet)),
            doors: doors.as_ref().map(|config| DoorSensorSheet::new(config, sheet)),
            landmarks: landmarks.as_ref().map(|config| LandmarkSensorSheet::new(config, sheet)),
        }
    }

    /// Returns the sensors that a participant believes in: the figures that it is not
    /// told are the defaults.
    #[must_use]
    pub fn believed(&self) -> Sensors {
        let Self { bumper, imu, sonar, doors, landmarks } = self;
        Sensors {
            bumper: *bumper,
            imu: imu.as_ref().map(|sheet| sheet.believed(&ImuConfig::default())),
            sonar: sonar.as_ref().map(|sheet| sheet.believed(&SonarConfig::default())),
            doors: doors.as_ref().map(|sheet| sheet.believed(&DoorSensorConfig::default())),
            landmarks: landmarks
                .as_ref()
                .map(|sheet| sheet.believed(&LandmarkSensorConfig::default())),
        }
    }

    /// Whether the robot has none of them.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests;
