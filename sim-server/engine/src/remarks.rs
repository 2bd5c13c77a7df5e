//! What a scenario plans and its run will not have.

use rusty_contract::config::Event;
use rusty_contract::{Participant, Role, RunConfig};

/// A line for each event or kidnapping that will not happen, for people, boxes and patches that
/// lie outside the world, where nothing meets them, for people who begin where the robot is, and
/// for estimators that the run does not wait for.
#[must_use]
pub fn remarks(config: &RunConfig, roster: &[Participant]) -> Vec<String> {
    let observes = |p: &&Participant| !p.required && p.role == Role::Estimator;
    let mut remarks: Vec<String> = (roster.iter().filter(observes))
        .map(|p| format!("{} is not required: its answers are not scored", p.name))
        .collect();
    too_late(config, &mut remarks);
    without_box(&config.events, &mut remarks);
    outside(config, &mut remarks);
    on_the_robot(config, &mut remarks);
    remarks
}

fn too_late(config: &RunConfig, remarks: &mut Vec<String>) {
    let RunConfig { ticks, kidnappings, events, .. } = config;
    let planned = kidnappings.iter().map(|k| ("a kidnapping", k.tick));
    for (what, tick) in planned.chain(events.iter().map(|event| ("an event", event.tick()))) {
        if tick >= *ticks {
            remarks
                .push(format!("the run has {ticks} ticks: {what} at tick {tick} will not happen"));
        }
    }
}

fn without_box(events: &[Event], remarks: &mut Vec<String>) {
    let is_put = |wanted: u8, until: u64| {
        events.iter().any(|event| match *event {
            Event::PutBox { tick, number, .. } => number == wanted && tick <= until,
            _ => false,
        })
    };
    for event in events {
        if let Event::RemoveBox { tick, number } = *event
            && !is_put(number, tick)
        {
            remarks.push(format!("event at tick {tick}: there is no box {number} to remove then"));
        }
    }
}

fn outside(config: &RunConfig, remarks: &mut Vec<String>) {
    let [x_min, y_min, x_max, y_max] = config.world.bounds;
    let mut tell = |what: String, points: &[[f64; 2]]| {
        let all = |is_out: &dyn Fn(&[f64; 2]) -> bool| points.iter().all(is_out);
        let outside = all(&|p| p[0] < x_min)
            || all(&|p| p[0] > x_max)
            || all(&|p| p[1] < y_min)
            || all(&|p| p[1] > y_max);
        if outside {
            remarks.push(format!(
                "{what} lies outside the world: x is {x_min} to {x_max} m there, y {y_min} to \
                 {y_max} m"
            ));
        }
    };
    for (i, walker) in config.walkers.iter().enumerate() {
        for (k, point) in walker.waypoints.iter().enumerate() {
            tell(format!("walker[{i}].waypoints[{k}] = {point:?}"), &[*point]);
        }
    }
    for event in &config.events {
        if let Event::PutBox { number, at, .. } = event {
            let at = [at.x(), at.y()];
            tell(format!("box {number} at {at:?}"), &[at]);
        }
    }
    for (i, patch) in config.patches.iter().enumerate() {
        tell(format!("patch[{i}]"), &patch.corners);
    }
}

fn on_the_robot(config: &RunConfig, remarks: &mut Vec<String>) {
    for (i, walker) in config.walkers.iter().enumerate() {
        let Some(first) = walker.waypoints.first() else { continue };
        let [dx_m, dy_m] = [first[0] - config.start.x(), first[1] - config.start.y()];
        let least_m = walker.radius_m + config.robot.body_radius_m;
        if dx_m * dx_m + dy_m * dy_m < least_m * least_m {
            remarks.push(format!(
                "walker[{i}] begins at {first:?}, on the robot, which it holds until it has gone"
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario_file::load;

    /// The remarks on the apartment with a change.
    fn of(change: &str) -> Vec<String> {
        remarks(&load("apartment", &[change.to_owned()]).unwrap().config().unwrap(), &[])
    }

    #[test]
    fn a_person_who_begins_on_the_robot_is_remarked() {
        let walker = |y_m: f64| of(&format!("walker=[{{ waypoints = [[6.0, {y_m}]] }}]"));
        // Radii of 0.25 and 0.11 m.
        assert_eq!(walker(4.5).len(), 1);
        assert_eq!(walker(4.15).len(), 1);
        assert_eq!(walker(4.13).len(), 0);
        assert_eq!(walker(99.0).len(), 1, "outside");
        assert!(of("seed=1").is_empty());
    }

    #[test]
    fn an_estimator_that_the_run_does_not_wait_for_is_remarked() {
        let config = load("apartment", &[]).unwrap().config().unwrap();
        let of = |required| {
            let p = Participant::new("mine", Role::Estimator);
            remarks(&config, &[Participant { required, ..p }]).len()
        };
        assert_eq!([true, false].map(of), [0, 1]);
    }
}
