//! `bench scan` on the page.

use super::Plan;
use super::results::{Case, ScanResults};
use crate::section::{Finding, Section, Table};

impl From<&ScanResults> for Section {
    fn from(found: &ScanResults) -> Self {
        let parry: usize = found.cases.iter().map(|case| case.parry_differs).sum();
        Self {
            title: "The scan",
            about: format!(
                "ns per beam, medians; all ways from the same poses in turns, ratios formed \
                 within a round. *Kernel*: a scan as one problem. *Rays*: the reference, a ray \
                 for each beam through parry's tree by our formula. *Parry*: its own ray cast on \
                 a polyline. *Noise*: noise and dropout on top of the kernel. Worlds are the \
                 Apartment and generated ones: rooms or free-standing segments, at constant \
                 density or on a constant area, with so many walls. {} of {} beams differ in a \
                 bit between kernel and rays; parry answers {parry} of them otherwise by more \
                 than 1 µm. Hash of the ranges, the same on every machine: `{}`.",
                found.beams_that_differ, found.beams_compared, found.ranges_hash
            ),
            tables: vec![Table {
                columns: vec![
                    "world, beams",
                    "kernel",
                    "rays",
                    "parry",
                    "rays / kernel",
                    "parry / kernel",
                    "noise",
                ],
                rows: found.cases.iter().map(row).collect(),
            }],
            findings: findings(found),
        }
    }
}

/// First cells of the rows that a run of the bench has.
#[must_use]
pub fn rows() -> Vec<String> {
    let plan = Plan::default();
    let of = |world: &String| plan.beams.iter().map(|b| label(world, *b)).collect::<Vec<_>>();
    plan.worlds().iter().flat_map(of).collect()
}

fn label(world: &str, beams: u32) -> String {
    format!("{world}, {beams}")
}

fn row(case: &Case) -> Vec<String> {
    vec![
        label(&case.world, case.beams),
        format!("{:.1}", case.kernel_ns_per_beam.median),
        format!("{:.1}", case.rays_ns_per_beam.median),
        format!("{:.1}", case.parry_ns_per_beam.median),
        format!("{:.1}", case.rays_over_kernel.median),
        format!("{:.1}", case.parry_over_kernel.median),
        format!("{:+.1}", case.noise_ns_per_beam.median),
    ]
}

/// What the goals of the scan come to.
fn findings(found: &ScanResults) -> Vec<Finding> {
    let generated = || found.cases.iter().filter(|case| case.world != "apartment");
    let apartment = |beams: u32, number: fn(&Case) -> f64| {
        let case = found.cases.iter().find(|c| c.world == "apartment" && c.beams == beams);
        case.map_or(f64::NAN, number)
    };
    let kernel = |case: &Case| case.kernel_ns_per_beam.median;
    let noise = |case: &Case| case.noise_ns_per_beam.median;
    let few = apartment(180, kernel);
    let many = apartment(1080, kernel);
    let (least, most) = range(generated().map(|case| case.rays_over_kernel.median));
    let growth = |density: &str| range(growths(found, density));
    let ((little, much), (area_little, area_much)) = (growth("constant"), growth("area"));
    let (_, worst_many) = range(generated().filter(|case| case.beams == 1080).map(kernel));
    let (_, worst_noise) = range(found.cases.iter().map(noise));
    vec![
        Finding {
            key: "scan-apartment",
            goal: "≤ 15 ns per beam in the Apartment with 180 beams",
            found: format!("{few:.1} ns"),
            met: few <= 15.0,
        },
        Finding {
            key: "scan-reference",
            goal: "≥ 8 × faster than a ray for each beam at 64, 512, 4,096 and 32,768 walls",
            found: format!("{least:.1} to {most:.1} ×"),
            met: least >= 8.0,
        },
        Finding {
            key: "scan-growth",
            goal: "from 64 to 32,768 walls the cost of a beam grows ≤ 2 ×",
            found: format!(
                "{little:.1} to {much:.1} × at constant density, {area_little:.1} to \
                 {area_much:.1} × on a constant area"
            ),
            met: much <= 2.0 && area_much <= 2.0,
        },
        Finding {
            key: "scan-many-beams",
            goal: "≤ 6 ns per beam with 1080 beams",
            found: format!("{many:.1} ns in the Apartment, up to {worst_many:.1} ns elsewhere"),
            met: many <= 6.0,
        },
        Finding {
            key: "scan-noise",
            goal: "noise and dropout ≤ 15 ns per beam on top",
            found: format!("up to {worst_noise:.1} ns"),
            met: worst_noise <= 15.0,
        },
    ]
}

