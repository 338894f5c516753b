//! Line charts as inline SVG: one, or several stacked over one horizontal axis.

use std::fmt::Write;

use super::axis::{Axis, range, short};
use super::page::escape;

/// One line of a chart.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points (x, y) in the units of the axes; the line is broken where y is not finite.
    pub points: Vec<(f64, f64)>,
    /// Colour and dashes; `None` takes the next colour of the palette.
    pub stroke: Option<Stroke>,
    /// Lower and upper bound of the band at each point, as many as points; empty without a band.
    pub band: Vec<(f64, f64)>,
}

impl Series {
    /// Makes a line without a band, in the next colour of the palette.
    pub fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, stroke: None, band: Vec::new() }
    }
}

/// Colour and dashes of a line.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// CSS colour.
    pub colour: &'static str,
    /// True if the line is dashed, so that it differs in print without colour.
    pub dashed: bool,
}

/// A chart of lines over a common axis.
#[derive(Clone, Copy, Debug)]
pub struct Chart<'a> {
    /// Description for readers who cannot see the chart.
    pub title: &'a str,
    /// Label of the horizontal axis, with its unit.
    pub x_label: &'a str,
    /// Label of the vertical axis, with its unit.
    pub y_label: &'a str,
    /// The lines.
    pub series: &'a [Series],
    /// Width and height [px].
    pub size: (f64, f64),
    /// True if the vertical axis starts at zero.
    pub from_zero: bool,
    /// Vertical range drawn as a tolerance band.
    pub band: Option<(f64, f64)>,
}

/// Width and height of a chart across the page [px].
pub const WIDE: (f64, f64) = (900.0, 260.0);
const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 42.0;
/// Greatest number of points of a drawn line; longer lines are thinned.
const MOST_POINTS: usize = 600;
/// Greatest number of positions along the axis at which values show under the pointer.
const MOST_STRIPS: usize = 80;
/// Mean width of a letter of the legend [px].
const LETTER: f64 = 7.0;
/// Palette of Okabe & Ito (2008), distinguishable by colour-blind readers.
const COLOURS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];

