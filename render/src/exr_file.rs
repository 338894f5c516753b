//! Writes the float buffers of a frame as one OpenEXR file, which Blender, Nuke, OpenCV and Python's `OpenEXR` read.

use std::io::Cursor;

use exr::error::Result;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};
use glam::Vec3;

use super::frame::Frame;

/// Encodes a frame: one unnamed part with lossless 32-bit float channels, one value per pixel.
///
/// `R`, `G`, `B` linear colour; `Z` depth [m], infinite for background; `normal.X`, `.Y`, `.Z`; `position.X`, `.Y`,
/// `.Z` [m]; `weld` id; `dose` D; `removed` depth [m]; `seen` 0 background, 1 part, 2 table.
///
/// # Errors
/// The encoder's error, for example for a picture without pixels.
pub fn to_exr(frame: &Frame) -> Result<Vec<u8>> {
    let channel = |name: &str, values: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(values));
    let along = |vectors: &[Vec3], axis: usize| vectors.iter().map(|v| v[axis]).collect::<Vec<f32>>();
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (axis, colour) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(colour, along(&frame.colour, axis)));
    }
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        channels.push(channel(&format!("normal.{name}"), along(&frame.normal, axis)));
        channels.push(channel(&format!("position.{name}"), along(&frame.position, axis)));
    }
    channels.push(channel("Z", frame.depth.clone()));
    channels.push(channel("weld", frame.weld.iter().map(|&weld| f32::from(weld)).collect()));
    channels.push(channel("dose", frame.dose.clone()));
    channels.push(channel("removed", frame.removed.clone()));
    channels.push(channel("seen", frame.seen.iter().map(|&seen| f32::from(seen as u8)).collect()));
    let layer = Layer::new(
        (frame.width, frame.height),
        // Blender takes a part's name as the layer of all channels, and then finds neither colour nor passes.
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut file)?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::VisibleObject;
    use exr::prelude::*;

    #[test]
    fn every_buffer_comes_back_bit_by_bit() {
        let mut frame = Frame::empty(5, 3);
        (0..15).for_each(|pixel| {
            let at = pixel as f32;
            frame.colour[pixel] = Vec3::new(at, 0.1 * at, 1.0 / (at + 1.0));
            frame.normal[pixel] = Vec3::new(-at, 0.5, 0.25 * at);
            frame.position[pixel] = Vec3::new(1e-4 * at, -2.0, 3e7);
            if pixel % 3 > 0 {
                frame.depth[pixel] = 0.3 + 1e-6 * at;
            }
            frame.dose[pixel] = 0.07 * at;
            frame.removed[pixel] = 1e-5 * at;
            frame.weld[pixel] = (1000 * pixel) as u16;
            frame.seen[pixel] = [VisibleObject::Background, VisibleObject::Part, VisibleObject::Table][pixel % 3];
        });
        let bytes = to_exr(&frame).unwrap();
        let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
        let image = reader.all_attributes().non_parallel().from_buffered(Cursor::new(bytes)).unwrap();
        assert_eq!(image.layer_data.size, Vec2(5, 3));
        let read_back = |name: &str| -> Vec<f32> {
            let channels = &image.layer_data.channel_data.list;
            let channel = channels.iter().find(|channel| channel.name.eq(name)).expect(name);
            channel.sample_data.values_as_f32().collect()
        };
        assert_eq!(read_back("Z"), frame.depth);
        assert_eq!(read_back("dose"), frame.dose);
        assert_eq!(read_back("removed"), frame.removed);
        assert_eq!(read_back("G"), frame.colour.iter().map(|c| c.y).collect::<Vec<_>>());
        assert_eq!(read_back("normal.X"), frame.normal.iter().map(|n| n.x).collect::<Vec<_>>());
        assert_eq!(read_back("position.Z"), frame.position.iter().map(|p| p.z).collect::<Vec<_>>());
        assert_eq!(read_back("weld"), frame.weld.iter().map(|&w| f32::from(w)).collect::<Vec<_>>());
        assert_eq!(read_back("seen"), frame.seen.iter().map(|&s| f32::from(s as u8)).collect::<Vec<_>>());
        assert_eq!(image.layer_data.channel_data.list.len(), 14);
    }
}
