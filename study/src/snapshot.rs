//! State between two passes on disk: the workpiece, the states of the tool, and the inputs of both.
//!
//! After pass N a folder holds `state-N.nvdb` (the field with all its channels) and `state-N.json`. A run that is
//! resumed from there gives the same bytes as one that was never interrupted.

use std::fs;
use std::path::{Path, PathBuf};

use effects::{CompiledModel, States};
use files::input::{self, MOST_MESH_BYTES, quoted_near};
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{self, Codec};
use serde::{Deserialize, Serialize};
use sim::PassRecord;

use files::json_file::read_json;
use files::json_file::write_json;
use files::{FileError, WrongUse, sha256};
use lab::{LabError, Origin, Result};

/// Value of the `format` key.
const STATE_FORMAT: &str = "robofin-state/2";

/// Files of states in a result folder.
pub const STATE_NAMES: &[&str] = &["state-*.nvdb", "state-*.json"];

/// A workpiece and a tool after a pass.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The workpiece.
    pub part: BrickGrid,
    /// States of the tool.
    pub tool: States,
    /// Time since the first pass began [s].
    pub trial_time: f64,
    /// Figures and log of the pass.
    pub record: PassRecord,
}

/// Options of a run: the states to write, and the state to start from.
#[derive(Clone, Debug, Default)]
pub struct Keeping {
    /// True if the state after every pass is written.
    pub snapshots: bool,
    /// The state to start from; `None` starts from the first pass.
    pub resume: Option<Resume>,
}

/// A state of an earlier run.
#[derive(Clone, Debug)]
pub struct Resume {
    /// Result folder of that run.
    pub folder: PathBuf,
    /// Number of passes done before the state.
    pub passes: usize,
}

/// `state-N.json`.
#[derive(Serialize, Deserialize)]
struct StateFile {
    format: String,
    version: String,
    passes: usize,
    trial_time_s: f64,
    /// SHA-256 of `state-N.nvdb`.
    field_sha256: String,
    origin: Origin,
    /// States of the tool in the order of the model [SI].
    tool: Vec<f64>,
    /// For each state of the tool's cells, a list over them [SI].
    tool_cells: Vec<Vec<f64>>,
    record: PassRecord,
}

impl Resume {
    /// The state after `passes`, or the last one in the folder.
    ///
    /// # Errors
    /// Wrong use if the folder has no such state, or the run has only `most` passes.
    pub fn new(folder: &Path, passes: Option<usize>, most: usize) -> Result<Self> {
        let kept: Vec<usize> = (1..=most).filter(|&n| place(folder, n, "json").is_file()).collect();
        let found = || match kept.as_slice() {
            [] => "none that fits; `simulate --snapshot` keeps them".to_owned(),
            kept => kept.iter().map(|n| format!("{n}")).collect::<Vec<_>>().join(", "),
        };
        let passes = match passes {
            Some(n) if kept.contains(&n) => n,
            Some(n) => {
                return Err(wrong_use(format!("--after-pass {n}: states in {}: {}", folder.display(), found())));
            }
            None => match kept.last() {
                Some(&n) => n,
                None => return Err(wrong_use(format!("--resume {}: states there: {}", folder.display(), found()))),
            },
        };
        Ok(Self { folder: folder.to_owned(), passes })
    }
}

impl Keeping {
    /// Copies the states up to the one that a run starts from to its own `folder`, where states are written, so that
    /// this run can also be resumed.
    ///
    /// # Errors
    /// If a file cannot be read or written.
    pub fn copy_earlier(&self, folder: &Path) -> Result<()> {
        let Some(resume) = self.resume.as_ref().filter(|_| self.snapshots) else { return Ok(()) };
        for (pass, extension) in (1..=resume.passes).flat_map(|pass| [(pass, "nvdb"), (pass, "json")]) {
            let source = place(&resume.folder, pass, extension);
            let copied = fs::write(place(folder, pass, extension), input::read(&source, MOST_MESH_BYTES)?);
            copied.map_err(FileError::at(&source, "cannot copy this state"))?;
        }
        Ok(())
    }
}

/// Description of the result folder of a run that ended after some of its passes.
pub fn kept(folder: &Path, (done, all): (usize, usize), snapshots: bool) -> String {
    let place = folder.display();
    let from_there =
        if snapshots && done > 0 { format!(", and --resume {place} goes on from there") } else { String::new() };
    format!("{place} keeps what was good until then: {done} of {all} passes{from_there}")
}

