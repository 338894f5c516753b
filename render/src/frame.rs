//! Result of a rendering: float buffers, and the eight-bit picture made from them.

use glam::Vec3;

use super::colour::to_srgb8;

/// Object that a pixel shows: the visibility mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum VisibleObject {
    /// The background behind the scene.
    #[default]
    Background = 0,
    /// The part.
    Part = 1,
    /// The table that the part stands on.
    Table = 2,
    /// A thing that is no part.
    Obstacle = 3,
    /// The tool.
    Tool = 4,
}

/// Float buffers of one view, row by row from the top left, shape `[height, width]` each.
///
/// Colour is the mean over a pixel; the others belong to the ray through the pixel's centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Linear RGB, background included.
    pub colour: Vec<Vec3>,
    /// Distance along the camera's axis [m]; infinite for background.
    pub depth: Vec<f32>,
    /// Outward unit normal in the part's frame, without the tilt of grinding marks; zero for background.
    pub normal: Vec<Vec3>,
    /// Point on the surface in the part's frame [m]; zero for background.
    pub position: Vec<Vec3>,
    /// Weld id; 0 for base metal and for everything but the part.
    pub weld: Vec<u16>,
    /// Coating dose D, 1 where the coating is gone; 0 for everything but the part.
    pub dose: Vec<f32>,
    /// Removed depth [m]; 0 where nothing was removed and for background.
    pub removed: Vec<f32>,
    /// Object at the pixel's centre.
    pub seen: Vec<VisibleObject>,
    /// Removed depth of the colour map's last colour [m], if removed depth was drawn.
    pub removed_full_scale: Option<f64>,
}

impl Frame {
    /// A frame that shows only background.
    pub fn empty(width: usize, height: usize) -> Self {
        let mut frame = Self::zeroed(width, height);
        frame.depth.fill(f32::INFINITY);
        frame
    }

    /// Resizes the frame; all pixels must then be written. Its memory is reused if the size is unchanged.
    pub(crate) fn be_of_size(&mut self, width: usize, height: usize) {
        self.removed_full_scale = None;
        if (self.width, self.height) != (width, height) {
            *self = Self::zeroed(width, height);
        }
    }

    fn zeroed(width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self {
            width,
            height,
            colour: bytemuck::zeroed_vec(pixels),
            depth: vec![0.0; pixels],
            normal: bytemuck::zeroed_vec(pixels),
            position: bytemuck::zeroed_vec(pixels),
            weld: vec![0; pixels],
            dose: vec![0.0; pixels],
            removed: vec![0.0; pixels],
            seen: vec![VisibleObject::Background; pixels],
            removed_full_scale: None,
        }
    }

    /// Converts the colour to an eight-bit sRGB picture.
    pub fn to_srgb8(&self) -> Picture {
        let rgb = self.colour.iter().flat_map(|&colour| to_srgb8(colour)).collect();
        Picture { width: self.width, height: self.height, rgb }
    }
}

/// An eight-bit sRGB picture, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel, shape `[height, width, 3]`.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, rgb: colour.repeat(width * height) }
    }

    /// Fills the part of a rectangle that lies within the picture.
    pub fn fill(&mut self, (x, y): (usize, usize), (width, height): (usize, usize), colour: [u8; 3]) {
        let right = (x + width).min(self.width);
        for row in y..(y + height).min(self.height) {
            for column in x..right {
                let at = 3 * (row * self.width + column);
                self.rgb[at..at + 3].copy_from_slice(&colour);
            }
        }
    }

    /// Copies another picture with its top left corner at `(x, y)`; parts outside are clipped.
    pub fn paste(&mut self, (x, y): (usize, usize), other: &Picture) {
        let columns = other.width.min(self.width.saturating_sub(x));
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let to = 3 * ((y + row) * self.width + x);
            let from = 3 * row * other.width;
            self.rgb[to..to + 3 * columns].copy_from_slice(&other.rgb[from..from + 3 * columns]);
        }
    }
}
