//! Pictures of workpieces, and their PNG files.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context, Result};
use png::{BitDepth, ColorType, Compression, Decoder, Encoder};
use render::{
    Camera, Legend, Panel, Picture, RemovedView, View, clearest_direction, clearest_of, contact_sheet, outward, render,
};
use sdf_bake::BrickGrid;

use crate::asset::WeldTruth;
use files::output::FileKind;

/// Width and height of one view [pixels].
pub const VIEW_SIZE: (usize, usize) = (960, 720);

/// Samples along each side of a pixel.
pub const SAMPLES_PER_SIDE: usize = 2;

/// Keyword and text of the PNG chunk that names the program.
const MARK: (&str, &str) = ("Software", "RoboFin");

/// Encodes a picture as PNG.
///
/// # Errors
/// If the pixel buffer does not match the picture's size.
pub fn to_png(picture: &Picture) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, picture.width as u32, picture.height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    let context = "the picture cannot be written as PNG";
    encoder.add_text_chunk(MARK.0.to_owned(), MARK.1.to_owned()).context(context)?;
    let mut writer = encoder.write_header().context(context)?;
    writer.write_image_data(&picture.rgb).context(context)?;
    writer.finish().context(context)?;
    Ok(bytes)
}

/// A drawing of `robofin render`: a PNG with the mark of this program.
pub const DRAWING: FileKind = FileKind { what: "a picture", is_own: is_drawing };

fn is_drawing(file: &Path) -> bool {
    let reader = File::open(file).ok().and_then(|file| Decoder::new(BufReader::new(file)).read_info().ok());
    let texts = reader.map(|reader| reader.info().uncompressed_latin1_text.clone()).unwrap_or_default();
    texts.iter().any(|text| (text.keyword.as_str(), text.text.as_str()) == MARK)
}

/// Draws the whole workpiece from the three-quarter view that shows most of its weld, or from the front right above.
///
/// # Errors
/// If the field has no surface.
pub fn overview(
    grid: &BrickGrid,
    weld: Option<&WeldTruth>,
    (width, height): (usize, usize),
    samples_per_side: usize,
) -> Result<Picture> {
    let bounds = grid.surface_bounds().or_else(|| grid.near_surface_bounds());
    let (low, high) = bounds.context("the field holds no surface to draw")?;
    let (azimuth, elevation) = three_quarter_view(grid, weld, CameraRange::Either);
    let camera = Camera::framing(low, high, azimuth, elevation, width as f64 / height as f64);
    Ok(render(grid, &camera, &View { samples_per_side, ..view(width, height, None) }).to_srgb8())
}

/// Range of the camera in a standard view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraRange {
    /// Above the horizon only, because the part stands on a surface.
    Above,
    /// Above the horizon, or below it if a weld is visible only from there.
    Either,
}

/// Returns azimuth and elevation [rad] of the standard view that shows most of a weld.
pub fn three_quarter_view(grid: &BrickGrid, weld: Option<&WeldTruth>, horizon: CameraRange) -> (f64, f64) {
    let elevations = match horizon {
        CameraRange::Above => &[32f64][..],
        CameraRange::Either => &[32.0, -32.0],
    };
    let azimuths = [-58f64, 32.0, 122.0, 212.0];
    let views =
        elevations.iter().flat_map(|elevation| azimuths.map(|azimuth| (azimuth.to_radians(), elevation.to_radians())));
    let views: Vec<(f64, f64)> = views.collect();
    let Some(weld) = weld else { return views[0] };
    let directions = views.iter().map(|&(azimuth, elevation)| outward(azimuth, elevation));
    let clearest = clearest_of(grid, &weld.curve.position, 1e-3 * weld.width_mm, directions);
    views.into_iter().find(|&(azimuth, elevation)| outward(azimuth, elevation) == clearest).unwrap_or_default()
}

fn view<'a>(width: usize, height: usize, removed: Option<RemovedView<'a>>) -> View<'a> {
    View { width, height, samples_per_side: SAMPLES_PER_SIDE, removed }
}

/// Close-ups of a weld before and after grinding, and of the removed depth.
pub struct GrindPictures {
    /// Before the first pass.
    pub before: Picture,
    /// After the last pass.
    pub after: Picture,
    /// Removed depth in colours.
    pub removed: Picture,
    /// All three side by side with titles and the legend.
    pub sheet: Picture,
}

/// Stacks pictures vertically on white.
pub fn stacked(strips: &[Picture]) -> Picture {
    let width = strips.iter().map(|strip| strip.width).max().unwrap_or(1);
    let mut sheet = Picture::filled(width, strips.iter().map(|strip| strip.height).sum(), [255; 3]);
    let mut top = 0;
    for strip in strips {
        sheet.paste((0, top), strip);
        top += strip.height;
    }
    sheet
}

/// Draws a weld before and after grinding.
pub fn grinding(before: &BrickGrid, after: &BrickGrid, weld: &WeldTruth, title: &str) -> GrindPictures {
    let (width, height) = (VIEW_SIZE.0 * 2 / 3, VIEW_SIZE.1 * 2 / 3);
    let (points, bead) = (&weld.curve.position, 1e-3 * weld.width_mm);
    let camera =
        Camera::close_up(points, clearest_direction(before, points, bead), 1.5 * bead, width as f64 / height as f64);
    let shade = |grid| render(grid, &camera, &view(width, height, None)).to_srgb8();
    let (first, last) = (shade(before), shade(after));
    let removed = RemovedView { before, full_scale: None };
    let frame = render(after, &camera, &view(width, height, Some(removed)));
    let legend = frame.removed_full_scale.map(Legend::removed_depth);
    let depth = frame.to_srgb8();
    let panel = |caption: &str, picture: &Picture, legend| Panel {
        caption: caption.to_owned(),
        picture: picture.clone(),
        legend,
    };
    let sheet = contact_sheet(
        title,
        &[panel("before", &first, None), panel("after", &last, None), panel("removed depth", &depth, legend.clone())],
    );
    let removed = contact_sheet("removed depth", &[panel("", &depth, legend)]);
    GrindPictures { before: first, after: last, removed, sheet }
}
