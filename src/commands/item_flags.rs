//! Flags that define the items of a data set.

use anyhow::Result;
use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, Parser};
use sdf_bake::read::UnitChoice;

use super::flags::{MESH, MeshFlags, RUNS, SEEDS, solid_only};
use super::values::{number, whole};
use super::weld::WeldFlags;
use crate::dataset::item::ItemSettings;
use crate::dataset::{DATASET_FORMAT, Recipe};
use crate::store::limits::Limits;
use crate::workpiece::{Fineness, WeldingOptions};

/// Default number of voxels along the diagonal.
const DIAGONAL_VOXELS: u32 = 256;
/// Width and height of an item's picture [pixels]; `robofin render` draws larger ones.
const PREVIEW_SIZE: (usize, usize) = (320, 240);

/// Heading of the help for flags that define items.
pub(super) const ITEMS: &str = "Items";
/// Accepted time limits of an item [s].
pub(super) const SECONDS: [f64; 2] = [0.1, 1e6];
/// Accepted memory limits of an item [GB].
pub(super) const GIGABYTES: [f64; 2] = [0.1, 1e4];

/// Settings of an item beside its part and number, and the limits of its process.
#[derive(Clone, Debug, Args)]
#[command(mut_arg("shell_mm", solid_only))]
pub(super) struct ItemFlags {
    /// Seed of the set; each item's own follows from it, the part's content and the item's number.
    #[arg(
        long,
        default_value_t = 1,
        allow_negative_numbers = true,
        value_parser = whole::<u64>(SEEDS),
        help_heading = ITEMS
    )]
    seed: u64,
    #[command(flatten, next_help_heading = MESH)]
    mesh: MeshFlags,
    #[command(flatten)]
    weld: WeldFlags,
    /// Licence of the parts; it is written beside each item.
    #[arg(long, value_name = "TEXT", default_value = "not stated", help_heading = ITEMS)]
    licence: String,
    /// Time by the clock that an item may take [s].
    #[arg(
        long,
        value_name = "s",
        default_value_t = 600.0,
        allow_negative_numbers = true,
        value_parser = number(SECONDS),
        help_heading = RUNS
    )]
    time_limit: f64,
    /// Memory that the process of an item may ask for [GB].
    #[arg(
        long,
        value_name = "GB",
        default_value_t = 2.0,
        allow_negative_numbers = true,
        value_parser = number(GIGABYTES),
        help_heading = RUNS
    )]
    memory_limit: f64,
}

/// The flags alone, as stored in a data set's marker.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Kept {
    #[command(flatten)]
    items: ItemFlags,
}

impl ItemFlags {
    /// Returns the given flags of this struct as they were written, in the order of their declaration.
    pub(super) fn given(matches: &ArgMatches) -> Vec<String> {
        let mut given = Vec::new();
        for flag in Self::augment_args(Command::new("items")).get_arguments() {
            let (id, name) = (flag.get_id().as_str(), flag.get_long().unwrap_or_default());
            if matches.value_source(id) == Some(ValueSource::CommandLine) {
                let values = matches.get_raw(id).into_iter().flatten();
                given.extend(values.map(|value| format!("--{name}={}", value.to_string_lossy())));
            }
        }
        given
    }

    /// Parses stored flags.
    pub(super) fn read(kept: &[String]) -> Result<Self> {
        Ok(Kept::try_parse_from(kept)?.items)
    }

    pub(super) fn unit(&self) -> UnitChoice {
        self.mesh.unit.into()
    }

    /// Returns the settings shared by all items.
    pub(super) fn wishes(&self) -> ItemSettings {
        let options = WeldingOptions {
            seed: self.seed,
            fineness: self.mesh.fineness_or(Fineness::Diagonal(DIAGONAL_VOXELS)),
            band_voxels: self.mesh.band,
            sign: self.mesh.sign.into(),
            wishes: self.weld.wishes(),
        };
        ItemSettings { unit: self.unit(), options }
    }

    /// Returns the limits of an item's process.
    pub(super) fn limits(&self) -> Limits {
        Limits { time: self.time_limit, memory: (self.memory_limit * 1e9) as u64 }
    }

    /// Makes the recipe of the flags.
    pub(super) fn recipe(&self, wishes: &ItemSettings, flags: &[String], sources: Vec<String>) -> Result<Recipe> {
        Ok(Recipe {
            format: DATASET_FORMAT.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seed: self.seed,
            unit: serde_json::to_value(self.unit())?,
            options: Recipe::options_without_seed(&wishes.options)?,
            preview: PREVIEW_SIZE,
            licence: self.licence.clone(),
            flags: flags.to_vec(),
            sources,
        })
    }
}
