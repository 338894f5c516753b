//! Requested imperfections that do not fit on the part.

use crate::bead::DefectKind;
use crate::place::Weld;

impl Weld {
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
