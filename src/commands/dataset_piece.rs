//! `robofin dataset-piece`: one piece of a data set, in the process that `robofin dataset` starts for it.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;

use super::piece_flags::PieceFlags;
use crate::dataset::Dataset;
use crate::dataset::limits::Usage;
use crate::dataset::piece::make;
use crate::dataset::process::Answer;

#[derive(Debug, Args)]
pub(super) struct DatasetPieceArgs {
    /// Mesh file.
    source: PathBuf,
    /// Name of the piece.
    #[arg(long)]
    id: String,
    /// Folder of the data set.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    pieces: PieceFlags,
}

pub(super) fn run(args: &DatasetPieceArgs) -> Result<()> {
    args.pieces.limits()?.bind()?;
    let dataset = Dataset::open(&args.out)?;
    let ending = make(&dataset, &args.source, &args.id, &args.pieces.wishes()?);
    println!("{}", serde_json::to_string(&Answer { ending, usage: Usage::now() })?);
    Ok(())
}
