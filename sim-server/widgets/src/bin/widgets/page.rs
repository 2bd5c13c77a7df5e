//! The pages: what each is made of.

use anyhow::{Context, Result};
use rusty_contract::{LidarConfig, RobotConfig};
use rusty_geometry::places::place;
use rusty_geometry::{Material, WallSpec};
use rusty_plot::assets::{CHARTS_JS, DRAW_JS, DRIVE_JS, LOOK_CSS, VIEW_CSS, one_script};
use serde_json::{Map, Value, json};

use crate::module::Module;

/// A page.
pub struct Page {
    /// Name of its file.
    pub file: &'static str,
    title: &'static str,
    lead: &'static str,
    /// Whether its module has EKF and MCL.
    pub needs_filters: bool,
    scenario: &'static str,
    main: &'static str,
    scripts: &'static [&'static str],
}

/// Reads a file of this package at build time.
macro_rules! own {
    ($name:literal) => {
        include_str!(concat!("../../../page/", $name))
    };
}

/// Reads a built-in scenario.
macro_rules! scenario {
    ($name:literal) => {
        include_str!(concat!("../../../../engine/scenarios/", $name))
    };
}

/// All pages.
pub const PAGES: [Page; 4] = [
    Page {
        file: "dashboard.html",
        title: "Dashboard",
        lead: "A robot patrols a corridor. Dead reckoning integrates its encoders, which measure \
               the wheels and not the floor.",
        needs_filters: false,
        scenario: scenario!("apartment.toml"),
        main: own!("dashboard.html"),
        scripts: &[
            DRAW_JS,
            CHARTS_JS,
            DRIVE_JS,
            own!("kit.js"),
            own!("run-page.js"),
            own!("dashboard.js"),
        ],
    },
    Page {
        file: "lidar.html",
        title: "LiDAR anatomy",
        lead: "A robot stands in front of a doorway and scans. Move along the beams, and change \
               the noise.",
        needs_filters: false,
        scenario: scenario!("anatomy.toml"),
        main: own!("lidar.html"),
        scripts: &[DRAW_JS, own!("kit.js"), own!("lidar.js")],
    },
    Page {
        file: "seed-lab.html",
        title: "Seed Lab",
        lead: "One robot, one list of commands, many seeds: a run is a sample, and the fan is \
               what it is a sample of.",
        needs_filters: false,
        scenario: scenario!("seed-lab.toml"),
        main: own!("seed-lab.html"),
        scripts: &[DRAW_JS, CHARTS_JS, own!("kit.js"), own!("seed-lab.js")],
    },
    Page {
        file: "filters.html",
        title: "The kidnapped robot",
        lead: "An extended Kalman filter and Monte Carlo localisation know the same map and see \
               the same scans. Carry the robot away, and watch which of them notices.",
        needs_filters: true,
        scenario: include_str!("../../../../../clients/filters/scenarios/kidnapped.toml"),
        main: own!("filters.html"),
        scripts: &[DRAW_JS, CHARTS_JS, own!("kit.js"), own!("run-page.js"), own!("filters.js")],
    },
];

impl Page {
    /// Returns the page around `module`: one file that loads nothing.
    ///
    /// # Errors
    /// The scenario cannot be read.
    pub fn html(&self, module: &Module) -> Result<String> {
        let scenario: Map<String, Value> = toml::from_str(self.scenario)
            .with_context(|| format!("{}: its scenario", self.file))?;
        let seed = scenario.get("seed").unwrap_or(&json!(42)).to_string();
        let scene = scene(&scenario)?;
        // A `<` could end the element.
        let data = json!({ "scenario": scenario, "scene": scene }).to_string();
        let style = [LOOK_CSS, VIEW_CSS, own!("widgets.css")].concat();
        let script = one_script(self.scripts);
        let parts = [
            ("{title}", self.title),
            ("{lead}", self.lead),
            ("{seed}", &seed),
            ("{style}", &style),
            ("{main}", self.main),
            ("{scenario}", &data.replace('<', "\\u003c")),
            ("{module}", &module.base64()),
            ("{worker}", own!("worker.js")),
            ("{script}", &script),
        ];
        Ok(filled(own!("page.html"), &parts))
    }
}

/// A template with its parts; what is in a part is not filled again.
fn filled(template: &str, parts: &[(&str, &str)]) -> String {
    let next = parts.iter().filter_map(|(key, text)| Some((template.find(key)?, *key, *text)));
    match next.min() {
        None => template.to_owned(),
        Some((at, key, text)) => {
            [&template[..at], text, &filled(&template[at + key.len()..], parts)].concat()
        }
    }
}

/// The floor plan, and what a page draws robot and scan with.
fn scene(scenario: &Map<String, Value>) -> Result<Value> {
    let name = scenario.get("world").and_then(Value::as_str).unwrap_or("apartment");
    let world = place(name).with_context(|| format!("world {name}: it is not built in"))?;
    let wall = |w: &WallSpec| {
        let material = match w.material {
            Material::Wall => "wall",
            Material::Glass => "glass",
            Material::Door(_) => "door",
        };
        json!([w.a[0], w.a[1], w.b[0], w.b[1], material])
    };
    let walls: Vec<Value> = world.spec().walls.iter().map(wall).collect();
    let (robot, lidar) = (RobotConfig::default(), LidarConfig::default());
    Ok(json!({
        "bounds_m": world.spec().bounds,
        "walls": walls,
        "start": scenario.get("start"),
        "body_radius_m": robot.body_radius_m,
        "beams": lidar.beams,
        "first_bearing_rad": lidar.first_bearing_rad,
        "fov_rad": lidar.fov_rad,
        "range_max_m": lidar.range_max_m,
        "sensor_in_body": lidar.sensor_in_body,
    }))
}
