//! Reading of a trial's scans. The surface before the first pass is scanned, or nominal, which is the surface as drawn.

use std::path::{Path, PathBuf};

use effects::Signal;
use sdf_bake::{HeightMap, PixelGrid};
use toml::Spanned;

use super::error::{Place, TrialError};
use super::manifest::{Manifest, PassTable, ScanTable, Source};
use super::read::{PassForm, Reader};
use super::scan::{Read, ScanFrame, read_exposure, read_heights, read_labels};
use super::{PassScan, Scans, Trial};
use crate::measure::{
    CLEARANCE, DegreesOfFreedom, Registration, RegistrationError, despiked, register, untouched_in_passes,
};

/// Value of `nominal` for a flat part.
pub(crate) const PLANE: &str = "plane";
/// Maximum number of passes of a trial; each takes seconds.
const MOST_PASSES: usize = 1000;
/// Maximum number of pixels of all scans of a trial: 4 GB.
const MOST_PIXELS: f64 = 5e8;

/// Source of the surface before the first pass.
enum FirstSurface<'a> {
    /// A scan.
    Scanned(&'a Spanned<PathBuf>),
    /// A plane; the value of `nominal`.
    Plane(&'a Spanned<PathBuf>),
    /// A file with the surface as drawn.
    Drawn(&'a Spanned<PathBuf>),
}

impl ScanTable {
    /// The source of the surface before the first pass.
    fn first_surface(&self, source: &Source) -> Result<FirstSurface<'_>, TrialError> {
        match (&self.before, &self.nominal) {
            (Some(before), None) => Ok(FirstSurface::Scanned(before)),
            (None, Some(nominal)) => match self.repeat.first() {
                Some(repeat) => Err(source.bad(
                    repeat.span(),
                    "a repeated scan beside nominal",
                    "the scan that it repeats is expected as before, instead of nominal",
                )),
                None if nominal.get_ref() == Path::new(PLANE) => Ok(FirstSurface::Plane(nominal)),
                None => Ok(FirstSurface::Drawn(nominal)),
            },
            (Some(_), Some(nominal)) => Err(source.bad(
                nominal.span(),
                "both before and nominal",
                "one of them is expected: a scan before the first pass, or the surface as drawn",
            )),
            (None, None) => Err(Place::file(&source.file).bad(
                "[scan] without before",
                format!(
                    "before = \"FILE\" is expected; without a scan before the first pass, nominal = \"FILE\" with the \
                     surface as drawn, or nominal = \"{PLANE}\""
                ),
            )),
        }
    }

    /// Name of the surface before the first pass in messages.
    pub(super) fn first_name(&self) -> &Path {
        self.before.as_ref().or(self.nominal.as_ref()).map_or(Path::new(PLANE), |name| name.get_ref())
    }
}

impl Reader<'_> {
    /// Reads the surface before the first pass, its repeated scans and its material.
    pub(super) fn scans(&mut self, manifest: &Manifest, frame: ScanFrame) -> Result<Scans, TrialError> {
        let before = self.first_surface(manifest, frame)?;
        let same = |name: &Spanned<PathBuf>, pixels: &PixelGrid| self.same_shape(name, pixels, &before.content.pixels);
        let mut notes = before.notes.clone();
        let mut repeats = Vec::new();
        for name in &manifest.scan.repeat {
            let repeat = self.file(name, |file| read_heights(file, frame.like(&before.content.pixels)))?;
            same(name, &repeat.content.pixels)?;
            repeats.push(repeat.content);
            notes.extend(repeat.notes);
        }
        let mut material = None;
        if let Some(name) = &manifest.scan.material {
            let labels = self.file(name, |file| read_labels(file, frame.like(&before.content.pixels)))?;
            same(name, &labels.content.pixels)?;
            material = Some(labels.content);
            notes.extend(labels.notes);
        }
        self.notes.extend(notes);
        Ok(Scans { before: before.content, is_nominal: manifest.scan.nominal.is_some(), repeats, material })
    }

    /// Reads the scan after a pass.
    pub(super) fn pass_scan(&self, table: &PassTable, form: &PassForm) -> Result<Read<PassScan>, TrialError> {
        let PassForm { process, pixels, frame, .. } = *form;
        let Some(name) = &table.scan else {
            return Ok(Read { content: PassScan::missing(process.signal(), *pixels), notes: Vec::new() });
        };
        let scan = match process.signal() {
            Signal::Height => {
                self.file(name, |file| read_heights(file, frame.like(pixels)))?.converted(PassScan::Heights)
            }
            Signal::Dose => {
                self.file(name, |file| read_exposure(file, frame.like(pixels)))?.converted(PassScan::Exposure)
            }
        };
        self.same_shape(name, &scan.content.pixels(), pixels)?;
        Ok(scan)
    }

    /// Reads the surface before the first pass; a nominal one is not yet aligned.
    fn first_surface(&self, manifest: &Manifest, frame: ScanFrame) -> Result<Read<HeightMap>, TrialError> {
        match manifest.scan.first_surface(self.source)? {
            FirstSurface::Scanned(name) => self.file(name, |file| read_heights(file, frame)),
            FirstSurface::Plane(word) => {
                let pixels = self.scanned_pixels(manifest, frame)?.ok_or_else(|| {
                    self.source.bad(
                        word.span(),
                        format!("nominal = \"{PLANE}\" for a process whose scans are masks"),
                        "a file is expected, because masks show no height of the plane",
                    )
                })?;
                Ok(Read { content: HeightMap { pixels, heights: vec![0.0; pixels.len()] }, notes: Vec::new() })
            }
            FirstSurface::Drawn(name) => {
                let like = self.scanned_pixels(manifest, frame)?;
                self.file(name, |file| read_heights(file, like.map_or(frame, |pixels| frame.like(&pixels))))
            }
        }
    }

    /// Pixels of the first scan of heights after a pass; `None` if the scans are masks.
    fn scanned_pixels(&self, manifest: &Manifest, frame: ScanFrame) -> Result<Option<PixelGrid>, TrialError> {
        if manifest.process.signal() == Signal::Dose {
            return Ok(None);
        }
        let first = manifest.pass.iter().find_map(|table| table.scan.as_ref());
        let scan = first.map(|name| self.file(name, |file| read_heights(file, frame))).transpose()?;
        Ok(scan.map(|scan| scan.content.pixels))
    }

    /// Refuses a trial without passes, or without any scan after a pass.
    pub(super) fn check_passes(&self, manifest: &Manifest) -> Result<(), TrialError> {
        let place = Place::file(&self.source.file);
        if manifest.pass.is_empty() {
            return Err(place.bad("no [[pass]]", "at least one pass is expected"));
        }
        if manifest.pass.iter().all(|table| table.scan.is_none()) {
            return Err(place.bad("no [[pass]] with a scan", "scan = \"FILE\" is expected, of the last pass at least"));
        }
        Ok(())
    }

    /// Aligns a nominal surface with the scans.
    pub(super) fn align(&self, trial: &mut Trial, manifest: &Manifest) -> Result<(), TrialError> {
        let note = laid_on_scans(trial).map_err(|error| {
            Place::file(&self.source.file).bad::<TrialError>(
                format!("[scan] nominal = \"{}\" cannot be aligned: {error}", manifest.scan.first_name().display()),
                "a scan after a pass is expected that shows enough of the surface where no tool came",
            )
        })?;
        trial.notes.extend(note);
        Ok(())
    }

    /// Refuses more passes, or more pixels in all their scans, than fit into memory.
    pub(super) fn check_size(&self, manifest: &Manifest, pixels: &PixelGrid) -> Result<(), TrialError> {
        let passes = manifest.pass.len();
        let place = || Place::file(&self.source.file);
        if passes > MOST_PASSES {
            return Err(place().bad(format!("{passes} passes"), format!("at most {MOST_PASSES} are accepted")));
        }
        let scanned = (passes + manifest.scan.repeat.len() + 1) as f64 * pixels.nx as f64 * pixels.ny as f64;
        if scanned > MOST_PIXELS {
            let found = format!("{passes} passes with scans of {} x {} pixels", pixels.nx, pixels.ny);
            return Err(place().bad(found, format!("at most {MOST_PIXELS:.0e} pixels together are accepted")));
        }
        Ok(())
    }

    fn same_shape(&self, name: &Spanned<PathBuf>, found: &PixelGrid, before: &PixelGrid) -> Result<(), TrialError> {
        let shown = |pixels: &PixelGrid| format!("{} x {} pixels of {} mm", pixels.nx, pixels.ny, pixels.pitch * 1e3);
        let same_pitch = (found.pitch / before.pitch - 1.0).abs() < 1e-9;
        if (found.nx, found.ny) == (before.nx, before.ny) && same_pitch {
            return Ok(());
        }
        Err(Place::file(&self.folder.join(name.get_ref())).bad(
            shown(found),
            format!("{} as in the scan before the first pass are expected, unless that one was cut off", shown(before)),
        ))
    }
}

