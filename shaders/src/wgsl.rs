//! Kernels put together: constants and structs written out from Rust, then the WGSL files they are made of.

use crate::constants;
use crate::layout::GridHeader;
use crate::stage::RenderStage;

/// A WGSL file of this crate.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// File name in `src/wgsl/`.
    pub file: &'static str,
    /// Its text.
    pub text: &'static str,
}

macro_rules! source {
    ($file:literal) => {
        Source { file: $file, text: include_str!(concat!("wgsl/", $file)) }
    };
}

/// An entry point and what it is compiled from.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name of the entry point, the stem of its file.
    pub entry: &'static str,
    /// The files, what is called before what calls it.
    pub sources: &'static [Source],
}

/// φ at a list of points.
pub const SAMPLE: Kernel = Kernel { entry: "sample", sources: &[source!("brick_grid.wgsl"), source!("sample.wgsl")] };

/// Blocks of each brick that a ray must look into.
pub const OCCUPANCY: Kernel =
    Kernel { entry: "occupancy", sources: &[source!("brick_grid.wgsl"), source!("occupancy.wgsl")] };

/// A picture of a scene.
pub const RENDER: Kernel = Kernel {
    entry: "render",
    sources: &[
        source!("brick_grid.wgsl"),
        source!("cubic.wgsl"),
        source!("walk.wgsl"),
        source!("surface.wgsl"),
        source!("microfacet.wgsl"),
        source!("marks.wgsl"),
        source!("lights.wgsl"),
        source!("camera.wgsl"),
        source!("render.wgsl"),
    ],
};

/// Every kernel.
pub const KERNELS: [Kernel; 3] = [SAMPLE, OCCUPANCY, RENDER];

impl Kernel {
    /// The whole WGSL text that is compiled.
    pub fn text(&self) -> String {
        let files = self.sources.iter().map(|source| format!("\n// {}\n{}", source.file, source.text));
        constants::wgsl() + &GridHeader::wgsl() + &RenderStage::wgsl() + &files.collect::<String>()
    }
}
