//! Texts of scenarios.

use std::fs;
use std::path::Path;

use crate::{arg, repository};

/// Entries of a scorer and a logger.
pub const RECORDERS: &str = "[[participant]]\nname = \"score\"\nrole = \"scorer\"\n\
    command = [\"score\"]\n[[participant]]\nname = \"logger\"\nrole = \"logger\"\n\
    command = [\"logger\"]\n";

/// Writes a file, and returns its path.
pub fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    arg(&path).to_owned()
}

/// A scenario of the filters, by the name of its file.
pub fn filter_scenario(name: &str) -> String {
    arg(&repository().join("clients/filters/scenarios").join(name)).to_owned()
}

/// The built-in scenario `apartment`.
pub fn apartment_scenario() -> String {
    let path = repository().join("sim-server/engine/scenarios/apartment.toml");
    fs::read_to_string(path).unwrap()
}

/// The entry of an estimator; `more` are further lines of it.
pub fn estimator(name: &str, command: &[&str], more: &str) -> String {
    format!("[[participant]]\nname = \"{name}\"\ncommand = {command:?}\n{more}\n")
}

/// Writes a scenario in which a robot with every small sensor drives into a wall
/// after 40 of its 80 ticks; `more` are further lines of its sensors.
pub fn sensed_scenario(folder: &Path, name: &str, more: &str) -> String {
    let mut world = rusty_geometry::apartment().spec().clone();
    let posts = [[11.0, 2.0], [10.5, 3.5], [6.0, 4.5], [11.9, 2.5]];
    let landmark = |(at, id)| rusty_geometry::Landmark { id, at };
    world.landmarks = posts.into_iter().zip(7..).map(landmark).collect();
    write(folder, "sensed-world.json", world.to_json().unwrap());
    let text = format!(
        "ticks = 80\nworld_file = \"sensed-world.json\"\n\
         start = {{ x_m = 11.5, y_m = 3.0, theta_rad = 0.0 }}\n\
         script = {{ kind = \"straight\", v_m_s = 0.5 }}\n\
         [sensors]\nbumper = {{}}\nsonar = {{ every = 3 }}\nlandmarks = {{}}\n\
         doors = {{ every = 1 }}\n{more}\n{}{RECORDERS}",
        estimator("dead-reckoning", &["dead-reckoning"], "")
    );
    write(folder, name, text)
}
