//! The cases: families, designs and hidden effects.

use effects::{Effect, Library, Process};
use random::Stream;
use serde::{Deserialize, Serialize};

use super::ladder::{POWER_RUNGS, RUNGS};
use virtual_lab::{FrontEnd, Plan, outside};

/// Family of cases, by the kind of the hidden effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Family {
    /// Nothing is hidden.
    N,
    /// One effect of the library.
    S,
    /// One effect that is removed from the library.
    L,
    /// An effect outside the library.
    U,
    /// Hard front ends, with and without an effect.
    H,
    /// An effect whose change the base parameters absorb.
    A,
    /// Two effects.
    D,
    /// The plan of two equal passes.
    P,
    /// A few effects in many sizes, for their detectable size.
    W,
}

impl Family {
    /// All families, in the order of the table.
    pub const ALL: [Self; 9] = [Self::N, Self::S, Self::L, Self::U, Self::H, Self::A, Self::D, Self::P, Self::W];
}

/// A campaign without its hidden effects.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Design {
    /// Grinding or sanding.
    pub process: Process,
    /// Plan of the passes: settings that differ between them.
    pub plan: Plan,
    /// Front end: errors of scanner, robot and tool in addition to the hidden effects.
    pub front: FrontEnd,
    /// Seed of workpieces, base law, noise and path.
    pub seed: u64,
}

impl Design {
    /// Its name in file names.
    pub fn id(&self) -> String {
        let Self { process, plan, front, seed } = self;
        format!("{process:?}-{plan:?}-{}-{seed}", front.word()).to_lowercase()
    }
}

/// One case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Its family.
    pub family: Family,
    /// Number within the family.
    pub number: usize,
    /// The campaign.
    pub design: Design,
    /// Names of the hidden effects.
    pub hidden: Vec<String>,
    /// Size of the hidden effects over the visible size [1].
    pub rung: f64,
}

impl Case {
    /// Its name in file names and tables.
    pub fn id(&self) -> String {
        format!("{:?}{:02}", self.family, self.number)
    }

    /// True if the hidden effects are removed from the study's library.
    pub fn is_left_out(&self) -> bool {
        self.family == Family::L
    }
}

/// Designs of campaigns in which nothing is hidden, in turn.
const PLANS: [(Process, Plan); 4] = [
    (Process::Grinding, Plan::Varied),
    (Process::Sanding, Plan::Varied),
    (Process::Grinding, Plan::Paper),
    (Process::Grinding, Plan::Steps),
];
/// Effects that the free parameters of every fit absorb: the rate constant at one force, feed and speed, or the scans'
/// poses and blur.
const ABSORBED: [(&str, Plan); 6] = [
    ("speed-exponent", Plan::Reversed),
    ("scan-tilt", Plan::Varied),
    ("cutting-direction", Plan::Paper),
    ("lateral-blur", Plan::Varied),
    ("force-bias", Plan::Paper),
    ("scan-shift", Plan::Varied),
];
/// Pairs of effects: distinct, similar, and opposed.
const PAIRS: [(Process, [&str; 2]); 6] = [
    (Process::Grinding, ["tool-tilt", "grit-dulling"]),
    (Process::Sanding, ["pressure-exponent", "pad-loading"]),
    (Process::Grinding, ["wheel-crown", "pressure-exponent"]),
    (Process::Grinding, ["grit-dulling", "break-in"]),
    (Process::Sanding, ["tool-tilt", "pad-loading"]),
    (Process::Grinding, ["entry-overshoot", "tool-tilt"]),
];
/// Effects hidden in the cases of two equal passes, in turn.
const EQUAL_PASSES: [&str; 4] = ["pressure-exponent", "break-in", "surface-layer", "tool-tilt"];
/// Front ends that are not clean.
const FRONTS: [FrontEnd; 6] =
    [FrontEnd::Frame, FrontEnd::Clock, FrontEnd::Ripple, FrontEnd::Texture, FrontEnd::Worn, FrontEnd::Hard];
