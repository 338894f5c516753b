//! `robofin study`: compares, calibrates, diagnoses, adds effects and repeats until nothing more is found.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use effects::{Library, Model};

use super::flags::{OutFlags, SEEDS};
use super::model_flags::{ModelFlags, read_text};
use super::values::whole;
use crate::console::Console;
use crate::wrong_use;
use files::folder::StagedFolder;
use files::output::{FolderKind, OutputPath};
use report::study::page;
use study::{
    Action, Data, EXPECTED_SIMULATIONS, Measurements, Progress, STUDY_FILE, StudyRecord, StudyState, inputs_sha256,
};
use study::{MODEL_WITH_PROPOSAL, NEXT_TRIAL_NAMES as NEXT, StudyReport, write_next_trial, write_proposal};

/// Name of the model's file in a study's folder.
const MODEL_FILE: &str = "model.toml";
/// Files of a study beside its record.
pub(super) const STUDY_NAMES: &[&str] = &[MODEL_FILE, "report.html", MODEL_WITH_PROPOSAL];
/// Kind of a study's folder.
const STUDY: FolderKind = FolderKind {
    marker: STUDY_FILE,
    key: "measurements_sha256",
    names: &[("", STUDY_NAMES), ("effects/", &["*.toml"]), NEXT[0], NEXT[1], NEXT[2]],
};

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin study trials --out out/study\n  \
                        robofin study trials --out out/study --step     (again and again, one step each time)")]
pub(super) struct StudyArgs {
    /// Folder of trial folders, one trial folder, or a folder with a table.toml.
    campaign: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    #[command(flatten)]
    model: ModelFlags,
    /// Continue the study that an interrupted run, or --step, left in this place.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// Do the next step only, and say what the one after it would be; the folder keeps how far the study is.
    #[arg(long)]
    step: bool,
    /// Seed of the permutations in significance tests.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: u64,
}

/// Runs the verb.
pub(super) fn run(args: &StudyArgs, console: &Console) -> Result<()> {
    let out = &args.out.out;
    let goes_on = (args.step || args.resume) && !args.out.force && out.join(STUDY_FILE).is_file();
    let folder = StagedFolder::new(
        &OutputPath { force: args.out.force || goes_on, ..args.out.beside(&args.model.inputs(&args.campaign)) },
        &STUDY,
    )?;
    let library = args.model.own.library()?;
    let measurements = Measurements::read(&args.campaign)?;
    let mut data = measurements.data()?;
    let library = data.library(library)?;
    console.step("read", data.describe());
    data.notes().iter().for_each(|note| console.step("note", note));
    let progress = Progress::take_up(&std::path::absolute(out)?, &mut data, &inputs_sha256(&args.campaign)?)?;
    if let Some(progress) = progress.as_ref().filter(|progress| progress.known > 0) {
        let folder = progress.folder().display();
        console.step("resumed", format!("{} predictions of an interrupted run are in {folder}", progress.known));
    }
    let mut course = if goes_on { resumed(args, data, &library)? } else { begun(args, data, &library)? };
    if course.record.next.is_none() {
        describe_end(&course.record, console);
        progress.map_or(Ok(()), Progress::end)?;
        return console.answer(&course.record);
    }
    advance(&mut course, args.step, &|record| progress.as_ref().map_or(Ok(()), |it| Ok(it.note(record)?)), console)?;
    write(&mut course, folder, &library, console)?;
    progress.map_or(Ok(()), Progress::end)?;
    console.answer(&course.record)
}

/// Starts a study.
fn begun<'a>(args: &StudyArgs, data: Data<'a>, library: &'a Library) -> Result<StudyState<'a>> {
    let record = StudyRecord::new(inputs_sha256(&args.campaign)?, args.seed);
    let model = args.model.model(data.evidence().process(), library)?;
    Ok(StudyState::new(data, library, model, record)?)
}

/// Continues a study from its folder.
fn resumed<'a>(args: &StudyArgs, data: Data<'a>, library: &'a Library) -> Result<StudyState<'a>> {
    let out = &args.out.out;
    if args.model.model.is_some() {
        let model = out.join(MODEL_FILE);
        return Err(wrong_use(format!(
            "--model: this study continues with its own {}; change that file, or start again with --force",
            model.display()
        )));
    }
    let record = StudyRecord::read(out, &args.campaign)?;
    let model = out.join(MODEL_FILE);
    let model = Model::parse(&model.display().to_string(), &read_text(&model)?, library)?;
    Ok(StudyState::new(data, library, model, record)?)
}

/// Does the next step, or all steps to the end; reports each, and lets `note` store it.
pub(super) fn advance(
    course: &mut StudyState,
    one: bool,
    note: &dyn Fn(&StudyRecord) -> Result<()>,
    console: &Console,
) -> Result<()> {
    while let Some(next) = course.record.next {
        let started = Instant::now();
        let progress = console.progress(next.word());
        let done = course.step(&|what, done, all| progress.report(what, done, all))?;
        drop(progress);
        if let Some(done) = done {
            let seconds = started.elapsed().as_secs_f64();
            console.step(done.action.word(), format!("{}\nin {seconds:.1} s", done.outcome));
        }
        if next == Action::Compare && !one {
            first_answer(course, console)?;
        }
        note(&course.record)?;
        if one {
            break;
        }
    }
    describe_end(&course.record, console);
    Ok(())
}

/// Reports a first answer within a minute, and the expected duration of the rest.
fn first_answer(course: &mut StudyState, console: &Console) -> Result<()> {
    let started = Instant::now();
    course.simulate_once()?;
    let minutes = |count: f64| (started.elapsed().as_secs_f64() * count / 60.0).ceil();
    let [least, most] = EXPECTED_SIMULATIONS.map(minutes);
    console.step("time", format!("the study may take {least:.0} to {most:.0} min"));
    let answer = course.first_answer()?;
    let record = &mut course.record;
    console.step("first look", answer.words(record.noise_floor, record.error_unit));
    record.first_answer = Some(answer);
    Ok(())
}

fn describe_end(record: &StudyRecord, console: &Console) {
    match (record.next, &record.ended) {
        (Some(next), _) => console.step("next", format!("{}: {}", next.word(), next.intent())),
        (None, ended) => {
            let why = ended.as_deref().unwrap_or_default();
            console.step("ended", why);
            console.step("verdict", record.sentence.as_deref().unwrap_or_default());
        }
    }
}

/// Writes the folder of a study.
fn write(course: &mut StudyState, folder: StagedFolder, library: &Library, console: &Console) -> Result<()> {
    write_files(course, folder.path(), library, console)?;
    let place = folder.commit()?;
    console.step("written", format!("{}; open report.html there", place.display()));
    Ok(())
}

/// Writes the files of a study into a folder; returns the report shown on its page.
pub(super) fn write_files(
    course: &mut StudyState,
    folder: &Path,
    library: &Library,
    console: &Console,
) -> Result<StudyReport> {
    let write = |name: &str, text: String| {
        std::fs::write(folder.join(name), text).with_context(|| format!("{name}: cannot be written"))
    };
    if let Some(proposal) = course.proposal() {
        write_proposal(proposal, folder)?.into_iter().for_each(|(what, text)| console.step(what, text));
    }
    if let Some(next) = course.next_trial() {
        write_next_trial(next, folder)?.into_iter().for_each(|(what, text)| console.step(what, text));
    }
    write(STUDY_FILE, serde_json::to_string_pretty(&course.record)?)?;
    write(MODEL_FILE, course.model.to_text(library))?;
    let report = course.report()?;
    write("report.html", page(&report))?;
    Ok(report)
}
