//! Dead reckoning that claims a covariance and innovations, for tests of what a
//! scorer makes of them. Nothing in it is a filter: the numbers are a plain
//! function of the tick. Abstains now and then, and claims no innovation then.

use nalgebra::Matrix3;
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_clients::{Filter, Tick};
use rusty_contract::{Estimate, Exit, Reply};

struct Surprised(DeadReckoning);

impl Filter for Surprised {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let pose = self.0.advance(tick.encoders());
        let k = tick.index();
        if k % 11 == 3 {
            return Reply::Abstain;
        }
        // Of no rank at first, and larger with time.
        let p = Matrix3::from_diagonal_element(1e-5 * k as f64);
        let mut covariance = [0.0; 9];
        covariance.copy_from_slice(p.as_slice());
        let estimate = Estimate::new(pose).with_covariance(covariance);
        match tick.ranges_m() {
            Some(ranges_m) => {
                let degrees = 1 + (k % 180) as u32;
                let nis = f64::from(degrees) * (0.5 + ranges_m[0] / (1.0 + ranges_m[0]));
                estimate.with_innovation(nis, degrees).into()
            }
            None => estimate.into(),
        }
    }
}

fn main() -> Exit {
    rusty_clients::run(|start, ()| Ok(Surprised(DeadReckoning::of_start(start))))
}
