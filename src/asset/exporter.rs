//! Exporters: the name of each file of an asset, its writer and its check.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;

use super::check::{Opened, Validation};
use super::{Extras, Welds};
use crate::console::Console;
use crate::workpiece::Workpiece;
use export::models::Models;
use export::surface::WeldedSurface;

/// A type of file written into every asset.
pub trait Exporter {
    /// Name of the file.
    const FILE: &'static str;
    /// Media type (IANA) for the catalogues of data sets.
    const MEDIA_TYPE: &'static str;
    /// False if an asset may lack the file.
    const ALWAYS: bool = true;

    /// Writes the file at `place`, beside those that precede it in [`super::EXPORTS`].
    ///
    /// # Errors
    /// If it cannot be made or written.
    fn write(content: &Content<'_>, place: &Path) -> Result<()>;

    /// Compares the file with the others of the asset, beyond the comparisons of [`crate::validate`].
    ///
    /// # Errors
    /// If a program that the check needs is not available; a wrong file is a failed check, not an error.
    fn check(_opened: &Opened<'_>, _found: &mut Validation) -> Result<()> {
        Ok(())
    }
}

/// Inputs of an asset's exporters.
pub struct Content<'a> {
    /// Welded workpiece.
    pub workpiece: &'a Workpiece,
    /// Ground truth of its welds.
    pub truth: &'a Welds,
    /// Surface of the workpiece.
    pub surface: &'a WeldedSurface,
    /// Contents of the files that follow from the surface; `None` leaves them out.
    pub models: Option<Models<'a>>,
    /// Source file of the part, its hash, the seed: texts by name, for files that hold custom data.
    pub origin: BTreeMap<&'static str, String>,
    /// Settings of the picture and of USD.
    pub extras: Extras,
    /// Console for messages on files left out.
    pub console: &'a Console,
}

/// A row of [`super::EXPORTS`]: an [`Exporter`] as a value.
pub struct Export {
    /// [`Exporter::FILE`].
    pub file: &'static str,
    /// [`Exporter::MEDIA_TYPE`].
    pub media_type: &'static str,
    /// [`Exporter::ALWAYS`].
    pub always: bool,
    /// [`Exporter::write`].
    pub write: fn(&Content<'_>, &Path) -> Result<()>,
    /// [`Exporter::check`].
    pub check: fn(&Opened<'_>, &mut Validation) -> Result<()>,
}

impl Export {
    /// Makes the row of an exporter.
    pub const fn of<E: Exporter>() -> Self {
        Self { file: E::FILE, media_type: E::MEDIA_TYPE, always: E::ALWAYS, write: E::write, check: E::check }
    }
}
