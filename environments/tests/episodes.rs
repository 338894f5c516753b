//! Environments on a ridge of known volume.

use std::sync::Arc;

use effects::{CompiledModel, Library, Model, Process, RowCounts};
use environments::{
    ACTION, Batch, Limits, METRICS, Observation, Outputs, RGB, Randomisation, STATE, Setup, Task, WeldFacts,
};
use glam::DVec3;
use robot::{Controller, Pad, Tool, Wheel};
use sdf_bake::BrickGrid;

const WELD: WeldFacts = WeldFacts { width: 6e-3, height: 1.5e-3 };

/// Makes a plate with a ridge 30 mm long.
fn plate(height: f64) -> BrickGrid {
    let half = DVec3::new(0.025, 0.015, 0.004);
    let ridge = move |p: DVec3| match p.x.abs() <= 15e-3 {
        true => (height * (1.0 - (p.y / 3e-3).powi(2))).max(0.0),
        false => 0.0,
    };
    BrickGrid::from_distance(-half, half, 0.5e-3, 4.0, move |p| p.z - ridge(p))
}

fn points() -> Vec<(DVec3, DVec3)> {
    (-15..=15).map(|k| (DVec3::X * f64::from(k) * 1e-3, DVec3::Z)).collect()
}

fn setup(process: Process, observation: Observation) -> Setup {
    let (task, tool) = match process {
        Process::Grinding => {
            let task = Task::grinding(&plate(WELD.height), &plate(0.0), WELD, &points());
            (task, Tool::from(Wheel::cylinder(0.04, 0.012)))
        }
        Process::Sanding => (Task::sanding(&plate(0.0), WELD, &points()), Pad { radius: 6e-3 }.into()),
    };
    let effects = if process == Process::Grinding { &["grit-dulling"][..] } else { &[] };
    let stated = effects.iter().fold(Model::new(process), |model, effect| model.with(effect));
    let model = CompiledModel::new(&stated, Library::builtin(), RowCounts::default()).unwrap();
    Setup {
        tasks: vec![Arc::new(task.unwrap())],
        tool,
        model: Arc::new(model),
        randomisations: Vec::new(),
        limits: Limits::default(),
        controller: Controller::Admittance { mass: 2.0, damping: 1500.0, period: 4e-3 },
        observation,
        time_limit: None,
    }
}

/// Output arrays of a batch.
struct Written {
    observations: Vec<f32>,
    rewards: Vec<f64>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
    metrics: Vec<f64>,
}

impl Written {
    fn new(count: usize, size: usize) -> Self {
        Self {
            observations: vec![0.0; count * size],
            rewards: vec![0.0; count],
            terminated: vec![false; count],
            truncated: vec![false; count],
            metrics: vec![0.0; count * METRICS.len()],
        }
    }

    fn step(&mut self, batch: &mut Batch, action: [f32; ACTION]) {
        let Self { observations, rewards, terminated, truncated, metrics } = self;
        let actions = action.repeat(rewards.len());
        batch.step(&actions, &mut Outputs { observations, rewards, terminated, truncated, metrics }).expect("a step");
    }

    fn metric(&self, name: &str) -> f64 {
        self.metrics[METRICS.iter().position(|known| *known == name).expect("a figure")]
    }
}

#[test]
fn a_wheel_takes_the_ridge_off_until_the_task_is_done() {
    let mut batch = Batch::new(setup(Process::Grinding, Observation::State), 1, 3).unwrap();
    let mut written = Written::new(1, STATE);
    let volume = 30e-3 * 2.0 / 3.0 * WELD.width * WELD.height;
    let (mut way, mut total, mut steps) = (0.5, 0.0, 0);
    while !written.terminated[0] && !written.truncated[0] {
        written.step(&mut batch, [way, 0.0, 0.0, 0.0, 0.0]);
        way = if written.observations[0].abs() > 0.999 { -0.5 * written.observations[0].signum() } else { way };
        total += written.rewards[0];
        steps += 1;
    }
    assert!(written.terminated[0] && written.metric("left") <= 0.03, "{:?}", written.metrics);
    let removed = written.metric("removed_volume");
    assert!((removed / volume - 1.0).abs() < 0.15, "{removed} of {volume}");
    assert!((total - written.metric("return")).abs() < 1e-12 && (0.5..1.0).contains(&total), "{total}");
    assert!((written.metric("time") - 0.04 * f64::from(steps)).abs() < 1e-9);
    assert!(written.metric("force_error") < 20.0 && written.metric("gouge_depth") < 0.3e-3, "{:?}", written.metrics);
}

