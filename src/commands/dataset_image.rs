//! `robofin dataset-image`: one task of a set of images, in the process that `robofin dataset images` starts for it.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::dataset_images::LimitFlags;
use crate::images::ImageSet;
use crate::images::make::make;
use crate::store::limits::Usage;
use crate::store::process::Answer;

#[derive(Debug, Args)]
pub(super) struct DatasetImageArgs {
    /// Name of the workpiece, simulation or image.
    #[arg(long)]
    id: String,
    /// Folder of the set.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    limits: LimitFlags,
}

pub(super) fn run(args: &DatasetImageArgs) -> Result<()> {
    args.limits.limits().bind()?;
    let set = ImageSet::open(&args.out)?;
    let ending = make(&set, &args.id);
    println!("{}", serde_json::to_string(&Answer { ending, usage: Usage::now() })?);
    Ok(())
}
