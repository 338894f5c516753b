//! `robofin render`: a drawing of an asset or a field, photographs with float buffers, a turntable, a time-lapse.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use files::input::{self, MOST_MESH_BYTES};
use glam::{DQuat, DVec3};
use render::{Camera, Marks, Picture, Placement, ROLLED_STEEL, Raster, Scene, Sensor, Table};
use sdf_bake::{BrickGrid, nvdb};
use serde::Serialize;

use super::backend_flags::{BackendFlags, name_of};
use super::faults::refuse_all;
use super::flags::OutFlags;
use super::sensor_flags::SensorFlags;
use super::values::whole;
use crate::asset::{AssetFields, Manifest, WeldTruth, Welds, write_json};
use crate::console::Console;
use crate::photo::{PHOTOGRAPHS, PhotoBackend, PictureRecord, RENDER_FILE, RenderRecord, to_animated_png, write_frame};
use crate::picture::{CameraRange, DRAWING, SAMPLES_PER_SIDE, overview, three_quarter_view, to_png};
use crate::wrong_use;
use files::folder::{StagedFile, StagedFolder};
use study::snapshot::kept_fields;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin render out/bracket --out out/bracket.png\n  \
                  robofin render out/bracket.nvdb --size 640x480 --out out/field.png\n  \
                  robofin render out/bracket --camera=-58,32 --table --out out/photo\n  \
                  robofin render out/bracket --turntable 24 --size 640x480 --out out/turntable\n  \
                  robofin render out/ground --lapse --grind-along 1,0,0 --out out/lapse\n\n\
                  --out NAME.png draws one picture; any other --out becomes a folder with a photograph \
                  (picture.png), its float buffers (buffers.exr) and render.json.")]
pub(super) struct RenderArgs {
    /// Asset folder, result folder of `simulate --snapshot`, or a NanoVDB file with a level set `phi`.
    source: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    /// Width and height of the picture [pixels].
    #[arg(long, default_value = "960x720", value_parser = parse_size)]
    size: (usize, usize),
    #[command(flatten, next_help_heading = "Photograph")]
    photo: PhotoFlags,
}

/// Greatest number of colour samples in all pictures, which take hours on a CPU.
const MOST_RAYS: f64 = 1e11;
/// Default number of colour samples along each side of a pixel.
const SAMPLES: usize = 2;

/// Flags of photographs only.
#[derive(Clone, Debug, Args)]
struct PhotoFlags {
    /// Where the camera stands, seen from the part: azimuth from x towards y and elevation [deg] [default: a
    /// three-quarter view from above that shows the weld, from below where it is hidden from above and no table is].
    #[arg(long, value_name = "AZIMUTH,ELEVATION", allow_hyphen_values = true, value_parser = parse_camera)]
    camera: Option<[f64; 2]>,
    #[command(flatten)]
    backend: BackendFlags,
    /// Colour samples along each side of a pixel.
    #[arg(
        long,
        value_name = "N",
        default_value_t = SAMPLES,
        allow_negative_numbers = true,
        value_parser = whole::<usize>([1, 16])
    )]
    samples: usize,
    /// Puts the part on a table, which the camera stands above.
    #[arg(long)]
    table: bool,
    /// Direction of grinding marks in the part's frame [default: along the asset's weld; none without one].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = parse_direction)]
    grind_along: Option<DVec3>,
    /// Pictures of one turn of the part, as a sequence and as an animated PNG.
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "lapse",
        allow_negative_numbers = true,
        value_parser = whole::<usize>([2, 720]),
        help_heading = "Sequences"
    )]
    turntable: Option<usize>,
    /// One picture of every state that the folder holds, as a sequence and as an animated PNG.
    #[arg(long, help_heading = "Sequences")]
    lapse: bool,
    #[command(flatten, next_help_heading = "Lens and sensor")]
    sensor: SensorFlags,
}

