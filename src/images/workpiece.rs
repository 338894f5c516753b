//! Coated workpieces: the bundled bracket with a weld, the shapes of [`perception`], and assets.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use files::input::{self, MOST_MESH_BYTES, MOST_TEXT_BYTES};
use perception::Shape;
use sdf_bake::nvdb::{self, Codec};
use sdf_bake::{BrickGrid, SignChoice};
use serde::{Deserialize, Serialize};

use super::{FIELDS_FOLDER, ImageSet};
use crate::asset::{AssetFields, MANIFEST_FILE, Manifest};
use crate::console::Console;
use crate::part::{Part, sha256};
use crate::workpiece::{DEFAULT_BAND, Fineness, WeldSettings, WeldingOptions, weld_part};
use crate::wrong_use;
use files::folder::write_file;

/// Name of the bundled part with a weld.
const BRACKET: &str = "bracket";
/// Number of characters of an asset's hash in its name.
const KEY_LETTERS: usize = 8;

/// Origin of a workpiece.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Origin {
    /// The bundled part, with a weld placed by the set's seed.
    Bracket,
    /// A bundled shape.
    Shape {
        /// Shape.
        shape: Shape,
    },
    /// A folder made by `robofin weld`.
    Asset {
        /// Path as given.
        folder: String,
    },
}

/// A fully coated workpiece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coated {
    /// Name, which is part of its images' names.
    pub name: String,
    /// Key of its field: all inputs that define it; for an asset the hash of its manifest.
    pub key: String,
    /// Origin.
    pub origin: Origin,
    /// Distance between voxels [mm].
    pub voxel_mm: f64,
}

impl Coated {
    /// Finds a workpiece by its name, one of [`Coated::bundled`] or an asset folder; `voxel_mm` applies to those without a
    /// field.
    ///
    /// # Errors
    /// Wrong use if there is no such workpiece.
    pub fn named(word: &str, voxel_mm: f64) -> Result<Self> {
        let own = |origin: Origin| Self {
            name: word.to_owned(),
            key: format!("{word}, voxel {voxel_mm} mm"),
            origin,
            voxel_mm,
        };
        if word == BRACKET {
            return Ok(own(Origin::Bracket));
        }
        if let Some(shape) = Shape::ALL.into_iter().find(|shape| shape.name() == word) {
            return Ok(own(Origin::Shape { shape }));
        }
        if Path::new(word).join(MANIFEST_FILE).is_file() {
            return Self::of_asset(word);
        }
        let known = Self::bundled().join(", ");
        Err(wrong_use(format!("--workpieces {word}: {known}, or an asset folder with {MANIFEST_FILE} is accepted")))
    }

    /// Returns the names of the bundled workpieces.
    pub fn bundled() -> Vec<&'static str> {
        std::iter::once(BRACKET).chain(Shape::ALL.map(Shape::name)).collect()
    }

    /// Returns the word that names it in a flag.
    pub fn word(&self) -> String {
        match &self.origin {
            Origin::Bracket | Origin::Shape { .. } => self.name.clone(),
            Origin::Asset { folder } => folder.clone(),
        }
    }

    fn of_asset(folder: &str) -> Result<Self> {
        let manifest = Manifest::read(Path::new(folder))?;
        let key = manifest_key(folder)?;
        let stem = Path::new(&manifest.source.file).file_stem().unwrap_or_default().to_string_lossy();
        let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' };
        let name = format!("{}-{}", stem.chars().map(plain).collect::<String>(), &key[..KEY_LETTERS]);
        let origin = Origin::Asset { folder: folder.to_owned() };
        Ok(Self { name, key, origin, voxel_mm: 1e3 * manifest.baking.voxel_m })
    }

    /// Makes or reads the field without a dose; `seed` is that of the set.
    ///
    /// # Errors
    /// If a weld cannot be placed, or an asset cannot be read.
    pub fn field(&self, seed: u64) -> Result<BrickGrid> {
        match &self.origin {
            Origin::Bracket => {
                let options = WeldingOptions {
                    seed,
                    fineness: Fineness::Voxel(1e-3 * self.voxel_mm),
                    band_voxels: DEFAULT_BAND,
                    sign: SignChoice::Auto,
                    wishes: WeldSettings::default(),
                };
                Ok(weld_part(Part::bundled()?, &options, &Console::silent())?.welded)
            }
            Origin::Shape { shape } => Ok(shape.field(1e-3 * self.voxel_mm)),
            Origin::Asset { folder } => {
                let key = manifest_key(folder)?;
                ensure!(key == self.key, "{folder}: not the asset that the set was started with");
                Ok(AssetFields::open(Path::new(folder))?.welded)
            }
        }
    }
}

fn manifest_key(folder: &str) -> Result<String> {
    let path = Path::new(folder).join(MANIFEST_FILE);
    Ok(sha256(&input::read(&path, MOST_TEXT_BYTES)?))
}

impl ImageSet {
    pub(super) fn workpiece_path(&self, name: &str) -> std::path::PathBuf {
        self.folder().join(FIELDS_FOLDER).join(format!("{name}.nvdb"))
    }

    /// Returns true if a workpiece's field exists.
    pub fn holds_workpiece(&self, name: &str) -> bool {
        self.workpiece_path(name).is_file()
    }

    /// Makes and stores the field of a workpiece.
    ///
    /// # Errors
    /// Those of [`Coated::field`], and if it cannot be written.
    pub fn make_workpiece(&self, coated: &Coated) -> Result<()> {
        let field = coated.field(self.recipe.seed)?;
        let bytes = nvdb::write_field(&field, Codec::Zip)?;
        Ok(write_file(&self.workpiece_path(&coated.name), &bytes)?)
    }

    /// Reads the field of a workpiece, and the hash of its file.
    ///
    /// # Errors
    /// If it is missing or damaged.
    pub fn read_workpiece(&self, name: &str) -> Result<(BrickGrid, String)> {
        let path = self.workpiece_path(name);
        let bytes = input::read(&path, MOST_MESH_BYTES)?;
        let field = nvdb::read(&bytes).map_err(anyhow::Error::from).and_then(|file| Ok(file.to_field()?));
        Ok((field.with_context(|| format!("{}: no field", path.display()))?, sha256(&bytes)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_workpiece_is_refused_with_what_there_is() {
        let error = Coated::named("spaceship", 0.6).unwrap_err();
        assert!(crate::is_wrong_use(&error) && error.to_string().contains("bracket, panel, tee"), "{error}");
    }
}
