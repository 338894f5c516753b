//! Kernels put together: constants and structs written out from Rust, then the WGSL files they are made of.

use crate::constants;
use crate::layout::GridHeader;

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

/// Every kernel.
pub const KERNELS: [Kernel; 1] = [SAMPLE];

impl Kernel {
    /// The whole WGSL text that is compiled.
    pub fn text(&self) -> String {
        let files = self.sources.iter().map(|source| format!("\n// {}\n{}", source.file, source.text));
        constants::wgsl() + &GridHeader::wgsl() + &files.collect::<String>()
    }
}
