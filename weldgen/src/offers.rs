//! Advice if nothing fits: each dial is relaxed alone, and a weld that then fits shows what the part allows.

use crate::bead::BeadProfile;
use crate::dial_fault::{shown, shown_mm};
use crate::fit::first_fit;
use crate::place::{DrawnDials, Search};
use crate::propose::{Candidate, mix};
use crate::rejection::Tally;
use crate::request::WIDTHS_PER_LENGTH;

/// Proposals tried with one dial relaxed.
const ATTEMPTS: usize = 96;
/// Factors on the length and on the width that are tried, largest first.
const FACTORS: [f64; 6] = [0.8, 0.6, 0.45, 0.3, 0.2, 0.1];

/// Returns a sentence for each dial that alone makes the weld fit when relaxed, or one sentence if none does.
pub(crate) fn offers(search: &Search, wanted: &DrawnDials, profile: BeadProfile, seed: u64) -> Vec<String> {
    let fits = |wanted: DrawnDials, profile: BeadProfile| -> Option<Candidate> {
        let proposals = search.proposals(&wanted, profile);
        first_fit(&proposals, ATTEMPTS, mix(seed, usize::MAX), &mut Tally::default(), &mut 0.0)
    };
    let mut offers = Vec::new();
    let lengths = FACTORS.map(|factor| factor * wanted.length).into_iter();
    let shorter = lengths.filter(|length| *length >= WIDTHS_PER_LENGTH * profile.width);
    if let Some(length) = shorter.map(|length| DrawnDials { length, ..*wanted }).find(|w| fits(*w, profile).is_some()) {
        offers.push(format!("the length is impossible: {:.2} mm fits", 1e3 * length.length));
    }
    let mut calmer = [0.5, 0.0].map(|factor| factor * wanted.curvature_rms).into_iter();
    if wanted.curvature_rms > 0.0
        && let Some(rms) =
            calmer.find(|&curvature_rms| fits(DrawnDials { curvature_rms, ..*wanted }, profile).is_some())
    {
        offers.push(format!("the curvature is impossible: {rms:.3} 1/m RMS fits"));
    }
    if wanted.exposure != [0.0, 1.0]
        && let Some(fit) = fits(DrawnDials { exposure: [0.0, 1.0], ..*wanted }, profile)
    {
        offers.push(format!("the exposure is impossible: {:.2} fits", fit.curve.min_exposure()));
    }
    let narrower =
        |factor: f64| BeadProfile { width: factor * profile.width, height: factor * profile.height, ..profile };
    if let Some(thin) = FACTORS.map(narrower).into_iter().find(|narrow| fits(*wanted, *narrow).is_some()) {
        offers.push(format!("the bead is impossible: {:.3} mm wide fits", 1e3 * thin.width));
    }
    if offers.is_empty() {
        let [low, high] = wanted.exposure;
        offers.push(format!(
            "relaxing any single one of length ({}), curvature ({} 1/m RMS), exposure ({low:.2} to {high:.2}) or width ({}) is \
             not enough: relax several, or use another part",
            shown_mm(wanted.length),
            shown(wanted.curvature_rms),
            shown_mm(profile.width)
        ));
    }
    offers
}
