//! Criteria of first answers, attempts and next trials.

use super::Criterion;

criteria! {
    OF_EXPERIMENTS;
    /// Effects that the first answer of a study names.
    FIRST_LOOK_EFFECTS: usize = 5, "1", "chosen";
    /// Voxel of the lattice on which steps of fits and first looks are made, over that of the simulation.
    COARSE_VOXEL_RATIO: f64 = 2.0, "1", "chosen: a fifth of the time; what it errs by is taken off";
    /// Most times that the usual lattice corrects the coarser one in a fit.
    MAPPING_ROUNDS: usize = 4, "1", "chosen";
    /// Sizes of an effect from which an attempt may begin.
    ATTEMPT_STARTS: usize = 12, "1", "chosen";
    /// Best of them that are fitted, beside one from no effect.
    ATTEMPT_FITS: usize = 1, "1", "chosen";
    /// Most times that a fit on the coarse lattice is begun again from where it ended.
    ATTEMPT_ROUNDS: usize = 2, "1", "chosen";
    /// Most effects that a next trial distinguishes, beside none of them.
    NEXT_TRIAL_HYPOTHESES: usize = 4, "1", "chosen: each costs a simulation of every trial on the menu";
    /// Best trials of the menu that are reported beside the one proposed.
    NEXT_TRIAL_RUNNERS_UP: usize = 5, "1", "chosen";
    /// Voxel of simulated trials of the menu when grinding, over that of fits.
    NEXT_TRIAL_VOXEL_RATIO: f64 = 2.0, "1", "chosen: errors of the lattice cancel in differences of hypotheses";
    /// Most tiles of a scan that is only predicted.
    NEXT_TRIAL_TILES: usize = 300, "1", "chosen: hypotheses differ smoothly";
    /// Time to fetch, clamp and locate a workpiece.
    TRIAL_SETUP_MINUTES: f64 = 15.0, "min", "chosen: an assumption about a laboratory";
    /// Time of a scan.
    TRIAL_SCAN_MINUTES: f64 = 4.0, "min", "chosen: an assumption about a profilometer";
    /// Time to dress a wheel or to change a sheet.
    TRIAL_DRESSING_MINUTES: f64 = 5.0, "min", "chosen: an assumption about a laboratory";
}
