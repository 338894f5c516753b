//! Welds a part: a weld is placed, swept and united with the part in the field.

use anyhow::{Context, Result, anyhow, bail};
use sdf_bake::query::MeshQuery;
use sdf_bake::{BakeError, BakeOptions, BakeReport, BrickGrid, Combine, Mesh, SignChoice, bake};
use serde::Serialize;
pub use weldgen::WeldSettings;
use weldgen::{PlaceError, Surface, Weld, WeldRequest, place_welds_on};

use crate::console::Console;
use crate::part::Part;
use sdf_bake::memory_budget;

/// Weld id of the first weld.
pub const FIRST_WELD: u16 = 1;

/// Default half width of the band [voxels].
pub const DEFAULT_BAND: f64 = 3.0;

/// Voxel size of a field, given in one of three ways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fineness {
    /// Number of voxels along the part's longest side.
    Resolution(u32),
    /// Number of voxels along the diagonal of the part's bounding box.
    Diagonal(u32),
    /// Distance between voxels [m].
    Voxel(f64),
}

/// Options of welding a part.
#[derive(Clone, Debug, Serialize)]
pub struct WeldingOptions {
    /// Seed of every random choice.
    pub seed: u64,
    /// Voxel size.
    pub fineness: Fineness,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Sign rule.
    pub sign: SignChoice,
    /// Requested properties of the weld; the others are chosen for the part.
    pub wishes: WeldSettings,
}

/// A part with its welds, as meshes and as fields.
pub struct Workpiece {
    /// The part before welding.
    pub part: Part,
    /// The welds, in order of their id.
    pub welds: Vec<PlacedWeld>,
    /// Field of the part alone: the target of finishing.
    pub target: BrickGrid,
    /// Field of part and welds, with weld labels.
    pub welded: BrickGrid,
    /// Report of baking the part.
    pub baking: BakeReport,
}

/// A weld of a workpiece.
pub struct PlacedWeld {
    /// Weld id in labels; 0 is base metal.
    pub id: u16,
    /// Curve, frames, bead mesh.
    pub weld: Weld,
    /// Volume that it adds to the part [m³], measured in the field.
    pub volume: f64,
    /// Least radius of its toes in the field [m]; 0 for sharp ones.
    pub toe_radius: f64,
}

/// Describes why a part that must be a solid cannot be baked, without remedies that only `robofin bake` offers.
pub fn needs_solid(error: BakeError) -> anyhow::Error {
    match error {
        BakeError::Open { boundary_edges, share } => anyhow!(
            "open surface: {boundary_edges} boundary edges leave {:.1} % of the band without a clear inside, and a solid part \
             is needed; close the mesh, or use --sign winding to accept the guess",
            100.0 * share
        ),
        BakeError::NoInside { voxel, boundary_edges, share } => anyhow!(
            "the surface encloses nothing at a voxel of {:.4} mm ({boundary_edges} boundary edges, {:.1} % of the band without a \
             clear inside), and a solid part is needed: use a smaller voxel, or give a sheet a thickness",
            1e3 * voxel,
            100.0 * share
        ),
        other => other.into(),
    }
}

impl Workpiece {
    /// Lists implausible or unmet properties, one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let of_welds = self.welds.iter().flat_map(|placed| placed.weld.warnings());
        self.part.source.unit_doubts.iter().cloned().chain(of_welds).collect()
    }
}

impl Fineness {
    /// Returns the distance between voxels [m] for a part.
    pub fn voxel(self, part: &Part) -> f64 {
        match self {
            Self::Resolution(across) => part.extent().max_element() / f64::from(across),
            Self::Diagonal(across) => part.extent().length() / f64::from(across),
            Self::Voxel(voxel) => voxel,
        }
    }
}

/// Welds a part: bake the part, place a weld, sweep its bead, bake the bead, unite.
///
/// # Errors
/// If the part has no clear inside, or no weld fits it; the message states what would help.
pub fn weld_part(part: Part, options: &WeldingOptions, console: &Console) -> Result<Workpiece> {
    let baking = BakeOptions {
        voxel: options.fineness.voxel(&part),
        band_voxels: options.band_voxels,
        sign: options.sign,
        shell: None,
    };
    memory_budget::check(&part.mesh, &baking)?;
    let request = options.wishes.request(&part.mesh, baking.voxel);
    options.wishes.check(&request, &baking)?;
    let welds = place(&part, options, (&request, &baking))?;
    let (target, report) = bake(&part.mesh, &baking).map_err(needs_solid)?;
    console.step("bake", describe_baking(&report, &target));

    if console.reports_steps()
        && let Some(warning) = describe_volume(&part.mesh, &target)
    {
        console.step("note", warning);
    }

    let (mut welded, mut placed) = (target.clone(), Vec::new());
    for (id, weld) in (FIRST_WELD..).zip(welds?) {
        report_weld(&weld, console);
        let mut with_bead = add(&welded, &weld, id, (&baking, options.wishes.toe_radius))?;
        if !weld.cuts.triangles.is_empty() {
            with_bead = cut(&with_bead, &weld, (&baking, &target), id)?;
        }
        let volume = with_bead.difference_volume(&welded);
        if volume.is_nan() || volume <= 0.0 {
            bail!("the bead adds nothing to the part at a voxel of {:.4} mm", baking.voxel * 1e3);
        }
        console.step("unite", format!("the bead adds {:.2} mm³", volume * 1e9));
        welded = with_bead;
        placed.push(PlacedWeld { id, weld, volume, toe_radius: options.wishes.toe_radius.unwrap_or(0.0) });
    }
    Ok(Workpiece { part, welds: placed, target, welded, baking: report })
}

