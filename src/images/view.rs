//! Files of a view: camera, pose and buffers common to all images of one placement.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use perception::{View, depth_steps, instances, png8, png16};
use render::to_exr;
use serde::{Deserialize, Serialize};

use super::plan::PlannedView;
use super::{ImageSet, VIEWS_FOLDER};
use crate::asset::FileRecord;
use crate::store::remove;
use files::folder::write_file;
use files::json_file::read_json;

/// Endings of the files beside a view's JSON: instance labels, depth, whole workpiece, float buffers.
const ENDINGS: [&str; 4] = ["-instances.png", "-depth.png", "-amodal.png", ".exr"];

/// `views/ID.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewRecord {
    /// Name.
    pub id: String,
    /// Name of the workpiece.
    pub workpiece: String,
    /// SHA-256 of the workpiece's field.
    pub workpiece_sha256: String,
    /// Camera, pose, boxes and welds.
    #[serde(flatten)]
    pub view: View,
    /// Files beside it, in the order instance labels, depth, whole workpiece, float buffers.
    pub files: [FileRecord; 4],
}

/// Returns the path of a file of a view, relative to the set.
fn path_of(id: &str, ending: &str) -> String {
    format!("{VIEWS_FOLDER}/{id}{ending}")
}

/// Paths of the record, the instance labels, the depth and the whole workpiece of a view, relative to the set.
pub fn view_paths(id: &str) -> [String; 4] {
    [".json", ENDINGS[0], ENDINGS[1], ENDINGS[2]].map(|ending| path_of(id, ending))
}

impl ImageSet {
    fn view_path(&self, id: &str, ending: &str) -> PathBuf {
        self.folder().join(path_of(id, ending))
    }

    /// Reads the record of a view.
    ///
    /// # Errors
    /// If it is missing or damaged.
    pub fn read_view(&self, id: &str) -> Result<ViewRecord> {
        Ok(read_json(&self.view_path(id, ".json"), "the record of a view")?)
    }

    /// Returns true if a view is complete, with all its files at their lengths.
    pub fn holds_view(&self, id: &str) -> bool {
        let has_length = |(ending, record): (&str, &FileRecord)| {
            std::fs::metadata(self.view_path(id, ending)).is_ok_and(|file| file.len() == record.bytes)
        };
        self.read_view(id).is_ok_and(|record| ENDINGS.into_iter().zip(&record.files).all(has_length))
    }

    /// Makes and writes a view, its record last.
    ///
    /// # Errors
    /// If the workpiece cannot be read or a file cannot be written.
    pub fn make_view(&self, planned: &PlannedView) -> Result<()> {
        let recipe = &self.recipe;
        let name = &recipe.workpieces[planned.workpiece].name;
        let (part, workpiece_sha256) = self.read_workpiece(name)?;
        let (scene, files) = self.scene(&part, &recipe.view_seeds(planned))?;
        let (view, frame) = View::of(&part, &scene, recipe.size, &files)?;
        let contents = [
            png8(recipe.size, &instances(&frame.buffers))?,
            png16(recipe.size, &depth_steps(&frame.buffers))?,
            png8(recipe.size, &frame.amodal)?,
            to_exr(&frame.buffers)?,
        ];
        for (ending, bytes) in ENDINGS.into_iter().zip(&contents) {
            write_file(&self.view_path(&planned.id, ending), bytes)?;
        }
        let files = contents.each_ref().map(|bytes| FileRecord::of_bytes(bytes));
        let record = ViewRecord { id: planned.id.clone(), workpiece: name.clone(), workpiece_sha256, view, files };
        let text = serde_json::to_string(&record)? + "\n";
        Ok(write_file(&self.view_path(&planned.id, ".json"), text.as_bytes())?)
    }

    /// Removes a view, its record first.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn remove_view(&self, id: &str) -> Result<()> {
        std::iter::once(".json").chain(ENDINGS).try_for_each(|ending| remove(&self.view_path(id, ending)))
    }

    /// Compares the files of a view with its record; returns the faults.
    ///
    /// # Errors
    /// If a file is missing.
    pub fn check_view(&self, id: &str) -> Result<Vec<String>> {
        let record = self.read_view(id)?;
        ensure!(record.id == id, "its record is that of {}", record.id);
        let mut faults = Vec::new();
        for (ending, expected) in ENDINGS.into_iter().zip(&record.files) {
            if FileRecord::of(&self.view_path(id, ending))? != *expected {
                faults.push(format!("{}: its content is not the one recorded", path_of(id, ending)));
            }
        }
        let (_, workpiece_sha256) = self.read_workpiece(&record.workpiece)?;
        if workpiece_sha256 != record.workpiece_sha256 {
            faults.push(format!("not of {} as it is", record.workpiece));
        }
        Ok(faults)
    }
}

#[cfg(test)]
mod tests {
    use perception::{Scene, SceneFiles, Seeds, Shape};

    use super::*;

    #[test]
    fn the_record_of_a_view_with_welds_is_read_as_it_was_written() {
        let part = Shape::Tee.field(3e-3);
        let scene = Scene::draw(&part, &Seeds { placement: 1, image: 1 }, (64, 48), &[]).unwrap();
        let (view, _) = View::of(&part, &scene, (64, 48), &SceneFiles::default()).unwrap();
        assert!(!view.welds.is_empty());
        let files = [(); 4].map(|()| FileRecord::of_bytes(b""));
        let [id, workpiece, workpiece_sha256] = ["tee-p00", "tee", ""].map(str::to_owned);
        let record = ViewRecord { id, workpiece, workpiece_sha256, view, files };
        let text = serde_json::to_string(&record).unwrap();
        assert_eq!(serde_json::from_str::<ViewRecord>(&text).unwrap(), record);
    }
}
