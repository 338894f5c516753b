//! The menu: variants of a trial that was made, each on one new workpiece.

use glam::DVec2;

use effects::Signal;
use robot::Controller;
use trials::trial::{ForceInput, Trial};

use super::design::Design;
use trial_simulation::PassPlan;

/// Most passes of the template trial that variants use.
const MOST_PASSES: usize = 4;
/// Factors of force and feed, in all combinations.
const FORCES: [f64; 5] = [1.0, 0.5, 0.7, 1.4, 2.0];
const FEEDS: [f64; 3] = [1.0, 0.5, 2.0];
/// Factors of the spindle speed.
const SPINDLES: [f64; 2] = [0.6, 1.4];
/// Factors of the feed on the second half of each pass.
const FEED_STEPS: [f64; 3] = [0.5, 2.0, 3.0];
/// Factors for the two halves of a pass, or for successive passes.
const FORCE_PAIRS: [[f64; 2]; 2] = [[0.6, 1.6], [1.6, 0.6]];
const FEED_PAIRS: [[f64; 2]; 2] = [[0.5, 2.0], [2.0, 0.5]];
const SPINDLE_PAIRS: [[f64; 2]; 2] = [[1.0, 0.6], [1.0, 1.4]];
/// Pauses between passes [s].
const PAUSES: [f64; 2] = [60.0, 300.0];
/// Factors of force and feed with a worn tool.
const WORN: [[f64; 2]; 4] = [[1.0, 1.0], [0.6, 1.0], [1.6, 1.0], [1.0, 0.5]];
/// Number of scans of each surface.
const SCANS: [usize; 2] = [2, 4];
/// Shift across the feed, over half of the tool's width.
const ACROSS: f64 = 0.25;
/// Numbers of repetitions of all passes.
const TIMES: [usize; 2] = [2, 3];

/// A menu under construction.
struct Menu<'a> {
    template: &'a Trial,
    passes: Vec<PassPlan>,
    designs: Vec<Design>,
}

/// All variants of a trial; the trial itself comes first. Empty if its tool never touched.
pub(super) fn menu(template: &Trial) -> Vec<Design> {
    let made = template.passes.iter().take(MOST_PASSES);
    let passes: Vec<PassPlan> = made.filter_map(|pass| PassPlan::of(pass, &template.tool)).collect();
    if passes.is_empty() {
        return Vec::new();
    }
    let mut menu = Menu { template, passes, designs: Vec::new() };
    menu.add_settings();
    menu.add_steps();
    menu.add_contrasts();
    menu.add_tool_states();
    menu.add_ways();
    menu.add_lengths();
    menu.add_scans();
    menu.designs
}

