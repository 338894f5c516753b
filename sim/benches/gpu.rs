//! Steps of many trials at once, on the device and on the CPU: `cargo bench -p robofin-sim --bench gpu`.
//!
//! A wheel on a plate under an admittance controller that is sampled every millisecond. A step is a millisecond, so
//! trials run in real time if a step of all of them takes no longer. The time of a step is the difference between a
//! long and a short pass over the difference of their steps; so compilation, upload and read-back do not count.
//!
//! The limit printed beside it is the memory bandwidth: every array over the columns of the contact, the state, the
//! sums and the row of the log are read and written once each step, at the rate at which the device copies buffers.

use std::time::Instant;

use effects::{CompiledModel, Library, Model, RowCounts, States};
use glam::DVec3;
use rayon::prelude::*;
use robot::{Controller, Tool, Wheel};
use sdf_bake::BrickGrid;
use shaders::Device;
use shaders::adapters::AdapterKind;
use shaders::constants::{COLUMN_ARRAYS, PARTIALS};
use shaders::device::{BackendChoice, open};
use shaders::layout::{LogRecord, TrialState};
use shaders::testing::copy_bandwidth;
use sim::gpu::{Settings, Trial, run_batch};
use sim::{CurvePoint, Pass, PassRecord, PassSettings, Path, TOOL_CELLS, run_pass};

const VOXEL: f64 = 0.5e-3;
const WIDTH: f64 = 4e-3;
const FEED: f64 = 5e-3;
/// Time of a step [s].
const PERIOD: f64 = 1e-3;
/// Lengths of the passes [m].
const WAYS: [f64; 2] = [0.2e-3, 0.8e-3];
/// Numbers of trials at once on a software driver, and on a real device.
const FEW: [usize; 3] = [1, 8, 32];
const MANY: [usize; 5] = [1, 64, 512, 1024, 4096];

/// Inputs that all trials share.
struct Bench {
    part: BrickGrid,
    tool: Tool,
    settings: PassSettings,
    model: CompiledModel,
    states: States,
    paths: [Path; 2],
}

fn main() {
    let bench = Bench::new();
    let record = bench.on_cpu(1, 1).1;
    println!("a step: {:.0} lines of the contact, {:.0} bytes at least", lines(&record), bytes(&record));
    let threads = rayon::current_num_threads();
    let cpu = bench.step_time(|way| bench.on_cpu(4 * threads, way).0);
    report(&format!("CPU, {threads} threads"), 4 * threads, cpu);
    match open(BackendChoice::Gpu) {
        Ok(opened) => bench.measure(&opened.device.expect("a device"), &record),
        Err(error) => println!("no device: {error}"),
    }
}

/// Number of columns of the contact and of the border around it.
fn lines(record: &PassRecord) -> f64 {
    (WIDTH / VOXEL + 2.0) * (record.area_max / WIDTH / VOXEL + 2.0)
}

/// Minimum memory traffic of a step of a trial [bytes].
fn bytes(record: &PassRecord) -> f64 {
    let fixed = 4 * PARTIALS as usize + size_of::<TrialState>() + size_of::<LogRecord>();
    2.0 * (4.0 * f64::from(COLUMN_ARRAYS) * lines(record) + fixed as f64)
}

fn report(name: &str, trials: usize, step: f64) {
    let real_time = trials as f64 * PERIOD / step;
    println!(
        "{name}: {trials} trials, {:.3} ms a step of all, {:.1} µs a trial; {real_time:.0} trials in real time at 1 kHz",
        step * 1e3,
        step * 1e6 / trials as f64
    );
}

impl Bench {
    fn new() -> Self {
        let half = DVec3::new(0.012, 0.006, 0.003);
        let text = "process = \"grinding\"\n[law.winkler]\nstiffness = \"1e10 Pa/m\"\n\
                    [law.preston-threshold]\ngrind_rate = \"1e-9 m/(Pa s)\"\n";
        let model = Model::parse("the base law", text, Library::builtin()).expect("a model");
        let model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model");
        let path = |way: f64| {
            let at = |x: f64| CurvePoint { position: DVec3::new(x, 0.0, 0.13e-3), normal: DVec3::Z };
            Path::along(&[at(0.0), at(way)], FEED).expect("a path")
        };
        Self {
            part: BrickGrid::from_distance(-half, half, VOXEL, 3.0, |p| p.z - 0.13e-3),
            tool: Tool::from(Wheel::cylinder(0.02, WIDTH)),
            settings: PassSettings {
                controller: Controller::Admittance { mass: 2.0, damping: 2000.0, period: PERIOD },
                quasi_static: false,
                ..PassSettings::default()
            },
            states: States::new(&model, TOOL_CELLS),
            model,
            paths: WAYS.map(path),
        }
    }

    fn pass(&self, way: usize) -> Pass<'_> {
        Pass::first(&self.tool, &self.paths[way], &self.settings, &self.model)
    }

    /// Time [s] and steps of a pass of a number of trials, on all threads; and one record.
    fn on_cpu(&self, trials: usize, way: usize) -> ((f64, usize), PassRecord) {
        let started = Instant::now();
        let run = |_| {
            let (mut part, mut states) = (self.part.clone(), self.states.clone());
            run_pass(&mut part, self.pass(way), &mut states, &mut |_| {}).expect("a pass on the CPU")
        };
        let mut records: Vec<PassRecord> = (0..trials).into_par_iter().map(run).collect();
        let record = records.remove(0);
        ((started.elapsed().as_secs_f64(), record.steps), record)
    }

    /// The same on a device.
    fn on_device(&self, device: &Device, trials: usize, way: usize) -> (f64, usize) {
        let started = Instant::now();
        let trial = Trial { part: &self.part, pass: self.pass(way), tool: &self.states };
        let outcomes = run_batch(device, &vec![trial; trials], Settings::default(), &mut |_, _| {});
        let seconds = started.elapsed().as_secs_f64();
        let records = outcomes.into_iter().map(|outcome| outcome.expect("a pass").record.expect("a pass"));
        let steps: Vec<usize> = records.map(|record| record.steps).collect();
        assert!(steps.iter().all(|count| *count == steps[0]), "trials of equal length");
        (seconds, steps[0])
    }

    /// Time of one step [s].
    fn step_time(&self, run: impl Fn(usize) -> (f64, usize)) -> f64 {
        let [(short, few), (long, many)] = [0, 1].map(run);
        (long - short) / (many - few) as f64
    }

    fn measure(&self, device: &Device, record: &PassRecord) {
        let adapter = device.adapter();
        let is_software = adapter.kind == AdapterKind::Cpu;
        println!("device: {adapter}{}", if is_software { "; software, on this same processor" } else { "" });
        let started = Instant::now();
        self.on_device(device, 1, 0);
        println!("first pass, kernels compiled: {:.1} s", started.elapsed().as_secs_f64());
        for &trials in if is_software { &FEW[..] } else { &MANY[..] } {
            report("device", trials, self.step_time(|way| self.on_device(device, trials, way)));
        }
        let bandwidth = copy_bandwidth(device).expect("copies");
        println!(
            "limit: {:.1} GB/s copied are {:.0} trials in real time at 1 kHz",
            bandwidth * 1e-9,
            bandwidth * PERIOD / bytes(record)
        );
    }
}
