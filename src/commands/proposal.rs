//! Files of an effect that is proposed for what no effect of the library describes, in the folder of a study or a
//! diagnosis.

use std::path::Path;

use anyhow::{Context, Result};

use crate::console::Console;
use lab::{Proposal, WaterfallStep};

/// Folder of the effect files.
pub(super) const PROPOSED_EFFECTS: &str = "effects";
/// The model with the proposed effect.
pub(super) const MODEL_WITH_PROPOSAL: &str = "model-with-proposal.toml";

/// Writes the effect files and the model with the effect, and says what they are.
pub(super) fn write_proposal(proposal: &Proposal, folder: &Path, console: &Console) -> Result<()> {
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).with_context(|| format!("{name}: cannot be written"))
    };
    std::fs::create_dir_all(folder.join(PROPOSED_EFFECTS))?;
    for (file, text) in &proposal.files {
        write(&format!("{PROPOSED_EFFECTS}/{file}"), text)?;
    }
    write(MODEL_WITH_PROPOSAL, &proposal.model)?;
    let error = |step: &WaterfallStep| format!("{:.2}", step.evaluation_rms_um.unwrap_or(step.calibration_rms_um));
    let which = if proposal.errors[0].evaluation_rms_um.is_some() { "held-out error" } else { "error" };
    let errors: Vec<String> = proposal.errors.iter().map(error).collect();
    for form in &proposal.forms {
        console.step("proposed", format!("{}: {PROPOSED_EFFECTS}/{}.toml", form.summary, form.name));
    }
    console.step(
        "error",
        format!(
            "{which} {} {}; give it a name and a cause, and go on with --model {MODEL_WITH_PROPOSAL} --effects {PROPOSED_EFFECTS}",
            errors.join(", then "),
            proposal.error_unit.symbol()
        ),
    );
    Ok(())
}
