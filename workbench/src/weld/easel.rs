//! The welds of one part for the flags of the page, and pictures of them.

use glam::DVec3;
use render::{Frame, Picture, View, render};
use sdf_bake::{BakeError, BakeOptions, BrickGrid, Combine, Mesh, SignChoice, bake, memory_budget};
use weldgen::{Surface, Weld, WeldRequest, place_welds_on};

use super::flags::Flags;
use crate::error::Refusal;
use crate::part::{Shot, Size, painted, threads};

/// Voxels along the longest side of the part while a dial moves, and at rest.
const ACROSS: [f64; 2] = [96.0, 192.0];
/// Voxel of a picture down to which a part with thin walls is tried [longest sides].
const FINEST: f64 = 1.0 / 384.0;
/// Half width of the band [voxels], the default of `robofin weld`.
const BAND: f64 = 3.0;
/// Colours of the part and of weld metal.
const PART: [u8; 3] = [0xb4, 0xbc, 0xc6];
const WELD: [u8; 3] = [0xd5, 0x5e, 0x00];

/// A mesh from a file.
pub(super) struct ReadPart {
    /// The cleaned mesh [m].
    pub(super) mesh: Mesh,
    /// Reason for the unit, notes of the reader, repairs.
    pub(super) notes: Vec<String>,
}

/// A part, its fields without a weld, and the welds of the last flags.
pub(crate) struct Easel<'a> {
    pub(super) part: &'a ReadPart,
    surface: Surface<'a>,
    /// Rule of the inside of the fields in `bare`.
    sign: SignChoice,
    bare: [Option<Result<BrickGrid, String>>; 2],
    last: Option<Drawn>,
}

/// Welds of some flags.
struct Drawn {
    flags: Flags,
    placed: Placed,
    fields: [Option<BrickGrid>; 2],
}

/// Welds, or the reason why there is none.
pub(super) type Placed = Result<Vec<Weld>, String>;

impl<'a> Easel<'a> {
    /// Prepares a part.
    pub(super) fn new(part: &'a ReadPart, surface: Surface<'a>) -> Self {
        Self { part, surface, sign: SignChoice::Auto, bare: [None, None], last: None }
    }

    /// Longest side of the part [m].
    pub(super) fn longest(&self) -> f64 {
        longest(&self.part.mesh)
    }

    /// Request of some flags for the field that `robofin weld` makes.
    pub(super) fn request(&self, flags: &Flags) -> (WeldRequest, BakeOptions) {
        let baking = baking(self.longest() / f64::from(flags.across), flags.sign);
        (flags.settings.request(&self.part.mesh, baking.voxel), baking)
    }

    /// Places the welds of some flags, as `robofin weld` does; those of the last flags are kept.
    pub(super) fn placed(&mut self, flags: &Flags) -> &Placed {
        if self.last.as_ref().is_none_or(|last| last.flags != *flags) {
            let placed = threads().install(|| self.place(flags));
            self.last = Some(Drawn { flags: flags.clone(), placed, fields: [None, None] });
        }
        // It was set above.
        self.last.as_ref().map_or(const { &Ok(Vec::new()) }, |last| &last.placed)
    }

    fn place(&mut self, flags: &Flags) -> Placed {
        let (request, baking) = self.request(flags);
        memory_budget::check(&self.part.mesh, &baking).map_err(|error| error.to_string())?;
        flags.settings.check(&request, &baking).map_err(|fault| fault.to_string())?;
        self.bare(0, flags.sign).as_ref().map_err(Clone::clone)?;
        let count = usize::from(flags.settings.count.unwrap_or(1));
        let placed = place_welds_on(&self.surface, &request, count, flags.seed).map_err(|error| error.to_string())?;
        for weld in &placed {
            flags.settings.check_toes(&weld.profile, &baking).map_err(|fault| fault.to_string())?;
        }
        Ok(placed)
    }

    /// Field of the part alone at a fineness; made once.
    fn bare(&mut self, fineness: usize, sign: SignChoice) -> &Result<BrickGrid, String> {
        if self.sign != sign {
            (self.sign, self.bare) = (sign, [None, None]);
        }
        let voxel = self.longest() / ACROSS[fineness];
        let mesh = &self.part.mesh;
        self.bare[fineness].get_or_insert_with(|| threads().install(|| bare(mesh, voxel, sign)))
    }