#[test]
fn a_pad_takes_the_coating_off_and_nothing_else() {
    let mut batch = Batch::new(setup(Process::Sanding, Observation::Heights), 1, 3).unwrap();
    let mut written = Written::new(1, Observation::Heights.size());
    for step in 0..60 {
        written.step(&mut batch, [if step < 30 { 1.0 } else { -1.0 }, 0.0, 0.0, 0.0, 0.0]);
    }
    assert!(written.metric("left") < 0.95 && written.metric("removed_volume") == 0.0, "{:?}", written.metrics);
    assert!(written.metric("gouge_depth") < 1e-5);
    assert!(written.observations.iter().all(|left| *left <= 1.0));
}

#[test]
fn a_snapshot_goes_on_to_the_same_bytes_and_the_next_episode_is_another() {
    let mut drawn = setup(Process::Grinding, Observation::Depth);
    let range = Some([50e-9, 500e-9]);
    drawn.randomisations = vec![Randomisation::new(&drawn.model, "grit-dulling.dulling_volume", range).unwrap()];
    let mut batch = Batch::new(drawn, 1, 8).unwrap();
    let mut written = Written::new(1, Observation::Depth.size());
    let mut run = |batch: &mut Batch, steps: usize| {
        let mut seen = Vec::new();
        for _ in 0..steps {
            written.step(batch, [0.6, 0.1, 0.2, -0.1, 0.3]);
            seen.push((written.observations.clone(), written.rewards[0], written.metrics.clone()));
        }
        seen
    };
    let begun = batch.environments()[0].snapshot();
    run(&mut batch, 5);
    let moment = batch.environments()[0].snapshot();
    let first = run(&mut batch, 12);
    let part = batch.environments()[0].part().clone();
    batch.environment_mut(0).restore(&moment);
    assert_eq!(run(&mut batch, 12), first);
    assert_eq!(*part, **batch.environments()[0].part());
    batch.environment_mut(0).restore(&begun);
    let same_seed = run(&mut batch, 17);
    assert_eq!(same_seed[5..], first[..]);
    batch.environment_mut(0).reset(None);
    assert_ne!(run(&mut batch, 17)[5..], first[..], "another draw");
    batch.environment_mut(0).reset(Some(8));
    assert_eq!(run(&mut batch, 17)[5..], first[..]);
}

#[test]
fn a_photograph_is_the_same_on_any_number_of_threads_and_shows_ground_metal() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut batch = Batch::new(setup(Process::Grinding, Observation::Rgb), 2, 3).unwrap();
            let mut written = Written::new(2, Observation::Rgb.size());
            let mut shown = Vec::new();
            for _ in 0..12 {
                written.step(&mut batch, [0.0, 0.0, 0.0, 0.0, 1.0]);
                shown.push(written.observations.clone());
            }
            shown
        })
    };
    let shown = run(1);
    assert_eq!(shown, run(3));
    let [height, width, colours] = RGB;
    let (first, last) = (&shown[0], &shown[11]);
    assert!(first.iter().all(|value| value.fract() == 0.0 && (0.0..=255.0).contains(value)));
    let change = |row: usize, column: usize| {
        let at = (row * width + column) * colours;
        (first[at] - last[at]).abs()
    };
    // The wheel stands in the middle; beside the weld nothing changes.
    assert!(change(height / 2, width / 2) > 10.0, "{}", change(height / 2, width / 2));
    assert!((0..height).all(|row| change(row, 4) < 3.0));
}

#[test]
fn what_cannot_be_an_environment_is_refused() {
    let setup = setup(Process::Grinding, Observation::State);
    let flat = Task::grinding(&plate(0.0), &plate(0.0), WELD, &points()).unwrap_err().to_string();
    assert!(flat.contains("stands nowhere above the target"), "{flat}");
    let unknown = Randomisation::new(&setup.model, "tool-tilt.roll_angle", None).unwrap_err().to_string();
    assert!(unknown.contains("tool-tilt.roll_angle"), "{unknown}");
    let range = Randomisation::new(&setup.model, "winkler.stiffness", Some([2.0, 1.0])).unwrap_err().to_string();
    assert!(range.contains("from 2 to 1"), "{range}");
    let mut batch = Batch::new(setup, 2, 0).unwrap();
    let mut seen = vec![0.0; 2 * STATE];
    let error = batch.reset((&[None], &[true, true]), &mut seen).unwrap_err().to_string();
    assert_eq!(error, "seeds has 1 values, and 2 are accepted");
}
