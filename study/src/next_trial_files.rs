//! Files of the next trial, in the folder of a study or a diagnosis.

use std::path::Path;
use std::{fs, io};

use lab::{MenuChoice, NextTrial};
use trials::trial::{PLAN_NAMES, Trial, write_plan};

/// Folder of the next trial.
pub const NEXT_TRIAL: &str = "next-trial";
/// Folders below that of a study, with the names of the files in them.
pub const NEXT_TRIAL_NAMES: [(&str, &[&str]); 3] =
    [("next-trial/", PLAN_NAMES), ("next-trial/part-1/", PLAN_NAMES), ("next-trial/part-2/", PLAN_NAMES)];

/// Writes the planned trial, or its two parts if the tool is dressed in between; returns lines for the console, each
/// with its label. A row of a table has no files.
///
/// # Errors
/// If a file cannot be written, with its name.
pub fn write_next_trial(next: &NextTrial, folder: &Path) -> io::Result<Vec<(&'static str, String)>> {
    let Some(choice) = &next.choice else { return Ok(Vec::new()) };
    for (part, trial) in (1..).zip(&choice.plan) {
        let place = match choice.plan.len() {
            1 => folder.join(NEXT_TRIAL),
            _ => folder.join(NEXT_TRIAL).join(format!("part-{part}")),
        };
        fs::create_dir_all(&place)?;
        write_plan(trial, &remarks(next, choice, (part, trial)), &place).map_err(io::Error::other)?;
    }
    let worth = choice.worth;
    let line = format!("{} {:.0} min; {NEXT_TRIAL}/", next.summary, worth.minutes);
    Ok(vec![("next trial", line)])
}

/// Instructions for the reader of `trial.toml`.
fn remarks(next: &NextTrial, choice: &MenuChoice, (part, trial): (usize, &Trial)) -> Vec<String> {
    let tool = if trial.fresh { "Dress the tool first." } else { "Do not dress the tool: it goes on as it is." };
    let workpiece = match part {
        1 => "The workpiece is a new one. Teach the height of the path on it.",
        _ => "The workpiece is that of part 1, and before.csv is its last scan. Teach the height of the path on it.",
    };
    let scans = match choice.scans_per_surface {
        1 => String::new(),
        count => format!(" Scan each surface {count} times, and give the mean."),
    };
    vec![
        format!("A plan. {}", next.summary),
        format!("{tool} {workpiece}"),
        "The path of each pass is in passN_path.csv: force 0 means in the air.".to_owned(),
        format!("Measure the scans and logs that are named below, and put them into this folder.{scans}"),
    ]
}
