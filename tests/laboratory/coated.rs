//! Masks on which the coating is whole everywhere.

use effects::{Library, Model, Process};
use lab::{Evidence, ScanEvidence, Split, calibrate_scans};
use trials::trial::PassScan;
use virtual_lab::{Choice, Experiment, Instrument, Plan, Robot, Size};

#[test]
fn masks_that_never_show_the_substrate_are_compared_but_no_law_is_fitted_to_them() {
    let new = Experiment::new(Process::Sanding, Library::builtin(), 5).unwrap();
    let clean = Experiment { instrument: Instrument::clean(), robot: Robot::clean(), plan: Plan::Paper, ..new };
    let (size, choice) = (Size::Small, Choice::These(Vec::new()));
    let mut made = Experiment { trials: 1, size, choice, ..clean }.make().unwrap();
    for pass in made.trials.iter_mut().flat_map(|trial| &mut trial.passes) {
        let PassScan::Exposure(mask) = &mut pass.scan else { panic!("sanding has masks") };
        mask.exposed.iter_mut().for_each(|seen| *seen = seen.map(|_| false));
    }
    let mut evidence = ScanEvidence::new(&made.trials, None).unwrap();
    let model = Model::new(Process::Sanding);
    let compiled = effects::CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap();
    assert!(evidence.residuals(&compiled, Split::Calibration).unwrap().iter().all(|residual| residual.is_finite()));
    let error = calibrate_scans(&mut evidence, &model, Library::builtin()).err().expect("nothing was sanded through");
    assert!(error.to_string().contains("no mask of a calibration pass shows the substrate"), "{error}");
}
