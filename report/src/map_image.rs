//! A map on the page: a PNG inside an SVG with axes in millimetres; its values show under the pointer.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec2;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, Rgb};
use sdf_bake::PixelGrid;

use crate::{Axis, escape, short};

/// Embedded value of a missing pixel.
const ABSENT: i16 = i16::MIN;
/// Margins for the axes: left and below [px].
const LEFT: f64 = 34.0;
const BELOW: f64 = 36.0;
const ABOVE: f64 = 4.0;
const RIGHT: f64 = 8.0;
/// Greatest height of a picture [px].
const MOST_HEIGHT: f64 = 420.0;

/// A map ready for the page.
pub(crate) struct MapImage<'a> {
    /// Positions of the pixels.
    pub(crate) pixels: PixelGrid,
    /// Colours, shape `[ny, nx]`.
    pub(crate) colours: Vec<Rgb<u8>>,
    /// Values shown under the pointer, shape `[ny, nx]`.
    pub(crate) values: Values<'a>,
    /// Name of the map, such as `base model`.
    pub(crate) label: &'a str,
    /// Description of the map in one sentence.
    pub(crate) title: &'a str,
    /// Width on the page [px].
    pub(crate) width: f64,
    /// Lines drawn over the map.
    pub(crate) lines: Vec<Line>,
}

/// A line over a map.
pub(crate) struct Line {
    /// Points of the line [m].
    pub(crate) points: Vec<DVec2>,
    /// CSS colour.
    pub(crate) colour: &'static str,
}

/// Values of pixels shown under the pointer.
pub(crate) enum Values<'a> {
    /// Heights [m].
    Heights(&'a [f64]),
    /// Words, and the index of each pixel's word.
    Words(&'a [&'static str], &'a [usize]),
}

impl MapImage<'_> {
    /// Returns the map as an SVG element.
    pub(crate) fn to_svg(&self) -> String {
        let PixelGrid { origin, pitch, nx, ny } = self.pixels;
        let scale = ((self.width - LEFT - RIGHT) / nx as f64).min(MOST_HEIGHT / ny as f64);
        let (wide, high) = (scale * nx as f64, scale * ny as f64);
        let edge =
            |start: f64, count: usize| (1e3 * (start - 0.5 * pitch), 1e3 * (start + (count as f64 - 0.5) * pitch));
        let (x, y) = (edge(origin.x, nx), edge(origin.y, ny));
        let across = Axis { low: x.0, high: x.1, start: LEFT, end: LEFT + wide };
        let up = Axis { low: y.0, high: y.1, start: ABOVE + high, end: ABOVE };
        let (total_width, total_height) = (LEFT + wide + RIGHT, ABOVE + high + BELOW);
        let mut svg = format!(
            "<svg viewBox=\"0 0 {total_width:.1} {total_height:.1}\" style=\"width:{total_width:.0}px\" role=\"img\" \
             font-family=\"system-ui, sans-serif\" font-size=\"11\"><title>{}</title>",
            escape(self.title)
        );
        let _ = write!(
            svg,
            "<image class=\"map\" x=\"{LEFT}\" y=\"{ABOVE}\" width=\"{wide:.2}\" height=\"{high:.2}\" \
             preserveAspectRatio=\"none\" data-label=\"{}\" data-nx=\"{nx}\" data-ny=\"{ny}\" data-x-mm=\"{}\" \
             data-y-mm=\"{}\" data-pitch-mm=\"{}\" {} href=\"data:image/png;base64,{}\"/>",
            escape(self.label),
            1e3 * origin.x,
            1e3 * origin.y,
            1e3 * pitch,
            self.values.to_attributes(),
            STANDARD.encode(self.png())
        );
        self.lines.iter().for_each(|line| line.draw(&mut svg, &across, &up));
        draw_axes(&mut svg, &across, &up);
        svg + "</svg>"
    }

    /// Encodes the picture as PNG, y upwards.
    fn png(&self) -> Vec<u8> {
        let PixelGrid { nx, ny, .. } = self.pixels;
        let rows = self.colours.chunks(nx).rev().flatten().flat_map(|Rgb(colour)| *colour);
        let rgb: Vec<u8> = rows.collect();
        let mut bytes = Vec::new();
        // The picture has few colours and no gradients: a PNG filter would hide the repetition from the compressor.
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::NoFilter)
            .write_image(&rgb, nx as u32, ny as u32, ExtendedColorType::Rgb8)
            .expect("a buffer of the picture's size, written to memory");
        bytes
    }
}

