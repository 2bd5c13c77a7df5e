//! The files that a scenario names.

use std::path::PathBuf;

use rusty_contract::ScriptConfig;

use super::Loaded;

impl Loaded {
    /// Returns the files that the scenario names and the configuration is read from: the
    /// world's, and those with commands.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let s = &self.scenario;
        let scripts = s.robot.entries().iter().filter_map(|robot| robot.own.script.as_ref());
        let commands =
            std::iter::once(&s.script).chain(scripts).filter_map(|script| match script {
                ScriptConfig::Commands { file, .. } => file.as_ref(),
                _ => None,
            });
        s.world_file.iter().chain(commands).map(|file| self.folder.join(file)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::load;

    #[test]
    fn they_are_the_worlds_and_those_with_commands() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let script =
            |file: &str| format!("script = {{ kind = \"commands\", file = \"{file}\" }}\n");
        let robot = |name: &str, x_m: f64| {
            let start = format!("start = {{ x_m = {x_m:.1}, y_m = 2.0, theta_rad = 0.0 }}\n");
            format!("[[robot]]\nname = \"{name}\"\n{start}")
        };
        let text = format!("world_file = \"w.svg\"\n{}{}", script("c.txt"), robot("a", 2.0));
        fs::write(at("s.toml"), format!("{text}{}{}", robot("b", 3.0), script("d.txt"))).unwrap();
        let files = load(at("s.toml").to_str().unwrap(), &[]).unwrap().files();
        assert_eq!(files, ["w.svg", "c.txt", "d.txt"].map(at));
        assert!(load("apartment", &[]).unwrap().files().is_empty());
    }
}
