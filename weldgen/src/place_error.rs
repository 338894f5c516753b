//! Reason why no weld was placed, and what the part allows instead.

use thiserror::Error;

use crate::bead::BeadError;
use crate::dial_fault::{DialFault, shown_mm};
use crate::rejection::Tally;

/// Reason why no weld was placed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlaceError {
    /// The part has no seam for a fillet.
    #[error("the part has no seam: no two of its faces meet in a concave edge of 30° or more; place on the surface")]
    NoSeam,
    /// All faces are inside bodies or turned inwards.
    #[error("the part has no face in the open: all are inside a body or turned inwards (a cleaner mesh is needed)")]
    Hidden,
    /// The part has no surface with the requested exposure.
    #[error(
        "exposure {:.2} to {:.2} is impossible on this part: it offers {:.2} to {:.2} within {:.2} mm; change the range \
         of exposure",
        asked[0], asked[1], offered[0], offered[1], 1e3 * reach
    )]
    Exposure {
        /// Requested range.
        asked: [f64; 2],
        /// Least and greatest exposure of the part's surface.
        offered: [f64; 2],
        /// Distance beyond which nothing occludes [m].
        reach: f64,
    },
    /// A dial is out of range.
    #[error(transparent)]
    Request(#[from] DialFault),
    /// The part has no face with an area.
    #[error("the part has no surface to weld on: {0} triangles without area")]
    NoSurface(usize),
    /// The stitches of an intermittent weld cannot be swept.
    #[error("a bead of the intermittent weld: {0}")]
    Stitch(#[from] BeadError),
    /// Nothing fits.
    #[error(
        "no place for the weld in {} proposals (length {}, width {} at last; longest clear run {}): {tally}{}",
        tally.total(), shown_mm(*length), shown_mm(*width), shown_mm(*longest_run), listed(offers)
    )]
    Nowhere {
        /// Length of the last stage [m].
        length: f64,
        /// Width of the last stage [m].
        width: f64,
        /// Longest run found without an edge in the way [m].
        longest_run: f64,
        /// Number of rejected proposals by reason.
        tally: Tally,
        /// Dials that alone prevent the weld, with the values that the part allows, as sentences.
        offers: Vec<String>,
    },
}

fn listed(offers: &[String]) -> String {
    match offers {
        [] => String::new(),
        offers => format!(". With the other dials as they are, {}", offers.join("; ")),
    }
}
