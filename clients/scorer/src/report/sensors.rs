//! What the small sensors read: on the floor, and the noise of the IMU.

use rusty_contract::config::sensors::ImuConfig;
use rusty_metrics::{Allan, AllanDeviation};
use rusty_plot::style::{INK, Look, RGBColor, SOFT_INK, WHITE};
use rusty_plot::{Axes, Axis, Canvas, Drawing, Layer, Rect};

use super::{figure, figures};
use crate::scoring::map;
use crate::scoring::sensed::Points;
use crate::scoring::trace::RunTrace;

/// Size of the chart of the IMU.
const CHART: (f64, f64) = (480.0, 320.0);
/// The law is drawn through this many points.
const LAW_POINTS: usize = 65;

/// The part of the page; `None` of a run without small sensors.
pub(super) fn draw(trace: &RunTrace) -> Option<String> {
    let sensed = trace.sensed.as_ref()?;
    let floor = sensed.has_points().then(|| draw_floor(trace));
    let imu = sensed.imu.as_ref().and_then(|(imu, allan)| draw_allan(imu, allan));
    let part: String = floor.into_iter().chain(imu).collect();
    (!part.is_empty()).then(|| format!("<div class=\"charts\">\n{part}</div>\n"))
}

fn draw_floor(trace: &RunTrace) -> String {
    let (axes, size) = figures::map_axes(&map::View::of(trace));
    let look = |index| Look::of(index, 4).ink;
    let sensed = trace.sensed.as_ref();
    let sensors: [(&str, RGBColor, Option<&Points>); 4] = [
        ("sonar: each echo on the axis of its cone", look(1), sensed.map(|s| &s.echoes)),
        ("landmarks, by range and bearing", look(2), sensed.map(|s| &s.landmarks)),
        ("robot when a door was reported", look(3), sensed.map(|s| &s.doors)),
        ("bumper: sectors in contact", look(0), sensed.map(|s| &s.contacts)),
    ];
    let present = || {
        let all = sensors.iter().filter_map(|(name, ink, points)| Some((name, ink, (*points)?)));
        all.filter(|(.., points)| !points.at_m.is_empty())
    };
    let mut drawing = Drawing::new(size, "sensors");
    drawing.layer(&Layer::of("ground"), |canvas| {
        map::draw_ground(canvas, &axes, trace);
        for post in &trace.world.landmarks {
            let at = axes.px(post.at);
            canvas.disc(at, 5.0, &INK);
            canvas.disc(at, 3.4, &WHITE);
        }
    });
    for (_, ink, points) in present() {
        drawing.layer(&Layer::default().within(axes.frame), |canvas| {
            points.at_m.iter().for_each(|&at| canvas.disc(axes.px(at), 1.4, ink))
        });
    }
    let names: Vec<&str> = present().map(|(name, ..)| *name).collect();
    let text = format!("The floor seen from above, with: {}", names.join("; "));
    let svg = drawing.finish("Readings of the small sensors", &text, "");
    let mut part = figure(&svg, "Readings, put on the floor by the true pose.");
    part.insert_str(part.len() - "</figure>\n".len(), &key(present().map(|(n, i, _)| (*n, i))));
    part
}

fn key<'a>(entries: impl Iterator<Item = (&'a str, &'a RGBColor)>) -> String {
    let mut list = "<ul class=\"key\">\n".to_owned();
    for (k, (name, ink)) in entries.enumerate() {
        let mut drawing = Drawing::new((30.0, 22.0), &format!("sensor-{k}"));
        drawing.layer(&Layer::default(), |canvas| canvas.disc([15.0, 11.0], 4.0, ink));
        let svg = drawing.finish("", "", "class=\"swatch\" aria-hidden=\"true\"");
        list.push_str(&format!("<li>{svg}<span>{name}</span></li>\n"));
    }
    list + "</ul>\n"
}