/// Places the welds on a part. The inner error is the reason why none fits; it is reported only if the part can be
/// baked.
///
/// # Errors
/// If the toes of a weld cannot have the requested radius.
fn place(
    part: &Part,
    options: &WeldingOptions,
    (request, baking): (&WeldRequest, &BakeOptions),
) -> Result<Result<Vec<Weld>, PlaceError>> {
    let query = MeshQuery::new(&part.mesh);
    let count = usize::from(options.wishes.count.unwrap_or(1));
    let placed = place_welds_on(&Surface::new(&part.mesh, &query), request, count, options.seed);
    for weld in placed.iter().flatten() {
        options.wishes.check_toes(&weld.profile, baking)?;
    }
    Ok(placed)
}

/// Adds a weld to the field: its bead is united with sharp or rounded toes.
fn add(
    welded: &BrickGrid,
    weld: &Weld,
    id: u16,
    (baking, toe_radius): (&BakeOptions, Option<f64>),
) -> Result<BrickGrid> {
    let (bead, _) = bake(&weld.bead, baking)?;
    let Some(radius) = toe_radius else { return Ok(welded.united_with(&bead, id)?) };
    let blended = welded.blended_with(&bead, id, weld.profile.blend_radius(radius));
    blended.with_context(|| format!("--toe-radius-mm {:?}", 1e3 * radius))
}

/// Subtracts a weld's imperfections from the field. Newly open surface moves the border of the weld metal, so
/// unlabelled voxels that now hold some get the weld's id.
fn cut(welded: &BrickGrid, weld: &Weld, (baking, target): (&BakeOptions, &BrickGrid), id: u16) -> Result<BrickGrid> {
    let (cuts, _) = bake(&weld.cuts, baking)?;
    let mut left = welded.combined_with(&cuts, Combine::Difference)?;
    let share = left.difference_share(target);
    for (label, _) in left.label.iter_mut().zip(share).filter(|(label, share)| **label == 0 && *share > 0.0) {
        *label = id;
    }
    Ok(left)
}

fn report_weld(weld: &Weld, console: &Console) {
    console.step("weld", describe_weld(weld));
    for warning in weld.warnings() {
        console.step("warning", warning);
    }
}

fn describe_weld(weld: &Weld) -> String {
    let curve = &weld.curve;
    format!(
        "{:.2} mm long, {:.2} mm wide, {:.2} mm high, curvature {:.2} 1/m rms, exposure {:.2} at least, access {:.2}\n{}",
        curve.length() * 1e3,
        weld.profile.width * 1e3,
        weld.profile.height * 1e3,
        weld.curvature_rms,
        weld.min_exposure,
        weld.mean_access,
        weld.reasons.join("\n")
    )
}

/// Relative difference between the volumes of mesh and field from which it is reported.
const VOLUME_NOTE: f64 = 0.05;

/// Returns a note if the field does not hold the volume of the mesh.
fn describe_volume(mesh: &Mesh, field: &BrickGrid) -> Option<String> {
    let share = field.volume() / mesh.volume();
    if (share - 1.0).abs() <= VOLUME_NOTE {
        return None;
    }
    Some(format!(
        "the field holds {:.1} % of the volume that the triangles enclose: bodies overlap, the surface is open, or walls are \
         thinner than a voxel; a finer --resolution shows which",
        100.0 * share
    ))
}

/// Describes the baking of a part for people.
pub fn describe_baking(report: &BakeReport, grid: &BrickGrid) -> String {
    let mut line = format!(
        "voxel {:.4} mm, {} bricks, {} active voxels, {:.1} MB\ninside by {} ({})",
        report.voxel_m * 1e3,
        report.bricks,
        report.active_voxels,
        grid.bytes() as f64 / 1e6,
        report.sign_method,
        report.sign_reason
    );
    if report.inner_triangles > 0 {
        line += &format!(
            "\n{} triangles lie inside another body, or partly: the bodies are united",
            report.inner_triangles
        );
    }
    if report.boundary_edges > 0 {
        line += &format!(
            "\nopen surface: {} boundary edges, {:.2} % of the band without a clear inside",
            report.boundary_edges,
            100.0 * report.ambiguous_share
        );
    }
    line
}
