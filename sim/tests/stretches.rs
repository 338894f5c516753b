//! A pass in stretches against the same pass without interruption, and against itself.

use effects::{CompiledModel, Library, Model, RowCounts, States};
use glam::DVec3;
use robot::{Controller, Pad, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::{CurvePoint, Pass, PassRecord, PassSettings, Path, PathSample, TOOL_CELLS, Underway, run_pass, run_stretch};

fn plate() -> BrickGrid {
    let half = DVec3::new(0.03, 0.012, 0.005);
    BrickGrid::from_distance(-half, half, 0.5e-3, 4.0, |p| p.z)
}

fn model(effect: Option<&str>) -> CompiledModel {
    let model = Model::new(effects::Process::Grinding);
    let model = effect.into_iter().fold(model, Model::with);
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap()
}

fn path() -> Path {
    let curve = [-12e-3, 12e-3].map(|x| CurvePoint { position: DVec3::X * x, normal: DVec3::Z });
    Path::along(&curve, 20e-3).unwrap()
}

const STEPS: usize = 30;

/// The path from one step's beginning to a step beyond its end.
fn piece(path: &Path, step: usize) -> Path {
    let dt = path.duration() / STEPS as f64;
    let place = |k: usize| PathSample { time: k as f64 * dt, ..path.at(k as f64 * dt) };
    let (begin, end) = (place(step), place(step + 1));
    let beyond = PathSample { time: 2.0 * end.time - begin.time, position: 2.0 * end.position - begin.position, ..end };
    Path::from_samples(vec![begin, end, beyond]).unwrap()
}

/// A plate, a wheel on it and the pass in progress.
struct Work {
    grid: BrickGrid,
    states: States,
    underway: Underway,
}

impl Work {
    fn new(model: &CompiledModel) -> Self {
        Self { grid: plate(), states: States::new(model, TOOL_CELLS), underway: Underway::default() }
    }

    fn step(&mut self, model: &CompiledModel, settings: &PassSettings, step: usize, settles: bool) -> PassRecord {
        let (tool, path) = (Tool::from(Wheel::cylinder(0.04, 0.012)), piece(&path(), step));
        let pass = Pass::first(&tool, &path, settings, model);
        let until = path.samples()[1].time;
        let record =
            run_stretch(&mut self.grid, pass, &mut self.states, (&mut self.underway, until)).expect("a stretch");
        if settles {
            self.underway.settle(&mut self.grid);
        }
        record
    }
}

fn settings(controller: Controller) -> PassSettings {
    PassSettings { controller, ..PassSettings::default() }
}

const ADMITTANCE: Controller = Controller::Admittance { mass: 2.0, damping: 1500.0, period: 4e-3 };

#[test]
fn stretches_remove_what_one_pass_removes() {
    let (model, tool) = (model(Some("grit-dulling")), Tool::from(Wheel::cylinder(0.04, 0.012)));
    for controller in [Controller::Ideal, ADMITTANCE] {
        let settings = settings(controller);
        let (mut grid, mut states) = (plate(), States::new(&model, TOOL_CELLS));
        let path = path();
        let whole =
            run_pass(&mut grid, Pass::first(&tool, &path, &settings, &model), &mut states, &mut |_| {}).unwrap();
        for settles in [false, true] {
            let mut work = Work::new(&model);
            let removed: f64 = (0..STEPS).map(|step| work.step(&model, &settings, step, settles).removed_volume).sum();
            work.underway.settle(&mut work.grid);
            let off = removed / whole.removed_volume - 1.0;
            assert!(off.abs() < 2e-3, "{controller:?}, settles {settles}: {off}");
            let (lost, expected) = (plate().volume() - work.grid.volume(), plate().volume() - grid.volume());
            assert!((lost / expected - 1.0).abs() < 1e-2, "{controller:?}: {lost} {expected}");
            let dull = |states: &States| states.tool_state(&model, "grit-dulling.ground_volume").unwrap();
            assert!((dull(&work.states) / dull(&states) - 1.0).abs() < 2e-3, "the states go on");
        }
    }
}

#[test]
fn a_copy_goes_on_to_the_same_bytes() {
    let (model, settings) = (model(Some("grit-dulling")), settings(ADMITTANCE));
    let mut first = Work::new(&model);
    for step in 0..9 {
        first.step(&model, &settings, step, false);
    }
    first.underway.settle(&mut first.grid);
    let mut second = Work { grid: first.grid.clone(), states: first.states.clone(), underway: first.underway.copy() };
    for step in 9..20 {
        let [a, b] = [&mut first, &mut second].map(|work| work.step(&model, &settings, step, step % 3 == 0));
        assert_eq!(a, b, "step {step}");
    }
    first.underway.settle(&mut first.grid);
    second.underway.settle(&mut second.grid);
    assert_eq!(first.grid, second.grid);
    assert_eq!(first.states, second.states);
}

#[test]
fn the_tool_moves_on_from_where_the_controller_left_it() {
    let (model, settings) = (model(None), settings(ADMITTANCE));
    let mut work = Work::new(&model);
    assert_eq!(work.underway.motion(), sim::control::Motion::default());
    let mut before = 0.0;
    for step in 0..12 {
        let record = work.step(&model, &settings, step, true);
        let travel = work.underway.motion().travel;
        assert!((travel - before).abs() < 1e-3, "step {step}: from {before} to {travel}");
        before = travel;
        assert!((record.duration - path().duration() / STEPS as f64).abs() < 1e-12);
    }
    assert!(before < 0.0, "the wheel is pressed in: {before}");
}

#[test]
fn a_pad_that_hardly_moves_is_followed() {
    let model = Model::new(effects::Process::Sanding);
    let model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap();
    let (tool, settings) = (Tool::from(Pad { radius: 6e-3 }), settings(ADMITTANCE));
    let place = |time: f64, x: f64| PathSample { time, position: DVec3::X * x, approach: DVec3::Z, axis: DVec3::Y };
    let path = Path::from_samples(vec![place(0.0, 0.0), place(0.04, 1e-17)]).unwrap();
    let (mut grid, mut states, mut underway) = (plate(), States::new(&model, TOOL_CELLS), Underway::default());
    let pass = Pass::first(&tool, &path, &settings, &model);
    let record = run_stretch(&mut grid, pass, &mut states, (&mut underway, 0.04)).expect("a stretch");
    assert!(record.coating_volume > 0.0 && record.removed_volume == 0.0);
}
