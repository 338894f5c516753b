//! Reliability diagram as an SVG picture.

use super::forecast::{Bin, Reliability};

/// Side of the unit square, and margins left, right, above and below it [px].
const SIDE: f64 = 320.0;
const MARGINS: [f64; 4] = [52.0, 14.0, 14.0, 44.0];

/// Position of a stated probability and a share in the picture [px].
fn place([stated, share]: [f64; 2]) -> [f64; 2] {
    [MARGINS[0] + SIDE * stated, MARGINS[2] + SIDE * (1.0 - share)]
}

/// Draws the share of true statements over the stated probability with 95 % intervals and counts; the points lie on the
/// diagonal if the probabilities are reliable.
pub fn reliability_svg(reliability: &Reliability) -> String {
    let (width, height) = (MARGINS[0] + SIDE + MARGINS[1], MARGINS[2] + SIDE + MARGINS[3]);
    let [left, top] = place([0.0, 1.0]);
    let [right, bottom] = place([1.0, 0.0]);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n\
         <rect x=\"{left}\" y=\"{top}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"none\" stroke=\"#888\"/>\n\
         <path d=\"M{left} {bottom}L{right} {top}\" stroke=\"#888\" stroke-dasharray=\"4 4\"/>\n"
    );
    for tick in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        let ([x, _], [_, y]) = (place([tick, 0.0]), place([0.0, tick]));
        text += &format!("<text x=\"{x:.0}\" y=\"{:.0}\" text-anchor=\"middle\">{tick}</text>\n", bottom + 16.0);
        text += &format!("<text x=\"{:.0}\" y=\"{:.0}\" text-anchor=\"end\">{tick}</text>\n", left - 6.0, y + 4.0);
    }
    let middle = left + 0.5 * SIDE;
    text += &format!("<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">stated probability</text>\n", bottom + 34.0);
    let (x, y) = (left - 36.0, top + 0.5 * SIDE);
    text += &format!(
        "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" transform=\"rotate(-90 {x} {y})\">share that is true</text>\n"
    );
    let note = format!("calibration error {:.3}", reliability.calibration_error);
    text += &format!("<text x=\"{}\" y=\"{}\">{note}</text>\n", left + 8.0, top + 18.0);
    reliability.bins.iter().for_each(|bin| text += &point(bin));
    text + "</svg>\n"
}

/// Draws a bin: its interval, its point and its count.
fn point(bin: &Bin) -> String {
    let [x, y] = place([bin.stated, bin.is_true.share()]);
    let [low, high] = bin.is_true.interval.map(|share| place([bin.stated, share])[1]);
    format!(
        "<path d=\"M{x:.1} {low:.1}V{high:.1}\" stroke=\"#1f6fb4\"/>\n<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"#1f6fb4\"/>\n\
         <text x=\"{:.1}\" y=\"{:.1}\" fill=\"#1f6fb4\">{}</text>\n",
        x + 6.0,
        y - 5.0,
        bin.is_true.of
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bin_stands_at_its_mean_and_its_share_with_its_count() {
        let statements: Vec<(f64, bool)> = (0..4).map(|k| (0.75, k < 2)).collect();
        let svg = reliability_svg(&Reliability::new(&statements));
        // Half of four are true: three quarters of the side to the right, half of it up.
        assert!(svg.contains("cx=\"292.0\" cy=\"174.0\"") && svg.contains(">4</text>"), "{svg}");
        assert!(svg.contains("calibration error 0.250") && svg.ends_with("</svg>\n"));
        let parsed = svg.matches("<text").count() == svg.matches("</text>").count();
        assert!(parsed && svg.matches('<').count() == svg.matches('>').count());
    }
}
