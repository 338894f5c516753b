//! Why a mesh cannot be baked.

use thiserror::Error;

/// Farthest voxel from the origin: its coordinates are exact in i32, and places between voxels to 1e-7 voxels in f64.
pub(super) const FARTHEST: f64 = 8e8;

/// Why a mesh cannot be baked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BakeError {
    /// The mesh has no triangles.
    #[error("the mesh has no triangles: nothing to bake")]
    Empty,
    /// The voxel size or band is not usable.
    #[error(
        "a voxel of {voxel} m with a band of {band_voxels} voxels cannot be baked: both must be positive, the band at least 2"
    )]
    Options {
        /// Asked voxel [m].
        voxel: f64,
        /// Asked band [voxels].
        band_voxels: f64,
    },
    /// The grid would not fit.
    #[error(
        "{cells:.2e} index bricks are too many (limit {limit:.0e}): a voxel of at least {least_voxel:.3e} m would fit"
    )]
    TooFine {
        /// Index entries needed.
        cells: f64,
        /// Index entries allowed.
        limit: f64,
        /// Smallest voxel that fits [m].
        least_voxel: f64,
    },
    /// The part is so far from the origin that voxels cannot be counted.
    #[error(
        "the part reaches {:.3e} m from the origin, {:.1e} voxels of {voxel:.3e} m, and {FARTHEST:.0e} voxels are accepted: \
         move it to within {:.3e} m of the origin", away, away / voxel, FARTHEST * voxel
    )]
    FarAway {
        /// Largest coordinate, with the band around the part [m].
        away: f64,
        /// Voxel [m].
        voxel: f64,
    },
    /// Open surface whose inside is a guess.
    #[error(
        "open surface: {boundary_edges} boundary edges leave {:.1} % of the band without a clear inside; close the mesh, \
         use --sign winding to accept the guess, or --shell-mm T to bake the surface as a shell T thick", 100.0 * share
    )]
    Open {
        /// Edges with one triangle only.
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
        /// Edges with one triangle only.
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
        /// Asked thickness [m].
        thickness: f64,
        /// Voxel [m].
        voxel: f64,
        /// Least thickness accepted [m].
        least: f64,
    },
    /// Normals would not tell inside from outside.
    #[error("--sign normal is not safe here: {reason}; use --sign auto")]
    NormalsUnsafe {
        /// What was found.
        reason: String,
    },
}