impl Chart<'_> {
    /// Returns the chart as an SVG element; empty without points.
    pub fn to_svg(&self) -> String {
        stacked(self.title, std::slice::from_ref(self))
    }

    fn horizontal(&self) -> Option<(f64, f64)> {
        range(self.series.iter().flat_map(|s| &s.points).filter(|p| p.1.is_finite()).map(|p| p.0))
    }

    fn vertical(&self) -> Option<(f64, f64)> {
        let lines = self.series.iter().flat_map(|s| &s.points).map(|p| p.1);
        let bands = self.series.iter().flat_map(|s| &s.band).flat_map(|b| [b.0, b.1]);
        let (low, high) = range(lines.chain(bands).chain(self.band.into_iter().flat_map(|b| [b.0, b.1])))?;
        if self.from_zero {
            return Some((low.min(0.0), if high > 0.0 { 1.08 * high } else { 1.0 }));
        }
        let margin = if high > low { 0.06 * (high - low) } else { 0.5 * high.abs().max(1e-9) };
        Some((low - margin, high + margin))
    }

    /// Draws the chart from `top` [px] downwards; only the lowest of a stack labels the horizontal axis.
    fn draw(&self, svg: &mut String, across: &Axis, top: f64, lowest: bool) {
        let Some((low, high)) = self.vertical() else { return };
        let bottom = top + self.size.1 - if lowest { BOTTOM } else { 14.0 };
        let up = Axis { low, high, start: bottom, end: top + TOP };
        if let Some((from, to)) = self.band {
            let (y, height) = (up.at(to), up.at(from) - up.at(to));
            let width = across.end - across.start;
            let _ = write!(
                svg,
                r##"<rect x="{LEFT}" y="{y:.1}" width="{width:.1}" height="{height:.1}" fill="#eef0f3"/>"##
            );
        }
        self.draw_axes(svg, across, &up, lowest);
        let mut x = LEFT;
        for (i, series) in self.series.iter().enumerate() {
            let stroke = series.stroke.unwrap_or(Stroke { colour: COLOURS[i % COLOURS.len()], dashed: false });
            draw_series(svg, series, stroke, across, &up);
            draw_legend(svg, &series.name, stroke, x, top + 12.0);
            x += 44.0 + LETTER * series.name.chars().count() as f64;
        }
    }

    fn draw_axes(&self, svg: &mut String, across: &Axis, up: &Axis, lowest: bool) {
        let (bottom, top, right) = (up.start, up.end, across.end);
        let rows = ((bottom - top) / 26.0).clamp(2.0, 8.0) as usize;
        for value in up.ticks(rows) {
            let y = up.at(value);
            let colour = if value == 0.0 { "#8a93a3" } else { "#e3e7ee" };
            let _ = write!(svg, r#"<path d="M{LEFT} {y:.1}H{right}" stroke="{colour}"/>"#);
            let (x, y) = (LEFT - 6.0, y + 4.0);
            let _ = write!(svg, r#"<text x="{x}" y="{y:.1}" text-anchor="end">{}</text>"#, short(value));
        }
        let columns = ((right - LEFT) / 90.0).clamp(3.0, 10.0) as usize;
        let is_counted = self.series.iter().flat_map(|s| &s.points).all(|p| p.0.fract() == 0.0);
        for value in if is_counted { across.whole_ticks(columns) } else { across.ticks(columns) } {
            let x = across.at(value);
            let _ = write!(svg, r##"<path d="M{x:.1} {bottom:.1}v5" stroke="#8a93a3"/>"##);
            if lowest {
                let y = bottom + 18.0;
                let _ = write!(svg, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="middle">{}</text>"#, short(value));
            }
        }
        let _ = write!(svg, r##"<path d="M{LEFT} {top:.1}V{bottom:.1}H{right}" fill="none" stroke="#8a93a3"/>"##);
        if lowest {
            let (x, y) = ((LEFT + right) / 2.0, bottom + 35.0);
            let _ = write!(svg, r#"<text x="{x}" y="{y:.1}" text-anchor="middle">{}</text>"#, escape(self.x_label));
        }
        let (y, label) = ((top + bottom) / 2.0, escape(self.y_label));
        let _ =
            write!(svg, r#"<text transform="translate(14 {y:.1}) rotate(-90)" text-anchor="middle">{label}</text>"#);
    }
}

/// Returns charts of one width over one horizontal axis as an SVG element; values show under the pointer. Empty without
/// points.
pub fn stacked(title: &str, charts: &[Chart]) -> String {
    let Some((low, high)) = range(charts.iter().filter_map(Chart::horizontal).flat_map(|r| [r.0, r.1])) else {
        return String::new();
    };
    if low >= high {
        return String::new();
    }
    let width = charts[0].size.0;
    let height: f64 = charts.iter().map(|chart| chart.size.1).sum();
    let across = Axis { low, high, start: LEFT, end: width - RIGHT };
    let title = escape(title);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width} {height}\" style=\"width:{width}px\" role=\"img\" \
         font-family=\"system-ui, sans-serif\" font-size=\"12\"><title>{title}</title>"
    );
    let mut top = 0.0;
    for (i, chart) in charts.iter().enumerate() {
        chart.draw(&mut svg, &across, top, i + 1 == charts.len());
        top += chart.size.1;
    }
    draw_strips(&mut svg, charts, &across, height - BOTTOM);
    svg + "</svg>"
}

fn draw_series(svg: &mut String, series: &Series, stroke: Stroke, across: &Axis, up: &Axis) {
    let Stroke { colour, .. } = stroke;
    if !series.band.is_empty() {
        let there = series.points.iter().zip(&series.band).map(|(p, b)| (p.0, b.1));
        let back = series.points.iter().zip(&series.band).rev().map(|(p, b)| (p.0, b.0));
        let outline = path(there.chain(back), across, up);
        let _ = write!(svg, r#"<path d="{outline}Z" fill="{colour}" fill-opacity="0.16"/>"#);
        for p in &series.points {
            let _ =
                write!(svg, r#"<circle cx="{:.1}" cy="{:.1}" r="2.6" fill="{colour}"/>"#, across.at(p.0), up.at(p.1));
        }
    }
    let stride = series.points.len().div_ceil(MOST_POINTS).max(1);
    let path = path(series.points.iter().step_by(stride).copied(), across, up);
    let dashes = dashes(stroke);
    let _ = write!(svg, r#"<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.5"{dashes}/>"#);
}

fn dashes(stroke: Stroke) -> &'static str {
    if stroke.dashed { " stroke-dasharray=\"5 3\"" } else { "" }
}

fn draw_legend(svg: &mut String, name: &str, stroke: Stroke, x: f64, y: f64) {
    let (colour, dashes) = (stroke.colour, dashes(stroke));
    let _ = write!(svg, r#"<path d="M{x} {:.1}h22" stroke="{colour}" stroke-width="2"{dashes}/>"#, y - 4.0);
    let _ = write!(svg, r#"<text x="{:.1}" y="{y:.1}">{}</text>"#, x + 27.0, escape(name));
}

/// Returns a path through the finite points, broken where one is missing.
fn path(points: impl Iterator<Item = (f64, f64)>, across: &Axis, up: &Axis) -> String {
    let mut text = String::new();
    let mut pen_down = false;
    for (x, y) in points {
        let finite = x.is_finite() && y.is_finite();
        if finite {
            let _ = write!(text, "{}{:.1} {:.1}", if pen_down { 'L' } else { 'M' }, across.at(x), up.at(y));
        }
        pen_down = finite;
    }
    text
}

/// Draws vertical strips that show the values of all lines under the pointer.
fn draw_strips(svg: &mut String, charts: &[Chart], across: &Axis, bottom: f64) {
    let Some(first) = charts.iter().flat_map(|chart| chart.series).next() else { return };
    let stride = first.points.len().div_ceil(MOST_STRIPS).max(1);
    let width = ((across.end - across.start) * stride as f64 / first.points.len() as f64).max(2.0);
    for (k, place) in first.points.iter().enumerate().step_by(stride).filter(|(_, p)| p.0.is_finite()) {
        let mut says = format!("{}: {}", charts[0].x_label, short(place.0));
        for chart in charts {
            for series in chart.series.iter().filter(|s| s.points.get(k).is_some_and(|p| p.0 == place.0)) {
                let value = series.points[k].1;
                let value = if value.is_finite() { short(value) } else { "missing".to_owned() };
                let _ = write!(says, "\n{}: {value}", series.name);
            }
        }
        let x = (across.at(place.0) - 0.5 * width).max(across.start);
        let height = bottom - TOP;
        let _ = write!(
            svg,
            r#"<rect class="strip" x="{x:.1}" y="{TOP}" width="{width:.1}" height="{height:.1}"><title>{}</title></rect>"#,
            escape(&says)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart<'a>(series: &'a [Series]) -> Chart<'a> {
        let (x_label, y_label) = ("time [s]", "force [N]");
        Chart { title: "Force", x_label, y_label, series, size: WIDE, from_zero: true, band: None }
    }

    #[test]
    fn a_chart_has_one_path_for_each_series_and_breaks_it_where_a_value_is_missing() {
        let broken = vec![(0.0, 2.0), (1.0, 2.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, 1.0)];
        let series = [Series::new("pass 1", vec![(0.0, 1.0), (1.0, 3.0)]), Series::new("pass 2", broken)];
        let svg = chart(&series).to_svg();
        assert_eq!(svg.matches("stroke-width=\"1.5\"").count(), 2);
        assert!(!svg.contains("NaN"));
        let line = svg.rsplit("<path d=\"").find(|path| path.contains("stroke-width=\"1.5\"")).unwrap();
        assert_eq!(line.split('"').next().unwrap().matches('M').count(), 2, "{line}");
        assert_eq!(chart(&[]).to_svg(), "");
    }

    #[test]
    fn numbers_of_passes_have_no_halves_between_them() {
        let series = [Series::new("error", vec![(1.0, 30.0), (2.0, 40.0)])];
        assert!(!chart(&series).to_svg().contains(">1.2</text>"));
        let series = [Series::new("error", vec![(1.0, 30.0), (1.5, 40.0), (2.0, 40.0)])];
        assert!(chart(&series).to_svg().contains(">1.2</text>"), "times have halves");
    }

    #[test]
    fn a_strip_says_the_values_of_all_lines() {
        let series = [
            Series::new("measured", vec![(0.0, 1.0), (1.0, 3.0)]),
            Series::new("simulated", vec![(0.0, f64::NAN), (1.0, 2.5)]),
        ];
        let svg = chart(&series).to_svg();
        assert!(svg.contains("time [s]: 1\nmeasured: 3\nsimulated: 2.5"), "{svg}");
        assert!(svg.contains("simulated: missing"));
    }
}
