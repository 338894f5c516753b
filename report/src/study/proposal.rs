//! Proposed effects: curve, file, and the other fitted forms.

use super::number::{p_value, significant};
use crate::{Cell, Chart, Page, Series, Stroke, Table, escape};
use lab::{FittedForm, Proposal, ProposedForm};
use study::{MODEL_WITH_PROPOSAL, PROPOSED_EFFECTS, with_raised_powers};

/// Files of each form: the form, and its curve.
const FILES_PER_FORM: usize = 2;
const SIZE: (f64, f64) = (640.0, 300.0);
const CURVE: Stroke = Stroke { colour: "#0072b2", dashed: false };
const FORM: Stroke = Stroke { colour: "#d55e00", dashed: true };

/// Appends the proposal.
pub(super) fn add(page: &mut Page, proposal: &Proposal) {
    page.part("proposed", "A form for what no known effect explains");
    let summaries: Vec<String> = proposal.forms.iter().map(|form| with_raised_powers(&form.summary)).collect();
    page.paragraph(&format!("From the data alone: {}. {}", summaries.join("; and "), fall(proposal)));
    for (form, (file, text)) in proposal.forms.iter().zip(proposal.files.iter().step_by(FILES_PER_FORM)) {
        page.block(&format!(
            "<figure>{}<figcaption>A curve of no form with its 95 % band, and the form. Where the form leaves the band, another \
             one fits better.</figcaption></figure>\n<p>The file <code>{PROPOSED_EFFECTS}/{}</code> holds it.</p>\n<pre>{}</pre>\n{}",
            drawing(form),
            escape(file),
            escape(text),
            forms(&form.fitted)
        ));
    }
    page.block(&format!(
        "<p>Give it a name and a cause, and continue with <code>--model {MODEL_WITH_PROPOSAL} \
         --effects {PROPOSED_EFFECTS}</code>.</p>\n",
    ));
}

/// Returns a sentence with the error after each step of the proposal.
fn fall(proposal: &Proposal) -> String {
    let (symbol, per_one) = (proposal.error_unit.symbol(), proposal.error_unit.per_one());
    let shown = |error: &f64| significant(error * per_one, 3);
    let all = |errors: Vec<f64>| errors.iter().map(shown).collect::<Vec<_>>().join(", then ");
    let seen = all(proposal.errors.iter().map(|step| step.calibration_rms).collect());
    let held_out: Option<Vec<f64>> = proposal.errors.iter().map(|step| step.evaluation_rms).collect();
    let held_out =
        held_out.map_or(String::new(), |errors| format!("; that of the evaluation passes {} {symbol}", all(errors)));
    format!("The error of the calibration passes is {seen} {symbol}{held_out}.")
}

fn drawing(form: &ProposedForm) -> String {
    let curve = Series {
        stroke: Some(CURVE),
        band: form.curve.iter().map(|point| (point.band[0], point.band[1])).collect(),
        ..Series::new("curve", form.curve.iter().map(|point| (point.at, point.change)).collect())
    };
    let own = form.curve.iter().map(|point| (point.at, point.form)).collect();
    let own = Series { stroke: Some(FORM), ..Series::new("form", own) };
    let ([acts_on, change], [about, unit]) = (&form.acts_on, &form.variable);
    let unit = if unit == "1" { String::new() } else { format!(" [{}]", with_raised_powers(unit)) };
    Chart {
        title: &format!("Change of the {acts_on} over the {about}"),
        x_label: &format!("{about}{unit}"),
        y_label: &format!("change of the {acts_on} [{change}]"),
        series: &[curve, own],
        size: SIZE,
        from_zero: false,
        band: None,
    }
    .to_svg()
}

/// Builds the table of all fitted forms.
fn forms(forms: &[FittedForm]) -> String {
    let mut table = Table::new("Forms that were fitted", &["form", "in words", "Δχ²", "predicts better by", "p-value"]);
    for form in forms {
        table.rows.push(vec![
            Cell::text(&form.name),
            Cell::text(with_raised_powers(&form.summary)),
            Cell::number(significant(form.delta_chi2, 4), form.delta_chi2),
            Cell::number(significant(form.predicts_better_by, 4), form.predicts_better_by),
            Cell::number(p_value(form.p_value), form.p_value),
        ]);
    }
    table.to_html()
}
