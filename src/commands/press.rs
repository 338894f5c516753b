//! `robofin press`: presses a tool into a part, holds it still, and prints force, patch and pressures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, anyhow, bail};
use clap::Args;
use effects::{CompiledModel, RowCounts, States};
use files::input::{self, MOST_MESH_BYTES};
use glam::DVec3;
use robot::{FieldTool, MeshDepth, Tool, ToolText, tool_notations};
use sdf_bake::nvdb;
use sdf_bake::{BakeOptions, BrickGrid, Mesh, bake};
use serde::Serialize;
use sim::physics::Physics;
use sim::press::Press;
use sim::{Contact, Frame, Pose, TOOL_CELLS};

use super::flags::{STIFFNESS, SignFlag, UnitFlag};
use super::model_flags::ModelFlags;
use super::values::{number, positive};
use crate::asset::{AssetFields, Manifest};
use crate::console::Console;
use crate::part::Part;
use crate::workpiece::{DEFAULT_BAND, needs_solid};
use crate::wrong_use;
use sdf_bake::memory_budget;

/// Heading of the help for the laws of the contact.
const MODEL: &str = "Model";
/// Greatest number of iterations under effects that depend on the contact's own force.
const MAX_ITERATIONS: usize = 30;
/// Half width of the band of a tool from a file [voxels]; a tool with inner walls can be pressed no deeper.
const TOOL_BAND: f64 = 8.0;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  robofin press plate.obj --tool wheel:radius=50mm,width=20mm --depth-mm 0.1 --voxel-mm 0.5\n  \
                  robofin press out/bracket --tool pad:radius=25mm --force-n 15 --at 10,4"
)]
pub(super) struct PressArgs {
    /// Mesh file, asset folder made by `robofin weld`, or .nvdb file with a grid `phi`.
    part: PathBuf,
    #[arg(long, value_name = "TOOL", help = tool_help())]
    tool: ToolText,
    #[command(flatten)]
    goal: GoalFlags,
    /// Where the tool comes down along -z: x and y of the part's frame [mm].
    #[arg(long, value_name = "X,Y", default_value = "0,0", allow_hyphen_values = true, value_parser = parse_place)]
    at: (f64, f64),
    /// Contact stiffness K: pressure per depth [Pa/m].
    #[arg(
        long,
        value_name = "PA_M",
        default_value_t = 1e10,
        conflicts_with = "model",
        allow_negative_numbers = true,
        value_parser = number(STIFFNESS),
        help_heading = MODEL
    )]
    stiffness: f64,
    /// Voxel of parts and tools that are meshes [mm].
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 0.5,
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = "Part"
    )]
    voxel_mm: f64,
    /// Unit of the coordinates in mesh files.
    #[arg(long, value_enum, default_value_t, help_heading = "Part")]
    unit: UnitFlag,
    /// Rule that distinguishes inside from outside of a mesh.
    #[arg(long, value_enum, default_value_t, help_heading = "Part")]
    sign: SignFlag,
    #[command(flatten, next_help_heading = MODEL)]
    model: ModelFlags,
}

/// Goal of the press: either a depth or a force.
#[derive(Clone, Debug, Args)]
#[group(required = true, multiple = false)]
struct GoalFlags {
    /// Depth below the first touch [mm].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = number([1e-6, 1e3]))]
    depth_mm: Option<f64>,
    /// Force to press with [N].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number([1e-6, 1e9]))]
    force_n: Option<f64>,
}

impl GoalFlags {
    fn goal(&self) -> Goal {
        match (self.depth_mm, self.force_n) {
            (Some(mm), _) => Goal::Depth(mm * 1e-3),
            (None, Some(force)) => Goal::Force(force),
            (None, None) => unreachable!("the parser insists on one"),
        }
    }
}

/// The answer of `press --json`.
#[derive(Serialize)]
struct PressAnswer {
    force_n: f64,
    /// Depth below the first touch [mm].
    depth_mm: f64,
    /// Area projected along z [mm²].
    area_mm2: f64,
    /// Length along the tool's x axis: along the feed, across a wheel's axis [mm].
    patch_length_mm: f64,
    /// Width along the tool's y axis: along a wheel's axis [mm].
    patch_width_mm: f64,
    pressure_max_pa: f64,
    pressure_mean_pa: f64,
    /// Moment about the tool's reference point [N m].
    moment_nm: [f64; 3],
    /// Position of the tool's reference point [mm].
    position_mm: [f64; 3],
    voxel_mm: f64,
}

