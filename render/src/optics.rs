//! Imperfections of a lens and of the exposure: defocus, motion, vignetting, colour balance. They act on linear light.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::frame::Frame;

/// Radius of the largest circle of confusion [pixels].
const MOST_BLUR: f32 = 6.0;
/// Number of moments of an exposure for each pixel of its motion.
const MOMENTS: f32 = 2.0;

/// A lens, and the motion of the camera during the exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optics {
    /// Radius of the circle of confusion of an infinitely distant point, times the focused depth [pixels m].
    pub aperture: f32,
    /// Depth of sharp points [m].
    pub focus: f32,
    /// Motion of the picture during the exposure [pixels].
    pub motion: Vec2,
    /// Share of the light that is lost in the corners.
    pub vignetting: f32,
    /// Gain of each channel.
    pub balance: Vec3,
}

impl Default for Optics {
    /// A pinhole at rest.
    fn default() -> Self {
        Self { aperture: 0.0, focus: 1.0, motion: Vec2::ZERO, vignetting: 0.0, balance: Vec3::ONE }
    }
}

impl Optics {
    /// Changes the colour of a frame; the other buffers stay exact.
    pub fn apply(&self, frame: &mut Frame) {
        if self.aperture > 0.0 {
            self.defocus(frame);
        }
        if self.motion != Vec2::ZERO {
            self.move_over(frame);
        }
        let half = 0.5 * Vec2::new(frame.width as f32, frame.height as f32);
        let width = frame.width;
        frame.colour.par_iter_mut().enumerate().for_each(|(pixel, colour)| {
            let at = Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
            let away = (at - half).length_squared() / half.length_squared();
            *colour *= self.balance * (1.0 - self.vignetting * away);
        });
    }

    /// Radius of the circle of confusion at a depth [m], in pixels (thin lens).
    fn confusion(&self, depth: f32) -> f32 {
        (self.aperture * (1.0 / self.focus - 1.0 / depth).abs()).min(MOST_BLUR)
    }

    /// Averages the pixels within each pixel's circle of confusion. A sharper pixel does not spread over it.
    fn defocus(&self, frame: &mut Frame) {
        let (width, height) = (frame.width as isize, frame.height as isize);
        let radii: Vec<f32> = frame.depth.iter().map(|&depth| self.confusion(depth)).collect();
        let colour = |pixel: usize| {
            let (x, y) = (pixel as isize % width, pixel as isize / width);
            let radius = radii[pixel];
            let reach = radius.ceil() as isize;
            let (mut sum, mut weights) = (frame.colour[pixel], 1.0);
            for step in (-reach..=reach).flat_map(|j| (-reach..=reach).map(move |i| (i, j))) {
                let at = (x + step.0, y + step.1);
                let away = (step.0 as f32).hypot(step.1 as f32);
                let is_there = (0..width).contains(&at.0) && (0..height).contains(&at.1);
                if step != (0, 0) && is_there {
                    let other = (at.1 * width + at.0) as usize;
                    let weight = (radius.min(radii[other]) + 0.5 - away).clamp(0.0, 1.0);
                    sum += frame.colour[other] * weight;
                    weights += weight;
                }
            }
            sum / weights
        };
        frame.colour = (0..radii.len()).into_par_iter().map(colour).collect();
    }

    /// Averages the picture over its motion.
    fn move_over(&self, frame: &mut Frame) {
        let count = (MOMENTS * self.motion.length()).ceil().max(1.0) as usize;
        let (width, height) = (frame.width, frame.height);
        let limit = Vec2::new(width as f32 - 1.0, height as f32 - 1.0);
        let colour = |pixel: usize| {
            let at = Vec2::new((pixel % width) as f32, (pixel / width) as f32);
            let moment = |i: usize| {
                let share = (i as f32 + 0.5) / count as f32 - 0.5;
                bilinear(frame, (at + self.motion * share).clamp(Vec2::ZERO, limit))
            };
            (0..count).map(moment).sum::<Vec3>() / count as f32
        };
        frame.colour = (0..width * height).into_par_iter().map(colour).collect();
    }
}

/// Colour at a place within the frame [pixels from the middle of the first].
fn bilinear(frame: &Frame, at: Vec2) -> Vec3 {
    let low = at.floor();
    let share = at - low;
    let (x, y) = (low.x as usize, low.y as usize);
    let colour = |x: usize, y: usize| frame.colour[y.min(frame.height - 1) * frame.width + x.min(frame.width - 1)];
    let row = |y: usize| colour(x, y).lerp(colour(x + 1, y), share.x);
    row(y).lerp(row(y + 1), share.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(depth: f32) -> Frame {
        let mut frame = Frame::empty(31, 21);
        frame.depth.fill(depth);
        frame.colour[10 * 31 + 15] = Vec3::ONE;
        frame
    }

    #[test]
    fn a_pinhole_at_rest_changes_nothing() {
        let mut frame = point(0.5);
        Optics::default().apply(&mut frame);
        assert_eq!(frame, point(0.5));
    }

    #[test]
    fn a_point_out_of_focus_becomes_a_disc_of_the_thin_lens_s_radius() {
        let optics = Optics { aperture: 1.5, focus: 1.0, ..Optics::default() };
        let lit = |depth: f32| {
            let mut frame = point(depth);
            optics.apply(&mut frame);
            frame.colour.iter().filter(|colour| colour.x > 1e-6).count()
        };
        assert_eq!(lit(1.0), 1);
        // At half the focused depth the radius is 1.5 pixels; the disc and its soft border hold 21 pixels at most.
        assert!((9..=21).contains(&lit(0.5)), "{}", lit(0.5));
        let mut frame = point(0.5);
        optics.apply(&mut frame);
        let light: f32 = frame.colour.iter().map(|colour| colour.x).sum();
        assert!((light - 1.0).abs() < 1e-4, "{light}");
    }

    #[test]
    fn motion_makes_a_line_of_its_length_and_vignetting_darkens_the_corners() {
        let mut frame = point(1.0);
        Optics { motion: Vec2::new(4.0, 0.0), ..Optics::default() }.apply(&mut frame);
        let lit: Vec<usize> = (0..frame.colour.len()).filter(|&i| frame.colour[i].x > 1e-6).collect();
        assert!(lit.iter().all(|pixel| pixel / 31 == 10) && (4..=6).contains(&lit.len()), "{lit:?}");
        let mut white = Frame::empty(30, 20);
        white.colour.fill(Vec3::ONE);
        Optics { vignetting: 0.4, balance: Vec3::new(1.1, 1.0, 0.9), ..Optics::default() }.apply(&mut white);
        assert!((white.colour[0].y - 0.6).abs() < 0.05 && (white.colour[10 * 30 + 15].x - 1.1).abs() < 0.01);
    }
}
