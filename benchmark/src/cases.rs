//! The cases: families, designs and what is hidden in each.

use effects::{Effect, Library};
use serde::{Deserialize, Serialize};

use trials::trial::Process;
use virtual_lab::Plan;

/// What a family of cases asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Family {
    /// Nothing is hidden.
    N,
    /// One effect of the library.
    S,
    /// An effect that changes nothing but the base parameters under one force, feed and speed.
    A,
    /// Two effects.
    D,
    /// An effect that the library lacks, or one taken out of it.
    U,
    /// A fault of the scanner.
    M,
    /// Sanding.
    B,
    /// The plan of two equal passes.
    P,
}

impl Family {
    /// All families, in the order of the table.
    pub const ALL: [Self; 8] = [Self::N, Self::S, Self::A, Self::D, Self::U, Self::M, Self::B, Self::P];
}

/// How good scanner and robot are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Instruments {
    /// A careful laboratory.
    Clean,
    /// More of every error.
    Hard,
}

/// A campaign but for what is hidden in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Design {
    /// Grinding or sanding.
    pub process: Process,
    /// How the passes differ.
    pub plan: Plan,
    /// How good scanner and robot are.
    pub instruments: Instruments,
    /// Of workpieces, base law, noise and path.
    pub seed: u64,
}

impl Design {
    /// Its name in file names.
    pub fn id(&self) -> String {
        format!("{:?}-{:?}-{:?}-{}", self.process, self.plan, self.instruments, self.seed).to_lowercase()
    }
}

/// How large a hidden effect is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sized {
    /// Large enough to be seen by eye.
    Visible,
    /// A multiple of the least size that the same campaign could show.
    Detectable(f64),
}

/// One case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// What is asked.
    pub family: Family,
    /// Number within the family.
    pub number: usize,
    /// The campaign.
    pub design: Design,
    /// Names of the hidden effects.
    pub hidden: Vec<String>,
    /// How large they are.
    pub size: Sized,
    /// Whether the diagnosis must do without the hidden effect in its library.
    pub left_out: bool,
}

impl Case {
    /// The same campaign with nothing hidden in it.
    pub fn clean(&self) -> Self {
        let (family, size) = (Family::N, Sized::Visible);
        Self { family, size, hidden: Vec::new(), left_out: false, ..self.clone() }
    }

    /// Its name in file names and tables.
    pub fn id(&self) -> String {
        format!("{:?}{:02}", self.family, self.number)
    }
}

/// Multiples of the detectable size, one for each round through the library.
const SIZES: [f64; 4] = [4.0, 8.0, 2.0, 1.0];
/// Cases in a row that share workpieces, base law and noise; single effects do for a round through the library.
const PER_SEED: usize = 4;
/// Effects that one force, feed and speed hide in the rate constant.
const ABSORBED: [(&str, Plan); 4] = [
    ("speed-exponent", Plan::Reversed),
    ("cutting-direction", Plan::Paper),
    ("force-bias", Plan::Paper),
    ("speed-exponent", Plan::Paper),
];
/// Pairs of effects: apart, alike, and one against the other.
const PAIRS: [(Process, [&str; 2]); 6] = [
    (Process::Grinding, ["tool-tilt", "grit-dulling"]),
    (Process::Sanding, ["pressure-exponent", "pad-loading"]),
    (Process::Grinding, ["wheel-crown", "pressure-exponent"]),
    (Process::Grinding, ["grit-dulling", "break-in"]),
    (Process::Sanding, ["tool-tilt", "pad-loading"]),
    (Process::Grinding, ["entry-overshoot", "tool-tilt"]),
];
/// Effects that are taken out of the library.
const LEFT_OUT: [(Process, &str); 4] = [
    (Process::Grinding, "tool-tilt"),
    (Process::Sanding, "pad-loading"),
    (Process::Grinding, "grit-dulling"),
    (Process::Grinding, "wheel-crown"),
];
/// Faults of the scanner.
const FAULTS: [(Process, &str); 4] = [
    (Process::Grinding, "height-gain"),
    (Process::Grinding, "slope-bias"),
    (Process::Sanding, "exposure-threshold"),
    (Process::Grinding, "stitching"),
];
/// What is hidden when sanding.
const SANDED: [Option<&str>; 6] =
    [Some("pad-loading"), None, Some("pressure-exponent"), Some("tool-tilt"), Some("break-in"), Some("random-orbit")];
/// What is hidden in two equal passes.
const EQUAL_PASSES: [&str; 4] = ["pressure-exponent", "break-in", "surface-layer", "pass-gain"];

/// The first `count` cases of each family.
pub fn cases(families: &[Family], count: usize, seed: u64, library: &Library) -> Vec<Case> {
    let family = |&family: &Family| (0..count).map(move |number| case(family, number, seed, library));
    families.iter().flat_map(family).collect()
}

