//! `preview.png`: a picture of the welded workpiece.

use std::fs;
use std::path::Path;

use anyhow::Result;

use super::PREVIEW_FILE;
use super::exporter::{Content, Exporter};
use crate::picture::{overview, to_png};

/// Exporter of `preview.png`.
pub(super) struct Preview;

impl Exporter for Preview {
    const FILE: &'static str = PREVIEW_FILE;
    const MEDIA_TYPE: &'static str = "image/png";

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        let Content { workpiece, truth, extras, .. } = content;
        let picture = overview(&workpiece.welded, truth.welds.first(), extras.preview, extras.samples_per_side)?;
        Ok(fs::write(place, to_png(&picture)?)?)
    }
}
