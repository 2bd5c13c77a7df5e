//! A scan from a place of choice, as numbers.

use anyhow::Result;
use rusty_contract::config::LidarConfig;
use rusty_contract::{FieldError, TextTable, outln};
use rusty_floorplan::FloorplanError;
use rusty_geometry::{Hit, SE2, World, WorldSpec};
use rusty_sim::Lidar;
use rusty_sim::noise::LidarNoise;
use serde_json::json;

use super::{WorldsArgs, numbers};
use crate::commands::arguments::Output;

/// Two neighbouring ranges that differ by more than this make a cliff, m.
const CLIFF_M: f64 = 0.5;

/// What the beams of one scan met, and what the sensor said.
pub struct Scan {
    pub sensor_in_world: SE2,
    pub lidar: LidarConfig,
    /// Exact ranges and materials.
    pub hits: Vec<Hit>,
    /// With noise and dropout, m; `None` where neither was asked for.
    pub measured_m: Option<Vec<f64>>,
}

impl Scan {
    pub fn take(args: &WorldsArgs, spec: &WorldSpec, pose: &str) -> Result<Self> {
        let [x, y, theta] = numbers("--scan", pose)?;
        let sensor_in_world = SE2::new(x, y, theta);
        let lidar = LidarConfig {
            beams: args.beams,
            range_max_m: args.range_max,
            range_std_m: args.noise.unwrap_or(0.0),
            dropout: args.dropout,
            ..LidarConfig::default()
        };
        lidar.check()?;
        let [left, bottom, right, top] = spec.bounds;
        if !((left..=right).contains(&x) && (bottom..=top).contains(&y)) {
            let problem =
                format!("is outside of the world, {left} to {right} and {bottom} to {top} m");
            let remedy = "give the pose of a sensor inside";
            return Err(FieldError::new("--scan", pose, problem, remedy).into());
        }
        let unusable = |error| FloorplanError::World { path: spec.name.clone(), error };
        let world = World::new(spec.clone()).map_err(unusable)?;
        let mut sensor = Lidar::new(&lidar);
        let mut hits = vec![Hit { distance_m: 0.0, material: None }; args.beams as usize];
        sensor.ranges_and_materials(&world, &sensor_in_world, &mut hits);
        let measured_m = (args.noise.is_some() || args.dropout > 0.0).then(|| {
            let mut ranges_m = vec![0.0; hits.len()];
            let mut noise = LidarNoise::new(args.seed);
            sensor.scan(&world, &sensor_in_world, &mut noise, 0, &mut ranges_m);
            ranges_m
        });
        Ok(Self { sensor_in_world, lidar, hits, measured_m })
    }

    /// The beams whose exact range is far from that of the beam before them.
    pub fn cliffs(&self) -> Vec<usize> {
        let jump = |k: &usize| self.hits[*k].distance_m - self.hits[*k - 1].distance_m;
        (1..self.hits.len()).filter(|k| jump(k).abs() > CLIFF_M).collect()
    }

    pub fn print(&self, output: &Output) {
        let material = |hit: &Hit| hit.material.map(|m| m.to_string());
        let beams = 0..self.hits.len() as u32;
        let report = json!({
            "bearings_rad": beams.map(|k| self.lidar.bearing_rad(k)).collect::<Vec<_>>(),
            "ranges": self.hits.iter().map(|h| h.distance_m).collect::<Vec<_>>(),
            "materials": self.hits.iter().map(material).collect::<Vec<_>>(),
            "measured": self.measured_m,
            "cliffs": self.cliffs(),
        });
        output.print_with(&report, || {
            let mut table = TextTable::new(match self.measured_m {
                Some(_) => ">beam  >bearing  >range  material  >measured",
                None => ">beam  >bearing  >range  material",
            });
            for (k, hit) in self.hits.iter().enumerate() {
                let bearing = format!("{:.1}°", self.lidar.bearing_rad(k as u32).to_degrees());
                let range = format!("{:.4} m", hit.distance_m);
                let met = material(hit).unwrap_or_else(|| "nothing within range".to_owned());
                match &self.measured_m {
                    Some(measured_m) => {
                        let measured = format!("{:.4} m", measured_m[k]);
                        table.row(&[&k, &bearing, &range, &met, &measured]);
                    }
                    None => table.row(&[&k, &bearing, &range, &met]),
                }
            }
            outln!("{table}");
            outln!("cliffs at beams {:?}", self.cliffs());
        });
    }
}
