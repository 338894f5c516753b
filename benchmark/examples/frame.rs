//! Rate at which correct logs are moved, and remaining error of wrong ones, on virtual campaigns that each hide one
//! effect of the library, with exact logs and with errors of frame and clock.
//!
//! `cargo run --release -p robofin-benchmark --example frame -- COUNT [FIRST_SEED] [clean|frame|clock|shop] [grinding|sanding]`

use effects::{Library, Model, Process};
use lab::aligned;
use virtual_lab::{Choice, Experiment, FrontEnd, Hidden, Made, Plan, Size};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Effects that are equivalent to an error of frame or clock, and are not hidden here.
const SAME: [&str; 4] = ["path-offset", "clock-offset", "scan-shift", "force-lag"];

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: u64| words.get(at).map_or(Ok(default), |word| word.parse());
    let (count, first) = (number(0, 10)?, number(1, 1)?);
    let front_end = words.get(2).and_then(|word| FrontEnd::ALL.into_iter().find(|one| one.word() == word));
    let front_end = front_end.unwrap_or_default();
    let process = if words.iter().any(|word| word == "sanding") { Process::Sanding } else { Process::Grinding };
    let acts = |effect: &&effects::Effect| effect.acts_in(process) && !SAME.contains(&effect.name.as_str());
    let names: Vec<&str> = Library::builtin().effects().iter().filter(acts).map(|e| e.name.as_str()).collect();
    println!("| seed | plan | hidden | x [mm] | y [mm] | yaw [mrad] | clock [s] |\n|---|---|---|---|---|---|---|");
    let mut moved = 0;
    for seed in first..first + count {
        let plan = [Plan::Varied, Plan::Steps, Plan::Reversed, Plan::Paper][(seed % 4) as usize];
        // Every third campaign hides nothing.
        let hidden = (seed % 3 != 0).then(|| names[seed as usize % names.len()]);
        match made((seed, plan, front_end), (process, hidden)) {
            Ok(made) => moved += usize::from(one(&made, plan, hidden)?),
            Err(why) => println!("| {seed} | {plan:?} | not made: {why} | | | | |"),
        }
    }
    println!("\nlogs of {moved} of {count} campaigns were moved ({})", front_end.about());
    Ok(())
}

fn made((seed, plan, front_end): (u64, Plan, FrontEnd), (process, hidden): (Process, Option<&str>)) -> Result<Made> {
    let new = Experiment::new(process, Library::builtin(), seed)?;
    let choice = Choice::These(hidden.map(Hidden::effect).into_iter().collect());
    let (instrument, robot) = (front_end.instrument(), front_end.robot());
    Ok(Experiment { plan, trials: plan.usual_trials(), size: Size::Small, choice, instrument, robot, ..new }.make()?)
}

/// Aligns one campaign and prints its row.
fn one(made: &Made, plan: Plan, hidden: Option<&str>) -> Result<bool> {
    let placed = aligned(&made.trials, &Model::new(made.trials[0].process), Library::builtin())?;
    let place = placed.as_ref().map(|trials| trials[0].frame_offset).unwrap_or_default();
    println!(
        "| {} | {plan:?} | {} | {:.3} | {:.3} | {:.2} | {:.3} |",
        made.answer.seed,
        hidden.unwrap_or("nothing"),
        1e3 * place.shift.x,
        1e3 * place.shift.y,
        1e3 * place.yaw,
        place.lag
    );
    Ok(placed.is_some())
}