impl Menu<'_> {
    /// Adds a trial with a fresh tool, unless it is already on the menu.
    fn add(&mut self, what: impl Into<String>, passes: Vec<PassPlan>) {
        let stage = self.stage(passes, true);
        self.push(Design { what: what.into(), stages: vec![stage], scans: 1 });
    }

    fn push(&mut self, design: Design) {
        let is_known = |known: &Design| known.stages == design.stages && known.scans == design.scans;
        if !self.designs.iter().any(is_known) {
            self.designs.push(design);
        }
    }

    /// Builds the trial of these passes. A replayed log has no controller, so an ideal one takes its place; setpoints
    /// of the plan replace logged forces.
    fn stage(&self, passes: Vec<PassPlan>, fresh: bool) -> Trial {
        let controller = match self.template.controller {
            Controller::Replay => Controller::Ideal,
            controller => controller,
        };
        let passes = passes.into_iter().map(PassPlan::into_pass).collect();
        let notes = Vec::new();
        let force_input = ForceInput::Setpoint;
        Trial { passes, fresh, controller, force_input, notes, findings: Vec::new(), ..self.template.clone() }
    }

    /// Applies a change to each pass.
    fn each(&self, change: impl Fn(PassPlan) -> PassPlan) -> Vec<PassPlan> {
        self.passes.iter().cloned().map(change).collect()
    }

    /// The passes, at least two of them.
    fn several(&self) -> Vec<PassPlan> {
        let count = self.passes.len().max(2);
        self.passes.iter().cycle().take(count).cloned().collect()
    }

    /// Applies a change that depends on the parity of the pass.
    fn alternating(&self, change: impl Fn(PassPlan, usize) -> PassPlan) -> Vec<PassPlan> {
        self.several().into_iter().enumerate().map(|(number, pass)| change(pass, number % 2)).collect()
    }

    /// Variants of force, feed and spindle speed of all passes.
    fn add_settings(&mut self) {
        for force in FORCES {
            for feed in FEEDS {
                let what = match (force == 1.0, feed == 1.0) {
                    (true, true) => "the same passes".to_owned(),
                    (false, true) => format!("the same passes at {force} times the force"),
                    (true, false) => format!("the same passes at {feed} times the feed"),
                    _ => format!("the same passes at {force} times the force and {feed} times the feed"),
                };
                self.add(what, self.each(|pass| pass.with_force(force).with_feed([feed; 2])));
            }
        }
        for factor in SPINDLES {
            let passes = self.each(|pass| pass.with_spindle(factor));
            self.add(format!("the same passes at {factor} times the spindle speed"), passes);
        }
    }

    /// Steps along each pass. A pass has one force and one spindle speed, so a step of these is two passes, each over
    /// half of the path.
    fn add_steps(&mut self) {
        for factor in FEED_STEPS {
            let passes = self.each(|pass| pass.with_feed([1.0, factor]));
            self.add(format!("the same passes, the second half of each at {factor} times the feed"), passes);
        }
        let halves = |pass: &PassPlan| Some([pass.clone().part(0.0..0.5)?, pass.clone().part(0.5..f64::INFINITY)?]);
        let Some(halves) = self.passes.iter().map(halves).collect::<Option<Vec<_>>>() else { return };
        let stepped = |change: &dyn Fn(PassPlan, usize) -> PassPlan| -> Vec<PassPlan> {
            halves.iter().flat_map(|[first, second]| [change(first.clone(), 0), change(second.clone(), 1)]).collect()
        };
        for factors in FORCE_PAIRS {
            let passes = stepped(&|pass, half| pass.with_force(factors[half]));
            self.add(steps_of("force", factors), passes);
        }
        for factors in SPINDLE_PAIRS {
            let passes = stepped(&|pass, half| pass.with_spindle(factors[half]));
            self.add(steps_of("spindle speed", factors), passes);
        }
    }

    /// Successive passes with different settings.
    fn add_contrasts(&mut self) {
        for factors in FORCE_PAIRS {
            let passes = self.alternating(|pass, odd| pass.with_force(factors[odd]));
            self.add(by_turns("force", factors), passes);
        }
        for factors in FEED_PAIRS {
            let passes = self.alternating(|pass, odd| pass.with_feed([factors[odd]; 2]));
            self.add(by_turns("feed", factors), passes);
        }
        for factors in SPINDLE_PAIRS {
            let passes = self.alternating(|pass, odd| pass.with_spindle(factors[odd]));
            self.add(by_turns("spindle speed", factors), passes);
        }
        for pause in PAUSES {
            let mut end = -pause;
            let passes = self.several().into_iter().map(|pass| {
                let pass = pass.begun_at(end + pause);
                end = pass.end();
                pass
            });
            let passes = passes.collect();
            self.add(format!("the same passes with a pause of {} min between them", pause / 60.0), passes);
        }
    }

    /// A tool that is dressed between passes, and one that is not dressed at all.
    fn add_tool_states(&mut self) {
        for force in [1.0, FORCE_PAIRS[0][1]] {
            let mut first = self.several();
            let second = first.split_off(1).into_iter().map(|pass| pass.with_force(force)).collect();
            let at = if force == 1.0 { String::new() } else { format!(", those after it at {force} times the force") };
            let stages = vec![self.stage(first, true), self.stage(second, true)];
            self.push(Design { what: format!("the tool dressed after the first pass{at}"), stages, scans: 1 });
        }
        for [force, feed] in WORN {
            let passes = self.each(|pass| pass.with_force(force).with_feed([feed; 2]));
            let at = match (force == 1.0, feed == 1.0) {
                (true, true) => String::new(),
                (false, _) => format!(" at {force} times the force"),
                _ => format!(" at {feed} times the feed"),
            };
            let what = format!("the same passes{at} with the tool as the last trial left it");
            self.push(Design { what, stages: vec![self.stage(passes, false)], scans: 1 });
        }
    }

    /// Variants of direction and lateral position.
    fn add_ways(&mut self) {
        self.add("the same passes in the opposite direction", self.each(PassPlan::reversed));
        let passes = self.alternating(|pass, odd| if odd == 1 { pass.reversed() } else { pass });
        self.add("the same passes, each second one in the opposite direction", passes);
        if let Some(passes) = self.passes.iter().cloned().map(|pass| pass.part(0.0..0.5)).collect() {
            self.add("the first half of each pass", passes);
        }
        // A panel is sanded over its whole area.
        if self.template.process.signal() == Signal::Dose {
            return;
        }
        let (tool, surface) = (&self.template.tool, self.template.scans.clean_before());
        for side in [-1.0, 1.0] {
            let by = DVec2::new(0.0, side * ACROSS * tool.half_width());
            let shifted = |pass: &PassPlan| pass.clone().shifted(by, (tool, &surface));
            if let Some(passes) = self.passes.iter().map(shifted).collect() {
                self.add(format!("the same passes, shifted by {:.1} mm across", by.y * 1e3), passes);
            }
        }
    }

    /// More and fewer passes.
    fn add_lengths(&mut self) {
        for times in TIMES {
            let count = times * self.passes.len();
            let passes = self.passes.iter().cycle().take(count).cloned().collect();
            self.add(format!("the same passes {times} times"), passes);
        }
        self.add("the first pass alone", vec![self.passes[0].clone()]);
    }

    /// Repeated scans of each surface, which average noise. The border of a mask does not improve by averaging.
    fn add_scans(&mut self) {
        if self.template.process.signal() == Signal::Dose {
            return;
        }
        for scans in SCANS {
            let stages = vec![self.stage(self.passes.clone(), true)];
            let what = format!("the same passes with {scans} scans of each surface, whose mean counts");
            self.push(Design { what, stages, scans });
        }
    }
}

fn steps_of(setting: &str, [first, second]: [f64; 2]) -> String {
    format!("each pass in two halves, the first at {first} and the second at {second} times the {setting}")
}

fn by_turns(setting: &str, [first, second]: [f64; 2]) -> String {
    format!("the same passes by turns at {first} and {second} times the {setting}")
}
