//! Files of proposed effects, in the folder of a study or a diagnosis.

use std::path::Path;
use std::{fs, io};

use super::unit_text::with_raised_powers;
use lab::{Proposal, WaterfallStep};

/// Folder of the effect files.
pub const PROPOSED_EFFECTS: &str = "effects";
/// File of the model with the proposed effect.
pub const MODEL_WITH_PROPOSAL: &str = "model-with-proposal.toml";

/// Writes the effect files and the model with them; returns lines for the console, each with its label.
///
/// # Errors
/// If a file cannot be written, with its name.
pub fn write_proposal(proposal: &Proposal, folder: &Path) -> io::Result<Vec<(&'static str, String)>> {
    let write = |name: &str, text: &str| {
        let named = |error: io::Error| io::Error::new(error.kind(), format!("{name}: cannot be written: {error}"));
        fs::write(folder.join(name), text).map_err(named)
    };
    fs::create_dir_all(folder.join(PROPOSED_EFFECTS))?;
    for (file, text) in &proposal.files {
        write(&format!("{PROPOSED_EFFECTS}/{file}"), text)?;
    }
    write(MODEL_WITH_PROPOSAL, &proposal.model)?;
    let form = |form: &lab::ProposedForm| {
        ("proposed", format!("{}: {PROPOSED_EFFECTS}/{}.toml", with_raised_powers(&form.summary), form.name))
    };
    Ok(proposal.forms.iter().map(form).chain([("error", errors(proposal))]).collect())
}

/// Sentence on the fall of the error, and on the next step.
fn errors(proposal: &Proposal) -> String {
    let unit = proposal.error_unit;
    let error = |step: &WaterfallStep| unit.shown(step.evaluation_rms.unwrap_or(step.calibration_rms));
    let which = if proposal.errors[0].evaluation_rms.is_some() { "held-out error" } else { "error" };
    let errors: Vec<String> = proposal.errors.iter().map(error).collect();
    format!(
        "{which} {}; give it a name and a cause, and continue with --model {MODEL_WITH_PROPOSAL} \
         --effects {PROPOSED_EFFECTS}",
        errors.join(", then ")
    )
}
