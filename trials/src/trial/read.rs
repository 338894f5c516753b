//! Reading of a trial folder: `trial.toml`, then every file it names, then the consistency checks.

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use sdf_bake::PixelGrid;
use toml::Spanned;

use super::columns::{Found, Logs, TrialColumn};
use super::error::TrialError;
use super::log::{Log, RPM, read_log};
use super::log_columns::LogColumns;
use super::manifest::{
    ControllerKind, ControllerTable, Manifest, PassTable, RobotTable, Source, TRIAL_FILE, ToolKind, ToolTable,
};
use super::scan::{Read, ScanFrame};
use super::{Checked, ForceInput, FrameErrors, FrameOffset, HeldTool, Pass, Trial, plausible};
use effects::Process;
use robot::Controller;

impl Trial {
    /// Reads a trial folder completely and checks that its files are consistent.
    ///
    /// # Errors
    /// [`TrialError`] with file, line and column, the value found and the values accepted.
    pub fn read(folder: &Path) -> Result<Self, TrialError> {
        let source = Source::read(folder.join(TRIAL_FILE))?;
        let manifest = source.manifest()?;
        let mut trial = Reader { folder, source: &source, notes: Vec::new() }.trial(&manifest)?;
        plausible::check(&mut trial, &plausible::Names::of(&manifest))?;
        Ok(trial)
    }

    /// Reads a trial folder as [`Trial::read`] does, and returns all findings of the checks, refusals included.
    ///
    /// # Errors
    /// [`TrialError`] if a file cannot be read.
    pub fn checked(folder: &Path) -> Result<(Self, Vec<Checked>), TrialError> {
        let source = Source::read(folder.join(TRIAL_FILE))?;
        let manifest = source.manifest()?;
        let mut trial = Reader { folder, source: &source, notes: Vec::new() }.trial(&manifest)?;
        let checks = plausible::check_all(&mut trial, &plausible::Names::of(&manifest));
        Ok((trial, checks))
    }
}

/// Accepted range of a tool's radius and width [mm], as in the flags of `robofin simulate`.
const TOOL_MM: [f64; 2] = [0.1, 1000.0];
/// Minimum number of a log's rows in a pass: down, pressing and up again, each with a row before the next.
const LEAST_ROWS: usize = 6;
/// Accepted range of a coating's thickness [mm]: a tenth of a micrometre, and that of a layer of filler.
const COATING_MM: [f64; 2] = [1e-4, 10.0];
/// Accepted range of a controller's period [s]: a hundred times faster than robots, and once per second.
const PERIOD_S: [f64; 2] = [1e-5, 1.0];
/// Maximum standard deviations of a robot's frame [mm, mrad] and clock [s]; 0 is exact.
const FRAME_SIGMAS: [f64; 3] = [100.0, 200.0, 10.0];

/// Settings for reading the files of every pass.
pub(super) struct PassForm<'a> {
    pub(super) process: Process,
    /// Pixels of the scan before.
    pub(super) pixels: &'a PixelGrid,
    pub(super) frame: ScanFrame,
    /// Columns of logs in other formats than the project's own.
    columns: Option<&'a LogColumns<'a>>,
}

/// The source of the controller's setpoint in a manifest.
fn force_input(manifest: &Manifest) -> ForceInput {
    match manifest.controller.as_ref().map(|table| table.get_ref().kind) {
        Some(ControllerKind::LoggedForce) => ForceInput::Log,
        _ => ForceInput::Setpoint,
    }
}

pub(super) struct Reader<'a> {
    pub(super) folder: &'a Path,
    pub(super) source: &'a Source,
    pub(super) notes: Vec<String>,
}

