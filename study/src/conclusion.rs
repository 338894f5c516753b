//! Conclusions from a diagnosis: its summary, a form for an unknown effect, and the trial that distinguishes rivals.

use effects::Library;
use lab::Result;

use super::measurements::Data;
use experiments::{live_hypotheses, separating_row, separating_trial, testing_row, testing_trial};
use lab::{Diagnosis, DiagnosisSummary, Proposal, Verdict, propose};

/// Summarises a diagnosis. If several hypotheses are still in play, it proposes the most informative trial. If only the
/// effect that was found is left, but the base law cannot reproduce the trend of equal passes, it proposes a trial that
/// tests this effect. The instrument's blur stays at the value of the diagnosed model.
///
/// # Errors
/// If a model cannot be simulated.
pub fn summary(data: &mut Data, diagnosis: &Diagnosis, library: &Library) -> Result<DiagnosisSummary> {
    let title = |name: &str| library.find(name).map_or(String::new(), |effect| effect.title.clone());
    let mut summary = DiagnosisSummary::new(data.evidence(), diagnosis, &title)?;
    data.fix_nuisances(&diagnosis.fit.model)?;
    let is_beyond_the_law = summary.equal_passes.as_ref().is_some_and(|trend| trend.out_of_reach);
    let is_identified = diagnosis.verdict == Verdict::Identified;
    if is_identified && !is_beyond_the_law {
        return Ok(summary);
    }
    summary.next_trial = match (data.scans(), data.rows()) {
        (Some((_, evidence)), _) if live_hypotheses(diagnosis).is_some() => separating_trial(evidence, diagnosis)?,
        (None, Some(rows)) if diagnosis.rivals().is_some() => separating_row(rows, diagnosis)?,
        (Some((_, evidence)), _) if is_beyond_the_law => testing_trial(evidence, diagnosis)?,
        (None, Some(rows)) if is_beyond_the_law => testing_row(rows, diagnosis)?,
        _ => None,
    };
    Ok(summary)
}

/// Proposes a form of the rate for an effect that is missing from the library; `None` if nothing is missing.
///
/// # Errors
/// If a model cannot be simulated.
pub fn proposal(data: &Data, diagnosis: &Diagnosis, library: &Library, seed: u64) -> Result<Option<Proposal>> {
    match diagnosis.verdict {
        Verdict::Unknown | Verdict::Partly => {
            Ok(propose(data.evidence(), (&diagnosis.model, &diagnosis.fit), library, seed)?)
        }
        _ => Ok(None),
    }
}
