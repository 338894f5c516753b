//! What follows from a diagnosis: its numbers, a form for what is unknown, the trial that would tell rivals apart.

use effects::Library;
use lab::Result;

use super::measurements::Data;
use lab::{
    Diagnosis, DiagnosisSummary, Proposal, Verdict, propose, separating_row, separating_trial, testing_row,
    testing_trial,
};

/// Sums up a diagnosis. Where several hypotheses are still in play it has the trial that says most about them. Where none is beside
/// the one that was found, but equal passes go on as the base law cannot, it has the trial that would test that one. The
/// instrument's blur stays at what the diagnosed model finds.
///
/// # Errors
/// When a model cannot be simulated.
pub fn summary(data: &mut Data, diagnosis: &Diagnosis, library: &Library) -> Result<DiagnosisSummary> {
    let title = |name: &str| library.find(name).map_or(String::new(), |effect| effect.title.clone());
    let mut summary = DiagnosisSummary::new(data.evidence(), diagnosis, &title)?;
    data.fix_observation(&diagnosis.fit.model)?;
    let is_beyond_the_law = summary.equal_passes.as_ref().is_some_and(|trend| trend.out_of_reach);
    let is_identified = diagnosis.verdict == Verdict::Identified;
    if is_identified && !is_beyond_the_law {
        return Ok(summary);
    }
    summary.next_trial = match (data.scans(), data.rows()) {
        (Some((_, evidence)), _) if diagnosis.live_hypotheses().is_some() => separating_trial(evidence, diagnosis)?,
        (None, Some(rows)) if diagnosis.rivals().is_some() => separating_row(rows, diagnosis)?,
        (Some((_, evidence)), _) if is_beyond_the_law => testing_trial(evidence, diagnosis)?,
        (None, Some(rows)) if is_beyond_the_law => testing_row(rows, diagnosis)?,
        _ => None,
    };
    Ok(summary)
}

/// A form of the rate for what is missing and not in the library, where something is.
///
/// # Errors
/// When a model cannot be simulated.
pub fn proposal(data: &Data, diagnosis: &Diagnosis, library: &Library, seed: u64) -> Result<Option<Proposal>> {
    match diagnosis.verdict {
        Verdict::Unknown | Verdict::Partly => {
            Ok(propose(data.evidence(), (&diagnosis.model, &diagnosis.fit), library, seed)?)
        }
        _ => Ok(None),
    }
}
