//! Sequence of a study: compare, calibrate, diagnose, add, calibrate again, until the stop rule ends it.

use std::cell::Cell;

use effects::{CompiledModel, Library, Model};
use lab::criteria::{MOST_EFFECTS, NEAR_FLOOR_RATIO};
use lab::{LabError, Result};

use super::calibrated::{CalibrationReport, bare_report, calibration_report};
use super::conclusion::{proposal, summary};
use super::measurements::Data;
use super::proposal_step::add_proposal;
use super::record::{Action, Done, STUDY_FILE, StudyRecord};
use super::report_from_diagnosis::waterfall;
use crate::StudyReport;
use lab::{
    BASE_STEP, Calibration, CalibrationSummary, Diagnosis, DiagnosisSummary, EffectSummary, Fitted, NextTrial,
    OnProgress, Order, ParameterSummary, Proposal, Searched, Totals, Unfitted, Verdict, beginning, parameter_summary,
};

/// A study in progress: its record, and the results that this run of the program holds in memory.
pub struct StudyState<'a> {
    /// The record that is stored.
    pub record: StudyRecord,
    /// The model so far.
    pub model: Model,
    pub(super) data: Data<'a>,
    pub(super) library: &'a Library,
    calibration: Option<Calibration>,
    diagnosis: Option<(Diagnosis, DiagnosisSummary)>,
    /// Effects that the searches of this run fitted, those of the last search first.
    suspects: Vec<EffectSummary>,
    /// Effects that the last search looked at and did not weigh.
    unfitted: Vec<Unfitted>,
}

impl<'a> StudyState<'a> {
    /// Continues a study from a record and a model, or begins it with them.
    ///
    /// # Errors
    /// If the model does not fit the measurements.
    pub fn new(data: Data<'a>, library: &'a Library, model: Model, record: StudyRecord) -> Result<Self> {
        let record = StudyRecord { notes: data.notes(), findings: data.findings(), ..record };
        let model = data.fitting(model, library)?;
        Ok(Self {
            record,
            model,
            data,
            library,
            calibration: None,
            diagnosis: None,
            suspects: Vec::new(),
            unfitted: Vec::new(),
        })
    }

