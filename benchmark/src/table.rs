//! The benchmark as a page of tables.

use effects::{Library, Process};

use super::answer::CaseAnswer;
use super::cases::Family;
use super::coverage::Coverage;
use super::error_gap::GapClosed;
use super::forecast::Reliability;
use super::ladder::{RUNGS, rung};
use super::outcome::Outcome;
use super::power::Power;
use super::summary::{Scores, Summary};
use virtual_lab::Size;

/// Header of a table of scores.
const SCORES: &str = "| | right | class | too shy | false alarm | wrong name | unknown said | Brier |\n\
                      |---|---|---|---|---|---|---|---|\n";

/// Description of a family, as the table prints it.
fn about(family: Family) -> &'static str {
    match family {
        Family::N => "nothing hidden",
        Family::S => "one effect of the library",
        Family::L => "one effect, left out of the library",
        Family::U => "outside the library",
        Family::H => "hard front ends",
        Family::A => "absorbed by base parameters or poses",
        Family::D => "two effects",
        Family::P => "two equal passes",
        Family::W => "a few effects, for their detectable size",
    }
}

impl Scores {
    fn row(&self, name: &str) -> String {
        let Self { right, class, too_shy, false_alarm, wrong_name, unknown_said, brier } = self;
        let unknown = if unknown_said.of == 0 { "-".to_owned() } else { unknown_said.to_string() };
        format!("| {name} | {right} | {class} | {too_shy} | {false_alarm} | {wrong_name} | {unknown} | {brier:.2} |\n")
    }
}

impl Summary {
    /// All tables, with a line for every case.
    ///
    /// - `library`: library whose effects' sizes are listed
    pub fn to_markdown(&self, outcomes: &[Outcome], (library, size): (&Library, Size)) -> String {
        let mut text =
            format!("# Benchmark of the study\n\n{} cases, refused {}.\n\n{SCORES}", self.cases, self.refused);
        text += &self.all.study.row("`robofin study`");
        text += &self.all.residual_regression.row("residual regression");
        text += &self.all.most_common_effect.row("always the most common effect");
        let groups = [
            ("family", self.families.iter().map(|(k, s)| s.row(&format!("{k:?}: {}", about(*k)))).collect::<String>()),
            ("front end", self.front_ends.iter().map(|(front, scores)| scores.row(front)).collect()),
            ("process", self.processes.iter().map(|(process, scores)| scores.row(process)).collect()),
            (
                "size of single effects over the visible one",
                self.rungs.iter().map(|(r, s)| s.row(&r.to_string())).collect(),
            ),
        ];
        for (name, rows) in groups.iter().filter(|(_, rows)| !rows.is_empty()) {
            text += &format!("\n## By {name}\n\n{SCORES}{rows}");
        }
        text += &self.rates();
        text += &reliability("All statements", &self.reliability);
        text += &reliability("The most probable statement of each case", &self.reliability_of_first);
        text += &self.coverage_table();
        text += &power(&self.power);
        text += &sizes(library, size);
        text + &all_cases(outcomes)
    }

    fn rates(&self) -> String {
        let gap = |gap: &GapClosed| match (gap.median, gap.mean) {
            (Some(median), Some(mean)) => {
                format!("median {:.0} %, mean {:.0} % of {} cases", 100.0 * median, 100.0 * mean, gap.cases)
            }
            _ => "no case with a gap".to_owned(),
        };
        format!(
            "\n- answers other than that nothing is missing, where nothing is hidden: {}\n- wrong among answers with a name: {}\n\
             - ambiguous answers with a next trial: {}\n- held-out error gap closed where effects are hidden: {}\n\
             - the same of right answers: {}\n- median time of a study: {:.0} s\n",
            self.false_alarms,
            self.wrong_of_named,
            self.next_trials,
            gap(&self.error_gap),
            gap(&self.error_gap_of_right),
            self.seconds
        )
    }

    fn coverage_table(&self) -> String {
        let mut text = "\n## Intervals of 95 %\n\n| cases | parameter | hold the truth | without an interval | found over true, median |\n\
                        |---|---|---|---|---|\n"
            .to_owned();
        for of in &self.coverage {
            for Coverage { name, held, without, ratio } in &of.parameters {
                let ratio = ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"));
                text += &format!("| {} | {name} | {held} | {without} | {ratio} |\n", of.cases);
            }
        }
        text
    }
}

