//! Events: the walls of the world at a tick.

use nalgebra::Point2;
use rusty_contract::config::Event;
use rusty_geometry::{Material, SE2, Wall, WorldSpec};

/// The walls of `spec` after these events: without those of doors that are open, and
/// with those of boxes, in the order of their numbers.
pub(crate) fn walls_after(spec: &WorldSpec, events: &[Event]) -> Vec<Wall> {
    let mut open = [false; 256];
    let mut boxes: [Option<(SE2, [f64; 2])>; 256] = [None; 256];
    for event in events {
        match *event {
            Event::OpenDoor { door, .. } => open[usize::from(door)] = true,
            Event::CloseDoor { door, .. } => open[usize::from(door)] = false,
            Event::PutBox { number, at, size_m, .. } => {
                boxes[usize::from(number)] = Some((at, size_m));
            }
            Event::RemoveBox { number, .. } => boxes[usize::from(number)] = None,
        }
    }
    let is_shut = |wall: &Wall| match wall.material {
        Material::Door(door) => !open[usize::from(door)],
        _ => true,
    };
    let mut walls: Vec<Wall> = spec.to_walls().into_iter().filter(is_shut).collect();
    for (at, [length_m, width_m]) in boxes.into_iter().flatten() {
        let (x, y) = (0.5 * length_m, 0.5 * width_m);
        let corners = [(-x, -y), (x, -y), (x, y), (-x, y)];
        let corners = corners.map(|(x, y)| at.transform_point(&Point2::new(x, y)));
        walls.extend((0..4).map(|k| Wall {
            a: corners[k],
            b: corners[(k + 1) % 4],
            material: Material::Wall,
        }));
    }
    walls
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sim;
    use rusty_contract::{Frame, RunConfig, Scenario, ScriptConfig};
    use rusty_geometry::apartment;

    /// A robot that does not move in the apartment and looks at door 0 in the wall x = 0.
    fn run(events: Vec<Event>) -> Vec<f64> {
        let mut scenario = Scenario { ticks: 20, scan_every: 1, ..Scenario::default() };
        scenario.start = SE2::new(1.5, 4.5, std::f64::consts::PI);
        scenario.script = ScriptConfig::Commands { file: None, list: Vec::new() };
        scenario.lidar.range_std_m = 0.0;
        let config = RunConfig { events, ..scenario.config(apartment().spec().clone()) };
        let mut sim = Sim::new(config).unwrap();
        let mut frame = Frame::boxed();
        (0..20)
            .map(|_| {
                let _ = sim.step(None, &mut frame);
                frame.ranges_m().unwrap()[90]
            })
            .collect()
    }

    #[test]
    fn doors_and_boxes_are_there_from_their_tick_on() {
        let at = SE2::new(1.0, 4.5, 0.5);
        let ranges_m = run(vec![
            Event::OpenDoor { tick: 3, door: 0 },
            Event::CloseDoor { tick: 6, door: 0 },
            Event::PutBox { tick: 9, number: 1, at, size_m: [0.2, 0.2] },
            Event::RemoveBox { tick: 12, number: 1 },
            Event::PutBox { tick: 15, number: 1, at, size_m: [0.2, 0.2] },
            Event::PutBox { tick: 18, number: 1, at: SE2::new(1.0, 8.0, 0.0), size_m: [0.2, 0.2] },
        ]);
        let shut_m = ranges_m[0];
        assert!((shut_m - 1.5).abs() < 1e-12, "{shut_m}");
        for (tick, range_m) in ranges_m.iter().enumerate() {
            match tick {
                3..=5 => assert_eq!(*range_m, 8.0, "open: nothing behind it"),
                9..=11 | 15..=17 => assert!((0.35..0.45).contains(range_m), "box: {range_m}"),
                _ => assert_eq!(*range_m, shut_m, "tick {tick}"),
            }
        }
    }

    #[test]
    fn a_restart_has_the_walls_of_the_start() {
        let events = vec![Event::OpenDoor { tick: 1, door: 0 }];
        let config = RunConfig { events, ..Scenario::default().config(apartment().spec().clone()) };
        let mut sim = Sim::new(config.clone()).unwrap();
        let mut frame = Frame::boxed();
        for _ in 0..4 {
            let _ = sim.step(None, &mut frame);
        }
        let walls = apartment().walls().len();
        assert_eq!(sim.world().walls().len(), walls - 1);
        sim.restart(7);
        assert_eq!(sim.world().walls().len(), walls);
        let mut new = Sim::new(RunConfig { seed: 7, ..config }).unwrap();
        let mut other = Frame::boxed();
        for _ in 0..4 {
            let _ = (sim.step(None, &mut frame), new.step(None, &mut other));
            assert_eq!(frame.observable(), other.observable());
        }
    }
}
