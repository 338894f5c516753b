//! Thread of a bench: reads the measurements, then does one task after the other.

use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::time::Instant;

use effects::{Library, Model};
use files::json_file::read_json;
use lab::{LabError, Result};
use report::study::{Sections, page};
use study::{Data, Hypothesis, Measurements, STUDY_FILE, StudyRecord, aligned, inputs_sha256};
use trials::trial::Campaign;

use super::engine::{Engine, FitView};
use super::journal::{Journal, Texts};
use super::plan::{OwnedChange, Plan};
use super::replay::{self, Change};
use super::shared::{Job, Phase, Reader, Shared};
use super::slider::{SliderSetting, four_digits};
use super::stage::{Errors, Record, Slider, Stage};
use super::suspects::Suspects;
use super::task::Task;
use crate::next_trial::has_plan;
use crate::part::Surfaces;
use crate::place::{Kind, Place, places};

/// Number of fitted models whose evidence is kept in memory, so that undo to the previous model is immediate.
const KEPT_ENGINES: usize = 2;
/// Name of the first model.
const BASE: &str = "base model";

/// Folders of a bench.
pub(super) struct Setup {
    /// The campaign or table.
    pub(super) place: Place,
    /// Folder in which the bench is saved.
    pub(super) out: PathBuf,
    /// Folder that may hold studies of the same measurements.
    pub(super) root: PathBuf,
}

struct Worker<'m> {
    setup: &'m Setup,
    shared: &'m Arc<Shared>,
    measurements: &'m Measurements,
    journal: Journal,
    library: Library,
    /// Data that no fit has used, prepared in advance.
    fresh: Option<Data<'m>>,
    engines: VecDeque<(usize, Engine<'m>)>,
}

/// Reads the measurements and does tasks until the senders of tasks are gone.
pub(super) fn run(setup: Setup, shared: &Arc<Shared>, tasks: &Receiver<Task>) {
    let ended = catch_unwind(AssertUnwindSafe(|| work(&setup, shared, tasks)));
    let fault = match ended {
        Ok(Ok(())) => return,
        Ok(Err(error)) => error.to_string(),
        Err(panic) => words_of(&*panic),
    };
    shared.change(|state| (state.phase, state.fault, state.job) = (Phase::Closed, Some(fault), None));
}

fn work(setup: &Setup, shared: &Arc<Shared>, tasks: &Receiver<Task>) -> Result<()> {
    let measurements = measurements(setup, shared)?;
    let mut worker = Worker::new(setup, &measurements, shared)?;
    let mut queue: VecDeque<Task> = VecDeque::from([Task::Renew]);
    loop {
        if queue.is_empty() {
            let Ok(task) = tasks.recv() else { return Ok(()) };
            queue.push_back(task);
        }
        queue.extend(tasks.try_iter());
        let task = queue.pop_front().expect("it was filled above");
        if queue.front().is_some_and(|next| is_overtaken(&task, next)) {
            continue;
        }
        let waiting = queue.len();
        shared.change(|state| state.waiting = waiting);
        worker.attempt(&task, queue.is_empty());
    }
}

/// Reads the measurements. The scanned surfaces are published before the slower alignment of the logs with the scans.
fn measurements(setup: &Setup, shared: &Arc<Shared>) -> Result<Measurements> {
    if setup.place.kind == Kind::Table {
        return Measurements::read(&setup.place.path);
    }
    let campaign = Campaign::read(&setup.place.path)?;
    shared.change(|state| state.surfaces = Some(Arc::new(Surfaces::of(&campaign))));
    Ok(Measurements::Scans(aligned(campaign)?))
}

/// Returns true if the next task makes a task superfluous.
fn is_overtaken(task: &Task, next: &Task) -> bool {
    matches!((task, next), (Task::Hold { .. }, Task::Hold { .. } | Task::Keep { .. }) | (Task::Renew, Task::Renew))
}

fn words_of(panic: &(dyn Any + Send)) -> String {
    let words = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("a bug in this program; please report it: {}", words.unwrap_or("it said nothing"))
}

