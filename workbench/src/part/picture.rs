//! Pictures of the workpiece in one of the colour modes.

use std::sync::{Arc, OnceLock};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::{ThreadPool, ThreadPoolBuilder};
use render::{Frame, Picture, Raster, RemovedView, Scene, View, render, round_full_scale};
use sdf_bake::BrickGrid;
use serde::Deserialize;
use serde_json::{Value, json};
use study::PassTiles;

use super::camera::{Size, Turn};
use super::paint;
use super::studio::Studio;
use super::surfaces::{ScannedTrial, Surfaces};
use crate::bench::{Live, ScanMap};
use crate::error::Refusal;

/// Share of the deepest pixels that the scale of removed depth ignores, because spikes are not removal.
const DEEPEST_SHARE: f64 = 0.002;

/// Colour mode of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mode {
    /// Materials and light.
    Photograph,
    /// Removed depth since before the first pass.
    Removed,
    /// Residual: measured minus simulated.
    Deviation,
    /// Residual in noise floors.
    Noise,
    /// Removed share of the coating.
    Dose,
    /// A covariate of the last pass done, by [`PictureRequest::covariate`].
    Covariate,
}

/// Source of the drawn surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SurfaceSource {
    /// Surface simulated with the model.
    Simulated,
    /// Scanned surface.
    Measured,
}

/// Request for a picture.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(crate) struct PictureRequest {
    /// Number of the model; `None` for the current one.
    pub(crate) model: Option<usize>,
    /// Index of the trial, from 0.
    pub(crate) trial: usize,
    /// Number of passes done.
    pub(crate) pass: usize,
    /// Place of the drawn covariate in the list of [`study::tile_covariate`].
    covariate: Option<usize>,
    /// Source of the surface.
    pub(crate) whose: SurfaceSource,
    /// Colour mode.
    pub(crate) mode: Mode,
    /// See [`Turn::azimuth`].
    azimuth: f64,
    /// See [`Turn::elevation`].
    elevation: f64,
    /// See [`Turn::zoom`].
    zoom: f64,
    /// See [`Turn::right`].
    right: f64,
    /// See [`Turn::up`].
    up: f64,
    /// Width [pixels].
    pub(crate) width: usize,
    /// Height [pixels].
    pub(crate) height: usize,
    /// True to smooth edges with four samples per pixel, which takes four times as long.
    pub(crate) fine: bool,
}

/// Data for pictures: the scans, and the requested model if it is simulated.
#[derive(Clone)]
pub(crate) struct PictureData {
    /// Scanned surfaces.
    pub(crate) surfaces: Arc<Surfaces>,
    /// Fields and maps of the model.
    pub(crate) live: Option<Arc<Live>>,
    /// Device for photographs; `None` for the CPU.
    pub(crate) studio: Option<Arc<Studio>>,
}

impl PictureRequest {
    /// Returns the camera parameters.
    pub(super) fn turn(&self) -> Turn {
        let Self { azimuth, elevation, zoom, right, up, .. } = *self;
        Turn { azimuth, elevation, zoom, right, up }
    }
}

impl PictureData {
    /// Returns the requested trial.
    pub(super) fn trial(&self, asked: &PictureRequest) -> Result<&ScannedTrial, Refusal> {
        let trial = self.surfaces.trials.get(asked.trial).filter(|trial| asked.pass <= trial.scans.len());
        trial.ok_or_else(|| Refusal::missing("there is no such trial or pass"))
    }

    /// Returns the field of the surface after `pass` passes.
    pub(super) fn field(&self, asked: &PictureRequest, pass: usize) -> Result<Arc<BrickGrid>, Refusal> {
        if asked.whose == SurfaceSource::Measured {
            return self.trial(asked)?.field(pass).map_err(Refusal::wrong);
        }
        let live = self.live.as_ref().ok_or_else(|| Refusal::early("the model is not simulated yet"))?;
        let fields = live.trials.get(asked.trial).and_then(|trial| trial.after.get(pass));
        fields.cloned().ok_or_else(|| Refusal::missing("there is no such trial or pass"))
    }

    /// Returns the tiles of the last pass done.
    pub(super) fn tiles(&self, asked: &PictureRequest) -> Result<&PassTiles, Refusal> {
        let live = self.live.as_ref().ok_or_else(|| Refusal::early("conditions need a model that is simulated"))?;
        let is_own = |pass: usize| move |tiles: &&PassTiles| (tiles.trial, tiles.pass) == (asked.trial, pass);
        let own = asked.pass.checked_sub(1).and_then(|pass| live.tiles.iter().find(is_own(pass)));
        own.ok_or_else(|| Refusal::missing("conditions need a pass that has worked on the part"))
    }

