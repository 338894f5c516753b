//! Geometry buffers of a tile, computed in lanes from its image positions.

use glam::{DVec3, IVec3, Vec3};
use sdf_bake::grid::trilinear;

use super::frame::VisibleObject;
use super::lanes::{LANES, Lanes, Points, any};
use super::lockstep::Crossings;
use super::padded::Cells;
use super::ray_packet::common_clear_length;
use super::rays::{ImagePositions, Rays, Wide};
use super::scene::{FIRST_OBSTACLE, FIRST_TOOL, Stage};
use super::surface::{LABEL_DEPTH, WeldCell, scalars_of};
use super::walk::integers;

/// Surface samples at the rays' hits; all values except directions are zero without a hit.
pub(crate) struct Samples {
    /// Unit directions of the rays.
    pub(crate) directions: Points,
    /// Metal of the field: the part, an obstacle or the tool.
    pub(crate) is_solid: [bool; LANES],
    pub(crate) is_table: [bool; LANES],
    /// Distance along the camera's axis [m]; infinite without a hit.
    pub(crate) depth: Lanes,
    /// Positions in the part's frame [m].
    pub(crate) positions: Points,
    /// Positions relative to the lowest voxel of the index [voxels].
    pub(crate) points: Points,
    /// Outward unit normals.
    pub(crate) normals: Points,
    /// Weld ids, 0 for base metal and obstacles.
    pub(crate) weld: [u16; LANES],
    /// Labels of obstacles and of the tool, 0 for the part.
    pub(crate) obstacle: [u16; LANES],
    /// Share of weld metal around the points, 0 to 1.
    pub(crate) weld_share: Lanes,
    pub(crate) dose: Lanes,
    /// Removed depth [m].
    pub(crate) removed: Lanes,
}

impl Samples {
    /// Samples without rays.
    const NONE: Self = Self {
        directions: Points::ZERO,
        is_solid: [false; LANES],
        is_table: [false; LANES],
        depth: [f32::INFINITY; LANES],
        positions: Points::ZERO,
        points: Points::ZERO,
        normals: Points::ZERO,
        weld: [0; LANES],
        obstacle: [0; LANES],
        weld_share: [0.0; LANES],
        dose: [0.0; LANES],
        removed: [0.0; LANES],
    };

    /// Object that a lane shows.
    #[inline(always)]
    pub(crate) fn seen(&self, lane: usize) -> VisibleObject {
        match (self.is_solid[lane], self.is_table[lane]) {
            (true, _) if self.obstacle[lane] >= FIRST_TOOL => VisibleObject::Tool,
            (true, _) if self.obstacle[lane] > 0 => VisibleObject::Obstacle,
            (true, _) => VisibleObject::Part,
            (false, true) => VisibleObject::Table,
            (false, false) => VisibleObject::Background,
        }
    }
}

/// Rays through image positions, and the surfaces that they meet; compiled by `pulp` for each instruction set.
pub(crate) struct PrimaryRays<'a> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) at: &'a ImagePositions,
    /// Length from the start of each ray that is known to be free of metal [m].
    pub(crate) clear: f64,
}

/// Length from the start of each ray between some image positions that is free of metal [m]; compiled by `pulp` for
/// each instruction set.
pub(crate) struct Clear<'a> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) at: &'a ImagePositions,
}

impl pulp::NullaryFnOnce for Clear<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { stage, at } = self;
        let rays = stage.rays(at);
        common_clear_length(&stage.scene.field, &rays, 0.0)
    }
}

impl pulp::NullaryFnOnce for PrimaryRays<'_> {
    type Output = Samples;

    #[inline(always)]
    fn call(self) -> Samples {
        let (stage, field) = (self.stage, &self.stage.scene.field);
        let rays = stage.rays(self.at);
        let clear = common_clear_length(field, &rays, self.clear);
        let distances = if clear < f64::INFINITY {
            Crossings { field, padded: field.padded(), rays: &rays, clear }.call()
        } else {
            [f64::INFINITY; LANES]
        };
        let mut samples = Samples::NONE;
        let at = self.place(&rays, &distances, &mut samples);
        if any(&samples.is_solid) {
            self.look(&at, &mut samples);
        }
        samples
    }
}

// Everything below is inlined into that call, so that it is compiled for the same instruction set.

