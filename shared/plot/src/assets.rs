//! Scripts and style that pages of hypertext have in common: the page of the viewer,
//! which shows a run as it happens, the report of a run, and the widgets. All scripts
//! are modules of JavaScript without imports.

/// Draws the map of a run on a canvas.
pub const DRAW_JS: &str = include_str!("../page/draw.js");

/// Draws values over time on a canvas.
pub const CHARTS_JS: &str = include_str!("../page/charts.js");

/// Makes commands of keys, buttons and game pads.
pub const DRIVE_JS: &str = include_str!("../page/drive.js");

/// Colours and common elements of a page, light and dark.
pub const LOOK_CSS: &str = include_str!("../page/look.css");

/// Layout of a page with a bar of controls, a map and panels, after [`LOOK_CSS`].
pub const VIEW_CSS: &str = include_str!("../page/view.css");

/// Returns modules as one script, for a page in one file: without imports and exports.
#[must_use]
pub fn one_script(modules: &[&str]) -> String {
    let lines = modules.iter().flat_map(|module| module.lines());
    let own = lines.filter(|line| !line.starts_with("import "));
    own.flat_map(|line| [line.strip_prefix("export ").unwrap_or(line), "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_become_one_script() {
        let modules = ["export class A {}\n", "import { A } from './a.js';\nnew A();\n"];
        assert_eq!(one_script(&modules), "class A {}\nnew A();\n");
        let script = one_script(&[DRAW_JS]);
        assert!(script.contains("class MapView") && !script.contains("export "), "{script}");
    }
}