/// Process and hidden effect of the cases with these front ends; `None` hides nothing.
const HIDDEN_BEHIND_FRONT_ENDS: [(Process, Option<&str>); 6] = [
    (Process::Grinding, None),
    (Process::Grinding, Some("grit-dulling")),
    (Process::Sanding, None),
    (Process::Grinding, Some("tool-tilt")),
    (Process::Sanding, Some("pad-loading")),
    (Process::Grinding, Some("speed-exponent")),
];
/// Process and hidden effect of the cases with a worn tool: effects of the tool's history; `None` hides nothing.
const HIDDEN_BEHIND_WORN_TOOL: [(Process, Option<&str>); 6] = [
    (Process::Grinding, Some("grit-dulling")),
    (Process::Sanding, Some("pad-loading")),
    (Process::Grinding, Some("wheel-wear")),
    (Process::Grinding, Some("self-sharpening")),
    (Process::Grinding, None),
    (Process::Grinding, Some("break-in")),
];
/// Effects whose detectable size is measured.
pub const POWER: [(Process, &str); 5] = [
    (Process::Grinding, "tool-tilt"),
    (Process::Sanding, "pad-loading"),
    (Process::Grinding, "grit-dulling"),
    (Process::Grinding, "pressure-exponent"),
    (Process::Grinding, "break-in"),
];
/// An effect of the library that describes each pass separately and explains none.
const NO_CAUSE: &str = "pass-gain";
/// Effects that no single-effect case hides: those that every fit absorbs, and [`NO_CAUSE`].
const NEVER_HIDDEN: [&str; 4] = ["scan-tilt", "scan-shift", "lateral-blur", NO_CAUSE];
/// Stride in the list from one effect to the next: a prime, so that a round reaches all of them.
const STRIDE: usize = 7;

/// The first `count` cases of each family.
pub fn cases(families: &[Family], count: usize, seed: u64, library: &Library) -> Vec<Case> {
    let family = |&family: &Family| (0..count).map(move |number| case(family, number, seed, library));
    families.iter().flat_map(family).collect()
}

/// Hidden effects, design and size of a case, before it gets family, number and seed.
struct Draft<'a> {
    hidden: Vec<&'a str>,
    process: Process,
    plan: Plan,
    front: FrontEnd,
    rung: f64,
}

impl<'a> Draft<'a> {
    /// Effects of visible size with the clean front end.
    fn new(hidden: impl IntoIterator<Item = &'a str>, process: Process, plan: Plan) -> Self {
        Self { hidden: hidden.into_iter().collect(), process, plan, front: FrontEnd::Clean, rung: 1.0 }
    }
}

fn case(family: Family, number: usize, seed: u64, library: &Library) -> Case {
    let varied = Plan::Varied;
    let outsiders = outsiders();
    let Draft { hidden, process, plan, front, rung } = match family {
        Family::N => {
            let (process, plan) = cycle(&PLANS, number);
            Draft::new([], process, plan)
        }
        Family::S => single(number, library),
        Family::L => Draft { rung: 1.0, ..single(number, library) },
        Family::U => {
            let (effect, process) = &outsiders[number % outsiders.len()];
            Draft::new([effect.as_str()], *process, varied)
        }
        Family::H => behind(number),
        Family::A => {
            let (effect, plan) = cycle(&ABSORBED, number);
            Draft::new([effect], Process::Grinding, plan)
        }
        Family::D => {
            let (process, pair) = cycle(&PAIRS, number);
            Draft::new(pair, process, varied)
        }
        Family::P => Draft::new([cycle(&EQUAL_PASSES, number)], Process::Grinding, Plan::Paper),
        Family::W => {
            let (process, effect) = cycle(&POWER, number);
            Draft { rung: cycle(&POWER_RUNGS, number / POWER.len()), ..Draft::new([effect], process, varied) }
        }
    };
    // Each case has its own workpieces.
    let seed = Stream::of(seed, &format!("{family:?}{number}")).below(1 << 31) as u64;
    let hidden = hidden.into_iter().map(str::to_owned).collect();
    Case { family, number, design: Design { process, plan, front, seed }, hidden, rung }
}

fn cycle<T: Copy>(list: &[T], number: usize) -> T {
    list[number % list.len()]
}

/// All effects of the library that may be hidden, when grinding and when sanding.
fn singles(library: &Library) -> Vec<(&str, Process)> {
    let known = library.effects().iter().filter(|effect| !NEVER_HIDDEN.contains(&effect.name.as_str()));
    known.flat_map(|effect| acting(effect).map(|process| (effect.name.as_str(), process))).collect()
}

/// Processes in which an effect acts.
fn acting(effect: &Effect) -> impl Iterator<Item = Process> {
    [Process::Grinding, Process::Sanding].into_iter().filter(|&process| effect.acts_in(process))
}

