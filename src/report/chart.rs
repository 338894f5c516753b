//! Line charts as inline SVG.

use std::fmt::Write;

use super::page::escape;

/// One line of a chart.
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y) in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// A chart of lines over a common axis.
pub struct Chart<'a> {
    /// Label of the horizontal axis, with its unit.
    pub x_label: &'a str,
    /// Label of the vertical axis, with its unit.
    pub y_label: &'a str,
    /// The lines.
    pub series: &'a [Series],
}

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 44.0;
/// Points a line is thinned to.
const MOST_POINTS: usize = 600;
/// Okabe & Ito 2008: told apart by colour-blind readers.
const COLOURS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];

/// Linear map of a data range to a pixel range.
struct Axis {
    low: f64,
    high: f64,
    start: f64,
    end: f64,
}

impl Axis {
    fn at(&self, value: f64) -> f64 {
        self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)
    }

    /// Round values at distances of 1, 2 or 5 times a power of ten.
    fn ticks(&self) -> Vec<f64> {
        let rough = (self.high - self.low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(rough);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

impl Chart<'_> {
    /// The chart as an SVG element; empty without points.
    pub fn to_svg(&self) -> String {
        let points = || self.series.iter().flat_map(|s| &s.points).filter(|p| p.0.is_finite() && p.1.is_finite());
        let range = |pick: fn(&(f64, f64)) -> f64| {
            points().map(pick).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        let (x, y) = (range(|p| p.0), range(|p| p.1));
        if x.0 >= x.1 {
            return String::new();
        }
        let top = if y.1 > 0.0 { 1.08 * y.1 } else { 1.0 };
        let across = Axis { low: x.0, high: x.1, start: LEFT, end: WIDTH - RIGHT };
        let up = Axis { low: y.0.min(0.0), high: top, start: HEIGHT - BOTTOM, end: TOP };
        let mut svg = format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" font-family=\"system-ui, sans-serif\" font-size=\"12\">"
        );
        self.draw_axes(&mut svg, &across, &up);
        for (i, series) in self.series.iter().enumerate() {
            draw_series(&mut svg, series, COLOURS[i % COLOURS.len()], i, &across, &up);
        }
        svg + "</svg>"
    }

    fn draw_axes(&self, svg: &mut String, across: &Axis, up: &Axis) {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        for value in up.ticks() {
            let y = up.at(value);
            let _ = write!(svg, "<path d=\"M{LEFT} {y:.1}H{right}\" stroke=\"#e3e7ee\"/>");
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                y + 4.0,
                short(value)
            );
        }
        for value in across.ticks() {
            let x = across.at(value);
            let _ = write!(svg, "<path d=\"M{x:.1} {bottom}v5\" stroke=\"#8a93a3\"/>");
            let _ = write!(
                svg,
                "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                bottom + 18.0,
                short(value)
            );
        }
        let _ = write!(svg, "<path d=\"M{LEFT} {TOP}V{bottom}H{right}\" fill=\"none\" stroke=\"#8a93a3\"/>");
        let middle = (LEFT + right) / 2.0;
        let _ = write!(
            svg,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            HEIGHT - 8.0,
            escape(self.x_label)
        );
        let y = (TOP + bottom) / 2.0;
        let _ = write!(
            svg,
            "<text transform=\"translate(14 {y}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(self.y_label)
        );
    }
}

fn draw_series(svg: &mut String, series: &Series, colour: &str, row: usize, across: &Axis, up: &Axis) {
    let stride = series.points.len().div_ceil(MOST_POINTS).max(1);
    let path: String = series
        .points
        .iter()
        .step_by(stride)
        .enumerate()
        .map(|(i, p)| format!("{}{:.1} {:.1}", if i == 0 { 'M' } else { 'L' }, across.at(p.0), up.at(p.1)))
        .collect();
    let _ = write!(
        svg,
        "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"><title>{}</title></path>",
        escape(&series.name)
    );
    let y = TOP + 14.0 + 16.0 * row as f64;
    let x = WIDTH - RIGHT - 150.0;
    let _ = write!(svg, "<path d=\"M{x} {}h22\" stroke=\"{colour}\" stroke-width=\"2\"/>", y - 4.0);
    let _ = write!(svg, "<text x=\"{}\" y=\"{y}\">{}</text>", x + 28.0, escape(&series.name));
}

/// A tick's number without needless digits.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let axis = Axis { low: 0.0, high: 16.2, start: 0.0, end: 1.0 };
        assert_eq!(axis.ticks(), [0.0, 5.0, 10.0, 15.0]);
        assert_eq!(short(0.5), "0.5");
        assert_eq!(short(-0.0), "0");
    }

    #[test]
    fn a_chart_has_one_path_for_each_series_and_no_nan() {
        let series = [
            Series { name: "pass 1".to_owned(), points: vec![(0.0, 1.0), (1.0, 3.0)] },
            Series { name: "pass 2".to_owned(), points: vec![(0.0, 2.0), (1.0, f64::NAN), (2.0, 1.0)] },
        ];
        let svg = Chart { x_label: "time [s]", y_label: "force [N]", series: &series[..1] }.to_svg();
        assert_eq!(svg.matches("stroke-width=\"1.5\"").count(), 1);
        assert!(!svg.contains("NaN"));
        assert_eq!(Chart { x_label: "", y_label: "", series: &[] }.to_svg(), "");
    }
}
