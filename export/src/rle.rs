//! Run-length encoding of masks in COCO's format (Lin et al. 2014; the reference is `maskApi.c` of pycocotools).
//!
//! A mask is read column by column; runs of background and mask alternate, background first. In the text form, each run
//! from the fourth on is stored as its difference from the run two places before. The number is split into groups of
//! five bits, lowest first, each with a sixth bit that marks a following group; 48 is added to make a character.

use serde::{Deserialize, Serialize};

/// A mask in compressed form.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rle {
    /// Rows and columns.
    pub size: [usize; 2],
    /// Encoded runs.
    pub counts: String,
}

/// Area and bounding box of a mask.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Number of pixels in the mask.
    pub area: u64,
    /// Left, top, width, height [pixels]; zeros for an empty mask.
    pub bounds: [usize; 4],
}

impl Rle {
    /// Encodes a mask, row by row from the top left, shape `[height, width]`.
    pub fn of(width: usize, height: usize, mask: impl Fn(usize) -> bool) -> Self {
        let mut runs: Vec<i64> = vec![0];
        let mut current = false;
        for pixel in (0..width).flat_map(|x| (0..height).map(move |y| y * width + x)) {
            if mask(pixel) != current {
                current = !current;
                runs.push(0);
            }
            *runs.last_mut().expect("there is a run") += 1;
        }
        let counts = runs.iter().enumerate().map(|(i, &run)| word(if i > 2 { run - runs[i - 2] } else { run }));
        Self { size: [height, width], counts: counts.collect() }
    }
}

impl Extent {
    /// Computes area and bounding box of a mask given row by row from the top left.
    pub fn of(width: usize, height: usize, mask: impl Fn(usize) -> bool) -> Self {
        let mut area = 0;
        let (mut low, mut high) = ([width, height], [0, 0]);
        for pixel in (0..width * height).filter(|&pixel| mask(pixel)) {
            area += 1;
            for (axis, at) in [pixel % width, pixel / width].into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at + 1);
            }
        }
        let bounds = if area == 0 { [0; 4] } else { [low[0], low[1], high[0] - low[0], high[1] - low[1]] };
        Self { area, bounds }
    }
}

/// Encodes a signed number as characters.
fn word(mut number: i64) -> String {
    let mut text = String::new();
    loop {
        let group = (number & 0x1f) as u8;
        number >>= 5;
        // The fifth bit of the last group is the sign.
        let more = if group & 0x10 != 0 { number != -1 } else { number != 0 };
        text.push(char::from(48 + (group | if more { 0x20 } else { 0 })));
        if !more {
            return text;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encode(rows: &[&str]) -> String {
        let pixels: Vec<bool> = rows.iter().flat_map(|row| row.bytes().map(|letter| letter == b'#')).collect();
        Rle::of(rows[0].len(), rows.len(), |pixel| pixels[pixel]).counts
    }

    #[test]
    fn texts_are_those_of_pycocotools() {
        // Expected texts are those of `pycocotools.mask.encode` 2.0.11.
        assert_eq!(encode(&["....", "....", "...."]), "<");
        assert_eq!(encode(&["####", "####", "####"]), "0<");
        assert_eq!(encode(&["....", ".##.", "...."]), "41202");
        assert_eq!(encode(&["#...", ".##.", "...#"]), "0130O010");
        let disc = |pixel: usize| (pixel % 640).abs_diff(320).pow(2) + (pixel / 640).abs_diff(240).pow(2) < 40_000;
        let large = Rle::of(640, 480, disc).counts;
        assert_eq!(large.len(), 809);
        assert!(large.starts_with("mmh1W1`=b0A<E:F:G8H8I6I8I6J6J6K4") && large.ends_with("F:F;D?^O\\Qh1"), "{large}");
    }

    #[test]
    fn an_empty_mask_has_no_box() {
        assert_eq!(Extent::of(4, 3, |_| false), Extent { area: 0, bounds: [0; 4] });
        assert_eq!(Extent::of(4, 3, |pixel| pixel == 6), Extent { area: 1, bounds: [2, 1, 1, 1] });
        assert_eq!(Extent::of(4, 3, |pixel| pixel != 0), Extent { area: 11, bounds: [0, 0, 4, 3] });
    }
}
