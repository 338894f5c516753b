//! Labels of an image as colours over it; background is transparent.

use image::{DynamicImage, ImageBuffer, ImageFormat, Rgba};
use render::{colour_map, to_srgb8};

/// Colours of the classes: sanded, unsanded, ignored.
const CLASSES: [(u8, [u8; 3], &str); 3] =
    [(1, [0xe6, 0x9f, 0x00], "sanded"), (2, [0x00, 0x72, 0xb2], "unsanded"), (255, [0xcc, 0x79, 0xa7], "ignored")];
/// Colours of base metal and of the welds, which are repeated from the second on (Wong 2011).
const INSTANCES: [[u8; 3]; 6] = [
    [0x56, 0xb4, 0xe9],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xf0, 0xe4, 0x42],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
];

/// How labels are coloured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Colouring {
    /// Classes of the coating.
    Classes,
    /// Base metal and welds.
    Instances,
    /// Values from the least to the greatest, zero is background.
    Depth,
}

/// Colours labels, and returns them as PNG with transparent background.
///
/// # Errors
/// If the bytes are no picture.
pub(super) fn overlay(png: &[u8], colouring: Colouring) -> Result<Vec<u8>, String> {
    let labels = image::load_from_memory_with_format(png, ImageFormat::Png).map_err(|error| error.to_string())?;
    let coloured = match colouring {
        Colouring::Depth => of_depth(&labels),
        _ => of_labels(&labels, colouring),
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    coloured.write_to(&mut bytes, ImageFormat::Png).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Returns the colours of labels as CSS with their words.
pub(super) fn legend(colouring: Colouring) -> Vec<(String, &'static str)> {
    let css = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    match colouring {
        Colouring::Classes => CLASSES.iter().map(|(_, colour, words)| (css(*colour), *words)).collect(),
        Colouring::Instances => {
            let words = ["base metal", "first weld", "second weld"];
            INSTANCES.iter().zip(words).map(|(colour, words)| (css(*colour), words)).collect()
        }
        Colouring::Depth => {
            let words = ["near", "", "", "", "far"];
            let ramp = |k: usize| css(to_srgb8(colour_map(k as f32 / 4.0)));
            words.iter().enumerate().map(|(k, words)| (ramp(k), *words)).collect()
        }
    }
}

type Coloured = ImageBuffer<Rgba<u8>, Vec<u8>>;

fn of_labels(labels: &DynamicImage, colouring: Colouring) -> Coloured {
    let of = |label: u8| match colouring {
        _ if label == 0 => None,
        Colouring::Classes => CLASSES.iter().find(|(class, ..)| *class == label).map(|(_, colour, _)| *colour),
        _ => Some(INSTANCES[instance(label)]),
    };
    let grey = labels.to_luma8();
    ImageBuffer::from_fn(grey.width(), grey.height(), |x, y| rgba(of(grey.get_pixel(x, y).0[0])))
}

/// Place of an instance's colour: base metal has the first, welds share the others.
fn instance(label: u8) -> usize {
    let label = usize::from(label) - 1;
    if label == 0 { 0 } else { 1 + (label - 1) % (INSTANCES.len() - 1) }
}

fn of_depth(labels: &DynamicImage) -> Coloured {
    let depth = labels.to_luma16();
    let known = || depth.pixels().map(|pixel| pixel.0[0]).filter(|value| *value > 0);
    let (least, most) = (known().min().unwrap_or(0), known().max().unwrap_or(0));
    let span = f32::from(most - least).max(1.0);
    let of = |value: u16| (value > 0).then(|| to_srgb8(colour_map(f32::from(value - least) / span)));
    ImageBuffer::from_fn(depth.width(), depth.height(), |x, y| rgba(of(depth.get_pixel(x, y).0[0])))
}

fn rgba(colour: Option<[u8; 3]>) -> Rgba<u8> {
    colour.map_or(Rgba([0; 4]), |[r, g, b]| Rgba([r, g, b, 255]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(image: &DynamicImage) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn coloured(image: DynamicImage, colouring: Colouring) -> Vec<[u8; 4]> {
        let bytes = overlay(&png(&image), colouring).unwrap();
        image::load_from_memory(&bytes).unwrap().to_rgba8().pixels().map(|pixel| pixel.0).collect()
    }

    #[test]
    fn background_is_transparent_and_every_class_has_its_colour() {
        let labels = ImageBuffer::from_raw(4, 1, vec![0u8, 1, 2, 255]).unwrap();
        let found = coloured(DynamicImage::ImageLuma8(labels), Colouring::Classes);
        let expected = CLASSES.map(|(_, [r, g, b], _)| [r, g, b, 255]);
        assert_eq!(found, [&[[0; 4]], &expected[..]].concat());
    }

    #[test]
    fn welds_differ_from_base_metal_and_depth_from_near_to_far() {
        let labels = ImageBuffer::from_raw(4, 1, vec![1u8, 2, 6, 7]).unwrap();
        let found = coloured(DynamicImage::ImageLuma8(labels), Colouring::Instances);
        assert!(found[1..].iter().all(|colour| *colour != found[0]), "{found:?}");
        let depth = ImageBuffer::from_raw(3, 1, vec![0u16, 5000, 6000]).unwrap();
        let found = coloured(DynamicImage::ImageLuma16(depth), Colouring::Depth);
        assert!(found[0] == [0; 4] && found[1] != found[2] && found[2][3] == 255, "{found:?}");
        assert!(overlay(b"no picture", Colouring::Depth).is_err());
    }
}
