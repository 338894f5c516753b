//! Intermittent welds: several beads on one curve.

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::bead::defect::Ground;
use crate::bead::{BeadError, BeadForm, sweep_formed};
use crate::curve::{CurvePoint, WeldCurve};
use crate::cut::PlacedBead;
use crate::place::Weld;
use crate::propose::mix;
use crate::request::Stitch;
use crate::surface::Surface;

/// Divides a continuous weld into the beads of an intermittent weld; each bead ends at a point of the curve.
///
/// Imperfections to be cut out of a bead are omitted if its surface does not allow them.
pub(crate) fn stitched(weld: &Weld, stitch: Stitch, surface: &Surface) -> Result<Vec<Weld>, BeadError> {
    let spacing = weld.length / (weld.curve.points.len() - 1) as f64;
    let steps = |length: f64| (length / spacing).round() as usize;
    let (length, last) = (steps(stitch.length).max(1), weld.curve.points.len() - 1);
    let starts = (0..).map(|i| steps(i as f64 * stitch.pitch)).take_while(|start| start + length <= last);
    let points = |start: usize| &weld.curve.points[start..=start + length];
    starts.enumerate().map(|(number, start)| one(weld, points(start), number, surface)).collect()
}

fn one(weld: &Weld, points: &[CurvePoint], number: usize, surface: &Surface) -> Result<Weld, BeadError> {
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
    let mut bead = sweep_formed(&curve, &profile, &form, weld.root_depth)?;
    let laid = PlacedBead { surface, curve: &curve, profile: &profile, form: &form };
    let cuts = laid.cuts(&weld.request.form, &mut rng).unwrap_or_default();
    let Surface { query, part, .. } = surface;
    let clear = form.half_reach(profile.half_width_at(weld.root_depth));
    let ground = Ground { curve: &curve, query, part, width: profile.width, clear };
    let (spattered, drops) = ground.spatter(weld.request.form.spatter, &mut rng);
    let bead_volume = bead.volume();
    bead.append(&drops);
    let mut reasons = weld.reasons.clone();
    reasons.push(format!("bead {} of an intermittent weld of {:.2} mm", number + 1, 1e3 * weld.length));
    Ok(Weld {
        length: curve.length(),
        bead_volume,
        curvature_rms: curve.curvature_rms(),
        min_exposure: curve.min_exposure(),
        mean_access: curve.mean_access(),
        curve,
        bead,
        defects: [&form.made_defects()[..], &spattered, &cuts.defects].concat(),
        cuts: cuts.bodies,
        reasons,
        ..weld.clone()
    })
}