impl<'m> Worker<'m> {
    fn new(setup: &'m Setup, measurements: &'m Measurements, shared: &'m Arc<Shared>) -> Result<Self> {
        let measured = inputs_sha256(&setup.place.path)?;
        let (journal, earlier) = Journal::open(&setup.out, measured.clone())?;
        let data = measurements.data()?;
        let library = journal.library(&data.library(Library::builtin().clone())?)?;
        let process = data.evidence().process();
        let reader = Reader { process, states: reader_states(&data, &library), library: library.clone() };
        let suspects = earlier.suspects.or_else(|| of_a_study(&setup.root, &measured));
        shared.change(|state| {
            (state.phase, state.about, state.notes) = (Phase::Open, data.describe(), data.notes());
            (state.stages, state.trail, state.suspects) = (earlier.stages, earlier.trail, suspects);
            state.reader = Some(Arc::new(reader));
        });
        let fresh = Some(data);
        Ok(Self { setup, shared, measurements, journal, library, fresh, engines: VecDeque::new() })
    }

    /// Does a task and publishes the outcome.
    fn attempt(&mut self, task: &Task, is_last: bool) {
        self.shared.stop.store(false, Ordering::Relaxed);
        let done = catch_unwind(AssertUnwindSafe(|| self.take(task, is_last)));
        let was_stopped = self.shared.stop.swap(false, Ordering::Relaxed);
        let fault = match done {
            Ok(Ok(())) => None,
            Ok(Err(_)) if was_stopped => Some("cancelled; nothing has changed".to_owned()),
            Ok(Err(error)) => Some(error.to_string()),
            Err(panic) => Some(words_of(&*panic)),
        };
        let kept = self.shared.read(|state| self.journal.keep(state));
        let fault = fault.or(kept.err().map(|error| error.to_string()));
        self.shared.change(|state| (state.job, state.fault) = (None, fault));
    }

    fn take(&mut self, task: &Task, is_last: bool) -> Result<()> {
        match task {
            Task::Add { effect } => {
                let hypothesis = Hypothesis::listed(self.library.clone(), effect)?;
                self.grow(hypothesis, OwnedChange::Add(effect.clone()), format!("+ {effect}"))
            }
            Task::Formula { line } => self.formula(line),
            Task::Remove { effect } => self.remove(effect),
            Task::Hold { parameter, value } => self.hold((parameter, *value), is_last),
            Task::Keep { parameter, value } => self.keep(parameter, *value),
            Task::Search => self.search(),
            Task::Renew | Task::Undo | Task::Redo | Task::GoTo { .. } | Task::Cancel => self.renew(),
        }
    }