impl Line {
    /// Draws the parts of the line that lie on the map.
    fn draw(&self, svg: &mut String, across: &Axis, up: &Axis) {
        let inside = |p: &DVec2| {
            let within = |axis: &Axis, value: f64| (axis.low..=axis.high).contains(&(value * 1e3));
            within(across, p.x) && within(up, p.y)
        };
        for part in self.points.split(|point| !inside(point)).filter(|part| part.len() > 1) {
            let shown = part.iter().map(|p| format!("{:.1},{:.1} ", across.at(p.x * 1e3), up.at(p.y * 1e3)));
            let points: String = shown.collect();
            let _ = write!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\" pointer-events=\"none\"/>",
                points.trim_end(),
                self.colour
            );
        }
    }
}

fn draw_axes(svg: &mut String, across: &Axis, up: &Axis) {
    let (bottom, right) = (up.start, across.end);
    for value in across.ticks(8) {
        let x = across.at(value);
        let _ = write!(svg, r##"<path d="M{x:.1} {bottom:.1}v4" stroke="#8a93a3"/>"##);
        let _ =
            write!(svg, r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{}</text>"#, bottom + 15.0, short(value));
    }
    for value in up.ticks(4) {
        let y = up.at(value);
        let _ = write!(svg, r##"<path d="M{LEFT} {y:.1}h-4" stroke="#8a93a3"/>"##);
        let _ = write!(svg, r#"<text x="{}" y="{:.1}" text-anchor="end">{}</text>"#, LEFT - 7.0, y + 4.0, short(value));
    }
    let (wide, high) = (right - LEFT, bottom - up.end);
    let _ = write!(
        svg,
        r##"<rect x="{LEFT}" y="{}" width="{wide:.1}" height="{high:.1}" fill="none" stroke="#8a93a3" pointer-events="none"/>"##,
        up.end
    );
    let (x, y) = (0.5 * (LEFT + right), bottom + 30.0);
    let _ = write!(svg, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="middle">x, y [mm]</text>"#);
}

impl Values<'_> {
    fn to_attributes(&self) -> String {
        match self {
            Self::Heights(heights) => {
                let (per_micrometre, values) = quantised(heights);
                format!("data-per-um=\"{per_micrometre}\" data-values=\"{}\"", encoded(&values))
            }
            Self::Words(words, indices) => {
                let values: Vec<i16> = indices.iter().map(|&index| index as i16).collect();
                format!("data-words=\"{}\" data-values=\"{}\"", escape(&words.join("|")), encoded(&values))
            }
        }
    }
}

/// Quantises heights [m] to 16-bit integers: in tenths of a micrometre, or coarser by a power of ten if they do not
/// fit. Returns the integers per micrometre, and the integers.
fn quantised(heights: &[f64]) -> (f64, Vec<i16>) {
    let most = heights.iter().filter(|h| h.is_finite()).fold(0.0f64, |most, h| most.max(h.abs())) * 1e6;
    let steps = [10.0, 1.0, 0.1, 0.01];
    let per_micrometre = steps.into_iter().find(|step| step * most <= f64::from(i16::MAX)).unwrap_or(0.001);
    let one = |h: &f64| if h.is_finite() { (h * 1e6 * per_micrometre).round() as i16 } else { ABSENT };
    (per_micrometre, heights.iter().map(one).collect())
}

/// Encodes little-endian 16-bit integers in base64.
fn encoded(values: &[i16]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_kept_to_a_tenth_of_a_micrometre_or_as_fine_as_they_fit() {
        assert_eq!(quantised(&[1.26e-6, -2e-6, f64::NAN]), (10.0, vec![13, -20, ABSENT]));
        assert_eq!(quantised(&[20e-3]), (1.0, vec![20000]));
    }
}