impl PrimaryRays<'_> {
    /// Finds the positions where rays meet part or table. Returns them relative to the lowest voxel of the index,
    /// rounded once [voxels].
    #[inline(always)]
    fn place(&self, rays: &Rays, distances: &Wide, samples: &mut Samples) -> Points {
        let (stage, field) = (self.stage, &self.stage.scene.field);
        let tables = self.table_distances(rays);
        let mut reached = [0.0; LANES];
        for i in 0..LANES {
            let (part, table) = (distances[i], tables[i]);
            let (is_solid, is_table) = ((part <= table) & (part < f64::INFINITY), table < f64::INFINITY);
            samples.is_solid[i] = rays.wanted[i] & is_solid;
            samples.is_table[i] = rays.wanted[i] & !is_solid & is_table;
            reached[i] = if is_solid { part } else { table };
            samples.directions.set(i, rays.direction(i).as_vec3());
        }
        let (points, up, mut at) = (rays.points(&reached), stage.up.as_vec3(), Points::ZERO);
        for i in 0..LANES {
            let point = DVec3::new(points[0][i], points[1][i], points[2][i]);
            let (position, is_met) = (point.as_vec3(), samples.is_solid[i] | samples.is_table[i]);
            let select = |wanted: bool, point: Vec3| if wanted { point } else { Vec3::ZERO };
            samples.depth[i] = if is_met { stage.depth(point, self.at.down[i]) as f32 } else { f32::INFINITY };
            samples.positions.set(i, select(is_met, position));
            samples.points.set(i, select(is_met, field.in_voxels(position.as_dvec3())));
            samples.normals.set(i, select(is_met, up));
            at.set(i, select(is_met, field.in_voxels(point)));
        }
        at
    }

    /// Distances along the rays to the table's top [m]; infinite for rays that miss it or start below it.
    #[inline(always)]
    fn table_distances(&self, rays: &Rays) -> Wide {
        let mut distances = [f64::INFINITY; LANES];
        if self.stage.table == f64::NEG_INFINITY {
            return distances;
        }
        for i in 0..LANES {
            let height = rays.origin(i).dot(self.stage.up) - self.stage.table;
            let fall = -rays.direction(i).dot(self.stage.up);
            let meets = (height > 0.0) & (height < f64::INFINITY) & (fall > 1e-9);
            distances[i] = if meets { height / fall } else { f64::INFINITY };
        }
        distances
    }

    /// Reads normals and channels of the grid where rays meet the part.
    #[inline(always)]
    fn look(&self, at: &Points, samples: &mut Samples) {
        let field = &self.stage.scene.field;
        let (padded, is_solid) = (field.padded(), samples.is_solid);
        let part = || (0..LANES).filter(|&i| is_solid[i]);
        let mut cells = Cells::new(field.grid.band);
        cells.low = at.corners(&Points::ZERO);
        padded.find(&mut cells);
        let (mut differences, mut scalars) = (Points::ZERO, Last { low: Vec3::NAN, found: [[0.0; 8]; 2] });
        for i in part() {
            let (low, within) = (cells.low.get(i), at.get(i) - cells.low.get(i));
            differences.set(i, padded.differences(&cells, i, within));
            if !padded.is_plain(&cells, i) {
                let scalars = scalars.of(low, |corner| scalars_of(field, corner));
                [samples.dose[i], samples.removed[i]] = scalars.map(|values| trilinear(&values, within));
            }
        }
        for i in 0..LANES {
            let normal = differences.get(i).normalize_or(-samples.directions.get(i));
            samples.normals.set(i, if is_solid[i] { normal } else { samples.normals.get(i) });
        }
        let below = at.moved(&samples.normals, &[-LABEL_DEPTH; LANES]);
        cells.low = below.corners(&Points::ZERO);
        padded.find(&mut cells);
        let mut welds = Last { low: Vec3::NAN, found: WeldCell::NONE };
        for i in part() {
            let low = cells.low.get(i);
            (samples.weld[i], samples.weld_share[i]) = match padded.label(&cells, i) {
                Some(label) => (label, f32::from(label.min(1))),
                None => welds.of(low, |corner| WeldCell::new(field, corner)).at(below.get(i) - low),
            };
            if samples.weld[i] >= FIRST_OBSTACLE {
                samples.obstacle[i] = std::mem::take(&mut samples.weld[i]);
                (samples.weld_share[i], samples.dose[i], samples.removed[i]) = (0.0, 0.0, 0.0);
            }
        }
    }
}

/// Result for the cell that was read last, which neighbouring samples often share.
struct Last<T> {
    low: Vec3,
    found: T,
}

impl<T> Last<T> {
    #[inline(always)]
    fn of(&mut self, low: Vec3, look: impl FnOnce(IVec3) -> T) -> &T {
        let is_known = self.low == low;
        if !is_known {
            *self = Self { low, found: look(integers(low.into())) };
        }
        &self.found
    }
}
