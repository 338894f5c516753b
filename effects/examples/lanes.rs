//! Speed of compiled formulas: lanes per second of the rate hook, compared with the same law written in Rust.
//!
//! `cargo run --release -p robofin-effects --example lanes`

use std::time::Instant;

use effects::{CompiledModel, Hook, Lanes, Library, Model, Process, RowCounts, States, StepValues, Variable};

const LANES: usize = 512;
const CALLS: usize = 20_000;

/// Lanes per second of a call over [`LANES`] lanes, best of five runs.
fn speed(mut call: impl FnMut(&mut [f64])) -> f64 {
    let mut out = vec![0.0; LANES];
    let mut best = 0.0f64;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..CALLS {
            call(&mut out);
            std::hint::black_box(&out);
        }
        best = best.max((LANES * CALLS) as f64 / start.elapsed().as_secs_f64());
    }
    best
}

fn compiled(effects: &[&str]) -> CompiledModel {
    let model = effects.iter().fold(Model::new(Process::Grinding), |model, effect| model.with(effect));
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("library effects compile")
}

fn main() {
    let pressure: Vec<f64> = (0..LANES).map(|lane| 0.25e6 + 3e3 * lane as f64).collect();
    let depth = vec![30e-6; LANES];
    let step = StepValues::new();
    let mut all: Vec<&str> = Library::builtin()
        .effects()
        .iter()
        .filter(|effect| effect.changes_in(Process::Grinding).any(|change| change.hook == Hook::Rate))
        .filter(|effect| effect.acts_in(Process::Grinding))
        .map(|effect| effect.name.as_str())
        .collect();
    all.sort_unstable();
    for (title, effects) in [
        ("base law", &[][..]),
        ("base law, dulling", &["grit-dulling"]),
        ("base law, dulling, pressure exponent", &["grit-dulling", "pressure-exponent"]),
        ("all effects on the rate", &all),
    ] {
        let model = compiled(effects);
        let states = States::new(&model, 16);
        let call = model.at(Hook::Rate, &step, &states);
        let places = vec![3.5; LANES];
        let needed = model.needs(Hook::Rate).iter().filter(|variable| variable.is_lane_at(Hook::Rate));
        let lanes = needed.fold(Lanes::new(LANES).with_tool_cell(&places), |lanes, variable| {
            lanes.with(*variable, if *variable == Variable::Pressure { &pressure } else { &depth })
        });
        let found = speed(|out| call.run(&lanes, out).expect("finite rates"));
        println!("{title:40} {:8.1} million lanes per second", found * 1e-6);
    }
    let (rate, threshold, exponent) = std::hint::black_box((1e-9, 0.0, 0.8));
    let by_hand = speed(|out| {
        for (out, pressure) in out.iter_mut().zip(&pressure) {
            let excess: f64 = pressure - threshold;
            *out = rate * excess.max(0.0) * (excess.max(1.0) / 1e6).powf(exponent - 1.0);
        }
    });
    println!("{:40} {:8.1} million lanes per second", "the last but one in Rust with powf", by_hand * 1e-6);
}
