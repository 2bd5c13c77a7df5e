//! The growth of a sweep's errors as a text for people.

use std::fmt;

use rusty_contract::TextTable;
use rusty_contract::score::{degrees, metres};

use super::growth::{Exponent, Growth};

/// Three samples of each growth, and the fitted exponents.
pub struct GrowthText<'a>(pub &'a [Growth]);

impl fmt::Display for GrowthText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = TextTable::new(
            "cell  estimator  >time  >driven  >mean error  >σ position  >σ along  >σ across  >ratio  >σ heading",
        );
        for growth in self.0 {
            let count = growth.samples.len();
            // A third of the way, two thirds, and the end.
            for third in 1..=3 {
                let Some(s) = (count * third).div_ceil(3).checked_sub(1) else { continue };
                let s = &growth.samples[s];
                let length = |m: f64| format!("{} m", metres(m));
                let ratio = match s.across_over_along {
                    ratio if ratio.is_finite() => format!("{ratio:.2}"),
                    _ => "–".to_owned(),
                };
                table.row(&[
                    &growth.cell,
                    &growth.estimator,
                    &format!("{:.2} s", s.time_s),
                    &length(s.distance_m),
                    &length(s.mean_error_m),
                    &length(s.position_m),
                    &length(s.along_m.standard_deviation),
                    &length(s.across_m.standard_deviation),
                    &ratio,
                    &format!("{} °", degrees(s.heading_rad.standard_deviation.to_degrees())),
                ]);
            }
            let e = &growth.exponents;
            let [position, heading] = [e.position, e.heading].map(text);
            let [along, across] = [e.log_along, e.log_across].map(text);
            let remark = format!(
                "grows with distance to the power of: position {position}, heading {heading}; in \
                 log coordinates along {along}, across {across}{}",
                range(e.position.or(e.heading))
            );
            table.row(&[&"", &remark]);
        }
        writeln!(f, "{table}")?;
        write!(
            f,
            "σ along and across: world frame, by the mean believed heading; ratio: across over \
             along. Log coordinates: log(truth⁻¹ estimate).\n\
             white slip on a straight track: heading 0.5; in log coordinates 0.5 along, 1.5 \
             across; ± is one standard error, by the jackknife over seeds"
        )
    }
}

fn text(exponent: Option<Exponent>) -> String {
    exponent.map_or_else(
        || "– (too few distances, or no spread)".to_owned(),
        |exponent| exponent.to_string(),
    )
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
        assert_eq!(text.lines().count(), 7, "{text}");
        assert!(text.contains("1.00 s") && text.contains("3.00 s"), "{text}");
        assert!(text.contains("across 1.") && text.contains("fitted from 0.2"), "{text}");
        let two = GrowthText(&growth(&tracks[..2])).to_string();
        assert!(two.contains("position 2.33,") && !two.contains("NaN"), "{two}");
        let mut still = straight_leg();
        still.robot.slip_std = 0.0;
        let tracks: Vec<_> = (0..3).map(|seed| reckoned(&still, 0, seed, 1)).collect();
        assert!(GrowthText(&growth(&tracks)).to_string().contains("no spread"));
    }
}