/// For each kind of world at this density and each number of beams: the kernel's
/// cost in the largest world over that in the smallest.
fn growths<'a>(found: &'a ScanResults, density: &'a str) -> impl Iterator<Item = f64> + 'a {
    // `rooms-area-64`: the kind is all but the size.
    let kind = |case: &Case| {
        let kind = case.world.rsplit_once('-').map(|(kind, _)| kind.to_owned());
        kind.map(|kind| (kind, case.beams))
    };
    let size = |case: &&Case| case.walls;
    found.cases.iter().filter_map(move |case| {
        let alike = || found.cases.iter().filter(|other| kind(other) == kind(case));
        kind(case).filter(|(kind, _)| kind.ends_with(density))?;
        let (small, large) = (alike().min_by_key(size)?, alike().max_by_key(size)?);
        let is_one = std::ptr::eq(case, small) && small.walls < large.walls;
        let cost = |case: &Case| case.kernel_ns_per_beam.median;
        is_one.then(|| cost(large) / cost(small))
    })
}

/// The least and the greatest; NaN where there is none, which meets no goal.
fn range(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::NAN, f64::NAN), |(least, most), x| (x.min(least), x.max(most)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantiles::Spread;

    fn case(world: &str, walls: usize, beams: u32, kernel_ns: f64, ratio: f64) -> Case {
        let of = |number| Spread::of([number]);
        Case {
            world: world.to_owned(),
            walls,
            beams,
            rounds: 5,
            kernel_ns_per_beam: of(kernel_ns),
            rays_ns_per_beam: of(kernel_ns * ratio),
            parry_ns_per_beam: of(300.0),
            rays_over_kernel: of(ratio),
            parry_over_kernel: of(20.0),
            noise_ns_per_beam: of(9.0),
            beams_compared: 10,
            beams_that_differ: 0,
            parry_differs: 0,
            ranges_hash: "00".to_owned(),
        }
    }

    fn met(cases: Vec<Case>) -> Vec<bool> {
        let section = Section::from(&ScanResults::of(cases));
        section.findings.iter().map(|finding| finding.met).collect()
    }

    #[test]
    fn each_goal_is_judged_by_its_worst_case() {
        let good = || {
            vec![
                case("apartment", 34, 180, 15.0, 8.0),
                case("apartment", 34, 1080, 6.0, 1.0),
                case("rooms-area-64", 64, 180, 10.0, 9.0),
                case("rooms-area-512", 512, 180, 20.0, 8.0),
                case("rooms-constant-64", 64, 180, 30.0, 8.5),
                case("rooms-constant-512", 512, 180, 60.0, 8.5),
            ]
        };
        assert_eq!(met(good()), [true; 5]);
        let mut slow = good();
        slow[3] = case("rooms-area-512", 512, 180, 21.0, 7.9);
        assert_eq!(met(slow), [true, false, false, true, true]);
    }

    #[test]
    fn what_was_not_measured_is_not_met() {
        assert_eq!(met(Vec::new()), [false; 5]);
    }

    #[test]
    fn a_row_for_each_world_and_number_of_beams() {
        let rows = rows();
        assert_eq!(rows.len(), 34);
        assert_eq!(rows[0], "apartment, 180");
        assert_eq!(rows[33], "segments-area-32768, 1080");
    }
}