    /// Field of the part with the welds of the last flags.
    fn welded(&mut self, fineness: usize, flags: &Flags) -> Result<BrickGrid, String> {
        let bare = self.bare(fineness, flags.sign).clone()?;
        let welds = self.placed(flags).as_deref().unwrap_or_default();
        let options = baking(bare.voxel, flags.sign);
        let add = |field: BrickGrid, (weld, id)| with_bead(&field, weld, id, &options);
        threads().install(|| welds.iter().zip(1..).try_fold(bare, add))
    }

    /// Draws the part with its welds, or alone if there is none.
    ///
    /// # Errors
    /// If the part has no field.
    pub(crate) fn picture(&mut self, flags: &Flags, shot: &Shot) -> Result<Picture, Refusal> {
        shot.size.check()?;
        let fineness = usize::from(shot.size.fine);
        self.placed(flags);
        let known = self.last.as_mut().and_then(|last| last.fields[fineness].take());
        let field = match known {
            Some(field) => field,
            None => self.welded(fineness, flags).map_err(Refusal::wrong)?,
        };
        let picture = threads().install(|| self.drawn(&field, shot));
        if let Some(last) = &mut self.last {
            last.fields[fineness] = Some(field);
        }
        Ok(picture)
    }

    fn drawn(&self, field: &BrickGrid, shot: &Shot) -> Picture {
        let (low, high) = self.part.mesh.bounds().unwrap_or((DVec3::ZERO, DVec3::ONE));
        let Size { width, height, fine } = shot.size;
        let camera = shot.turn.camera_on(low, high, (width, height));
        let view = View { width, height, samples_per_side: if fine { 2 } else { 1 }, removed: None };
        let frame: Frame = render(field, &camera, &view);
        painted(&frame, |at| if frame.weld[at] == 0 { PART } else { WELD })
    }
}

fn baking(voxel: f64, sign: SignChoice) -> BakeOptions {
    BakeOptions { voxel, band_voxels: BAND, sign, shell: None }
}

/// Bakes the part alone, with smaller voxels where its walls are thinner than one.
fn bare(mesh: &Mesh, voxel: f64, sign: SignChoice) -> Result<BrickGrid, String> {
    match bake(mesh, &baking(voxel, sign)) {
        Err(BakeError::NoInside { .. }) if voxel > FINEST * longest(mesh) => bare(mesh, 0.5 * voxel, sign),
        baked => baked.map(|(field, _)| field).map_err(in_words),
    }
}

/// Longest side of a mesh [m].
fn longest(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element())
}

/// Unites a field with the bead of a weld; at the voxels of a picture, round toes do not show.
fn with_bead(field: &BrickGrid, weld: &Weld, id: u16, options: &BakeOptions) -> Result<BrickGrid, String> {
    let (bead, _) = bake(&weld.bead, options).map_err(in_words)?;
    let united = field.united_with(&bead, id).map_err(|error| error.to_string())?;
    if weld.cuts.triangles.is_empty() {
        return Ok(united);
    }
    let (cuts, _) = bake(&weld.cuts, options).map_err(in_words)?;
    united.combined_with(&cuts, Combine::Difference).map_err(|error| error.to_string())
}

/// Words of a field that cannot be made; a shell, which only `robofin bake` makes, is not offered.
fn in_words(error: BakeError) -> String {
    match error {
        BakeError::Open { boundary_edges, share } => format!(
            "the surface is open: {boundary_edges} boundary edges leave {:.1} % of its neighbourhood without a clear inside, \
             and a weld needs a solid part; close the mesh, or choose to accept the guess",
            100.0 * share
        ),
        BakeError::NoInside { boundary_edges, .. } => format!(
            "the surface encloses nothing ({boundary_edges} boundary edges): it is a sheet, or thinner than a voxel, and a \
             weld needs a solid part; give it a thickness"
        ),
        other => other.to_string(),
    }
}
