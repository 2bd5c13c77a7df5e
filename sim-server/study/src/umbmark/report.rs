//! What a UMBmark came to: a document, and a text for people.

use std::fmt;

use rusty_contract::TextTable;
use serde::Serialize;

use super::belief::Belief;
use super::estimate::{Centre, Estimate};
use super::factors::Factors;
use super::lap::{Return, Square};
use rusty_contract::score::metres;

/// What a UMBmark came to.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the scenario that the robot is of.
    pub scenario: String,
    /// Seed of the first lap.
    pub seed: u64,
    /// Laps each way.
    pub runs: u32,
    /// The programmed path.
    pub square: Square,
    /// σ of the slip per wheel and tick.
    pub slip_std: f64,
    /// What is to be found.
    pub truth: Factors,
    /// Where the laps ended.
    pub returns: Vec<Return>,
    /// What they say.
    pub estimate: Estimate,
    /// The laps again, with the paper's estimate applied.
    pub corrected_by_paper: Corrected,
    /// The laps again, with the estimate by exact arcs applied.
    pub corrected_by_exact: Corrected,
}

/// The same laps, with the same slip, by a robot that knows better.
#[derive(Clone, Debug, Serialize)]
pub struct Corrected {
    /// What it believes now.
    pub belief: Belief,
    /// E_max,syst of its laps, m.
    pub e_max_syst_m: f64,
    /// Where they ended.
    pub returns: Vec<Return>,
}

impl Report {
    /// By how much a correction has made E_max,syst smaller.
    #[must_use]
    pub fn shrunk(&self, corrected: &Corrected) -> f64 {
        self.estimate.e_max_syst_m / corrected.e_max_syst_m
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Square { side_m, speed_m_s, turn_rad_s } = self.square;
        writeln!(
            f,
            "UMBmark of {}: a square of {side_m} m, {} laps each way, {speed_m_s} m/s, \
             {turn_rad_s} rad/s, slip {} per tick, seeds {} to {}",
            self.scenario,
            self.runs,
            self.slip_std,
            self.seed,
            self.seed.wrapping_add(2 * u64::from(self.runs) - 1)
        )?;
        let e = &self.estimate;
        writeln!(f, "\ncentre of gravity of the returns, true − believed")?;
        for centre in &e.centres {
            writeln!(f, "  {}", line(centre))?;
        }
        writeln!(f, "  E_max,syst = {} m", metres(e.e_max_syst_m))?;
        let error = e.standard_error_rad.to_degrees();
        writeln!(
            f,
            "type A, every corner turns short by  α = {:.4} ± {error:.4} °\n\
             type B, every side bends to the left β = {:.4} ± {error:.4} °\n",
            e.alpha_rad.to_degrees(),
            e.beta_rad.to_degrees()
        )?;
        let mut table = TextTable::new("estimate  >true  >Borenstein and Feng  >exact arcs");
        for (name, of) in
            [("E_b  wheelbase, true/believed", WHEELBASE), ("E_d  diameter, right/left", DIAMETERS)]
        {
            let [paper, exact] = [&e.paper, &e.exact].map(|found| {
                format!("{:.5} ± {:.5}", of(&found.factors), of(&found.standard_errors))
            });
            table.row(&[&name, &format!("{:.5}", of(&self.truth)), &paper, &exact]);
        }
        let [paper, exact] = [&self.corrected_by_paper, &self.corrected_by_exact].map(|c| {
            let factor = self.shrunk(c);
            let digits = usize::from(factor < 10.0);
            format!("{} m ({factor:.digits$}×)", metres(c.e_max_syst_m))
        });
        table.row(&[&"E_max,syst with it, same seeds", &"", &paper, &exact]);
        writeln!(f, "{table}")?;
        write!(
            f,
            "± is one standard error. A square cannot see the scale: E_b is the wheelbase over \
             the mean wheel."
        )
    }
}

const WHEELBASE: fn(&Factors) -> f64 = |f| f.wheelbase;
const DIAMETERS: fn(&Factors) -> f64 = |f| f.diameters;

fn line(centre: &Centre) -> String {
    let part = |m: &rusty_metrics::Moments| {
        format!("{:>8} ± {} m", metres(m.mean), metres(m.standard_error()))
    };
    let (x, y) = (part(&centre.x_m), part(&centre.y_m));
    format!("{:3}  x {x}   y {y}   r {} m", centre.way.word(), metres(centre.r_m))
}