/// The Allan deviation that the figures of the data sheet promise, °/h: with noise N and
/// an instability B in the time T, σ² = N²/τ + (B²/T)·τ/3.
fn law_deg_h(imu: &ImuConfig, interval_s: f64) -> f64 {
    // N in °/√h: within τ = 1 h it makes N °/h.
    let noise = imu.gyro_noise_deg_sqrt_h * imu.gyro_noise_deg_sqrt_h * 3600.0 / interval_s;
    let bias = imu.gyro_bias_instability_deg_h * imu.gyro_bias_instability_deg_h;
    (noise + bias / imu.bias_time_s * interval_s / 3.0).sqrt()
}

fn draw_allan(imu: &ImuConfig, allan: &Allan) -> Option<String> {
    let found: Vec<AllanDeviation> = allan.deviations().filter(|d| d.deviation > 0.0).collect();
    let (first, last) = (found.first()?.interval_s, found.last()?.interval_s);
    let interval_s = |k: usize| {
        let share = k as f64 / (LAW_POINTS - 1) as f64;
        first * rusty_geometry::trig::exp(share * rusty_geometry::trig::ln(last / first))
    };
    let law: Vec<[f64; 2]> =
        (0..LAW_POINTS).map(interval_s).map(|tau_s| [tau_s, law_deg_h(imu, tau_s)]).collect();
    let heights = || found.iter().map(|d| d.deviation).chain(law.iter().map(|at| at[1]));
    let low = heights().filter(|h| *h > 0.0).fold(f64::INFINITY, f64::min);
    let high = heights().fold(0.0, f64::max);
    let frame = Rect { left: 62.0, top: 28.0, right: CHART.0 - 12.0, bottom: CHART.1 - 48.0 };
    let x = Axis::log([0.8 * first, 1.25 * last]);
    let axes = Axes { frame, x, y: Axis::log([0.5 * low, 2.0 * high]) };
    let mut drawing = Drawing::new(CHART, "allan");
    let draw = |canvas: &mut Canvas| {
        axes.draw_grid(canvas);
        axes.draw_frame(canvas, true);
        axes.draw_titles(canvas, "Allan deviation of the yaw rate (°/h)", "interval τ (s)", "");
        let look = Look::of(1, 2);
        if law.iter().all(|at| at[1] > 0.0) {
            let law: Vec<_> = law.iter().map(|&at| axes.px(at)).collect();
            canvas.dashes(&law, &SOFT_INK, 1.6, 5.0);
        }
        for d in &found {
            let error = 1.2 / (2.0 * d.differences as f64).sqrt();
            let at = |share: f64| axes.px([d.interval_s, d.deviation * share]);
            // Down to a tenth, where the axis has no end.
            canvas.line(&[at((1.0 - error).max(0.1)), at(1.0 + error)], &look.ink, 1.6);
            look.mark(canvas, at(1.0), 4.0);
        }
    };
    drawing.layer(
        &Layer::of("ground").within(Rect { left: 0.0, top: 0.0, right: CHART.0, bottom: CHART.1 }),
        draw,
    );
    let svg = drawing.finish("Noise of the IMU", "The Allan deviation of the yaw rate", "");
    let caption = "Error of the yaw rate against the true motion, ± one standard error. Dashes: \
                   what noise and bias instability of the configuration promise; a slope of -½ \
                   is white noise, one of +½ a bias that walks.";
    Some(figure(&svg, caption))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_has_the_figures_of_the_data_sheet() {
        let imu = ImuConfig::default();
        // Within an hour 0.30 °/h of white noise; 4.6 °/h in 500 s, and σ² = B²·τ/3T.
        let noise = ImuConfig { gyro_bias_instability_deg_h: 0.0, ..imu };
        assert!((law_deg_h(&noise, 3600.0) - 0.30).abs() < 1e-12);
        let walk = ImuConfig { gyro_noise_deg_sqrt_h: 0.0, ..imu };
        assert!((law_deg_h(&walk, 1500.0) - 4.6).abs() < 1e-12);
    }
}
