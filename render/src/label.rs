//! Index labels of an image: pixels with sanded coating, pixels with intact coating, and undecided pixels.
//!
//! Both labels start from the share of the coating that is removed at a pixel, 0 to 1. By dose it is min(D, 1). By
//! appearance it is the pixel's distance from the unsanded reference relative to its distances from both references,
//! |I − I_unsanded| / (|I − I_unsanded| + |I − I_bare|). On the way from one to the other this is the share of the way;
//! a pixel that resembles neither, such as a primer, is near one half. All three are rendered without noise with the same
//! camera and light.

/// Outside the workpiece.
pub const BACKGROUND: u8 = 0;
/// The workpiece with its coating removed.
pub const SANDED: u8 = 1;
/// The workpiece with intact coating.
pub const UNSANDED: u8 = 2;
/// Next to another class, or undecided.
pub const IGNORE: u8 = 255;

/// Share of removed coating from which a pixel is labelled sanded.
pub const SANDED_FROM: f32 = 0.75;
/// Share of removed coating up to which a pixel is labelled unsanded; between the two limits it is undecided.
pub const UNSANDED_TO: f32 = 0.25;
/// Least difference in appearance between unsanded and bare that is used: Euclidean distance in display code (0 to 1),
/// about 15 of 255 codes in one channel.
pub const LEAST_CONTRAST: f32 = 0.06;

/// A colour in display code: each channel 0 to 1, with perceptually similar steps.
pub type Colour = [f32; 3];

/// Share of removed coating by appearance; `None` if bare metal looks too similar to the coating.
pub fn seen_share(seen: Colour, unsanded: Colour, bare: Colour) -> Option<f32> {
    let distance = |a: Colour, b: Colour| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
    let contrast = distance(bare, unsanded);
    (contrast >= LEAST_CONTRAST).then(|| {
        let from_unsanded = distance(seen, unsanded);
        from_unsanded / (from_unsanded + distance(seen, bare))
    })
}

/// Labels of an image, row by row from the top left.
///
/// `share(pixel)`: `None` outside the workpiece; otherwise the share of removed coating, or `Some(None)` if undecided.
pub fn labels(width: usize, height: usize, share: impl Fn(usize) -> Option<Option<f32>>) -> Vec<u8> {
    let class = |pixel: usize| match share(pixel) {
        None => BACKGROUND,
        Some(Some(share)) if share >= SANDED_FROM => SANDED,
        Some(Some(share)) if share <= UNSANDED_TO => UNSANDED,
        Some(_) => IGNORE,
    };
    let classes: Vec<u8> = (0..width * height).map(class).collect();
    let at_border = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let beside = [
            (x > 0).then(|| pixel - 1),
            (x + 1 < width).then(|| pixel + 1),
            (y > 0).then(|| pixel - width),
            (y + 1 < height).then(|| pixel + width),
        ];
        beside.into_iter().flatten().any(|other| classes[other] != IGNORE && classes[other] != classes[pixel])
    };
    (0..classes.len()).map(|pixel| if at_border(pixel) { IGNORE } else { classes[pixel] }).collect()
}

/// Number of pixels of each class: background, sanded, unsanded, ignored.
pub fn counts(labels: &[u8]) -> [u64; 4] {
    [BACKGROUND, SANDED, UNSANDED, IGNORE].map(|class| labels.iter().filter(|&&label| label == class).count() as u64)
}

/// Share of equal classes among the pixels that both labels call sanded or unsanded; `None` if there are no such
/// pixels.
pub fn agreement(one: &[u8], other: &[u8]) -> Option<f64> {
    let known = |label: u8| label == SANDED || label == UNSANDED;
    let both = || one.iter().zip(other).filter(|(a, b)| known(**a) && known(**b));
    let count = both().count();
    (count > 0).then(|| both().filter(|(a, b)| a == b).count() as f64 / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_divided_by_a_border_that_is_ignored() {
        // Background, then a share of removed coating that rises from 0 to 1.
        let share = |pixel: usize| (pixel % 9 > 1).then(|| Some((pixel % 9 - 2) as f32 / 6.0));
        let labels = labels(9, 3, share);
        for row in labels.chunks(9) {
            assert_eq!(row, [0, 255, 255, 2, 255, 255, 255, 1, 1]);
        }
        assert_eq!(counts(&labels), [3, 6, 3, 15]);
    }

    #[test]
    fn what_looks_alike_tells_nothing() {
        let (paint, metal) = ([0.2, 0.3, 0.5], [0.7, 0.7, 0.7]);
        let half = [0.45, 0.5, 0.6];
        assert_eq!(seen_share(paint, paint, metal), Some(0.0));
        assert!((seen_share(half, paint, metal).unwrap() - 0.5).abs() < 1e-6);
        assert_eq!(seen_share(metal, paint, metal), Some(1.0));
        assert_eq!(seen_share([0.71, 0.7, 0.7], [0.69, 0.7, 0.7], metal), None);
        // A red primer resembles neither.
        let primer = seen_share([0.6, 0.1, 0.1], paint, metal).unwrap();
        assert!((UNSANDED_TO..SANDED_FROM).contains(&primer), "{primer}");
    }

    #[test]
    fn agreement_counts_what_both_know() {
        assert_eq!(agreement(&[0, 1, 2, 255, 1], &[0, 1, 1, 1, 1]), Some(2.0 / 3.0));
        assert_eq!(agreement(&[0, 255], &[1, 1]), None);
    }
}
