//! Bakes many meshes into a cache, several at once; a mesh that fails does not affect the others.

use std::collections::{BTreeMap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use sdf_bake::read::MeshBytes;

use super::sources::Sources;
use super::{Cache, Recipe, Record};
use crate::baking::{FieldSettings, bake_part};
use crate::part::Part;
use crate::store::StoredItem;
use files::budget::Budget;
use files::file_lock::LockWait;
use sdf_bake::memory_budget;

/// Meshes to bake into a cache.
pub struct Batch<'a> {
    /// Cache of the results.
    pub cache: &'a Cache,
    /// Settings of the fields.
    pub settings: FieldSettings,
    /// Number of meshes baked at once.
    pub jobs: usize,
}

/// Outcome of one mesh.
pub struct Outcome {
    /// The mesh file.
    pub mesh: PathBuf,
    /// Its entry, or the reason of the failure.
    pub result: Result<Entry>,
    /// Time from opening the file to the end [s].
    pub process_s: f64,
}

/// A mesh's entry in the cache.
pub struct Entry {
    /// Name of the entry.
    pub key: String,
    /// Record of the field.
    pub record: Record,
    /// Baking time in this run [s]; `None` if the entry existed already.
    pub bake_s: Option<f64>,
}

/// A mesh file, and the reason if it cannot be searched for.
type Source = (PathBuf, Option<String>);

/// State shared by the jobs.
struct Work<'a> {
    batch: &'a Batch<'a>,
    /// Baking time of each entry made in this run [s].
    baked: Mutex<HashMap<String, f64>>,
    budget: Budget,
}

impl Batch<'_> {
    /// Bakes the meshes that the cache lacks, calls `done` for each mesh in the order of `sources`, and updates the
    /// index.
    ///
    /// # Errors
    /// If the index cannot be written, or `done` fails; a mesh that fails is an outcome.
    pub fn run(&self, sources: Sources, mut done: impl FnMut(&Outcome) -> Result<()>) -> Result<()> {
        let meshes: Vec<Source> = sources.into_iter().collect();
        let budget = Budget::new(memory_budget::MOST_BRICKS);
        let work = Work { batch: self, baked: Mutex::default(), budget };
        let mut keys = BTreeMap::new();
        let mut in_order = InOrder::default();
        let make = |(mesh, fault): &Source, wait| work.outcome(mesh, fault.as_deref(), wait);
        let worked = self.cache.work_through(&meshes, self.jobs, make, |turn, made| {
            in_order.add(turn, made, |mut outcome| {
                work.credit(&mut outcome);
                let key = outcome.result.as_ref().ok().map(|entry| entry.key.clone());
                keys.insert(outcome.mesh.to_string_lossy().into_owned(), key);
                done(&outcome)
            })
        });
        self.cache.update_index(&keys)?;
        worked
    }
}

impl Work<'_> {
    /// Finds or makes the entry of one mesh; `None` if another job is making it and `wait` does not allow waiting.
    fn entry(&self, mesh: &Path, wait: LockWait) -> Result<Option<Entry>> {
        let Batch { cache, settings, .. } = self.batch;
        let bytes = MeshBytes::load(mesh)?;
        let recipe = Recipe::new(&bytes, settings)?;
        let key = recipe.key()?;
        let filled = cache.fill(
            &key,
            wait,
            || cache.find(&key),
            || -> Result<Record> {
                let part = Part::from_bytes(&bytes, settings.unit)?;
                drop(bytes);
                let options = settings.options(&part);
                let _share = self.budget.reserve(memory_budget::check(&part.mesh, &options)?);
                let baked = bake_part(&part, &options)?;
                // Stored before other jobs can find the entry, so that it does not count as an earlier one.
                lock(&self.baked).insert(key.clone(), baked.bake_s);
                cache.keep(&recipe, baked)
            },
        )?;
        let Some(StoredItem::There(record) | StoredItem::Made(record)) = filled else { return Ok(None) };
        Ok(Some(Entry { key, record, bake_s: None }))
    }

    fn outcome(&self, mesh: &Path, fault: Option<&str>, wait: LockWait) -> Option<Outcome> {
        let started = Instant::now();
        let make = || match fault {
            Some(reason) => bail!("{reason}"),
            None => self.entry(mesh, wait),
        };
        // A bug that one mesh triggers must not affect the others.
        let result = catch_unwind(AssertUnwindSafe(make)).unwrap_or_else(|_| Err(anyhow!("a bug in this program")));
        let result = result.with_context(|| mesh.display().to_string()).transpose()?;
        Some(Outcome { mesh: mesh.to_owned(), result, process_s: started.elapsed().as_secs_f64() })
    }

    /// Credits the baking time to the first of the meshes with the same entry, whichever job was faster.
    fn credit(&self, outcome: &mut Outcome) {
        if let Ok(entry) = &mut outcome.result {
            entry.bake_s = lock(&self.baked).remove(&entry.key);
        }
    }
}

/// Passes on outcomes in the order of the sources, in whatever order they arrive.
#[derive(Default)]
struct InOrder {
    waiting: BTreeMap<usize, Outcome>,
    next: usize,
}

impl InOrder {
    fn add(&mut self, turn: usize, outcome: Outcome, mut done: impl FnMut(Outcome) -> Result<()>) -> Result<()> {
        self.waiting.insert(turn, outcome);
        while let Some(outcome) = self.waiting.remove(&self.next) {
            self.next += 1;
            done(outcome)?;
        }
        Ok(())
    }
}

/// Locks a mutex. The data of a job that panicked are consistent, because no operation under the lock can fail.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