/// The answer of `render --json`.
#[derive(Serialize)]
struct RenderAnswer<'a> {
    out: &'a Path,
    width: usize,
    height: usize,
    pictures: usize,
    seconds: f64,
}

pub(super) fn run(args: &RenderArgs, console: &Console) -> Result<()> {
    let started = std::time::Instant::now();
    refuse_all(args.faults())?;
    let pictures = if args.is_drawing() { draw(args, console)? } else { photograph(args, console)? };
    let (out, (width, height), seconds) = (&args.out.out, args.size, started.elapsed().as_secs_f64());
    console.answer(&RenderAnswer { out, width, height, pictures, seconds })
}

impl RenderArgs {
    fn is_drawing(&self) -> bool {
        self.out.out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
    }

    /// Lists the flags that contradict each other, one sentence each.
    fn faults(&self) -> Vec<String> {
        let mut faults = Vec::from_iter(self.photo.sensor.fault());
        if self.is_drawing() {
            let out = self.out.out.display();
            faults.extend(self.photo.given().map(|flag| {
                format!(
                    "{flag} with --out {out}: a .png is a drawing, made on the CPU; a photograph takes {flag}, and --out is \
                     the name of its folder"
                )
            }));
        }
        let (width, height) = self.size;
        let samples = width * height * self.photo.samples * self.photo.samples;
        let rays = samples as f64 * self.photo.turntable.unwrap_or(1) as f64;
        if rays > MOST_RAYS {
            faults.push(format!(
                "--size, --samples and --turntable make {rays:.1e} samples, and {MOST_RAYS:.0e} are accepted: lower one of \
                 them"
            ));
        }
        faults
    }
}

fn draw(args: &RenderArgs, console: &Console) -> Result<usize> {
    let size = args.size;
    let file = StagedFile::new(&args.out.beside(&[&args.source]), &DRAWING)?;
    let (grid, weld) = open(&args.source)?;
    let picture = overview(&grid, weld.as_ref(), size, SAMPLES_PER_SIDE)?;
    file.commit(&to_png(&picture)?)?;
    console.step("picture", format!("{} x {} in {}", size.0, size.1, args.out.out.display()));
    Ok(1)
}

fn photograph(args: &RenderArgs, console: &Console) -> Result<usize> {
    let (photo, (width, height)) = (&args.photo, args.size);
    let raster = Raster { width, height, samples_per_side: photo.samples };
    let folder = StagedFolder::new(&args.out.beside(&[&args.source]), &PHOTOGRAPHS)?;
    let states = if photo.lapse { kept_fields(&args.source)? } else { Vec::new() };
    let is_sequence = photo.lapse || photo.turntable.is_some();
    let mut album = Album::new(folder.path(), is_sequence, (raster, photo.sensor.sensor()));
    let (first, weld) = match states.first() {
        Some(state) => (read_field(state)?, None),
        None => open(&args.source)?,
    };
    let camera = photo.standing(&first, weld.as_ref(), &raster)?;
    let shots = photo.turns(&first, photo.scene(&first, weld.as_ref())?, camera)?;
    let device = photo.backend.device(None, console)?;
    let darkroom = PhotoBackend::new(device.as_ref())?;
    album.take(&darkroom, &first, &shots)?;
    for state in states.iter().skip(1) {
        let part = read_field(state)?;
        album.take(&darkroom, &part, &[(photo.scene(&part, None)?, camera)])?;
    }
    let pictures = album.finish(args.source.display().to_string(), name_of(device.as_ref()))?;
    folder.commit()?;
    console.step("pictures", format!("{pictures} of {width} x {height} in {}", args.out.out.display()));
    Ok(pictures)
}

/// A staged folder of pictures.
struct Album<'a> {
    folder: &'a Path,
    /// True for a sequence, which keeps only pictures; a single photograph keeps its buffers, too.
    is_sequence: bool,
    raster: Raster,
    sensor: Sensor,
    shown: Vec<Picture>,
    records: Vec<PictureRecord>,
}