/// Moves a nominal surface onto the first scan after a pass, by offset and tilt where no tool came. Returns a note;
/// `None` if the scans are masks.
fn laid_on_scans(trial: &mut Trial) -> Result<Option<String>, RegistrationError> {
    let Some((passes, after)) = trial.first_scanned() else { return Ok(None) };
    let PassScan::Heights(after) = after else { return Ok(None) };
    let (after, nominal) = (despiked(after).0, &trial.scans.before);
    let clear = |surface: &HeightMap, clearance: f64| untouched_in_passes(surface, passes, &trial.tool, clearance);
    let laid = |free: &[bool]| register(&after, nominal, DegreesOfFreedom::Plane, |at| free[at]);
    // Until the surface is moved, the height of the tool above it is unknown: only pixels beside its face count.
    let rough = laid(&clear(nominal, f64::MAX)).or_else(|_| laid(&vec![true; nominal.heights.len()]))?;
    let found = laid(&clear(&moved(nominal, &rough), CLEARANCE))?;
    trial.scans.before = moved(nominal, &found);
    Ok(Some(format!(
        "no scan before the first pass: the nominal surface is used, moved by {:+.3} mm along z and tilted by {:.2} \
         mrad onto the first scan at {} pixels where no tool came; there they differ by {:.2} µm",
        1e3 * found.offset,
        1e3 * found.tilt.length(),
        found.pixels,
        1e6 * found.sigma
    )))
}

/// A map raised by the plane of a registration.
fn moved(map: &HeightMap, found: &Registration) -> HeightMap {
    let PixelGrid { nx, .. } = map.pixels;
    let raised = |(at, height): (usize, &f64)| height + found.plane(map.pixels.position(at % nx, at / nx));
    HeightMap { heights: map.heights.iter().enumerate().map(raised).collect(), ..*map }
}
