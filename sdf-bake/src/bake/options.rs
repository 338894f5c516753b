//! What to bake, and what baking did.

use serde::{Deserialize, Serialize};

/// How inside and outside are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SignChoice {
    /// Whatever suits the surface; refuses an open one whose inside is unclear.
    #[default]
    Auto,
    /// Angle-weighted normals (Bærentzen & Aanæs 2005); refuses a surface on which they can err.
    Normal,
    /// As [`SignChoice::Auto`], also where an open surface leaves the inside to a guess.
    Winding,
}

/// What to bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// Distance between voxels [m].
    pub voxel: f64,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Sign rule.
    pub sign: SignChoice,
    /// Thickness of a shell around the surface [m], instead of what the surface encloses.
    pub shell: Option<f64>,
}

impl BakeOptions {
    /// A band of ±3 voxels with the automatic sign.
    pub fn with_voxel(voxel: f64) -> Self {
        Self { voxel, band_voxels: 3.0, sign: SignChoice::Auto, shell: None }
    }

    /// Half the thickness of the shell [m], 0 without one.
    pub fn half_shell(&self) -> f64 {
        0.5 * self.shell.unwrap_or(0.0)
    }
}

/// Where inside and outside came from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SignMethod {
    /// Signed crossings along columns of voxels: exact, for surfaces whose edges are all passed equally often both ways.
    #[default]
    Crossings,
    /// Signed crossings of the surface with its holes patched.
    Patched,
    /// Generalised winding number, for surfaces that hardly hang together.
    Winding,
    /// Angle-weighted normals.
    Normals,
    /// Within half the thickness of the surface.
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

/// What baking did.
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
    /// Where inside and outside came from.
    pub sign_method: SignMethod,
    /// Why that and not another.
    #[serde(default)]
    pub sign_reason: String,
    /// Edges with one triangle only.
    pub boundary_edges: usize,
    /// Share of the judged voxels whose winding number is farther than 0.25 from a whole number, where the surface
    /// does not tell how it goes on.
    pub ambiguous_share: f64,
    /// Triangles that are no part of the surface of the whole, or not wholly, since they lie inside another body.
    #[serde(default)]
    pub inner_triangles: usize,
}
