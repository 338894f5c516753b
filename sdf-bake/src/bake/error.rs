//! Reasons why a mesh cannot be baked.

use thiserror::Error;

/// Greatest distance of a voxel from the origin [voxels]: coordinates are exact in i32, and to 1e-7 voxels in f64
/// between voxels.
pub(super) const FARTHEST: f64 = 8e8;

/// Reason why a mesh cannot be baked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BakeError {
    /// The mesh has no triangles.
    #[error("the mesh has no triangles: nothing to bake")]
    Empty,
    /// The voxel size or the band is not usable.
    #[error(
        "a voxel of {voxel} m with a band of {band_voxels} voxels cannot be baked: both must be positive, the band at least 2"
    )]
    Options {
        /// Requested voxel [m].
        voxel: f64,
        /// Requested band [voxels].
        band_voxels: f64,
    },
    /// The grid has too many index entries.
    #[error(
        "{cells:.2e} index bricks are too many (limit {limit:.0e}): a voxel of at least {least_voxel:.3e} m would fit"
    )]
    TooFine {
        /// Required index entries.
        cells: f64,
        /// Allowed index entries.
        limit: f64,
        /// Smallest voxel that fits [m].
        least_voxel: f64,
    },
    /// The part is too far from the origin for the voxel coordinates.
    #[error(
        "the part reaches {:.3e} m from the origin, {:.1e} voxels of {voxel:.3e} m, and {FARTHEST:.0e} voxels are accepted: \
         move it to within {:.3e} m of the origin", away, away / voxel, FARTHEST * voxel
    )]
    FarAway {
        /// Greatest coordinate, including the band around the part [m].
        away: f64,
        /// Voxel [m].
        voxel: f64,
    },
    /// The surface is open, and the sign is ambiguous.
    #[error(
        "open surface: {boundary_edges} boundary edges leave {:.1} % of the band without a clear inside; close the mesh, \
         use --sign winding to accept the guess, or --shell-mm T to bake the surface as a shell T thick", 100.0 * share
    )]
    Open {
        /// Edges with only one triangle.
        boundary_edges: usize,
        /// Ambiguous share of the band, 0 to 1.
        share: f64,
    },
    /// No voxel is inside.
    #[error(
        "the surface encloses nothing at a voxel of {voxel} m ({boundary_edges} boundary edges, {:.1} % of the band \
         without a clear inside): it is a sheet, or thinner than a voxel; use --shell-mm T to bake it as a shell T \
         thick, or a smaller voxel", 100.0 * share
    )]
    NoInside {
        /// Voxel [m].
        voxel: f64,
        /// Edges with only one triangle.
        boundary_edges: usize,
        /// Ambiguous share of the band, 0 to 1.
        share: f64,
    },
    /// The shell is too thin for the voxel.
    #[error(
        "--shell-mm {}: a voxel of {} mm carries shells of {} mm or more; use a thicker shell or a smaller voxel",
        1e3 * thickness, 1e3 * voxel, 1e3 * least
    )]
    ThinShell {
        /// Requested thickness [m].
        thickness: f64,
        /// Voxel [m].
        voxel: f64,
        /// Least accepted thickness [m].
        least: f64,
    },
    /// The normals do not determine inside and outside.
    #[error("--sign normal is not safe here: {reason}; use --sign auto")]
    NormalsUnsafe {
        /// Reason found.
        reason: String,
    },
}