fn place(folder: &Path, pass: usize, extension: &str) -> PathBuf {
    folder.join(format!("state-{pass}.{extension}"))
}

/// The fields of the states in a result folder, in the order of their passes.
///
/// # Errors
/// If the folder has none.
pub fn kept_fields(folder: &Path) -> Result<Vec<PathBuf>> {
    let fields: Vec<PathBuf> =
        (1..).map(|pass| place(folder, pass, "nvdb")).take_while(|field| field.is_file()).collect();
    if fields.is_empty() {
        return Err(refused(format!("{}: no state-1.nvdb; `simulate --snapshot` keeps states", folder.display())));
    }
    Ok(fields)
}

/// Writes the state after a pass.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, pass: usize, state: &Snapshot, origin: Origin) -> Result<()> {
    let file = place(folder, pass, "nvdb");
    let field = nvdb::write_field(&state.part, Codec::Zip).map_err(FileError::encoding(&file))?;
    fs::write(&file, &field).map_err(FileError::at(&file, "cannot write this file"))?;
    let (tool, tool_cells) = state.tool.values();
    Ok(write_json(
        &place(folder, pass, "json"),
        &StateFile {
            format: STATE_FORMAT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            passes: pass,
            trial_time_s: state.trial_time,
            field_sha256: sha256(&field),
            origin,
            tool: tool.to_vec(),
            tool_cells: tool_cells.to_vec(),
            record: state.record.clone(),
        },
    )?)
}

/// Reads the state after a pass.
///
/// # Errors
/// If a file is absent or damaged, or the state has another `origin`: the message names the differences.
pub fn read(folder: &Path, pass: usize, model: &CompiledModel, origin: &Origin) -> Result<Snapshot> {
    let (json, nvdb) = (place(folder, pass, "json"), place(folder, pass, "nvdb"));
    let state: StateFile = read_json(&json, "a state")?;
    let shown = json.display();
    let check = |holds: bool, why: &dyn Fn() -> String| if holds { Ok(()) } else { Err(refused(why())) };
    check(state.format == STATE_FORMAT, &|| {
        format!("{shown}: format {}; {STATE_FORMAT} is expected", quoted_near(&state.format, [STATE_FORMAT]))
    })?;
    check(state.passes == pass, &|| {
        format!("{shown}: the state after pass {}; pass {pass} is expected", state.passes)
    })?;
    let differing = differences(&state.origin, origin);
    check(differing.is_empty(), &|| {
        format!("{shown}: this state cannot be continued here, because these differ: {}", differing.join("; "))
    })?;
    let bytes = input::read(&nvdb, MOST_MESH_BYTES)?;
    check(sha256(&bytes) == state.field_sha256, &|| {
        format!("{}: not the field that {shown} was written with", nvdb.display())
    })?;
    let unreadable = |error: &dyn std::fmt::Display| refused(format!("{}: {error}", nvdb.display()));
    let field = nvdb::read(&bytes).map_err(|error| unreadable(&error))?;
    let tool = States::restored(model, (state.tool, state.tool_cells));
    Ok(Snapshot {
        part: field.to_field().map_err(|error| unreadable(&error))?,
        tool: tool.ok_or_else(|| refused(format!("{shown}: another number of tool states than the model has")))?,
        trial_time: state.trial_time_s,
        record: state.record,
    })
}

/// Names that differ between two origins, with both values if they are short.
fn differences(then: &Origin, now: &Origin) -> Vec<String> {
    let names: std::collections::BTreeSet<&String> = then.keys().chain(now.keys()).collect();
    let shown = |value: Option<&String>| match value {
        None => "absent".to_owned(),
        Some(text) if text.len() < 60 => text.clone(),
        Some(_) => "other content".to_owned(),
    };
    let differs = |name: &&String| then.get(*name) != now.get(*name);
    let tell = |name: &String| match (then.get(name), now.get(name)) {
        (Some(a), Some(b)) if a.len() >= 60 && b.len() >= 60 => name.clone(),
        (a, b) => format!("{name} (then {}, now {})", shown(a), shown(b)),
    };
    names.into_iter().filter(differs).map(tell).collect()
}

fn refused(why: String) -> LabError {
    LabError::Refused(why)
}

fn wrong_use(why: String) -> LabError {
    LabError::File(WrongUse(why).into())
}