/// The single effect of a case; successive cases go round the library.
fn single(number: usize, library: &Library) -> Draft<'_> {
    let singles = singles(library);
    let (round, (effect, process)) = (number / singles.len(), singles[number * STRIDE % singles.len()]);
    let steps = process == Process::Grinding && round % 2 == 1;
    let plan = if steps { Plan::Steps } else { Plan::Varied };
    Draft { rung: cycle(&RUNGS, round), ..Draft::new([effect], process, plan) }
}

/// A hard front end, and the effect hidden behind it.
fn behind(number: usize) -> Draft<'static> {
    let front = cycle(&FRONTS, number);
    let list = if front == FrontEnd::Worn { &HIDDEN_BEHIND_WORN_TOOL } else { &HIDDEN_BEHIND_FRONT_ENDS };
    // Adding the round prevents a front end from always meeting the same hidden effects first.
    let (process, hidden) = cycle(list, number / FRONTS.len() + number % FRONTS.len());
    Draft { front, ..Draft::new(hidden, process, Plan::Varied) }
}

/// Effects outside the library, each once, then those of them that act in both processes once more, then [`NO_CAUSE`].
fn outsiders() -> Vec<(String, Process)> {
    let all = outside::with_outside(Library::builtin()).expect("their names are free");
    let is_outside = |effect: &&Effect| outside::EFFECTS.iter().any(|(file, _)| *file == effect.file);
    let own: Vec<&Effect> = all.effects().iter().filter(is_outside).collect();
    let nth = |n: usize| own.iter().filter_map(move |effect| Some((effect.name.clone(), acting(effect).nth(n)?)));
    nth(0).chain(nth(1)).chain([(NO_CAUSE.to_owned(), Process::Grinding)]).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_round_of_single_effects_meets_each_once_and_the_next_takes_another_rung() {
        let library = Library::builtin();
        let count = singles(library).len();
        for family in [Family::S, Family::L] {
            let cases = cases(&[family], 2 * count, 1, library);
            for round in 0..2 {
                let cases = &cases[round * count..(round + 1) * count];
                let met: BTreeSet<(&str, bool)> =
                    cases.iter().map(|c| (c.hidden[0].as_str(), c.design.process == Process::Sanding)).collect();
                assert_eq!(met.len(), count, "each effect once in each process, as far as it acts there");
                let rung = if family == Family::S { RUNGS[round] } else { 1.0 };
                assert!(cases.iter().all(|case| case.rung == rung && case.is_left_out() == (family == Family::L)));
            }
        }
    }

    #[test]
    fn every_effect_of_the_library_and_all_outside_it_are_hidden_somewhere() {
        let library = Library::builtin();
        let all = cases(&Family::ALL, 60, 1, library);
        let hidden: BTreeSet<&str> = all.iter().flat_map(|case| &case.hidden).map(String::as_str).collect();
        let missing: Vec<&str> =
            library.effects().iter().map(|e| e.name.as_str()).filter(|name| !hidden.contains(name)).collect();
        assert_eq!(missing, Vec::<&str>::new());
        let outside: BTreeSet<String> =
            cases(&[Family::U], 8, 1, library).into_iter().map(|c| c.hidden[0].clone()).collect();
        assert_eq!(outside.len(), outside::EFFECTS.len(), "the first eight are all there are");
    }

    #[test]
    fn every_case_has_a_seed_of_its_own_and_other_seeds_give_others() {
        let library = Library::builtin();
        let [one, other] = [1, 2].map(|seed| cases(&Family::ALL, 20, seed, library));
        let seeds = |cases: &[Case]| cases.iter().map(|case| case.design.seed).collect::<BTreeSet<_>>();
        assert_eq!(seeds(&one).len(), one.len());
        assert!(seeds(&one).is_disjoint(&seeds(&other)));
    }

    #[test]
    fn each_front_end_is_met_with_nothing_hidden_and_with_effects() {
        let cases = cases(&[Family::H], 36, 1, Library::builtin());
        for front in FRONTS {
            let behind: Vec<&Case> = cases.iter().filter(|case| case.design.front == front).collect();
            let empty = behind.iter().filter(|case| case.hidden.is_empty()).count();
            assert!(behind.len() == 6 && (1..=2).contains(&empty), "{front:?}: {empty} of {}", behind.len());
        }
    }
}