    /// Does the next step, unless the study has ended.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub fn step(&mut self, on_progress: OnProgress) -> Result<Option<Done>> {
        let Some(action) = self.record.next else { return Ok(None) };
        let outcome = match action {
            Action::Compare => self.compare()?,
            Action::Calibrate => self.calibrate(on_progress)?,
            Action::Diagnose => self.diagnose(on_progress)?,
            Action::Add => self.add()?,
        };
        let done = Done { action, outcome };
        self.record.done.push(done.clone());
        Ok(Some(done))
    }

    /// Compares the base law with the measurements.
    fn compare(&mut self) -> Result<String> {
        let evidence = self.data.evidence();
        let (waterfall, (floor, held_out)) = beginning(evidence, &self.start()?)?;
        let record = &mut self.record;
        (record.error_unit, record.noise_floor, record.waterfall) = (evidence.unit(), floor, waterfall);
        record.evaluation_noise_floor = held_out;
        record.next = Some(Action::Calibrate);
        let lines: Vec<String> = record.waterfall.iter().map(|step| step.shown(record.error_unit)).collect();
        Ok(format!("{}\nnoise floor: {}", lines.join("\n"), record.error_unit.shown(floor)))
    }

    /// The base law before any fit.
    pub(super) fn start(&self) -> Result<CompiledModel> {
        let start = self.data.start(&self.model, self.library)?;
        Ok(CompiledModel::new(&start, self.library, self.data.evidence().rows())?)
    }

    /// Fits the model, unless a search of this run has fitted it together with the effect that it found.
    fn calibrate(&mut self, on_progress: OnProgress) -> Result<String> {
        self.fitted(on_progress)?;
        let calibration = self.calibration.as_ref().expect("the model is fitted");
        let numbers = CalibrationSummary::new(self.data.evidence(), calibration, self.library)?;
        let record = &mut self.record;
        record.waterfall = numbers.waterfall;
        self.model = calibration.model.clone();
        let last = record.waterfall.last().expect("the model is a step");
        let ratio = last.calibration_rms / record.noise_floor;
        let text = format!("{}\n{ratio:.2} times the noise floor", last.shown(record.error_unit));
        if record.verdict == Some(Verdict::Identified) {
            let frame = self.data.evidence().frame(&calibration.last().fit)?;
            record.add_frame(frame.as_ref());
            let beside = frame.and_then(|frame| frame.sentence()).map_or(String::new(), |words| format!(" {words}"));
            record.sentence = Some(identified(&record.added, &numbers.parameters) + &beside);
        }
        let values: Vec<String> = numbers.parameters.iter().map(|parameter| parameter.shown()).collect();
        let text = [vec![text], values, numbers.remarks].concat().join("\n");
        self.decide(ratio);
        Ok(text)
    }

    /// Applies the stop rule after a calibration.
    fn decide(&mut self, floors: f64) {
        let record = &mut self.record;
        record.next = None;
        record.ended = match record.verdict {
            Some(Verdict::Identified) => {
                Some("what is left is noise and the error of the simulation itself".to_owned())
            }
            Some(_) if floors <= NEAR_FLOOR_RATIO => {
                Some(format!("the error is within {NEAR_FLOOR_RATIO} times the noise floor"))
            }
            Some(_) if record.added.len() >= MOST_EFFECTS => {
                Some(format!("{MOST_EFFECTS} effects were added, and more would be guessing"))
            }
            _ => {
                record.next = Some(Action::Diagnose);
                None
            }
        };
    }

    /// Fits the model and the smaller models on the way to it, if that is not done yet.
    fn fitted(&mut self, on_progress: OnProgress) -> Result<()> {
        if let Some(calibration) = self.calibration.take_if(|c| c.steps.len() == 1 + self.model.effects.len()) {
            let is_added = self.record.done.last().is_some_and(|done| done.action == Action::Add);
            self.calibration = Some(if is_added { self.data.renewed(calibration)? } else { calibration });
            return Ok(());
        }
        let count = 1 + self.model.effects.len();
        let start = self.data.start(&self.model, self.library)?;
        let done = Cell::new(0);
        let fitted = |name: &str| {
            done.set(done.get() + 1);
            on_progress(name, done.get(), count);
        };
        let models = (&self.model, &start);
        self.calibration = Some(self.data.calibrated(models, self.library, (Order::Joint, &fitted))?);
        Ok(())
    }

    /// Searches for one missing effect.
    fn diagnose(&mut self, on_progress: OnProgress) -> Result<String> {
        self.fitted(&|_, _, _| {})?;
        let fit = self.calibration.as_ref().expect("the model is fitted").last().fit.clone();
        let search = (self.record.seed, on_progress);
        let mut diagnosis = Diagnosis::within(self.data.evidence(), (&self.model, fit), self.library, search, 1)?;
        let to_add = self.judged(&mut diagnosis);
        if to_add.is_none() && diagnosis.verdict == Verdict::Identified {
            self.record.add_frame(diagnosis.frame.as_ref());
        }
        let mut summary = summary(&mut self.data, &diagnosis, self.library)?;
        self.data.free_nuisances();
        if to_add.is_none() {
            summary.proposal = proposal(&self.data, &diagnosis, self.library, self.record.seed)?;
        }
        let record = &mut self.record;
        let sentence = record.sentence_with(diagnosis.verdict, to_add.as_deref(), &summary.sentence);
        let outcome = [vec![sentence.clone()], summary.suspects.iter().take(3).map(|s| s.shown()).collect()].concat();
        (record.verdict, record.sentence) = (Some(diagnosis.verdict), Some(sentence));
        record.diagnosis = Some(serde_json::to_value(&summary)?);
        record.next = to_add.as_ref().map(|_| Action::Add);
        if to_add.is_none() {
            record.ended = Some("no further effect of the library can be named".to_owned());
        }
        let searched = self.suspects.iter().map(|suspect| suspect.search).max().unwrap_or(0);
        let numbered = |one: &EffectSummary| EffectSummary { search: searched + one.search, ..one.clone() };
        self.suspects.splice(0..0, summary.suspects.iter().map(numbered));
        let later = |one: &Unfitted| Unfitted { search: searched + one.search, ..one.clone() };
        self.unfitted = summary.unfitted.iter().map(later).collect();
        record.to_add = to_add.map(|name| [name, diagnosis.model.to_text(self.library)]);
        self.diagnosis = Some((diagnosis, summary));
        Ok(outcome.join("\n"))
    }

    /// Returns the effect to add, and sets the verdict over all searches so far by the rules of a diagnosis. While more
    /// may be found, the verdict of the last search is kept.
    fn judged(&mut self, diagnosis: &mut Diagnosis) -> Option<String> {
        let record = &mut self.record;
        let first = &diagnosis.rounds[0];
        match record.searched.last_mut() {
            None => record.searched.push(first.as_searched()),
            // The effect that was added last, as it is fitted now.
            Some(last) => *last = Searched { probability: last.probability, ..first.as_searched() },
        }
        let sure = matches!(diagnosis.verdict, Verdict::Identified | Verdict::Partly);
        let found = diagnosis.found().first().map(|found| (found.suspect.name().to_owned(), found.as_searched()));
        let chain: Vec<Searched> = record.searched.iter().cloned().chain(found.iter().map(|f| f.1.clone())).collect();
        let goes_on = sure && diagnosis.verdict == Verdict::Partly && chain.len() <= MOST_EFFECTS;
        if !goes_on && let Some(verdict) = Verdict::of_chain(&chain) {
            diagnosis.verdict = verdict;
        }
        let (name, searched) = found.filter(|_| sure && diagnosis.verdict != Verdict::Unknown)?;
        record.searched.push(searched);
        Some(name)
    }

    /// Adds the effect that was found, with its fitted values.
    fn add(&mut self) -> Result<String> {
        let Some([name, text]) = self.record.to_add.take() else {
            return Err(LabError::Refused(format!("{STUDY_FILE}: names no effect to add")));
        };
        self.model = Model::parse(STUDY_FILE, &text, self.library)?;
        if let (Some((diagnosis, _)), Some(calibration)) = (&self.diagnosis, &mut self.calibration) {
            calibration.steps.push(Fitted { name: format!("+ {name}"), fit: diagnosis.fit.clone(), staged: None });
            calibration.model = self.model.clone();
        }
        self.record.next = Some(Action::Calibrate);
        self.record.added.push(name.clone());
        Ok(format!("{name} is in the model"))
    }

    /// The fitted parameters of the present model; empty before the first calibration.
    pub fn parameters(&self) -> Vec<ParameterSummary> {
        let estimates = self.calibration.iter().flat_map(|calibration| calibration.last().estimates());
        estimates.map(|estimate| parameter_summary(&estimate)).collect()
    }

    /// The last search of this run.
    pub fn diagnosis(&self) -> Option<&Diagnosis> {
        self.diagnosis.as_ref().map(|(diagnosis, _)| diagnosis)
    }

    /// The effect proposed by the last search if no effect of the library describes the data.
    pub fn proposal(&self) -> Option<&Proposal> {
        self.diagnosis.as_ref().and_then(|(_, summary)| summary.proposal.as_ref())
    }

    /// The trial that the last search proposed.
    pub fn next_trial(&self) -> Option<&NextTrial> {
        self.diagnosis.as_ref().and_then(|(_, summary)| summary.next_trial.as_ref())
    }

    /// The measurements as evidence for fits.
    pub fn evidence(&self) -> &dyn Totals {
        self.data.evidence()
    }

    /// Fills the report of the present state.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub fn report(&mut self) -> Result<StudyReport> {
        let numbers = self
            .calibration
            .as_ref()
            .map(|calibration| CalibrationSummary::new(self.data.evidence(), calibration, self.library));
        let numbers = numbers.transpose()?;
        let seen = match &self.calibration {
            Some(calibration) => calibration.last().fit.model.clone(),
            None => self.start()?,
        };
        self.data.fix_nuisances(&seen)?;
        let report = self.report_with(&seen, numbers.as_ref());
        self.data.free_nuisances();
        report
    }

    fn report_with(&self, seen: &CompiledModel, numbers: Option<&CalibrationSummary>) -> Result<StudyReport> {
        let record = &self.record;
        let (sentence, answer) = (self.sentence(), serde_json::to_value(record)?);
        let (Some(calibration), Some(summary)) = (&self.calibration, numbers) else {
            let falls = waterfall(&record.waterfall, record.floors(), record.error_unit);
            let models = (&self.model, seen, None);
            let bare = bare_report(&self.data, models, falls, (0, record.seed))?;
            return Ok(StudyReport { sentence, diagnosis: answer, ..bare });
        };
        let mut report = calibration_report(&CalibrationReport {
            data: &self.data,
            calibration,
            summary,
            waterfall: &record.waterfall,
            rival: self.rival(),
            verdict: record.verdict,
            sentence,
            seed: record.seed,
            answer,
        })?;
        let Some((_, found)) = &self.diagnosis else { return Ok(report) };
        found.proposal.iter().for_each(|proposal| add_proposal(&mut report.waterfall, proposal));
        Ok(StudyReport {
            suspects: self.suspects.clone(),
            unfitted: self.unfitted.clone(),
            detectable: found.detectable.clone(),
            next_trial: found.next_trial.clone(),
            proposal: found.proposal.clone(),
            ..report
        })
    }

    /// The most probable model of the last search, if the study ended because it could not be named alone.
    fn rival(&self) -> Option<&CompiledModel> {
        let searched_last = self.record.done.last().is_some_and(|done| done.action == Action::Diagnose);
        let (diagnosis, _) = self.diagnosis.as_ref().filter(|_| searched_last && self.record.next.is_none())?;
        diagnosis.found().first().map(|found| &found.suspect.fit.model)
    }

    /// Sentence on the verdict, or on the present state.
    fn sentence(&self) -> String {
        let record = &self.record;
        let next = record.next.map_or(String::new(), |next| format!(" Next: {}.", next.intent()));
        match &record.sentence {
            Some(sentence) => format!("{sentence}{next}"),
            None => {
                let last = record.waterfall.iter().rev().find(|step| step.step == BASE_STEP);
                let far = last.or(record.waterfall.last()).map_or(String::new(), |step| step.shown(record.error_unit));
                format!("Nothing is diagnosed yet; {far}.{next}")
            }
        }
    }
}

/// Sentence on the effects that a study has identified, with the values of its last calibration.
fn identified(added: &[String], parameters: &[ParameterSummary]) -> String {
    let own = |name: &String| {
        let of_effect = parameters.iter().filter(|parameter| parameter.name.starts_with(&format!("{name}.")));
        let values: Vec<String> = of_effect.map(|parameter| parameter.shown()).collect();
        if values.is_empty() { name.clone() } else { format!("{name}: {}", values.join("; ")) }
    };
    format!("The model lacked {}.", added.iter().map(own).collect::<Vec<_>>().join(" and "))
}
