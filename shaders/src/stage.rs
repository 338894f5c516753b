//! Scene description for the kernel `render`, besides the part; all in the part's frame.

use bytemuck::{Pod, Zeroable};

use crate::layout::{SharedType, shared_struct};

shared_struct! {
    /// Camera, lights and materials in the part's frame.
    RenderStage {
        /// Centre of projection [voxels], from the lowest voxel of the index; the fourth is 0.
        eye: [f32; 4],
        /// Unit direction towards the right of the image; the fourth is 0.
        right: [f32; 4],
        /// Unit direction towards the top of the image; the fourth is 0.
        image_up: [f32; 4],
        /// Unit direction into the scene; the fourth is 0.
        forward: [f32; 4],
        /// Distortion k1, k2, k3, p1 of the lens.
        lens: [f32; 4],
        /// Unit direction that is up in the scene; the fourth is 0.
        up: [f32; 4],
        /// Radiance from straight above, linear RGB; the fourth is 0.
        sky: [f32; 4],
        /// Radiance added at the horizon; the fourth is 0.
        horizon: [f32; 4],
        /// Radiance from straight below; the fourth is 0.
        floor: [f32; 4],
        /// Colour and roughness of base metal.
        metal: [f32; 4],
        /// Colour and roughness of weld metal.
        weld: [f32; 4],
        /// Colour and roughness of ground metal.
        ground: [f32; 4],
        /// Colour and roughness of the coating.
        coating: [f32; 4],
        /// Colour and roughness of the table.
        table_top: [f32; 4],
        /// Metallic response of base, weld and ground metal and of the coating.
        metallic: [f32; 4],
        /// Distortion p2 of the lens.
        lens_askew: f32,
        /// Width of the image divided by its height.
        aspect: f32,
        /// Half the height of the image: at unit distance, or for parallel rays in [m].
        half_image: f32,
        /// Offset of a ray across a border [voxels].
        nudge: f32,
        /// Height of the table along `up` [voxels].
        table: f32,
        /// Metallic response of the table.
        table_metallic: f32,
        /// Removed depth above which metal looks ground [m].
        ground_depth: f32,
        /// Width of a grinding mark [m].
        mark_width: f32,
        /// Slope of its flanks.
        mark_slope: f32,
        /// Reduction of the roughness of ground metal along the marks, 0 to 1.
        mark_anisotropy: f32,
        /// Pixels along a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Colour samples along each side of a pixel.
        samples_per_side: u32,
        /// Number of lamps in the rows.
        lamps: u32,
        /// Number of points of the marks' path in the rows.
        marks: u32,
        /// 1 for parallel rays.
        parallel: u32,
        /// 1 if there is a table.
        has_table: u32,
        /// 1 if the part is coated.
        has_coating: u32,
        /// 1 if the grid has weld ids.
        has_label: u32,
        /// 1 if it has a dose.
        has_dose: u32,
        /// 1 if it has removed depths.
        has_removed: u32,
        /// Padding.
        padding_a: u32,
        /// Padding.
        padding_b: u32,
        /// Padding.
        padding_c: u32,
    }
}