fn reliability(title: &str, Reliability { bins, calibration_error }: &Reliability) -> String {
    let mut text = format!(
        "\n## Probabilities: {title}\n\nCalibration error {calibration_error:.3}.\n\n| stated | mean | true |\n|---|---|---|\n"
    );
    for bin in bins {
        let [low, high] = bin.range;
        text += &format!("| {low:.1} to {high:.1} | {:.2} | {} |\n", bin.stated, bin.is_true);
    }
    text
}

fn power(all: &[Power]) -> String {
    let mut text = "\n## Detectable sizes\n\nOver the visible size, from the share of cases whose effect is named or in the class.\n\n\
                    | effect | cases | tried | half of the cases | nine of ten |\n|---|---|---|---|---|\n"
        .to_owned();
    let from = |size: Option<f64>| size.map_or("not reached".to_owned(), |size| format!("{size:.2}"));
    for Power { effect, cases, tried: [least, greatest], half, nine_of_ten } in all {
        let (half, nine) = (from(*half), from(*nine_of_ten));
        text += &format!("| {effect} | {cases} | {least} to {greatest} | {half} | {nine} |\n");
    }
    text
}

/// Table of the ladder of every effect of the library.
fn sizes(library: &Library, size: Size) -> String {
    let mut rungs = RUNGS;
    rungs.sort_by(f64::total_cmp);
    let heads: String = rungs.iter().map(|rung| format!(" {rung} |")).collect();
    let mut text =
        format!("\n## Sizes\n\n| effect | process | parameter |{heads}\n|---|---|---|{}\n", "---|".repeat(rungs.len()));
    for effect in library.effects() {
        let acts = |process: &Process| effect.acts_in(*process);
        for process in [Process::Grinding, Process::Sanding].into_iter().filter(acts) {
            let columns = rungs.map(|factor| rung(effect, (process, size), factor));
            for (k, first) in columns[0].iter().enumerate() {
                let values: String = columns.iter().map(|column| format!(" {} |", column[k].value)).collect();
                let parameter = format!("{} [{}]", first.parameter, first.unit);
                text += &format!("| {} | {} | {parameter} |{values}\n", effect.name, process.name());
            }
        }
    }
    text
}

fn all_cases(outcomes: &[Outcome]) -> String {
    let mut text = "\n## Every case\n\n| case | design | hidden | size | verdict | named (indistinguishable) | none | held out: base, final, \
                    floor [µm] | judged |\n|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    outcomes.iter().for_each(|outcome| text += &row(outcome));
    for outcome in outcomes {
        let Some(why) = &outcome.refused else { continue };
        text += &format!("\n{}: {why}\n", outcome.case.id());
    }
    text
}

fn row(outcome: &Outcome) -> String {
    let case = &outcome.case;
    let error = |error: Option<f64>| error.map_or("-".to_owned(), |error| format!("{:.2}", 1e6 * error));
    format!(
        "| {} | {} | {}{} | {} | {} | {} | {:.2} | {}, {}, {} | {} |\n",
        case.id(),
        case.design.id(),
        case.hidden.join(" + "),
        if case.is_left_out() { " (not in the library)" } else { "" },
        case.rung,
        outcome.said.verdict_word(),
        outcome.said.names(),
        outcome.forecast.none,
        error(outcome.errors.base),
        error(outcome.errors.found),
        error(outcome.errors.floor),
        outcome.judgement.word()
    )
}

impl CaseAnswer {
    /// The verdict as `--json` writes it.
    pub fn verdict_word(&self) -> &'static str {
        self.verdict.map_or("refused", lab::Verdict::word)
    }

    /// Named effects, each followed by its indistinguishable ones in brackets, then the effect of a hint.
    pub fn names(&self) -> String {
        let named = self.named.iter().map(|named| match named.alike.is_empty() {
            true => named.name.clone(),
            false => format!("{} ({})", named.name, named.alike.join(", ")),
        });
        named.chain(self.hint.iter().map(|hint| format!("hint: {hint}"))).collect::<Vec<_>>().join(" + ")
    }
}