    /// Returns the residual map of the last pass done; `None` before the first pass, and without a simulated model.
    pub(super) fn map(&self, asked: &PictureRequest) -> Option<&ScanMap> {
        self.live.as_ref()?.map(asked.trial, asked.pass.checked_sub(1)?)
    }
}

/// Returns a separate thread pool for drawing, so that pictures do not wait in the queue of a running fit.
pub(crate) fn threads() -> &'static ThreadPool {
    static THREADS: OnceLock<ThreadPool> = OnceLock::new();
    THREADS.get_or_init(|| ThreadPoolBuilder::new().thread_name(|k| format!("draw-{k}")).build().expect("threads"))
}

/// Draws a picture; returns it as PNG, with its legend.
///
/// # Errors
/// If there is no such surface, or the model is not simulated yet.
pub(crate) fn drawn(looked: &PictureData, asked: &PictureRequest) -> Result<(Vec<u8>, Value), Refusal> {
    Size { width: asked.width, height: asked.height, fine: asked.fine }.check()?;
    let (picture, legend) = threads().install(|| picture(looked, asked))?;
    Ok((png(&picture), legend))
}

fn picture(looked: &PictureData, asked: &PictureRequest) -> Result<(Picture, Value), Refusal> {
    let (trial, field) = (looked.trial(asked)?, looked.field(asked, asked.pass)?);
    let camera = asked.turn().camera(&trial.before, (asked.width, asked.height));
    let samples_per_side = if asked.fine { 2 } else { 1 };
    let raster = Raster { width: asked.width, height: asked.height, samples_per_side };
    let view = View { width: asked.width, height: asked.height, samples_per_side, removed: None };
    Ok(match (asked.mode, looked.map(asked)) {
        (Mode::Removed, _) => {
            let before = looked.field(asked, 0)?;
            let most = deepest(trial);
            let removed = Some(RemovedView { before: &before, full_scale: Some(most) });
            let frame = render(&field, &camera, &View { removed, ..view });
            (frame.to_srgb8(), paint::legend_to("removed depth", 1e6 * most, "µm"))
        }
        (Mode::Deviation | Mode::Noise, Some(map)) => {
            let frame = render(&field, &camera, &view);
            let picture = paint::painted(&frame, paint::of_map(map, &frame));
            (picture, paint::legend_of(map, asked.mode == Mode::Noise))
        }
        (Mode::Covariate, _) => {
            let tiles = looked.tiles(asked)?;
            let covariate = asked.covariate.filter(|at| *at < tiles.values.len());
            let covariate = covariate.ok_or_else(|| Refusal::missing("there is no such condition"))?;
            let (frame, shown) = (render(&field, &camera, &view), paint::Condition::of(tiles, covariate));
            (paint::painted(&frame, shown.colours(&frame)), shown.legend())
        }
        (Mode::Dose, _) if !field.dose.is_empty() => {
            let frame = render(&field, &camera, &view);
            (paint::painted(&frame, paint::of_dose(&frame)), paint::legend_to("removed share of the coating", 1.0, ""))
        }
        _ => {
            let frame = match &looked.studio {
                Some(studio) => studio.photograph(field, camera, raster)?,
                None => Scene::new(&field).photograph(&camera, &raster),
            };
            (frame.to_srgb8(), json!({}))
        }
    })
}

/// Renders the geometry buffer at the centre of each pixel, with removed depth.
pub(super) fn frame(looked: &PictureData, asked: &PictureRequest) -> Result<Frame, Refusal> {
    let (trial, field, before) = (looked.trial(asked)?, looked.field(asked, asked.pass)?, looked.field(asked, 0)?);
    let camera = asked.turn().camera(&trial.before, (asked.width, asked.height));
    let removed = Some(RemovedView { before: &before, full_scale: Some(1.0) });
    let view = View { width: asked.width, height: asked.height, samples_per_side: 1, removed };
    Ok(threads().install(|| render(&field, &camera, &view)))
}

/// Returns a rounded full scale of removed depth for a whole trial [m], from the measured removal of all passes.
fn deepest(trial: &ScannedTrial) -> f64 {
    let Some(last) = trial.heights(trial.scans.len()) else { return round_full_scale(0.0) };
    let depths = trial.before.heights.iter().zip(&last.heights).map(|(before, after)| before - after);
    let mut depths: Vec<f64> = depths.filter(|depth| *depth > 0.0).collect();
    depths.sort_by(f64::total_cmp);
    let at = ((1.0 - DEEPEST_SHARE) * depths.len() as f64) as usize;
    round_full_scale(depths.get(at).or(depths.last()).copied().unwrap_or(1e-6))
}

/// Encodes a picture as PNG with fast compression, because it is viewed once.
pub(crate) fn png(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Sub)
        .write_image(&picture.rgb, picture.width as u32, picture.height as u32, ExtendedColorType::Rgb8)
        .expect("a buffer of the picture's size, written to memory");
    bytes
}