pub(super) fn run(args: &PressArgs, console: &Console) -> Result<()> {
    let voxel = args.voxel_mm * 1e-3;
    let tool = args.tool(voxel)?;
    let law = format!("[law.winkler]\nstiffness = \"{:e} Pa/m\"\n", args.stiffness);
    let model = args.model.compile_any(&law, RowCounts::default())?;
    let part = args.part(voxel)?;

    let place = Place::over(&part, args.at, &tool)?;
    let pressed = place.press(&part, &tool, &model, args.goal.goal())?;
    let contact = &pressed.contact;
    console.step("contact", describe(&pressed));
    let point = |v: DVec3| (v * 1e3).to_array();
    console.answer(&PressAnswer {
        force_n: contact.force,
        depth_mm: pressed.depth * 1e3,
        area_mm2: contact.area * 1e6,
        patch_length_mm: pressed.patch.0 * 1e3,
        patch_width_mm: pressed.patch.1 * 1e3,
        pressure_max_pa: contact.pressure_max,
        pressure_mean_pa: contact.pressure_mean(),
        moment_nm: contact.moment.to_array(),
        position_mm: point(pressed.position),
        voxel_mm: part.voxel * 1e3,
    })
}

fn describe(pressed: &PressedTool) -> String {
    let contact = &pressed.contact;
    format!(
        "{:.4} N at {:.5} mm below the first touch\npatch of {:.4} mm², {:.3} mm long and {:.3} mm wide\n\
         pressure {:.4e} Pa at most, {:.4e} Pa in the mean\n\
         moment {:.3e}, {:.3e}, {:.3e} N m about the tool's reference point",
        contact.force,
        pressed.depth * 1e3,
        contact.area * 1e6,
        pressed.patch.0 * 1e3,
        pressed.patch.1 * 1e3,
        contact.pressure_max,
        contact.pressure_mean(),
        contact.moment.x,
        contact.moment.y,
        contact.moment.z
    )
}

/// Start pose of a tool, and its range.
struct Place {
    pose: Pose,
    /// Distance above and below the pose within which the part lies [m].
    reach: f64,
    /// Position and extent of the part, for messages.
    words: String,
}

/// Goal of the press.
#[derive(Clone, Copy)]
enum Goal {
    /// Depth below the first touch [m].
    Depth(f64),
    /// Force [N].
    Force(f64),
}

/// A tool held in contact with a part.
struct PressedTool {
    contact: Contact,
    /// Length and width of the contact patch [m].
    patch: (f64, f64),
    depth: f64,
    position: DVec3,
}

impl Place {
    /// Places a tool over the part at (x, y) [m].
    fn over(part: &BrickGrid, (x, y): (f64, f64), tool: &Tool) -> Result<Self> {
        let (low, high) = surface_bounds(part).context("the field of the part has no surface")?;
        let words = format!(
            "--at {},{}: the part spans {:.3} to {:.3} mm in x and {:.3} to {:.3} mm in y",
            x * 1e3,
            y * 1e3,
            low.x * 1e3,
            high.x * 1e3,
            low.y * 1e3,
            high.y * 1e3
        );
        let frame = match tool {
            Tool::Wheel(_) => Frame::about(DVec3::Y, DVec3::Z),
            _ => Frame::facing(DVec3::Z, DVec3::X),
        };
        let middle = 0.5 * (low.z + high.z);
        let pose = Pose { centre: DVec3::new(x, y, middle + tool.drop()), approach: DVec3::Z, frame };
        Ok(Self { pose, reach: 0.5 * (high.z - low.z) + 4.0 * part.voxel, words })
    }

    fn press(&self, part: &BrickGrid, tool: &Tool, model: &CompiledModel, goal: Goal) -> Result<PressedTool> {
        let mut states = States::new(model, TOOL_CELLS);
        let mut physics = Physics::new(model, &mut states, sim::PassSettings::default().coating);
        let setpoint = if let Goal::Force(force) = goal { force } else { 0.0 };
        physics.hold(tool, setpoint);
        let mut press = Press::new(part, tool, self.pose, self.reach).closer();
        let Some(touch) = press.touch(&mut physics)? else {
            return Err(wrong_use(format!("{}; the tool meets nothing there", self.words)));
        };
        // If no underside is found below the touch, the part's whole height is its thickness.
        let thickness = press.thickness(part).unwrap_or(2.0 * self.reach);
        // Effects may depend on the force that they change, so the contact is iterated.
        let mut last = f64::NAN;
        let mut settle = || -> Result<(f64, Contact)> {
            let travel = match goal {
                Goal::Depth(depth) => touch - depth,
                Goal::Force(force) => {
                    press.travel_for(force, &mut physics)?.with_context(|| goes_through(goal, thickness))?
                }
            };
            if touch - travel >= thickness {
                let words = goes_through(goal, thickness);
                return Err(if matches!(goal, Goal::Depth(_)) { wrong_use(words) } else { anyhow!(words) });
            }
            check_band(tool, touch - travel)?;
            Ok((travel, press.contact(travel, &mut physics)?))
        };
        let (mut travel, mut contact) = settle()?;
        for _ in 0..MAX_ITERATIONS {
            if (contact.force - last).abs() <= 1e-9 * contact.force {
                break;
            }
            last = contact.force;
            (travel, contact) = settle()?;
        }
        if let Goal::Force(force) = goal
            && (contact.force / force - 1.0).abs() > 1e-3
        {
            bail!(
                "--force-n {force}: no depth with this force was found; at {:.4} mm it is {:.4} N",
                (touch - travel) * 1e3,
                contact.force
            );
        }
        let patch = press.patch(travel, &physics)?;
        Ok(PressedTool { contact, patch, depth: touch - travel, position: self.pose.lifted(travel).centre })
    }
}