impl<'a> Album<'a> {
    fn new(folder: &'a Path, is_sequence: bool, (raster, sensor): (Raster, Sensor)) -> Self {
        Self { folder, is_sequence, raster, sensor, shown: Vec::new(), records: Vec::new() }
    }

    /// Returns the file names of the next picture and of its buffers.
    fn names(&self) -> (String, Option<String>) {
        if self.is_sequence {
            return (format!("picture-{:04}.png", self.records.len()), None);
        }
        ("picture.png".to_owned(), Some("buffers.exr".to_owned()))
    }

    fn take(&mut self, darkroom: &PhotoBackend, part: &BrickGrid, shots: &[(Scene, Camera)]) -> Result<()> {
        let raster = self.raster;
        darkroom.photograph(part, shots, &raster, &mut |i, frame| {
            let (picture, buffers) = self.names();
            let shown = write_frame(self.folder, frame, &self.sensor, (&picture, buffers.as_deref()))?;
            self.records.push(PictureRecord::new(picture, buffers, &shots[i]));
            self.shown.push(shown);
            Ok(())
        })
    }

    /// Writes the animation and the record; returns the number of pictures.
    fn finish(self, source: String, backend: String) -> Result<usize> {
        if self.is_sequence {
            let file = self.folder.join("animation.png");
            std::fs::write(&file, to_animated_png(&self.shown)?)
                .with_context(|| format!("{}: cannot write this file", file.display()))?;
        }
        let pictures = self.records.len();
        let record = RenderRecord {
            version: env!("CARGO_PKG_VERSION"),
            source,
            size: [self.raster.width, self.raster.height],
            samples_per_side: self.raster.samples_per_side,
            backend,
            sensor: (&self.sensor).into(),
            pictures: self.records,
        };
        write_json(&self.folder.join(RENDER_FILE), &record)?;
        Ok(pictures)
    }
}

impl PhotoFlags {
    fn scene<'a>(&self, part: &'a BrickGrid, weld: Option<&WeldTruth>) -> Result<Scene<'a>> {
        let mut scene = Scene::new(part);
        scene.appearance.marks = match (self.grind_along, weld) {
            (Some(direction), _) => Marks::parallel(direction),
            (None, Some(weld)) => Marks::along_path(&weld.curve.position),
            (None, None) => Marks::default(),
        };
        if self.table {
            let height = surface_bounds(part)?.0.z;
            scene.table = Some(Table { height, material: ROLLED_STEEL, texture: None, pattern: None });
        }
        Ok(scene)
    }

    /// Returns the given flags that do not apply to a drawing.
    fn given(&self) -> impl Iterator<Item = &'static str> {
        let flags = [
            (self.camera.is_some(), "--camera"),
            (self.table, "--table"),
            (self.turntable.is_some(), "--turntable"),
            (self.lapse, "--lapse"),
            (self.samples != SAMPLES, "--samples"),
            (self.grind_along.is_some(), "--grind-along"),
            (self.sensor.is_given(), "a flag of lens or sensor"),
            (self.backend.is_gpu(), "--backend gpu"),
        ];
        flags.into_iter().filter(|(is_given, _)| *is_given).map(|(_, flag)| flag)
    }

    fn standing(&self, part: &BrickGrid, weld: Option<&WeldTruth>, raster: &Raster) -> Result<Camera> {
        let horizon = if self.table { CameraRange::Above } else { CameraRange::Either };
        let (azimuth, elevation) = match self.camera {
            Some([azimuth, elevation]) => (azimuth.to_radians(), elevation.to_radians()),
            None => three_quarter_view(part, weld, horizon),
        };
        let (mut low, mut high) = surface_bounds(part)?;
        if self.turntable.is_some() {
            // The turning part sweeps a cylinder.
            let (centre, half) = (0.5 * (low + high), 0.5 * (high - low));
            let reach = half.truncate().length();
            (low, high) = (centre - DVec3::new(reach, reach, half.z), centre + DVec3::new(reach, reach, half.z));
        }
        let aspect = raster.width as f64 / raster.height as f64;
        let camera = Camera::framing(low, high, azimuth, elevation, aspect);
        if self.table && camera.eye.z <= low.z {
            return Err(wrong_use(format!(
                "--camera with --table: this camera stands {:.0} mm below the table's top; a greater elevation is accepted, \
                 0 or more always",
                (low.z - camera.eye.z) * 1e3
            )));
        }
        Ok(Camera { distortion: self.sensor.distortion.unwrap_or_default(), ..camera })
    }

    /// Returns the views of one photograph, or of one turn about the vertical axis through the part's centre.
    fn turns<'a>(&self, part: &BrickGrid, scene: Scene<'a>, camera: Camera) -> Result<Vec<(Scene<'a>, Camera)>> {
        let Some(pictures) = self.turntable else { return Ok(vec![(scene, camera)]) };
        let (low, high) = surface_bounds(part)?;
        let centre = (0.5 * (low + high)).with_z(0.0);
        let turned = |i: usize| {
            let rotation = DQuat::from_rotation_z(std::f64::consts::TAU * i as f64 / pictures as f64);
            let placement = Placement { rotation, translation: centre - rotation * centre };
            (Scene { placement, ..scene.clone() }, camera)
        };
        Ok((0..pictures).map(turned).collect())
    }
}

