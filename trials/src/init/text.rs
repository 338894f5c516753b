//! The text of a draft `trial.toml`.

use std::fmt::Write as _;
use std::path::Path;

use effects::Signal;
use glam::{DVec2, DVec3};
use instruments::log::guess::Role;

use super::files::Found;
use super::place::{PassGuess, Placing};
use super::scans::Scans;
use crate::trial::{PLANE, RPM, TRIAL_FORMAT};

/// Heights of the log above the surface that count as a wheel's radius [m].
const RADII: [f64; 2] = [5e-3, 0.5];
/// Height of the log above the surface up to which the log gives the position of the tool's face [m].
const ON_FACE: f64 = 2e-3;
/// Distance between the frames of scan and log up to which they count as one [m].
const SAME_FRAME: f64 = 1e-3;
/// Slope of a direction up to which it counts as parallel to an axis.
const NEAR_AXIS: f64 = 0.05;

/// Writes a manifest line by line, and records the open keys.
pub(super) struct Writer<'a> {
    pub(super) found: &'a Found,
    pub(super) scans: &'a Scans<'a>,
    pub(super) placing: &'a Placing,
    pub(super) open: Vec<String>,
}

impl Writer<'_> {
    pub(super) fn text(&mut self, folder: &Path) -> String {
        let name = folder.canonicalize().ok().and_then(|place| Some(place.file_name()?.to_string_lossy().into_owned()));
        let name = name.unwrap_or_else(|| "trial".to_owned());
        let process = match self.scans.process.signal() {
            Signal::Height => "\"grinding\"   # or \"sanding\": coating, whose scans after passes are masks of 0 and 1",
            Signal::Dose => "\"sanding\"   # a scan is a mask of 0 and 1",
        };
        let mut text = format!(
            "# Guessed from the files of this folder. Check every line; FILL IN marks what no file states.\n\
             format = \"{TRIAL_FORMAT}\"\nname = {}\nprocess = {process}\n",
            quoted(&name)
        );
        for part in [self.tool(), self.scan(), self.log(), self.controller(), self.passes()] {
            text.push('\n');
            text.push_str(&part);
        }
        text
    }

    fn tool(&mut self) -> String {
        let gap = self.placing.gap;
        let lies_on_face = gap.is_some_and(|gap| gap.abs() < ON_FACE);
        let is_pad = self.scans.process.signal() == Signal::Dose || lies_on_face;
        let mut text = "[tool]\n".to_owned();
        let width = self.placing.width.map(|width| width * 1e3);
        if is_pad {
            text.push_str(
                "kind = \"pad\"   # guessed: the log lies on the surface; a wheel turns about a level axis\n",
            );
            let radius = width.map(|width| 0.5 * width);
            self.length(&mut text, "radius_mm", radius, "half of the ground track's width");
        } else {
            text.push_str("kind = \"wheel\"   # guessed; or \"pad\": a flat disc that faces the surface\n");
            let radius = gap.filter(|gap| (RADII[0]..RADII[1]).contains(gap)).map(|gap| gap * 1e3);
            self.length(&mut text, "radius_mm", radius, "height of the logged place above what the last pass left");
            self.length(&mut text, "width_mm", width, "width of the ground track; the wheel may be wider");
            let direction = self.placing.passes.first().map_or(DVec3::X, |pass| pass.direction);
            let axis = rounded(DVec3::Z.cross(direction));
            let _ = writeln!(text, "axis = [{}, {}, {}]   # guessed: level, across the path", axis.x, axis.y, axis.z);
        }
        text.push_str("fresh = true   # false: worn by the trial before, in the order of names\n");
        text
    }

    /// A length of the tool, estimated or left open.
    fn length(&mut self, text: &mut String, key: &str, value: Option<f64>, why: &str) {
        let _ = match value {
            Some(value) => writeln!(text, "{key} = {value:.2}   # guessed: {why}; give the true value"),
            None => {
                self.open.push(format!("[tool] {key}"));
                writeln!(text, "{key} = 0.0   # FILL IN")
            }
        };
    }

    fn scan(&mut self) -> String {
        let Scans { reason, .. } = self.scans;
        let reference = self.scans.reference();
        let surface = self.found.maps().find(|(name, _)| *name == reference).map(|(_, surface)| surface);
        let mut text = format!("[scan]   # the order of scans is guessed {reason}\n");
        match surface.and_then(|surface| surface.pitch) {
            Some(pitch) => {
                let _ = writeln!(text, "# the file states the distance between pixels: {:.4} mm", pitch.x * 1e3);
            }
            None => {
                self.open.push("[scan] pitch_mm".to_owned());
                text.push_str("pitch_mm = 0.0   # FILL IN: distance between pixels, which the file does not state\n");
            }
        }
        text.push_str(&self.origin(surface.and_then(|surface| surface.origin)));
        text.push_str(&self.first_surface());
        if let Some(material) = self.scans.material {
            let _ =
                writeln!(text, "material = {}   # guessed: labels of 0 and 1, base and weld metal", quoted(material));
        }
        text
    }

    /// The surface before the first pass and its repeated scans.
    fn first_surface(&self) -> String {
        let Some(before) = self.scans.before else {
            let (nominal, why) = match self.found.meshes().next() {
                Some(mesh) => (mesh, "the surface as drawn, in the frame of the scan"),
                None => (PLANE, "or \"FILE\" with the surface as drawn"),
            };
            return format!(
                "nominal = {}   # guessed: no scan was made before the first pass; {why}\n\
                 # before = \"FILE\"   # a scan before the first pass, instead of nominal\n",
                quoted(nominal)
            );
        };
        let names: Vec<String> = self.scans.repeats.iter().map(|name| quoted(name)).collect();
        let repeats = match names.len() {
            0 => "# repeat = [\"FILE\"]   # a second scan of the same surface: without one, the noise is taken from where\n\
                  #                        # no tool came, a lower bound\n"
                .to_owned(),
            _ => format!("repeat = [{}]   # shows the same surface as the scan before\n", names.join(", ")),
        };
        format!("before = {}\n{repeats}", quoted(before))
    }

    fn origin(&mut self, own: Option<DVec2>) -> String {
        let guess = self.placing.origin;
        match (own, guess) {
            (Some(own), _) => format!("# the file states x, y of the first pixel: {}\n", millimetres(own)),
            (None, Some(guess)) => {
                let along = if self.placing.slides_along { "; its position along the path is unknown" } else { "" };
                format!("origin_mm = {}   # guessed: the track lies under the path{along}\n", millimetres(guess))
            }
            (None, None) => {
                self.open.push("[scan] origin_mm".to_owned());
                "origin_mm = [0.0, 0.0]   # FILL IN: x, y of the first pixel in the frame of the log\n".to_owned()
            }
        }
    }

    fn log(&mut self) -> String {
        let Some((_, channels, guesses)) = self.found.logs().next() else { return String::new() };
        if crate::trial::REQUIRED_COLUMNS.iter().all(|column| channels.names.iter().any(|name| name == column)) {
            return "# the logs have the columns of the format: no [log.columns] is needed\n".to_owned();
        }
        let mut text = "[log]\n".to_owned();
        text.push_str(&self.offset());
        text.push('\n');
        text.push_str(&guesses.table());
        let missing = Role::ALL.into_iter().filter(|role| role.is_required() && guesses.best(*role).is_none());
        let missing = missing.filter(|role| *role != Role::Spindle);
        self.open.extend(missing.map(|role| format!("[log.columns] {}", role.key())));
        let used: Vec<usize> =
            Role::ALL.iter().filter_map(|role| guesses.best(*role)).map(|best| best.channel).collect();
        let others = (0..channels.names.len()).filter(|at| !used.contains(at)).map(|at| quoted(&channels.names[at]));
        let others: Vec<String> = others.collect();
        if !others.is_empty() {
            let _ = writeln!(text, "# kept for formulas: {}", others.join(", "));
        }
        text
    }

    /// Position of the log's origin, if log and scan have different frames.
    fn offset(&self) -> String {
        let before = self.found.maps().find(|(name, _)| *name == self.scans.reference());
        let own = before.and_then(|(_, surface)| surface.origin);
        match own.zip(self.placing.origin).map(|(own, guess)| own - guess) {
            Some(offset) if offset.length() > SAME_FRAME => format!(
                "offset_mm = [{:.3}, {:.3}, 0.0]   # guessed: moves the path onto the ground track\n",
                offset.x * 1e3,
                offset.y * 1e3
            ),
            _ => "# offset_mm = [0.0, 0.0, 0.0]   # of the log's zero in the frame of the scans; yaw_deg turns it first\n"
                .to_owned(),
        }
    }

    fn controller(&self) -> String {
        "[controller]\nkind = \"logged-force\"   # the logged force presses the tool on; or \"admittance\" with mass_kg, \
         damping_ns_m\n                        # and period_s, or \"ideal\": the setpoint; without this table z is replayed\n"
            .to_owned()
    }

    fn passes(&mut self) -> String {
        let logs: Vec<&str> = self.found.logs().map(|(name, ..)| name).collect();
        let (strokes, after) = (strokes(self.placing, logs.len()), &self.scans.after);
        let mut text = String::new();
        if after.is_empty() || (logs.len() < after.len() && strokes.len() != after.len()) {
            let _ = writeln!(
                text,
                "# {} logs and {} scans after passes: each pass needs a log, and the last one a scan",
                logs.len(),
                after.len()
            );
            self.open.push(format!("{} logs for {} scans after passes", logs.len(), after.len()));
        }
        for k in 0..strokes.len().max(after.len()) {
            let stroke = strokes.get(k);
            let log = stroke.map_or("\"\"   # FILL IN".to_owned(), |(log, _)| quoted(logs[*log]));
            let _ = writeln!(text, "[[pass]]\nlog = {log}");
            let pass = stroke.and_then(|(_, pass)| *pass);
            if let Some([from, to]) = pass.and_then(|pass| pass.time) {
                let _ = writeln!(text, "time_s = [{from:?}, {to:?}]   # guessed: one of the strokes of the log");
            }
            let _ = writeln!(text, "{}", scan_of(k, &strokes, after));
            text.push_str("role = \"calibration\"   # or \"evaluation\": kept apart to judge the model\n");
            if let Some(pass) = pass {
                text.push_str(&settings(pass));
            }
            if pass.is_none_or(|pass| pass.spindle.is_none()) {
                self.open.push(format!("spindle_rpm of pass {}", k + 1));
                text.push_str("spindle_rpm = 0.0   # FILL IN: the log has none\n");
            }
            text.push('\n');
        }
        text
    }
}

