//! A world file, TOML or JSON, and the world built from it.

use rusty_geometry::{SE2, World, WorldSpec};

/// Words of the format.
pub const WORDS: [&str; 12] = [
    "[[walls]]\n",
    "a = [0.0, 0.0]\n",
    "b = [1.0, 1.0]\n",
    "material = \"Wall\"\n",
    "\"Door(255)\"",
    "Door(256)",
    "nan",
    "-inf",
    "1e999",
    "{\"a\":",
    "[[[[[[[[",
    "a.b.c.d.e.f = 1\n",
];

/// Text that begins with `{` is JSON, other text TOML.
pub fn world(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let json = text.trim_start().starts_with('{');
    let spec = if json { WorldSpec::from_json_str(text) } else { WorldSpec::from_toml_str(text) };
    let Ok(spec) = spec else { return false };
    let checked = spec.check();
    let Ok(world) = World::new(spec.clone()) else {
        assert!(checked.is_err(), "what passes the check can be built");
        return false;
    };
    assert!(checked.is_ok(), "what is built passes the check");

    let toml = spec.to_toml().expect("a checked world can be written");
    assert_eq!(WorldSpec::from_toml_str(&toml).expect("TOML"), spec);
    let json = spec.to_json().expect("a checked world can be written");
    assert_eq!(WorldSpec::from_json_str(&json).expect("JSON"), spec);

    let [x_min, y_min, x_max, y_max] = world.bounds();
    let middle = nalgebra::Point2::new(0.5 * (x_min + x_max), 0.5 * (y_min + y_max));
    let distance_m = world.distance_to_nearest(middle);
    assert!(distance_m >= 0.0);
    for k in 0..8 {
        let hit = world.raycast(middle, f64::from(k) * 0.785, 8.0);
        assert!(hit.distance_m >= 0.0 && hit.distance_m <= 8.0);
        let rounding_m = 1e-9 * (1.0 + middle.x.abs() + middle.y.abs());
        assert!(hit.distance_m >= distance_m.min(8.0) - rounding_m, "nearer than the nearest");
    }
    let here = SE2::new(middle.x, middle.y, 0.0);
    assert!(distance_m < 0.1 + 1e-6 || !world.blocks(&here, &here, 0.1), "blocked by nothing");
    true
}