fn surface_bounds(part: &BrickGrid) -> Result<(DVec3, DVec3)> {
    part.surface_bounds().or_else(|| part.near_surface_bounds()).context("the field holds no surface to draw")
}

/// Reads the field to draw, and the weld that should be visible.
fn open(source: &Path) -> Result<(BrickGrid, Option<WeldTruth>)> {
    if source.is_dir() {
        if let Some(state) = kept_fields(source).ok().and_then(|mut states| states.pop()) {
            return Ok((read_field(&state)?, None));
        }
        Manifest::read(source)?;
        let weld = Welds::read(source)?.welds.into_iter().next();
        return Ok((AssetFields::open(source)?.welded, weld));
    }
    Ok((read_field(source)?, None))
}

fn read_field(source: &Path) -> Result<BrickGrid> {
    let context = || source.display().to_string();
    let bytes = input::read(source, MOST_MESH_BYTES).with_context(|| {
        format!(
            "{}: an asset folder, a result folder of `simulate --snapshot` or a NanoVDB file with a level set `phi` is \
             expected",
            source.display()
        )
    })?;
    let file = nvdb::read(&bytes).with_context(context)?;
    file.grid("phi").with_context(|| format!("{}: no grid `phi`", source.display()))?;
    file.to_field().with_context(context)
}

/// Parses `AZIMUTH,ELEVATION` [deg].
fn parse_camera(text: &str) -> Result<[f64; 2], String> {
    let angles = text.split_once(',').and_then(|(azimuth, elevation)| {
        let azimuth = azimuth.trim().parse().ok().filter(|azimuth: &f64| azimuth.is_finite())?;
        let elevation = elevation.trim().parse().ok().filter(|elevation| (-90.0..=90.0).contains(elevation))?;
        Some([azimuth, elevation])
    });
    angles.ok_or_else(|| {
        "AZIMUTH,ELEVATION in degrees is expected, elevation from -90 to 90, for example -58,32".to_owned()
    })
}

fn parse_direction(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let direction = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(DVec3::from);
    let is_one = |direction: &DVec3| direction.is_finite() && direction.length() > 0.0;
    direction.filter(is_one).ok_or_else(|| "X,Y,Z is expected, not all zero, for example 1,0,0".to_owned())
}

/// Parses `WIDTHxHEIGHT` [pixels].
pub(super) fn parse_size(text: &str) -> Result<(usize, usize), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (16..=4096).contains(side));
    let size = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    size.ok_or_else(|| "WIDTHxHEIGHT from 16 to 4096 pixels is expected, for example 960x720".to_owned())
}