/// The strokes of all logs, each with the number of its log; a log whose strokes are unknown counts as one.
fn strokes(placing: &Placing, logs: usize) -> Vec<(usize, Option<&PassGuess>)> {
    let of_log = |log: usize| {
        let own: Vec<_> = placing.passes.iter().filter(|pass| pass.log == log).collect();
        if own.is_empty() { vec![(log, None)] } else { own.into_iter().map(|pass| (log, Some(pass))).collect() }
    };
    (0..logs).flat_map(of_log).collect()
}

/// The line with the scan after a stroke.
fn scan_of(k: usize, strokes: &[(usize, Option<&PassGuess>)], after: &[&str]) -> String {
    let name = |k: usize| after.get(k).map_or("\"\"   # FILL IN".to_owned(), |name| quoted(name));
    let none = || "# scan = \"FILE\"   # none: the pass is simulated, and compared after the next scan".to_owned();
    let logs = strokes.last().map_or(0, |(log, _)| log + 1);
    if after.is_empty() || strokes.len() <= after.len() {
        return format!("scan = {}", name(k));
    }
    let is_last_of_log = strokes.get(k + 1).is_none_or(|next| next.0 != strokes[k].0);
    match (strokes[k].0 + after.len()).checked_sub(logs).filter(|_| is_last_of_log) {
        Some(scan) if logs > after.len() => format!("scan = {}   # guessed: made after the last passes", name(scan)),
        Some(scan) => format!("scan = {}", name(scan)),
        None => none(),
    }
}

