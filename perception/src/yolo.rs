//! Labels in the segmentation format of YOLO: a line for each region, its class and the polygon around it.

use std::fmt::Write;

use render::label::{SANDED, UNSANDED};

/// Names of the classes in the order of their numbers.
pub const CLASSES: [&str; 2] = ["sanded", "unsanded"];
/// Regions of fewer pixels are left out: their polygon is hardly more than their pixels' border.
const LEAST_PIXELS: usize = 12;

/// Writes the regions of an image. `labels`: index labels row by row from the top left.
///
/// A region is a set of pixels of one class connected along their sides. Its polygon is its outer border; holes are part
/// of it, since the format has none. Coordinates are shares of width and height.
pub fn regions(labels: &[u8], (width, height): (usize, usize)) -> String {
    let mut text = String::new();
    let mut visited = vec![false; labels.len()];
    for first in 0..labels.len() {
        let Some(class) = [SANDED, UNSANDED].iter().position(|&class| labels[first] == class) else { continue };
        if visited[first] || flood(labels, (width, first), &mut visited) < LEAST_PIXELS {
            continue;
        }
        let _ = write!(text, "{class}");
        for (x, y) in border(labels, (width, height), first) {
            let _ = write!(text, " {:.6} {:.6}", x as f64 / width as f64, y as f64 / height as f64);
        }
        text.push('\n');
    }
    text
}

/// Marks the region of a pixel as visited; returns its number of pixels.
fn flood(labels: &[u8], (width, first): (usize, usize), visited: &mut [bool]) -> usize {
    let mut open = vec![first];
    visited[first] = true;
    let mut count = 0;
    while let Some(pixel) = open.pop() {
        count += 1;
        let x = pixel % width;
        let beside = [
            (x > 0).then(|| pixel - 1),
            (x + 1 < width).then(|| pixel + 1),
            pixel.checked_sub(width),
            Some(pixel + width).filter(|&below| below < labels.len()),
        ];
        for other in beside.into_iter().flatten() {
            if !visited[other] && labels[other] == labels[first] {
                visited[other] = true;
                open.push(other);
            }
        }
    }
    count
}

/// Corners of the outer border of the region whose first pixel, row by row, is `first`: clockwise in the picture along
/// the pixels' sides, with the region on the right.
fn border(labels: &[u8], (width, height): (usize, usize), first: usize) -> Vec<(usize, usize)> {
    /// Steps to the right, down, to the left, up.
    const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let is_in = |x: i64, y: i64| {
        let inside = (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
        inside && labels[y as usize * width + x as usize] == labels[first]
    };
    // Pixels ahead on the left and on the right of a corner, for each direction.
    let ahead = |(x, y): (i64, i64), to: usize| match to {
        0 => [(x, y - 1), (x, y)],
        1 => [(x, y), (x - 1, y)],
        2 => [(x - 1, y), (x - 1, y - 1)],
        _ => [(x - 1, y - 1), (x, y - 1)],
    };
    let start = ((first % width) as i64, (first / width) as i64);
    let (mut at, mut to) = (start, 0);
    let mut corners = Vec::new();
    loop {
        let (step_x, step_y) = STEPS[to];
        at = (at.0 + step_x, at.1 + step_y);
        let [left, right] = ahead(at, to).map(|(x, y)| is_in(x, y));
        // Pixels that touch at a corner alone do not belong together, so the border turns right before it goes on.
        let turned = match (left, right) {
            (_, false) => (to + 1) % 4,
            (true, true) => (to + 3) % 4,
            (false, true) => to,
        };
        if turned != to {
            corners.push((at.0 as usize, at.1 as usize));
        }
        to = turned;
        if at == start && to == 0 {
            return corners;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area within a closed polygon of shares, in pixels (shoelace formula).
    fn area(line: &str, (width, height): (usize, usize)) -> f64 {
        let numbers: Vec<f64> = line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect();
        let points: Vec<(f64, f64)> =
            numbers.chunks(2).map(|pair| (pair[0] * width as f64, pair[1] * height as f64)).collect();
        let next = points.iter().cycle().skip(1);
        0.5 * points.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>()
    }

    #[test]
    fn the_polygon_of_a_rectangle_has_its_four_corners() {
        let (width, height) = (10, 8);
        let inside = |pixel: usize| (2..7).contains(&(pixel % width)) && (3..6).contains(&(pixel / width));
        let labels: Vec<u8> = (0..width * height).map(|pixel| if inside(pixel) { SANDED } else { 0 }).collect();
        assert_eq!(
            regions(&labels, (width, height)),
            "0 0.700000 0.375000 0.700000 0.750000 0.200000 0.750000 0.200000 0.375000\n"
        );
    }

    #[test]
    fn polygons_have_the_area_of_their_regions_whatever_their_shape() {
        let (width, height) = (40, 30);
        for seed in 0..20u32 {
            // A disc and another with its centre in the first: no hole.
            let hash = |k: u32| seed.wrapping_mul(2_654_435_761).wrapping_add(k.wrapping_mul(40_503)) >> 8;
            let (x, y, radius) =
                (f64::from(12 + hash(1) % 16), f64::from(12 + hash(2) % 6), f64::from(3 + hash(3) % 5));
            let beside = f64::from(hash(4) % 4) - 1.5;
            let discs = [(x, y, radius), (x + beside, y - beside, f64::from(2 + hash(5) % 6))];
            let inside = |pixel: usize| {
                let (x, y) = ((pixel % width) as f64, (pixel / width) as f64);
                discs.iter().any(|(cx, cy, radius)| (x - cx).hypot(y - cy) <= *radius)
            };
            let labels: Vec<u8> = (0..width * height).map(|pixel| if inside(pixel) { UNSANDED } else { 0 }).collect();
            let pixels = labels.iter().filter(|&&label| label == UNSANDED).count();
            let text = regions(&labels, (width, height));
            let sum: f64 = text.lines().map(|line| area(line, (width, height))).sum();
            assert!((sum - pixels as f64).abs() < 1e-2, "seed {seed}: {sum} for {pixels} pixels");
            assert!(text.lines().all(|line| line.starts_with("1 ")));
        }
    }

    #[test]
    fn pixels_that_touch_at_a_corner_are_regions_of_their_own_and_small_ones_are_left_out() {
        let (width, height) = (12, 12);
        let inside = |x: usize, y: usize| (x < 4 && y < 4) || ((4..8).contains(&x) && (4..8).contains(&y)) || x == 11;
        let labels: Vec<u8> = (0..width * height)
            .map(|pixel| if inside(pixel % width, pixel / width) && pixel / width < 11 { SANDED } else { 0 })
            .collect();
        let text = regions(&labels, (width, height));
        let areas: Vec<f64> = text.lines().map(|line| area(line, (width, height)).round()).collect();
        // The column of eleven pixels is below the least size.
        assert_eq!(areas, [16.0, 16.0]);
    }
}