fn case(family: Family, number: usize, seed: u64, library: &Library) -> Case {
    let varied = |process| (process, Plan::Varied);
    let mut block = number / PER_SEED;
    let (hidden, (process, plan), size) = match family {
        Family::N => visible(&[], cycle(&PLANS, number)),
        Family::S => {
            let (hidden, design, size, round) = single(number, library);
            block = round;
            (hidden, design, size)
        }
        Family::A => {
            let (effect, plan) = cycle(&ABSORBED, number);
            visible(&[effect], (Process::Grinding, plan))
        }
        Family::D => {
            let (process, pair) = cycle(&PAIRS, number);
            visible(&pair, varied(process))
        }
        Family::U if number % 3 == 2 => {
            let (process, effect) = cycle(&LEFT_OUT, number / 3);
            visible(&[effect], varied(process))
        }
        Family::U => {
            let (effect, process) = unknown(number - number / 3);
            visible(&[effect], varied(process))
        }
        Family::M => {
            let (process, effect) = cycle(&FAULTS, number);
            visible(&[effect], varied(process))
        }
        Family::B => visible(cycle(&SANDED, number).as_slice(), varied(Process::Sanding)),
        Family::P => visible(&[cycle(&EQUAL_PASSES, number)], (Process::Grinding, Plan::Paper)),
    };
    let hard = family == Family::N && number / PLANS.len() % 2 == 1;
    let instruments = if hard { Instruments::Hard } else { Instruments::Clean };
    let design = Design { process, plan, instruments, seed: seed.wrapping_add(block as u64) };
    let left_out = family == Family::U && number % 3 == 2;
    Case { family, number, design, hidden: hidden.into_iter().map(str::to_owned).collect(), size, left_out }
}

/// Designs of campaigns in which nothing is hidden, in turn.
const PLANS: [(Process, Plan); 4] = [
    (Process::Grinding, Plan::Varied),
    (Process::Sanding, Plan::Varied),
    (Process::Grinding, Plan::Paper),
    (Process::Grinding, Plan::Steps),
];

fn visible<'a>(hidden: &[&'a str], design: (Process, Plan)) -> (Vec<&'a str>, (Process, Plan), Sized) {
    (hidden.to_vec(), design, Sized::Visible)
}

fn cycle<T: Copy>(list: &[T], number: usize) -> T {
    list[number % list.len()]
}

/// All effects of the library that may be hidden, when grinding and when sanding.
fn singles(library: &Library) -> Vec<(&str, Process)> {
    let known = library.effects().iter().filter(|effect| !UNFIT.contains(&effect.name.as_str()));
    let acts = |effect: &Effect, process| effect.acts_in(effect_process(process));
    let in_both = known.flat_map(|effect| [Process::Grinding, Process::Sanding].map(|process| (effect, process)));
    let acting = in_both.filter(|&(effect, process)| acts(effect, process));
    acting.map(|(effect, process)| (effect.name.as_str(), process)).collect()
}

/// The single effect of a case, its design and size, and the round through the library that it belongs to.
fn single(number: usize, library: &Library) -> (Vec<&str>, (Process, Plan), Sized, usize) {
    let singles = singles(library);
    let (round, (effect, process)) = (number / singles.len(), singles[number * STRIDE % singles.len()]);
    let plan = if process == Process::Grinding && round % 2 == 1 { Plan::Steps } else { Plan::Varied };
    (vec![effect], (process, plan), Sized::Detectable(cycle(&SIZES, round)), round)
}

/// Way from one effect to the next in the list: a prime, so that a round meets all of them.
const STRIDE: usize = 7;
/// What every fit leaves free, or what is no cause by itself.
const UNFIT: [&str; 4] = ["scan-tilt", "scan-shift", "lateral-blur", "pass-gain"];

/// Effects outside the library, and those of them that act when sanding.
const UNKNOWN: [&str; 6] = ["grit-loss", "paint-run", "stick-slip", "lateral-wander", "spatter-patch", "plate-warping"];
const UNKNOWN_WHEN_SANDING: [&str; 2] = ["paint-run", "lateral-wander"];

/// An effect outside the library.
fn unknown(number: usize) -> (&'static str, Process) {
    let name = cycle(&UNKNOWN, number);
    (name, if UNKNOWN_WHEN_SANDING.contains(&name) { Process::Sanding } else { Process::Grinding })
}

/// The same word in the effect library.
pub(super) fn effect_process(process: Process) -> effects::Process {
    match process {
        Process::Grinding => effects::Process::Grinding,
        Process::Sanding => effects::Process::Sanding,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_round_of_single_effects_meets_each_once_on_the_same_workpieces() {
        let library = Library::builtin();
        let count = singles(library).len();
        let cases = cases(&[Family::S], 2 * count, 1, library);
        for (round, size) in [4.0, 8.0].into_iter().enumerate() {
            let cases = &cases[round * count..(round + 1) * count];
            let met: BTreeSet<(&str, bool)> =
                cases.iter().map(|c| (c.hidden[0].as_str(), c.design.process == Process::Sanding)).collect();
            assert_eq!(
                met.len(),
                count,
                "each effect once when grinding and once when sanding, as far as it acts there"
            );
            assert!(cases.iter().all(|c| c.design.seed == 1 + round as u64 && c.size == Sized::Detectable(size)));
        }
    }
}
