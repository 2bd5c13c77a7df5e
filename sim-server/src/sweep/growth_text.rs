//! The growth of a sweep's errors as a text for people.

use std::fmt;

use super::growth::{Exponent, Growth};
use super::summary::{degrees, metres};

/// Three samples of each growth, and the fitted exponents.
pub struct GrowthText<'a>(pub &'a [Growth]);

impl fmt::Display for GrowthText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:>4}  {:16}  {:>8}  {:>9}  {:>12}  {:>11}  {:>11}  {:>9}",
            "cell", "estimator", "time", "driven", "mean error", "σ along", "σ across", "σ heading"
        )?;
        for growth in self.0 {
            let count = growth.samples.len();
            // A third of the way, two thirds, and the end.
            for third in 1..=3 {
                let Some(s) = (count * third).div_ceil(3).checked_sub(1) else { continue };
                let s = &growth.samples[s];
                writeln!(
                    f,
                    "{:>4}  {:16}  {:>6.2} s  {:>7.2} m  {:>10} m  {:>9} m  {:>9} m  {:>7} °",
                    growth.cell,
                    growth.estimator,
                    s.time_s,
                    s.distance_m,
                    metres(s.mean_error_m),
                    metres(s.along_m.standard_deviation),
                    metres(s.across_m.standard_deviation),
                    degrees(s.heading_rad.standard_deviation.to_degrees())
                )?;
            }
            let e = &growth.exponents;
            let along = text(e.along);
            let (across, heading) = (text(e.across), text(e.heading));
            writeln!(
                f,
                "      grows with distance to the power of: along {along}, across {across}, \
                 heading {heading}{}",
                range(e.across.or(e.heading))
            )?;
        }
        write!(
            f,
            "white slip on a straight track: 0.5 along, 1.5 across, 0.5 heading; ± is one \
             standard error, by the jackknife over seeds"
        )
    }
}

fn text(exponent: Option<Exponent>) -> String {
    match exponent {
        None => "– (no spread)".to_owned(),
        Some(e) => format!("{:.2} ± {:.2}", e.law.exponent, e.standard_error),
    }
}

fn range(exponent: Option<Exponent>) -> String {
    let range =
        |e: Exponent| format!(" (fitted from {:.2} to {:.2} m)", e.law.range[0], e.law.range[1]);
    exponent.map_or_else(String::new, range)
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{reckoned, straight_leg};
    use super::super::growth;
    use super::*;

    #[test]
    fn a_growth_has_three_lines_and_its_exponents() {
        let config = straight_leg();
        let tracks: Vec<_> = (0..40).map(|seed| reckoned(&config, 0, seed, 1)).collect();
        let text = GrowthText(&growth(&tracks)).to_string();
        assert_eq!(text.lines().count(), 6, "{text}");
        assert!(text.contains("1.00 s") && text.contains("3.00 s"), "{text}");
        assert!(text.contains("across 1.") && text.contains("fitted from 0.2"), "{text}");
        let mut still = straight_leg();
        still.robot.slip_std = 0.0;
        let tracks: Vec<_> = (0..3).map(|seed| reckoned(&still, 0, seed, 1)).collect();
        assert!(GrowthText(&growth(&tracks)).to_string().contains("no spread"));
    }
}