/// Message why a tool cannot be pressed into a part that is `thickness` [m] thick below it.
fn goes_through(goal: Goal, thickness: f64) -> String {
    let thickness = format!("which is {:.3} mm thick below the first touch", thickness * 1e3);
    match goal {
        Goal::Depth(depth) => format!(
            "--depth-mm {}: the tool would go right through the part, {thickness}; less than that is accepted",
            depth * 1e3
        ),
        Goal::Force(force) => format!(
            "--force-n {force}: the tool would go right through the part, {thickness}; less force or more stiffness is \
             accepted"
        ),
    }
}

/// Checks the depth against the band of a tool from a file with inner walls.
fn check_band(tool: &Tool, depth: f64) -> Result<()> {
    match tool {
        Tool::Field(field) if field.mesh.is_none() && depth > 0.9 * f64::from(field.field.band) => bail!(
            "the tool is {:.4} mm deep, and a tool from a file with walls inside is known to {:.4} mm: a larger --voxel-mm, \
             a shallower press or a mesh without walls inside is accepted",
            depth * 1e3,
            0.9e3 * f64::from(field.field.band)
        ),
        _ => Ok(()),
    }
}

/// Returns the corners of a box around the zero set, accurate to a voxel [m].
fn surface_bounds(grid: &BrickGrid) -> Option<(DVec3, DVec3)> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (slot, &brick) in grid.bricks.iter().enumerate() {
        let values = &grid.phi[slot * sdf_bake::grid::BRICK_VOXELS..][..sdf_bake::grid::BRICK_VOXELS];
        for (offset, _) in values.iter().enumerate().filter(|(_, phi)| phi.abs() <= grid.voxel as f32) {
            let at = sdf_bake::grid::voxel_at(brick, offset).as_dvec3() * grid.voxel;
            (low, high) = (low.min(at), high.max(at));
        }
    }
    (low.x <= high.x).then_some((low, high))
}

impl PressArgs {
    fn mesh(&self, path: &Path, (voxel, band_voxels): (f64, f64)) -> Result<(Mesh, BakeOptions)> {
        let mesh = Part::load(path, self.unit.into())?.mesh;
        let options = BakeOptions { voxel, band_voxels, sign: self.sign.into(), shell: None };
        memory_budget::check(&mesh, &options).with_context(|| path.display().to_string())?;
        Ok((mesh, options))
    }

    /// Reads or bakes the part's field.
    fn part(&self, voxel: f64) -> Result<BrickGrid> {
        let path = &self.part;
        if path.is_dir() {
            Manifest::read(path)?;
            return Ok(AssetFields::open(path)?.welded);
        }
        let context = || path.display().to_string();
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("nvdb")) {
            if !path.exists() {
                return Err(wrong_use(format!("{}: no such file", path.display())));
            }
            let file = nvdb::read(&input::read(path, MOST_MESH_BYTES)?).with_context(context)?;
            let phi = file.grid("phi").with_context(|| format!("{}: no grid `phi`", path.display()))?;
            return phi.to_bricks().with_context(context);
        }
        let (mesh, options) = self.mesh(path, (voxel, DEFAULT_BAND))?;
        Ok(bake(&mesh, &options).map_err(needs_solid).with_context(context)?.0)
    }

    /// Returns the requested tool.
    fn tool(&self, voxel: f64) -> Result<Tool> {
        match &self.tool {
            ToolText::Solid(tool) => Ok(tool.clone()),
            ToolText::Mesh(file) => self.tool_of_mesh(file, voxel),
        }
    }

    /// Makes a tool from a mesh file, lowered until its lowest point is at z = 0.
    fn tool_of_mesh(&self, path: &Path, voxel: f64) -> Result<Tool> {
        let (mut mesh, options) = self.mesh(path, (voxel, TOOL_BAND))?;
        let lowest = mesh.bounds().map_or(0.0, |(low, _)| low.z);
        mesh.positions.iter_mut().for_each(|position| position.z -= lowest);
        let (low, high) = mesh.bounds().unwrap_or_default();
        let (field, report) = bake(&mesh, &options).map_err(needs_solid).with_context(|| path.display().to_string())?;
        let exact = (report.inner_triangles == 0).then(|| Arc::new(MeshDepth::new(&mesh)));
        Ok(Tool::Field(FieldTool { field: Arc::new(field), low, high, mesh: exact }))
    }
}

/// Help of `--tool`.
fn tool_help() -> String {
    format!("{}; a mesh comes down as it is in its file, and a wheel turns about y", tool_notations())
}

/// Parses `X,Y` [mm]; returns metres.
fn parse_place(text: &str) -> Result<(f64, f64), String> {
    let place = text.split_once(',').and_then(|(x, y)| {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|mm| mm.abs() < 1e6);
        Some((number(x)? * 1e-3, number(y)? * 1e-3))
    });
    place.ok_or_else(|| "x and y [mm] are expected, each within 1e6, for example 12.5,-4".to_owned())
}
