//! Options and report of baking.

use serde::{Deserialize, Serialize};

/// Requested method for the sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SignChoice {
    /// Chosen for the surface; rejects an open surface whose inside is ambiguous.
    #[default]
    Auto,
    /// Angle-weighted normals (Bærentzen & Aanæs 2005); rejects a surface on which they can be wrong.
    Normal,
    /// As [`SignChoice::Auto`], but also accepts an open surface whose inside is ambiguous.
    Winding,
}

/// Options of baking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// Distance between voxels [m].
    pub voxel: f64,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Sign rule.
    pub sign: SignChoice,
    /// Thickness of a shell around the surface [m], to be baked instead of the enclosed solid.
    pub shell: Option<f64>,
}

impl BakeOptions {
    /// A band of ±3 voxels with the automatic sign.
    pub fn with_voxel(voxel: f64) -> Self {
        Self { voxel, band_voxels: 3.0, sign: SignChoice::Auto, shell: None }
    }

    /// Half the thickness of the shell [m]; 0 without a shell.
    pub fn half_shell(&self) -> f64 {
        0.5 * self.shell.unwrap_or(0.0)
    }
}

/// Method that gave the sign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SignMethod {
    /// Signed crossings along columns of voxels: exact, for surfaces whose edges are all used equally often in both
    /// directions.
    #[default]
    Crossings,
    /// Signed crossings of the surface with its holes patched.
    Patched,
    /// Generalised winding number, for surfaces that are hardly connected.
    Winding,
    /// Angle-weighted normals.
    Normals,
    /// Shell: inside is within half the thickness of the surface.
    Shell,
}

impl std::fmt::Display for SignMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Crossings => "signed crossings",
            Self::Patched => "signed crossings with holes patched",
            Self::Winding => "winding number",
            Self::Normals => "angle-weighted normals",
            Self::Shell => "shell around the surface",
        })
    }
}

/// Results of baking.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// Distance between voxels [m].
    pub voxel_m: f64,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Bricks in the pool.
    pub bricks: usize,
    /// Voxels with |φ| < band.
    pub active_voxels: usize,
    /// Method that gave the sign.
    pub sign_method: SignMethod,
    /// Reason for this method.
    #[serde(default)]
    pub sign_reason: String,
    /// Edges with only one triangle.
    pub boundary_edges: usize,
    /// Share of the tested voxels whose winding number differs from a whole number by more than 0.25, where the surface
    /// does not show how it continues.
    pub ambiguous_share: f64,
    /// Triangles that lie inside another body, entirely or partly, and so are not part of the union's surface.
    #[serde(default)]
    pub inner_triangles: usize,
}
