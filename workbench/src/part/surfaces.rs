//! Scanned surfaces, and their fields, which are computed on first use.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::motion::Motion;
use sdf_bake::heights::{HeightsError, SlabOptions};
use sdf_bake::{BrickGrid, HeightMap};
use serde_json::{Value, json};
use trials::trial::{Campaign, Pass, PassScan, Role, Trial};

/// Margin beyond the tool's reach [voxels], the same as in a simulation.
const MARGIN_VOXELS: f64 = 4.0;

/// Scans of a campaign.
pub(crate) struct Surfaces {
    /// Scans of each trial.
    pub(crate) trials: Vec<ScannedTrial>,
}

/// Scans of one trial.
pub(crate) struct ScannedTrial {
    /// Name of the trial.
    pub(crate) name: String,
    /// Height map before the first pass, despiked.
    pub(crate) before: HeightMap,
    /// Scan after each pass.
    pub(crate) scans: Vec<PassScan>,
    /// Way of the tool in each pass.
    pub(super) motions: Vec<Motion>,
    passes: Vec<Value>,
    reach: f64,
    fields: Mutex<BTreeMap<usize, Arc<BrickGrid>>>,
}

impl Surfaces {
    /// Takes the scans of a campaign.
    pub(crate) fn of(campaign: &Campaign) -> Self {
        Self { trials: campaign.trials.iter().map(ScannedTrial::new).collect() }
    }

    /// Returns the names of trials and passes for the page.
    pub(crate) fn to_json(&self) -> Value {
        self.trials.iter().map(|trial| json!({ "name": trial.name, "passes": trial.passes })).collect()
    }
}

impl ScannedTrial {
    fn new(trial: &Trial) -> Self {
        let pass = |pass: &Pass| {
            json!({
                "isFitted": pass.role == Role::Calibration,
                "isHeights": pass.scan.heights().is_some(),
                "force": pass.force_setpoint,
                "feed": 1e3 * pass.feed,
            })
        };
        Self {
            name: trial.name.clone(),
            before: trial.scans.checked_before(),
            scans: trial.passes.iter().map(|pass| pass.scan.clone()).collect(),
            motions: trial.passes.iter().map(|pass| Motion::of(trial, pass)).collect(),
            passes: trial.passes.iter().map(pass).collect(),
            reach: trial.tool.half_width(),
            fields: Mutex::default(),
        }
    }

    /// Returns the height map after a number of passes; after sanding this is the map before the first pass, because
    /// the shape stays.
    pub(crate) fn heights(&self, passes: usize) -> Option<&HeightMap> {
        match passes.checked_sub(1) {
            None => Some(&self.before),
            Some(at) => self.scans.get(at)?.heights().or(Some(&self.before)),
        }
    }

    /// Returns the field of the scanned surface after a number of passes.
    ///
    /// # Errors
    /// If there is no such scan, or no field can be made of it.
    pub(crate) fn field(&self, passes: usize) -> Result<Arc<BrickGrid>, String> {
        let mut fields = self.fields.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(field) = fields.get(&passes) {
            return Ok(field.clone());
        }
        let map = self.heights(passes).ok_or_else(|| format!("{} has no pass {passes}", self.name))?;
        let voxel = map.pixels.pitch;
        let margin = self.reach + MARGIN_VOXELS * voxel;
        let made = BrickGrid::from_heights(map, &SlabOptions { margin, ..SlabOptions::with_voxel(voxel) });
        let (field, _) = made.map_err(|error: HeightsError| error.to_string())?;
        let field = Arc::new(field);
        fields.insert(passes, field.clone());
        Ok(field)
    }
}
