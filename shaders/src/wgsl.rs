//! Assembly of kernels: constants and structs written out from Rust, followed by WGSL files.

use crate::constants;
use crate::layout;
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
    (concat!($entry:literal, $end:literal)) => {
        Source { file: concat!($entry, $end), text: include_str!(concat!("wgsl/", $entry, $end)) }
    };
}

/// An entry point and its sources.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name of the entry point, the stem of its file.
    pub entry: &'static str,
    /// The files; callees come before callers.
    pub sources: &'static [Source],
}

/// φ at a list of points.
pub const SAMPLE: Kernel = Kernel { entry: "sample", sources: &[source!("brick_grid.wgsl"), source!("sample.wgsl")] };

/// Formulas without a model, a placeholder for those that are written out when a model is loaded.
const NO_MODEL: Source = source!("no_model.wgsl");

macro_rules! simulation {
    ($entry:literal, [$($file:literal),* $(,)?]) => {
        Kernel {
            entry: $entry,
            sources: &[
                source!("trial_names.wgsl"),
                source!("trial_data.wgsl"),
                source!("trial_math.wgsl"),
                source!("trial_facing.wgsl"),
                source!("trial_field.wgsl"),
                source!("trial_path.wgsl"),
                source!("trial_height_field.wgsl"),
                source!("trial_ramp.wgsl"),
                source!("trial_contact.wgsl"),
                source!("trial_tool_cells.wgsl"),
                source!("trial_lanes.wgsl"),
                NO_MODEL,
                $(source!($file),)*
                source!(concat!($entry, ".wgsl")),
            ],
        }
    };
}

/// First part of a phase of many trials.
pub const SIMULATE_FIRST: Kernel = simulation!(
    "simulate_first",
    [
        "trial_side_face.wgsl",
        "trial_relax.wgsl",
        "trial_threshold.wgsl",
        "trial_step.wgsl",
        "trial_apply.wgsl",
        "trial_write_back.wgsl",
        "trial_reinitialize.wgsl",
        "trial_bricks.wgsl",
        "trial_first.wgsl",
    ]
);

/// Second part of the phase.
pub const SIMULATE_SECOND: Kernel = simulation!(
    "simulate_second",
    [
        "trial_relax.wgsl",
        "trial_threshold.wgsl",
        "trial_step.wgsl",
        "trial_apply.wgsl",
        "trial_write_back.wgsl",
        "trial_reinitialize.wgsl",
        "trial_bricks.wgsl",
        "trial_second.wgsl",
    ]
);

/// Sums over the invocations of each trial.
pub const SIMULATE_REDUCE: Kernel = simulation!("simulate_reduce", []);

/// Choice of each trial's next phase.
pub const SIMULATE_CONTROL: Kernel = simulation!(
    "simulate_control",
    [
        "trial_forces.wgsl",
        "trial_balance.wgsl",
        "trial_moment.wgsl",
        "trial_plan.wgsl",
        "trial_seek.wgsl",
        "trial_found.wgsl",
        "trial_control.wgsl",
        "trial_written.wgsl",
        "trial_order.wgsl",
    ]
);

/// Blocks of each brick that a ray must examine.
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
pub const KERNELS: [Kernel; 7] =
    [SAMPLE, SIMULATE_FIRST, SIMULATE_SECOND, SIMULATE_REDUCE, SIMULATE_CONTROL, OCCUPANCY, RENDER];

impl Kernel {
    /// The whole WGSL text that is compiled; a simulation kernel is without a model.
    pub fn text(&self) -> String {
        self.with_formulas(NO_MODEL.text)
    }

    /// The same with the formulas of a model.
    pub fn with_formulas(&self, formulas: &str) -> String {
        let text = |source: &Source| if source.file == NO_MODEL.file { formulas } else { source.text };
        let files = self.sources.iter().map(|source| format!("\n// {}\n{}", source.file, text(source)));
        constants::wgsl() + &layout::wgsl() + &RenderStage::wgsl() + &files.collect::<String>()
    }
}
