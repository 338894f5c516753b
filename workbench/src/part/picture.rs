//! A picture of the workpiece in one of the modes.

use std::sync::{Arc, OnceLock};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::{ThreadPool, ThreadPoolBuilder};
use render::{Frame, Picture, Raster, RemovedView, Scene, View, render, round_full_scale};
use sdf_bake::BrickGrid;
use serde::Deserialize;
use serde_json::{Value, json};

use super::camera::Turn;
use super::paint;
use super::surfaces::{ScannedTrial, Surfaces};
use crate::bench::{Live, ScanMap};
use crate::error::Refusal;

/// Sides of a picture that are accepted [pixels].
const SIDES: [usize; 2] = [16, 2000];
/// Share of the deepest pixels that the scale of removed depth leaves out: spikes are no removal.
const DEEPEST_SHARE: f64 = 0.002;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mode {
    /// With materials and light.
    Photograph,
    /// Depth removed since before the first pass.
    Removed,
    /// Measured minus simulated.
    Deviation,
    /// The same in noise floors.
    Noise,
    /// Removed share of the coating.
    Dose,
}

/// Whose surface is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Whose {
    /// As the model has it.
    Simulated,
    /// As it was scanned.
    Measured,
}

/// A picture that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(crate) struct Asked {
    /// From 0.
    pub(crate) trial: usize,
    /// Passes that are done.
    pub(crate) pass: usize,
    /// Whose surface.
    pub(crate) whose: Whose,
    /// In which colours.
    pub(crate) mode: Mode,
    /// As [`Turn::azimuth`].
    azimuth: f64,
    /// As [`Turn::elevation`].
    elevation: f64,
    /// As [`Turn::zoom`].
    zoom: f64,
    /// As [`Turn::right`].
    right: f64,
    /// As [`Turn::up`].
    up: f64,
    /// Pixels along a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// Whether edges are smooth, which takes four times as long.
    pub(crate) fine: bool,
}

/// What is looked at: scans, and a model where it is there.
#[derive(Clone)]
pub(crate) struct Looked {
    /// The scans.
    pub(crate) surfaces: Arc<Surfaces>,
    /// The model.
    pub(crate) live: Option<Arc<Live>>,
}

impl Asked {
    /// Where one looks from.
    fn turn(&self) -> Turn {
        let Self { azimuth, elevation, zoom, right, up, .. } = *self;
        Turn { azimuth, elevation, zoom, right, up }
    }
}

impl Looked {
    /// The trial that is asked for.
    pub(super) fn trial(&self, asked: &Asked) -> Result<&ScannedTrial, Refusal> {
        let trial = self.surfaces.trials.get(asked.trial).filter(|trial| asked.pass <= trial.scans.len());
        trial.ok_or_else(|| Refusal::missing("there is no such trial or pass"))
    }

    /// The surface after so many passes.
    pub(super) fn field(&self, asked: &Asked, pass: usize) -> Result<Arc<BrickGrid>, Refusal> {
        if asked.whose == Whose::Measured {
            return self.trial(asked)?.field(pass).map_err(Refusal::wrong);
        }
        let live = self.live.as_ref().ok_or_else(|| Refusal::early("the model is not simulated yet"))?;
        let fields = live.trials.get(asked.trial).and_then(|trial| trial.after.get(pass));
        fields.cloned().ok_or_else(|| Refusal::missing("there is no such trial or pass"))
    }

    /// What is left of the scan after the last pass that is done; `None` before the first, and without a model.
    pub(super) fn map(&self, asked: &Asked) -> Option<&ScanMap> {
        self.live.as_ref()?.map(asked.trial, asked.pass.checked_sub(1)?)
    }
}

/// Threads of their own: a fit that is under way shares the processor with them, and does not make them wait in its queue.
pub(super) fn threads() -> &'static ThreadPool {
    static THREADS: OnceLock<ThreadPool> = OnceLock::new();
    THREADS.get_or_init(|| ThreadPoolBuilder::new().thread_name(|k| format!("draw-{k}")).build().expect("threads"))
}

/// A picture as PNG, and its legend.
///
/// # Errors
/// Where there is no such surface, or the model is not simulated yet.
pub(crate) fn drawn(looked: &Looked, asked: &Asked) -> Result<(Vec<u8>, Value), Refusal> {
    let [least, most] = SIDES;
    if !(least..=most).contains(&asked.width) || !(least..=most).contains(&asked.height) {
        return Err(Refusal::wrong(format!("pictures of {least} to {most} pixels along each side are accepted")));
    }
    let (picture, legend) = threads().install(|| picture(looked, asked))?;
    Ok((png(&picture), legend))
}

fn picture(looked: &Looked, asked: &Asked) -> Result<(Picture, Value), Refusal> {
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
        (Mode::Dose, _) if !field.dose.is_empty() => {
            let frame = render(&field, &camera, &view);
            (paint::painted(&frame, paint::of_dose(&frame)), paint::legend_to("removed share of the coating", 1.0, ""))
        }
        _ => (Scene::new(&field).photograph(&camera, &raster).to_srgb8(), json!({})),
    })
}

/// The buffers that the middle of each pixel sees, with removed depth.
pub(super) fn seen(looked: &Looked, asked: &Asked) -> Result<Frame, Refusal> {
    let (trial, field, before) = (looked.trial(asked)?, looked.field(asked, asked.pass)?, looked.field(asked, 0)?);
    let camera = asked.turn().camera(&trial.before, (asked.width, asked.height));
    let removed = Some(RemovedView { before: &before, full_scale: Some(1.0) });
    let view = View { width: asked.width, height: asked.height, samples_per_side: 1, removed };
    Ok(threads().install(|| render(&field, &camera, &view)))
}

/// A round depth that holds nearly all that was measured to be removed by all passes [m]: one scale for a whole trial.
fn deepest(trial: &ScannedTrial) -> f64 {
    let Some(last) = trial.heights(trial.scans.len()) else { return round_full_scale(0.0) };
    let depths = trial.before.heights.iter().zip(&last.heights).map(|(before, after)| before - after);
    let mut depths: Vec<f64> = depths.filter(|depth| *depth > 0.0).collect();
    depths.sort_by(f64::total_cmp);
    let at = ((1.0 - DEEPEST_SHARE) * depths.len() as f64) as usize;
    round_full_scale(depths.get(at).or(depths.last()).copied().unwrap_or(1e-6))
}

/// A picture as PNG, quickly: it is looked at once.
fn png(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Sub)
        .write_image(&picture.rgb, picture.width as u32, picture.height as u32, ExtendedColorType::Rgb8)
        .expect("a buffer of the picture's size, written to memory");
    bytes
}
