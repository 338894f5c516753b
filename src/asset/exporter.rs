//! Exporters: the name of each file of an asset, its writer and its check.

use std::path::Path;

use anyhow::Result;

use super::check::{Opened, Validation};
use super::{Extras, Welds};
use crate::console::Console;
use crate::workpiece::Workpiece;

/// A file that is written into every asset.
pub trait Exporter {
    /// Name of the file.
    const FILE: &'static str;
    /// Its media type (IANA), as catalogues of data sets say it.
    const MEDIA_TYPE: &'static str;
    /// False for a file that an asset may lack.
    const ALWAYS: bool = true;

    /// Writes it at `place`, beside the files that stand before it in [`super::EXPORTS`].
    ///
    /// # Errors
    /// When it cannot be made or written.
    fn write(content: &Content<'_>, place: &Path) -> Result<()>;

    /// Compares the file of an asset with the others, beyond what [`crate::validate`] compares.
    ///
    /// # Errors
    /// When a program that the check needs cannot be had; a file that is wrong is a failed check.
    fn check(_opened: &Opened<'_>, _found: &mut Validation) -> Result<()> {
        Ok(())
    }
}

/// Inputs of the exporters of an asset.
pub struct Content<'a> {
    /// The welded workpiece.
    pub workpiece: &'a Workpiece,
    /// The truth of its welds.
    pub truth: &'a Welds,
    /// Settings of the picture and of USD.
    pub extras: Extras,
    /// Console that reports what was left out.
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
    /// The row of an exporter.
    pub const fn of<E: Exporter>() -> Self {
        Self { file: E::FILE, media_type: E::MEDIA_TYPE, always: E::ALWAYS, write: E::write, check: E::check }
    }
}
