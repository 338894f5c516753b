//! Sections across a weld: the outline before and after grinding.

use sdf_bake::BrickGrid;
use sim::surface::way_to_surface;

use crate::asset::WeldTruth;
use crate::finishing::Ground;
use report::{Chart, Series, WIDE};

/// Number of points of an outline.
const POINTS: usize = 240;
/// Half width of a section [bead widths].
const REACH: f64 = 0.85;

/// Draws the outline across the middle of the weld, as welded and as ground, as SVG.
pub(super) fn middle_section(ground: &Ground) -> String {
    let middle = ground.weld.curve.position.len() / 2;
    let outline = |name: &str, grid: &BrickGrid| Series::new(name, outline(grid, &ground.weld, middle));
    let series = [outline("as welded", &ground.before), outline("as ground", &ground.run.state.part)];
    Chart {
        title: "Section across the middle of the weld",
        x_label: "across the weld [mm]",
        y_label: "height above the part [mm]",
        series: &series,
        size: WIDE,
        from_zero: true,
        band: None,
    }
    .to_svg()
}

/// Offsets across the weld and heights above its centreline [mm]; a line that meets no surface gives no point.
fn outline(grid: &BrickGrid, weld: &WeldTruth, at: usize) -> Vec<(f64, f64)> {
    let curve = &weld.curve;
    let (centre, normal, side) = (curve.position[at], curve.normal[at], curve.side[at]);
    let (reach, lift) = (REACH * 1e-3 * weld.width_mm, 2e-3 * weld.height_mm);
    let height = |i: usize| {
        let offset = reach * (2.0 * i as f64 / (POINTS - 1) as f64 - 1.0);
        let way = way_to_surface(grid, centre + side * offset + normal * lift, normal, 2.0 * lift)?;
        Some((offset * 1e3, (lift + way) * 1e3))
    };
    (0..POINTS).filter_map(height).collect()
}