/// Lines with the settings of a pass.
fn settings(pass: &PassGuess) -> String {
    let mut text =
        format!("force_setpoint_n = {:.2}   # guessed: median of the log while the tool pressed\n", pass.force);
    let _ = writeln!(text, "feed_mm_s = {:.3}   # guessed: median of the log while it moved", pass.feed * 1e3);
    if let Some(spindle) = pass.spindle {
        let _ = writeln!(text, "spindle_rpm = {:.0}   # guessed: median of the log", spindle / RPM);
    }
    let direction = rounded(pass.direction);
    let _ =
        writeln!(text, "direction = [{}, {}, 0]   # guessed: from the first to the last row", direction.x, direction.y);
    text
}

/// A direction, snapped to an axis if it is nearly parallel.
fn rounded(direction: DVec3) -> DVec3 {
    let clean = DVec3::from_array(direction.to_array().map(|part| if part.abs() < NEAR_AXIS { 0.0 } else { part }));
    let unit = clean.normalize_or(DVec3::X);
    DVec3::from_array(unit.to_array().map(|part| (part * 1e4).round() / 1e4 + 0.0))
}

fn millimetres(place: DVec2) -> String {
    format!("[{:.3}, {:.3}]", place.x * 1e3 + 0.0, place.y * 1e3 + 0.0)
}

/// A TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
