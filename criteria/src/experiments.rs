//! Criteria of first answers, attempts and next trials.

use super::Criterion;

criteria! {
    OF_EXPERIMENTS;
    /// Maximum number of effects that the first answer of a study names.
    FIRST_LOOK_EFFECTS: usize = 5, "1", "chosen";
    /// Ratio of the coarse lattice's voxel, for fit steps and screening, to the usual voxel of the simulation.
    COARSE_VOXEL_RATIO: f64 = 2.0, "1", "chosen: a fifth of the time; its error is corrected";
    /// Maximum number of times that the usual lattice corrects the coarse one in a fit.
    MAPPING_ROUNDS: usize = 4, "1", "chosen";
    /// Maximum number of combinations of an effect's starting sizes in an attempt.
    ATTEMPT_STARTS: usize = 12, "1", "chosen";
    /// Number of best starts in an attempt that are fitted, in addition to one at the effect's null.
    ATTEMPT_FITS: usize = 1, "1", "chosen";
    /// Maximum number of restarts of an attempt's fit from its own result.
    ATTEMPT_ROUNDS: usize = 2, "1", "chosen";
    /// Maximum number of effects that a next trial distinguishes, in addition to none of them.
    NEXT_TRIAL_HYPOTHESES: usize = 4, "1", "chosen: each costs a simulation of every trial on the menu";
    /// Maximum number of other trials of the menu that are reported with the one proposed.
    NEXT_TRIAL_RUNNERS_UP: usize = 5, "1", "chosen";
    /// Ratio of the voxel of simulated grinding trials of the menu to that of fits.
    NEXT_TRIAL_VOXEL_RATIO: f64 = 2.0, "1", "chosen: errors of the lattice cancel in differences of hypotheses";
    /// Maximum number of tiles of a scan that is only predicted.
    NEXT_TRIAL_TILES: usize = 300, "1", "chosen: hypotheses differ smoothly";
    /// Time to fetch, clamp and locate a workpiece.
    TRIAL_SETUP_MINUTES: f64 = 15.0, "min", "chosen: an assumption about a laboratory";
    /// Time of a scan.
    TRIAL_SCAN_MINUTES: f64 = 4.0, "min", "chosen: an assumption about a profilometer";
    /// Time to dress a wheel or to change a sheet.
    TRIAL_DRESSING_MINUTES: f64 = 5.0, "min", "chosen: an assumption about a laboratory";
}
