//! A sweep, drawn: where the runs ended up, and how they came apart.
//!
//! * [`fan()`]: the paths of all seeds on the floor, a panel per cell;
//! * [`growth()`]: their spread over the distance driven, on logarithmic axes,
//!   with the fitted powers;
//! * [`errors()`]: errors over time and over the runs.
//!
//! All are SVG texts of the same bytes for the same sweep;
//! [`png`](rusty_plot::png()) makes pixels of them. Colours go round with the
//! estimator in the fan and with cell and estimator in the growth; a colour is
//! never alone, each has a separate mark.

mod errors;
mod fan;
mod growth;

pub use errors::errors;
pub use fan::fan;
pub use growth::growth;

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

/// What an estimator in a cell is called: with the setting, where there are several.
fn name_of(swept: &super::Swept, cell: usize, estimator: &str) -> String {
    let setting = swept.cells.get(cell).map(|c| super::lines::setting(&c.parameters));
    match setting.filter(|text| text != "–") {
        Some(setting) => format!("{estimator}, {setting}"),
        None => estimator.to_owned(),
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