impl Reader<'_> {
    fn trial(&mut self, manifest: &Manifest) -> Result<Trial, TrialError> {
        let frame = self.frame(manifest)?;
        let tool = self.tool(&manifest.tool)?;
        self.check_passes(manifest)?;
        let scans = self.scans(manifest, frame)?;
        self.check_size(manifest, &scans.before.pixels)?;
        let columns = manifest.log.as_ref().map(|table| LogColumns::new(self.source, table)).transpose()?;
        let form =
            PassForm { process: manifest.process, pixels: &scans.before.pixels, frame, columns: columns.as_ref() };
        let passes = manifest.pass.iter().map(|table| self.pass(table, &form));
        let passes = passes.collect::<Result<Vec<_>, _>>()?;
        let columns = self.columns(manifest, &passes)?;
        let coating =
            manifest.coating.as_ref().map(|table| self.within("thickness_mm", &table.thickness_mm, COATING_MM));
        let mut trial = Trial {
            folder: self.folder.to_owned(),
            name: manifest.name.clone(),
            process: manifest.process,
            tool,
            fresh: manifest.tool.fresh,
            scans,
            controller: manifest.controller.as_ref().map_or(Ok(Controller::Replay), |table| self.controller(table))?,
            force_input: force_input(manifest),
            frame_errors: self.frame_errors(manifest.robot.as_ref())?,
            frame_offset: FrameOffset::default(),
            coating: coating.transpose()?.map(|thickness| thickness * 1e-3),
            passes,
            columns,
            notes: std::mem::take(&mut self.notes),
            findings: Vec::new(),
        };
        if trial.scans.is_nominal {
            self.align(&mut trial, manifest)?;
        }
        Ok(trial)
    }

    /// Prior standard deviations of frame and clock from a manifest; defaults for absent keys.
    fn frame_errors(&self, table: Option<&RobotTable>) -> Result<FrameErrors, TrialError> {
        let usual = FrameErrors::default();
        let Some(RobotTable { frame_sigma_mm, yaw_sigma_mrad, clock_sigma_s }) = table else { return Ok(usual) };
        let [shift, yaw, lag] = FRAME_SIGMAS;
        type Sigma = (f64, f64, f64);
        let sigma = |key: &str, given: &Option<Spanned<f64>>, (most, unit, usual): Sigma| -> Result<f64, TrialError> {
            match given {
                Some(value) if (0.0..=most).contains(value.get_ref()) => Ok(value.get_ref() * unit),
                Some(value) => {
                    let found = format!("{key} is {:?}", value.get_ref());
                    Err(self.source.bad(value.span(), found, format!("0.0 to {most:?} is expected")))
                }
                None => Ok(usual),
            }
        };
        Ok(FrameErrors {
            shift: sigma("frame_sigma_mm", frame_sigma_mm, (shift, 1e-3, usual.shift))?,
            yaw: sigma("yaw_sigma_mrad", yaw_sigma_mrad, (yaw, 1e-3, usual.yaw))?,
            lag: sigma("clock_sigma_s", clock_sigma_s, (lag, 1.0, usual.lag))?,
        })
    }

    /// Quantities for formulas, besides pose, force and speed.
    fn columns(&mut self, manifest: &Manifest, passes: &[Pass]) -> Result<Vec<TrialColumn>, TrialError> {
        let files = manifest.pass.iter().map(|table| self.folder.join(table.log.get_ref())).collect();
        let found = Found::new(self.source, manifest, &Logs { passes, files })?;
        self.notes.extend(found.notes);
        Ok(found.columns)
    }

    fn frame(&self, manifest: &Manifest) -> Result<ScanFrame, TrialError> {
        let pitch = manifest.scan.pitch_mm.as_ref().map(|pitch| self.positive("pitch_mm", pitch)).transpose()?;
        let origin = manifest.scan.origin_mm.as_ref().map(|origin| {
            let [x, y] = *origin.get_ref();
            let bad = || {
                self.source.bad(origin.span(), format!("origin_mm is [{x}, {y}]"), "two finite numbers are expected")
            };
            if x.is_finite() && y.is_finite() { Ok(DVec2::new(x, y) * 1e-3) } else { Err(bad()) }
        });
        Ok(ScanFrame {
            origin: origin.transpose()?,
            pitch: pitch.map(|pitch| pitch * 1e-3),
            like: None,
            mirror: manifest.scan.mirror,
        })
    }

    fn tool(&self, table: &ToolTable) -> Result<HeldTool, TrialError> {
        let radius = self.within("radius_mm", &table.radius_mm, TOOL_MM)? * 1e-3;
        let missing = |key: &str| self.source.bad(table.kind.span(), format!("a wheel without {key}"), "it is needed");
        match table.kind.get_ref() {
            ToolKind::Pad => {
                let extra = table.width_mm.as_ref().map(|width| ("width_mm", width.span()));
                if let Some((key, at)) = extra.or(table.axis.as_ref().map(|axis| ("axis", axis.span()))) {
                    return Err(self.source.bad(at, format!("a pad with {key}"), "a pad has a radius only"));
                }
                Ok(HeldTool::pad(radius))
            }
            ToolKind::Wheel => {
                let width = table.width_mm.as_ref().ok_or_else(|| missing("width_mm"))?;
                let axis = table.axis.as_ref().ok_or_else(|| missing("axis"))?;
                let width = self.within("width_mm", width, TOOL_MM)? * 1e-3;
                Ok(HeldTool::wheel(radius, width, self.unit("axis", axis)?))
            }
        }
    }

    fn controller(&self, table: &Spanned<ControllerTable>) -> Result<Controller, TrialError> {
        let ControllerTable { kind, mass_kg, damping_ns_m, period_s } = table.get_ref();
        if *kind != ControllerKind::Admittance {
            return self.without_inertia(table);
        }
        let need = |key: &str, value: &Option<Spanned<f64>>| match value {
            Some(value) => self.positive(key, value),
            None => {
                Err(self.source.bad(table.span(), format!("an admittance controller without {key}"), "it is needed"))
            }
        };
        let mass = match mass_kg {
            Some(mass) if *mass.get_ref() == 0.0 => 0.0,
            other => need("mass_kg", other)?,
        };
        Ok(Controller::Admittance {
            mass,
            damping: need("damping_ns_m", damping_ns_m)?,
            period: match period_s {
                Some(period) => self.within("period_s", period, PERIOD_S)?,
                None => need("period_s", period_s)?,
            },
        })
    }

    /// A controller without inertia; keys of mass and damping are refused.
    fn without_inertia(&self, table: &Spanned<ControllerTable>) -> Result<Controller, TrialError> {
        let ControllerTable { mass_kg, damping_ns_m, period_s, .. } = table.get_ref();
        let given = [("mass_kg", mass_kg), ("damping_ns_m", damping_ns_m), ("period_s", period_s)];
        match given.into_iter().find_map(|(key, value)| Some((key, value.as_ref()?))) {
            Some((key, value)) => {
                Err(self.source.bad(value.span(), key, "only kind = \"admittance\" has mass, damping and period"))
            }
            None => Ok(Controller::Ideal),
        }
    }

    fn pass(&mut self, table: &PassTable, form: &PassForm) -> Result<Pass, TrialError> {
        let spindle_speed = self.optional("spindle_rpm", &table.spindle_rpm)?.map(|rpm| rpm * RPM);
        let log = self.file(&table.log, |file| match form.columns {
            Some(columns) => columns.read(file, spindle_speed),
            None => read_log(file),
        })?;
        let scan = self.pass_scan(table, form)?;
        self.notes.extend(log.notes.iter().cloned().chain(scan.notes));
        self.note_missing(table);
        let log = self.part_of_log(log.content, table)?;
        let motion = super::poses::Motion::of(&log);
        let feed = self.optional("feed_mm_s", &table.feed_mm_s)?.map_or(motion.feed, |feed| feed * 1e-3);
        let direction = table.direction.as_ref().map(|given| self.unit("direction", given)).transpose()?;
        Ok(Pass {
            scan: scan.content,
            role: table.role,
            force_setpoint: self.force_setpoint(table, motion.force)?,
            feed,
            spindle_speed: spindle_speed.unwrap_or(motion.spindle_speed),
            direction: direction.unwrap_or(motion.direction),
            log,
        })
    }

    /// The rows of a log that belong to a pass.
    fn part_of_log(&self, log: Log, table: &PassTable) -> Result<Log, TrialError> {
        let Some(time) = &table.time_s else { return Ok(log) };
        let part = log.between(*time.get_ref());
        let [from, to] = time.get_ref();
        if part.rows.len() >= LEAST_ROWS && from.is_finite() && to.is_finite() {
            return Ok(part);
        }
        let found =
            format!("time_s = [{from:?}, {to:?}] holds {} rows of {}", part.rows.len(), table.log.get_ref().display());
        let ends = log.rows.first().zip(log.rows.last()).map(|(first, last)| (first.time, last.time));
        let (first, last) = ends.unwrap_or_default();
        let accepted = format!("at least {LEAST_ROWS} of its times from {first:?} to {last:?} s are expected");
        Err(self.source.bad(time.span(), found, accepted))
    }

    /// Setpoint of a pass [N]: the given value, or the logged force in contact.
    fn force_setpoint(&self, table: &PassTable, logged: f64) -> Result<f64, TrialError> {
        match &table.force_setpoint_n {
            Some(given) => self.positive("force_setpoint_n", given),
            None if logged > 0.0 => Ok(logged),
            None => Err(self.source.bad(
                table.log.span(),
                "a log whose force is never above zero",
                "force_setpoint_n is needed, or a log of the force with which the tool presses",
            )),
        }
    }

    /// Adds a note on the values of a pass that are taken from its log.
    fn note_missing(&mut self, table: &PassTable) {
        for (key, is_given) in [
            ("force_setpoint_n", table.force_setpoint_n.is_some()),
            ("feed_mm_s", table.feed_mm_s.is_some()),
            ("spindle_rpm", table.spindle_rpm.is_some()),
            ("direction", table.direction.is_some()),
        ] {
            if !is_given {
                self.notes.push(format!("{}: {key} is not given and taken from here", table.log.get_ref().display()));
            }
        }
    }

    /// Reads a file that `trial.toml` names; notes begin with its name.
    pub(super) fn file<T>(
        &self,
        name: &Spanned<PathBuf>,
        read: impl FnOnce(&Path) -> Result<Read<T>, TrialError>,
    ) -> Result<Read<T>, TrialError> {
        let path = self.source.named(self.folder, name)?;
        let Read { content, notes } = read(&path)?;
        let shown = name.get_ref().display();
        Ok(Read { content, notes: notes.into_iter().map(|note| format!("{shown}: {note}")).collect() })
    }

    fn within(&self, key: &str, value: &Spanned<f64>, [least, most]: [f64; 2]) -> Result<f64, TrialError> {
        let found = self.positive(key, value)?;
        if (least..=most).contains(&found) {
            return Ok(found);
        }
        Err(self.source.bad(value.span(), format!("{key} is {found:?}"), format!("{least:?} to {most:?} is expected")))
    }

    fn positive(&self, key: &str, value: &Spanned<f64>) -> Result<f64, TrialError> {
        let found = *value.get_ref();
        if found > 0.0 && found.is_finite() {
            return Ok(found);
        }
        Err(self.source.bad(value.span(), format!("{key} is {found:?}"), "a finite number above zero is expected"))
    }

    fn optional(&self, key: &str, value: &Option<Spanned<f64>>) -> Result<Option<f64>, TrialError> {
        value.as_ref().map(|value| self.not_negative(key, value)).transpose()
    }

    fn not_negative(&self, key: &str, value: &Spanned<f64>) -> Result<f64, TrialError> {
        let found = *value.get_ref();
        if found >= 0.0 && found.is_finite() {
            return Ok(found);
        }
        Err(self.source.bad(value.span(), format!("{key} is {found}"), "a finite number, zero or above, is expected"))
    }

    fn unit(&self, key: &str, value: &Spanned<[f64; 3]>) -> Result<DVec3, TrialError> {
        let at: Range<usize> = value.span();
        let found = DVec3::from_array(*value.get_ref());
        found
            .try_normalize()
            .filter(|unit| unit.is_finite())
            .ok_or_else(|| self.source.bad(at, format!("{key} is {found}"), "a vector with a length is expected"))
    }
}
