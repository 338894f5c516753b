//! Frame and clock of the robot: estimated within their intervals where they are off, and left unchanged where they are
//! right.

use effects::{Library, Model, Process};
use glam::DVec2;
use lab::{FrameCause, FrameEstimate, ScanEvidence, aligned, calibrate_scans};
use robot::LogRow;
use trials::trial::Trial;
use virtual_lab::{Choice, Experiment, FrontEnd, Plan, Size};

/// Makes three small trials without hidden effects, with a front end.
fn made(front: FrontEnd) -> Vec<Trial> {
    let new = Experiment::new(Process::Grinding, Library::builtin(), 12).unwrap();
    let choice = Choice::These(Vec::new());
    let small = Experiment { plan: Plan::Varied, trials: 3, size: Size::Small, choice, ..new };
    small.behind(front).make().unwrap().trials
}

/// Returns the mean offset of the true positions from those of a log.
fn off(front: &[Trial]) -> DVec2 {
    let rows = |trials: &[Trial]| -> Vec<LogRow> { trials[0].passes[0].log.rows.clone() };
    let (clean, off) = (rows(&made(FrontEnd::Clean)), rows(front));
    let sum: DVec2 = clean.iter().zip(&off).map(|(a, b)| (a.position - b.position).truncate()).sum();
    sum / clean.len() as f64
}

/// Returns the frame offset estimated beside the calibrated base law, and the remaining error over the noise floor.
fn estimate(trials: &[Trial]) -> (FrameEstimate, f64) {
    let mut evidence = ScanEvidence::new(trials, None).unwrap();
    let calibration = calibrate_scans(&mut evidence, &Model::new(Process::Grinding), Library::builtin()).unwrap();
    let fit = &calibration.last().fit;
    let agreement = lab::Evidence::agreement(&evidence, &fit.model, lab::Split::Calibration).unwrap();
    let ratio = agreement.iter().map(|a| a.rms / a.floor).sum::<f64>() / agreement.len() as f64;
    (evidence.frame_estimate(fit).unwrap().expect("logs"), ratio)
}

fn moved(trials: &[Trial]) -> Option<Vec<Trial>> {
    aligned(trials, &Model::new(Process::Grinding), Library::builtin()).unwrap()
}

#[test]
fn a_frame_that_is_off_is_found_and_the_logs_are_moved() {
    let trials = made(FrontEnd::Frame);
    let truth = off(&trials);
    assert!(truth.x.abs() > 0.3e-3, "the drawn frame is off along the bead: {truth}");
    let (found, ratio) = estimate(&moved(&trials).expect("logs that are far off"));
    println!("true x {:.3} mm; {found:?}; error over floor {ratio:.3}", 1e3 * truth.x);
    assert_eq!(found.cause, FrameCause::Frame);
    let [low, high] = found.shift_x_mm.interval;
    assert!((low..high).contains(&(1e3 * truth.x)) && high - low < 0.15, "{low} to {high}");
    assert!(!found.shift_y_mm.is_shown, "a wheel wider than the bead shows nothing across");
    assert!(found.sentence().is_some() && ratio < 1.15, "{ratio}");
}

#[test]
fn a_clock_that_is_late_is_told_by_the_effect_that_does_the_same() {
    let (found, ratio) = estimate(&moved(&made(FrontEnd::Clock)).expect("logs that are far off"));
    println!("true 0.08 s; {found:?}; error over floor {ratio:.3}");
    assert_eq!(found.cause.effect(), Some("clock-offset"));
    let [low, high] = found.clock_s.interval;
    assert!((low..high).contains(&0.08) && high - low < 0.04, "{low} to {high}");
    assert!(ratio < 1.15, "{ratio}");
}

#[test]
fn logs_that_are_right_stay_where_they_are() {
    assert_eq!(moved(&made(FrontEnd::Clean)), None);
}

#[test]
fn what_an_effect_makes_of_exact_logs_is_no_frame() {
    // In the bundled campaign the wheel dulls, and frame and clock together could explain a part of that.
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look");
    let trials = trials::trial::Campaign::read(&folder).unwrap().trials;
    assert_eq!(moved(&trials[..1]), None);
}

#[test]
fn a_frame_that_is_known_to_be_exact_takes_nothing_up() {
    let mut trials = made(FrontEnd::Frame);
    let exact = trials::trial::FrameErrors { shift: 0.0, yaw: 0.0, lag: 0.0 };
    trials.iter_mut().for_each(|trial| trial.frame_errors = exact);
    assert_eq!(moved(&trials), None);
}
