//! Implausible properties of a weld, and requested imperfections that do not fit on the part.

use crate::bead::DefectKind;
use crate::place::Weld;

/// Diameter of the thinnest welding wire [m]; no bead is narrower.
const THINNEST_WIRE: f64 = 0.6e-3;

impl Weld {
    /// Sentences for implausible or unmet properties.
    pub fn warnings(&self) -> Vec<String> {
        let width = self.profile.width;
        let thin = (width < THINNEST_WIRE).then(|| {
            format!(
                "the bead is {:.3} mm wide, and the thinnest welding wire is {} mm: check --unit and the size of the part, or \
                 give --width-mm",
                width * 1e3,
                THINNEST_WIRE * 1e3
            )
        });
        thin.into_iter().chain(self.shortfalls()).collect()
    }

    /// Sentences for imperfections that are fewer than requested, with reasons.
    pub fn shortfalls(&self) -> Vec<String> {
        let form = &self.request.form;
        let one = |share: f64| u32::from(share > 0.0);
        let asked = [
            (DefectKind::SurfacePore, form.pores, "pores", "the bead has no room"),
            (DefectKind::Sagging, one(form.sagging), "sags", "the bead has no room"),
            (DefectKind::Overlap, one(form.overlap), "overlaps", "the bead has no room"),
            (DefectKind::Spatter, form.spatter, "drops of spatter", "no more ground lies clear beside the bead"),
            (DefectKind::Undercut, one(form.undercut), "undercuts", "the ground beside the toes bends or is too thin"),
            (DefectKind::BurnThrough, form.burn_through, "burnt holes", "the ground is too thick or closed behind"),
        ];
        let short = |(kind, asked, name, why): (DefectKind, u32, &str, &str)| {
            let made = self.defects.iter().filter(|defect| defect.kind == kind).count();
            (made < asked as usize).then(|| format!("{made} of {asked} {name} were made: {why}"))
        };
        asked.into_iter().filter_map(short).collect()
    }
}
