//! A sweep, drawn: where the runs ended up, and how they came apart.
//!
//! * [`fan()`]: the paths of all seeds on the floor, a panel per cell;
//! * [`growth()`]: their spread over the distance driven, on logarithmic axes,
//!   with the fitted powers.
//!
//! Both are SVG texts of the same bytes for the same sweep;
//! [`png`](rusty_plot::png()) makes pixels of them. Colours go round with the
//! estimator in the fan and with cell and estimator in the growth; a colour is
//! never alone, each has a separate mark.

mod fan;
mod growth;

pub use fan::fan;
pub use growth::growth;

/// Width of a page, CSS pixels.
const WIDTH: f64 = 1200.0;
const MARGIN_LEFT: f64 = 72.0;
const MARGIN_RIGHT: f64 = 28.0;
/// Where the first thing below title and details may begin.
const TOP: f64 = 84.0;

/// How many seeds the tracks are of, and which.
fn seeds_of(tracks: &[super::Track]) -> String {
    let seeds: std::collections::BTreeSet<u64> = tracks.iter().map(|t| t.seed).collect();
    match (seeds.first(), seeds.last()) {
        (Some(first), Some(last)) if first != last => {
            format!("{} seeds, {first} to {last}", seeds.len())
        }
        (Some(only), _) => format!("seed {only}"),
        _ => "no seeds".to_owned(),
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
