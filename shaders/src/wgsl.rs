//! Kernels put together: constants and structs written out from Rust, then the WGSL files they are made of.

use crate::constants;
use crate::layout;

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

/// The formulas of no model, in the place of those that are written out when a model is loaded.
const NO_MODEL: Source = source!("no_model.wgsl");

/// A pass of many trials.
pub const SIMULATE: Kernel = Kernel {
    entry: "simulate",
    sources: &[
        source!("trial_names.wgsl"),
        source!("trial_data.wgsl"),
        source!("trial_math.wgsl"),
        source!("trial_field.wgsl"),
        source!("trial_path.wgsl"),
        source!("trial_sheet.wgsl"),
        source!("trial_ramp.wgsl"),
        source!("trial_contact.wgsl"),
        source!("trial_lanes.wgsl"),
        NO_MODEL,
        source!("trial_step.wgsl"),
        source!("trial_apply.wgsl"),
        source!("trial_commit.wgsl"),
        source!("trial_renew.wgsl"),
        source!("trial_bricks.wgsl"),
        source!("trial_balance.wgsl"),
        source!("trial_moment.wgsl"),
        source!("trial_plan.wgsl"),
        source!("trial_seek.wgsl"),
        source!("trial_found.wgsl"),
        source!("trial_control.wgsl"),
        source!("trial_written.wgsl"),
        source!("trial_order.wgsl"),
        source!("trial_parts.wgsl"),
        source!("simulate.wgsl"),
    ],
};

/// Every kernel.
pub const KERNELS: [Kernel; 2] = [SAMPLE, SIMULATE];

impl Kernel {
    /// The whole WGSL text that is compiled; a simulation is that of no model.
    pub fn text(&self) -> String {
        self.with_formulas(NO_MODEL.text)
    }

    /// The same with the formulas of a model.
    pub fn with_formulas(&self, formulas: &str) -> String {
        let text = |source: &Source| if source.file == NO_MODEL.file { formulas } else { source.text };
        let files = self.sources.iter().map(|source| format!("\n// {}\n{}", source.file, text(source)));
        constants::wgsl() + &layout::wgsl() + &files.collect::<String>()
    }
}