    /// Returns data that no fit has used.
    fn fresh(&mut self) -> Result<Data<'m>> {
        self.fresh.take().map_or_else(|| self.measurements.data(), Ok)
    }

    /// Publishes the start of a job with a number of parts.
    fn begin(&self, what: &str, all: usize) {
        let job = Job { what: what.to_owned(), done: 0, all, since: Instant::now() };
        self.shared.change(|state| (state.job, state.fault) = (Some(job), None));
    }

    /// Publishes that one part of the job is done.
    fn advance(&self, what: &str) {
        self.shared.change(|state| {
            state.job.iter_mut().for_each(|job| (job.done, job.what) = (job.done + 1, what.to_owned()));
        });
    }

    /// Returns number and text of the current model as fitted; `None` before the first.
    fn current(&self) -> Result<Option<(usize, Model)>> {
        let Some(number) = self.shared.read(|state| state.trail.current()) else { return Ok(None) };
        let (file, text) = self.journal.model(number, true)?;
        Ok(Some((number, Model::parse(&file, &text, &self.library)?)))
    }

    /// Returns the current model as the base of a change.
    fn standing(&self) -> Result<Model> {
        let current = self.current()?.map(|(_, model)| model);
        current.ok_or_else(|| LabError::Refused("the base model is not fitted yet".to_owned()))
    }

    /// Makes the current model available and simulated; fits the base model if there is none.
    fn renew(&mut self) -> Result<()> {
        let Some(number) = self.shared.read(|state| state.trail.current()) else { return self.base() };
        let stage = self.shared.read(|state| state.stage(number)).expect("the trail names stages");
        if let Some(at) = self.engines.iter().position(|(own, _)| *own == number) {
            let own = self.engines.remove(at).expect("it was found there");
            self.engines.push_back(own);
            return Ok(());
        }
        let (file, text) = self.journal.model(number, false)?;
        let model = Model::parse(&file, &text, &self.library)?;
        let (engine, shown) = self.fitted(&model, self.library.clone(), number)?;
        stage.set_live(shown.live.map(Arc::new));
        self.remember(number, engine);
        Ok(())
    }

    fn base(&mut self) -> Result<()> {
        let data = self.fresh()?;
        let model = Model::new(data.evidence().process());
        self.fresh = Some(data);
        let library = self.library.clone();
        self.make(Plan { label: BASE.to_owned(), model, library, change: OwnedChange::Base, effect: None })
    }

    /// Adds an effect to the current model and fits it.
    fn grow(&mut self, hypothesis: Hypothesis, change: OwnedChange, label: String) -> Result<()> {
        let model = self.standing()?;
        let Hypothesis { library, name, file, .. } = hypothesis;
        if model.effects.iter().any(|effect| effect.name == name) {
            return Err(LabError::Refused(format!("{name} is in the model already")));
        }
        let effect = file.map(|text| (name.clone(), text));
        self.make(Plan { label, model: model.with(&name), library, change, effect })
    }

    fn formula(&mut self, line: &str) -> Result<()> {
        let model = self.standing()?;
        self.begin("reading the formula", 1);
        let number = (1..).find(|n| self.library.find(&format!("try-{n}")).is_none()).expect("one is free");
        let data = self.fresh()?;
        let hypothesis = Hypothesis::typed((&data, &model), self.library.clone(), (line, number), &[]);
        self.fresh = Some(data);
        let hypothesis = hypothesis?;
        let change = OwnedChange::Add(hypothesis.name.clone());
        let label = format!("+ {}: {line}", hypothesis.name);
        self.grow(hypothesis, change, label)
    }

    fn remove(&mut self, effect: &str) -> Result<()> {
        let mut model = self.standing()?;
        if model.effects.iter().all(|own| own.name != effect) {
            return Err(LabError::Refused(format!("{effect} is not in the model")));
        }
        model.effects.retain(|own| own.name != effect);
        let prefix = format!("{effect}.");
        model.free.iter_mut().for_each(|free| free.retain(|path| !path.starts_with(&prefix)));
        model.ranges.retain(|(path, _)| !path.starts_with(&prefix));
        let (library, change) = (self.library.clone(), OwnedChange::Remove(effect.to_owned()));
        self.make(Plan { label: format!("\u{2212} {effect}"), model, library, change, effect: None })
    }

    fn keep(&mut self, parameter: &str, value: f64) -> Result<()> {
        self.renew()?;
        let (_, engine) = self.engines.back().expect("renewed above");
        let slid = SliderSetting::new(engine.fit(), parameter, value)?;
        let model = slid.in_model(&engine.calibration.model, engine.fit());
        let unit = &engine.fit().coordinates[slid.place].slot.unit_text;
        let label = format!("{parameter} held at {} {unit}", four_digits(slid.shown(engine.fit())));
        let library = self.library.clone();
        self.make(Plan { label, model, library, change: OwnedChange::Written, effect: None })
    }

    fn hold(&mut self, (parameter, value): (&str, f64), is_last: bool) -> Result<()> {
        self.renew()?;
        let since = Instant::now();
        let shared = self.shared;
        let (_, engine) = self.engines.back_mut().expect("renewed above");
        let slid = SliderSetting::new(engine.fit(), parameter, value)?;
        let coarse = engine.held(slid.place, slid.value)?;
        let held = slid.held(engine, (&coarse, None), since);
        shared.change(|state| state.held = Some(held));
        if !is_last {
            return Ok(());
        }
        self.begin("refining what is held on the fine lattice", 1);
        let (_, engine) = self.engines.back().expect("renewed above");
        let (fine, rms) = engine.refined(&coarse)?;
        let held = slid.held(engine, (&fine, Some(rms)), since);
        shared.change(|state| state.held = Some(held));
        Ok(())
    }

    fn search(&mut self) -> Result<()> {
        self.renew()?;
        self.begin("searching the library", 1);
        let shared = self.shared;
        let on_progress = |what: &str, done: usize, all: usize| {
            shared.change(|state| {
                state.job.iter_mut().for_each(|job| (job.what, job.done, job.all) = (what.to_owned(), done, all));
            });
        };
        let (number, engine) = self.engines.back_mut().expect("renewed above");
        let diagnosis = engine.searched(&on_progress)?;
        let source = format!("search beside model {number}");
        shared.change(|state| state.suspects = Suspects::of(source, &diagnosis));
        Ok(())
    }

    /// Fits a model and simulates its fields and maps.
    fn fitted(&mut self, model: &Model, library: Library, number: usize) -> Result<(Engine<'m>, FitView)> {
        let all = 3 + model.effects.len();
        self.begin(&format!("fitting model {number}"), all);
        let data = self.fresh()?;
        let on_progress = |name: &str| self.advance(&format!("fitting model {number}: {name} is done"));
        let mut engine = Engine::new(data, (model, library), (&self.shared.stop, &on_progress))?;
        self.advance("simulating maps and fields");
        let shown = engine.shown(PathBuf::from(format!("replay/{number}/model.toml")))?;
        match self.shared.stop.load(Ordering::Relaxed) {
            true => Err(LabError::Refused("was stopped".to_owned())),
            false => Ok((engine, shown)),
        }
    }

    /// Fits a model, saves it and makes it the current one.
    fn make(&mut self, plan: Plan) -> Result<()> {
        let before = self.shared.read(|state| state.trail.current());
        let number = 1 + self.shared.read(|state| state.stages.len());
        let start = plan.model.to_text(&plan.library);
        let start_model = Model::parse("the model", &start, &plan.library)?;
        let (engine, shown) = self.fitted(&start_model, plan.library.clone(), number)?;
        let sections = Sections::of(&shown.report);
        let calibration = serde_json::to_string_pretty(&shown.answer)?;
        let (model, page) = (engine.text(), page(&shown.report));
        let effect = plan.effect.as_ref().map(|(name, text)| (name.as_str(), text.as_str()));
        let texts = Texts { start: &start, model: &model, calibration: &calibration, page: &page, effect };
        self.journal.write(number, &sections, &texts)?;
        let record = Record {
            number,
            commands: self.commands((before.unwrap_or(0), number), &plan),
            label: plan.label,
            before,
            errors: Errors::of(&shown.answer.summary),
            effects: engine.calibration.model.effects.iter().map(|effect| effect.name.clone()).collect(),
            sliders: Slider::all(engine.fit()),
        };
        let stage = Arc::new(Stage::new(record, sections, shown.live.map(Arc::new)));
        self.library = plan.library;
        self.shared.change(|state| {
            state.stages.push(stage);
            state.trail.go(number);
            state.held = None;
            state.reader = state.reader.as_ref().map(|reader| Arc::new(reader.with(self.library.clone())));
        });
        self.remember(number, engine);
        Ok(())
    }

    fn commands(&self, numbers: (usize, usize), plan: &Plan) -> Vec<String> {
        let folder = self.journal.effects_folder();
        let is_typed = plan.effect.is_some() || folder.is_dir();
        let effects = is_typed.then_some(folder.as_path());
        let places = replay::Places { campaign: &self.setup.place.path, out: &self.setup.out, effects };
        let change = match &plan.change {
            OwnedChange::Base => Change::Base,
            OwnedChange::Add(name) => Change::Add(name),
            OwnedChange::Remove(name) => Change::Remove(name),
            OwnedChange::Written => Change::Written,
        };
        replay::commands(&places, numbers, change)
    }

    /// Stores the evidence of a model as the latest; drops evidence and fields of the oldest beyond the limit.
    fn remember(&mut self, number: usize, engine: Engine<'m>) {
        self.engines.retain(|(own, _)| *own != number);
        self.engines.push_back((number, engine));
        while self.engines.len() > KEPT_ENGINES {
            let (old, _) = self.engines.pop_front().expect("there are some");
            self.shared.read(|state| state.stage(old)).iter().for_each(|stage| stage.set_live(None));
        }
    }
}

/// Returns the states that formulas may read on these data.
fn reader_states(data: &study::Data, library: &Library) -> Vec<effects::NamedState> {
    [data.reaches().measured_states(), effects::NamedState::of_library(library)].concat()
}

/// Returns the suspects of the last study below a folder that has the same measurements.
fn of_a_study(root: &Path, measured: &str) -> Option<Suspects> {
    let studies = places(root).0.into_iter().filter(|place| place.kind == Kind::Study);
    let of = |place: Place| {
        let record: StudyRecord = read_json(&place.path.join(STUDY_FILE), "the record of a study").ok()?;
        let diagnosis = record.diagnosis.filter(|_| record.measurements_sha256 == measured)?;
        let suspects = Suspects::of(format!("study {}", place.title()), &diagnosis)?;
        let files = format!("/place/{}/next-trial.zip", place.id);
        Some(if has_plan(&place.path) { suspects.with_files(files) } else { suspects })
    };
    studies.filter_map(of).next_back()
}

impl Reader {
    /// Returns the same context with another library.
    fn with(&self, library: Library) -> Self {
        Self { process: self.process, states: self.states.clone(), library }
    }
}
