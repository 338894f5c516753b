//! `robofin dataset-item`: one item of a data set, in the process that `robofin dataset` starts for it.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::item_flags::ItemFlags;
use crate::dataset::Dataset;
use crate::dataset::item::make;
use crate::store::limits::Usage;
use crate::store::process::Answer;

#[derive(Debug, Args)]
pub(super) struct DatasetItemArgs {
    /// Mesh file.
    source: PathBuf,
    /// Name of the item.
    #[arg(long)]
    id: String,
    /// Folder of the data set.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    items: ItemFlags,
}

pub(super) fn run(args: &DatasetItemArgs) -> Result<()> {
    args.items.limits().bind()?;
    let dataset = Dataset::open(&args.out)?;
    let ending = make(&dataset, &args.source, &args.id, &args.items.wishes());
    println!("{}", serde_json::to_string(&Answer { ending, usage: Usage::now() })?);
    Ok(())
}
