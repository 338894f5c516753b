//! A form for what no effect of the library describes: the rate may depend on one thing that the simulator knows, and the
//! data say on which.

use effects::{Library, Model};

use super::diagnose::with_values;
use super::evidence::{Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::probe::Candidate;
use super::response::{Look, Projector};
use super::screen::Screened;
use super::significance::null_delta_chi2;
use super::suspect::{Suspect, suspects};
use crate::criteria::SIGNIFICANCE_LEVEL;

/// Things on which the rate may depend: name, formula, unit, a typical size, what it is.
const TEMPLATES: [(&str, &str, &str, f64, &str); 19] = [
    ("path-position", "path_position", "mm", 50.0, "the way along the path"),
    ("contact-time", "contact_time", "s", 10.0, "the time in contact"),
    ("trial-time", "trial_time", "s", 60.0, "the time since the trial began"),
    ("pass-number", "pass_number - 1", "1", 1.0, "the number of the pass"),
    ("removed-depth", "removed_depth", "um", 200.0, "the depth below the original surface"),
    ("pressure", "pressure", "MPa", 1.0, "the pressure"),
    ("contact-area", "contact_area", "mm^2", 30.0, "the area of the patch"),
    ("patch-width", "patch_width", "mm", 6.0, "the width of the patch"),
    ("force", "force", "N", 15.0, "the force"),
    ("place-along-x", "x", "mm", 50.0, "the place along x on the workpiece"),
    ("place-along-y", "y", "mm", 5.0, "the place along y on the workpiece"),
    ("place-on-tool", "tool_y", "mm", 5.0, "the place across the tool"),
    ("distance-from-tool-middle", "abs(tool_y)", "mm", 5.0, "the distance from the middle of the tool"),
    ("edge-distance", "edge_distance", "mm", 5.0, "the distance from the workpiece's edge"),
    ("slope", "slope", "1", 0.1, "the slope between surface and tool"),
    ("feed-speed", "feed_speed", "mm/s", 5.0, "the feed speed"),
    ("sliding-speed", "sliding_speed", "m/s", 30.0, "the sliding speed"),
    ("feed-direction", "feed_x", "1", 1.0, "the direction of feed along x"),
    ("lift-speed", "lift_speed", "mm/s", 0.2, "the speed at which the tool is lifted"),
];

/// A form that describes the data better than chance.
#[derive(Clone, Debug, PartialEq)]
pub struct Suggestion {
    /// Name of the effect.
    pub name: String,
    /// What it says, in words.
    pub summary: String,
    /// The effect file.
    pub text: String,
    /// Fall of the sum of squares.
    pub delta_chi2: f64,
}

/// The effect file of a form.
fn text(&(name, formula, unit, size, about): &(&str, &str, &str, f64, &str), amount: f64) -> String {
    format!(
        "name = \"suggested-{name}\"\ntitle = \"Rate that depends on {about}\"\n\
         source = \"suggested by a diagnosis: give it a name and a cause, or another form\"\n\
         signature = \"removal changes with {about}\"\nconfused_with = []\n\n\
         [parameters.amount]\nsymbol = \"a\"\nunit = \"1\"\nnull = 0.0\nrange = [-3.0, 3.0]\ndefault = {amount:.4}\n\
         about = \"relative change of the rate over one reference\"\n\n\
         [parameters.reference]\nsymbol = \"ref\"\nunit = \"{unit}\"\nrange = [{}, {}]\ndefault = {size:?}\nfree = false\n\
         about = \"a typical size of {about}\"\n\n\
         [modify]\nrate = \"rate * max(1 + amount * ({formula}) / reference, 0.05)\"\n\
         dose_rate = \"dose_rate * max(1 + amount * ({formula}) / reference, 0.05)\"\n",
        1e-3 * size,
        1e3 * size
    )
}

/// The form that describes best what a fitted model leaves; `None` where none does so better than chance.
///
/// # Errors
/// When the model cannot be simulated.
pub fn suggest(
    evidence: &dyn Evidence,
    (model, fit): (&Model, &Fit),
    library: &Library,
    seed: u64,
) -> Result<Option<Suggestion>, EvidenceError> {
    let files: Vec<(String, String)> =
        TEMPLATES.iter().map(|form| (format!("{}.toml", form.0), text(form, 0.1))).collect();
    let own = |(file, text): &(String, String)| library.with(&[(file.clone(), text.clone())]).ok();
    let projector = Projector::new(fit);
    let look = Look { evidence, base: fit, projector: &projector };
    let model = with_values(model, fit);
    let candidate = |(form, with): (&(&str, &str, &str, f64, &str), Option<Library>)| {
        let with = with?;
        let effect = with.find(&format!("suggested-{}", form.0))?;
        Candidate::new(evidence, &model, effect, &with).ok()
    };
    let candidates = TEMPLATES.iter().zip(files.iter().map(own)).filter_map(candidate);
    let screened: Vec<Screened> = candidates.map(|c| Screened::new(&look, c)).collect();
    let fitted = suspects(evidence, fit, &screened, &|_| {});
    let Some(best) = fitted.first() else { return Ok(None) };
    let chances =
        null_delta_chi2(&projector, &screened, &best.fit.residuals, &evidence.blocks(Split::Calibration), seed);
    let delta_chi2 = fit.chi2 - best.fit.chi2;
    Ok((chances.p_value(fit, &best.fit) < SIGNIFICANCE_LEVEL).then(|| suggestion(best, delta_chi2)))
}

fn suggestion(best: &Suspect, delta_chi2: f64) -> Suggestion {
    let form =
        TEMPLATES.iter().find(|form| best.name() == format!("suggested-{}", form.0)).expect("a form of the list");
    let amount = best.fit.model.value(best.screened.candidate.coordinates[0].index);
    let summary = format!(
        "the rate changes by {:+.1} % per {} {} of {}",
        100.0 * amount,
        form.3,
        if form.2 == "1" { "unit" } else { form.2 },
        form.4
    );
    Suggestion { name: best.name().to_owned(), summary, text: text(form, amount), delta_chi2 }
}
