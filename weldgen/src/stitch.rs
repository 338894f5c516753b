//! Intermittent welds: one curve, several beads.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::bead::{BeadError, BeadForm, sweep_formed};
use crate::curve::{CurvePoint, WeldCurve};
use crate::place::Weld;
use crate::propose::mix;
use crate::request::Stitch;

/// The beads of an intermittent weld on the curve of a continuous one, each to the curve's next point.
pub(crate) fn stitched(weld: &Weld, stitch: Stitch) -> Result<Vec<Weld>, BeadError> {
    let spacing = weld.length / (weld.curve.points.len() - 1) as f64;
    let steps = |length: f64| (length / spacing).round() as usize;
    let (length, last) = (steps(stitch.length).max(1), weld.curve.points.len() - 1);
    let starts = (0..).map(|i| steps(i as f64 * stitch.pitch)).take_while(|start| start + length <= last);
    starts.enumerate().map(|(number, start)| one(weld, &weld.curve.points[start..=start + length], number)).collect()
}

fn one(weld: &Weld, points: &[CurvePoint], number: usize) -> Result<Weld, BeadError> {
    let first = points[0].arc_length;
    let mut points = points.to_vec();
    for point in &mut points {
        point.arc_length -= first;
    }
    let mut curve = WeldCurve { points };
    let profile = weld.profile;
    let mut rng = Pcg64Mcg::seed_from_u64(mix(weld.seed, number));
    let form = BeadForm::new(weld.request.form, [curve.length(), profile.width, profile.height], &mut rng);
    for point in &mut curve.points {
        point.width = profile.width * form.width_factor(point.arc_length);
        point.height = profile.height * form.height_factor(point.arc_length);
    }
    let bead = sweep_formed(&curve, &profile, &form, weld.root_depth)?;
    let mut reasons = weld.reasons.clone();
    reasons.push(format!("bead {} of an intermittent weld of {:.2} mm", number + 1, 1e3 * weld.length));
    Ok(Weld {
        length: curve.length(),
        bead_volume: bead.volume(),
        curvature_rms: curve.curvature_rms(),
        min_exposure: curve.min_exposure(),
        mean_access: curve.mean_access(),
        curve,
        bead,
        defects: form.defects().to_vec(),
        reasons,
        ..weld.clone()
    })
}
