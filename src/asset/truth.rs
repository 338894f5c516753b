//! `welds.json`: the ground truth of every weld of an asset.

use std::path::Path;

use anyhow::{Result, ensure};
use files::input::quoted_near;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use weldgen::bead::{BeadShape, Defect, DefectKind};
use weldgen::{Joint, Weld, WeldCurve};

use super::exporter::{Content, Exporter};
use super::{WELDS_FILE, write_json};
use crate::workpiece::PlacedWeld;
use files::json_file::read_json;

/// Value of the `format` key.
pub const WELDS_FORMAT: &str = "robofin-welds/1";

/// All welds of an asset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welds {
    /// [`WELDS_FORMAT`].
    pub format: String,
    /// The frame and the unit of all vectors.
    pub frame: String,
    /// The welds, in order of their id.
    pub welds: Vec<WeldTruth>,
}

/// Ground truth of one weld: size, volume and centreline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WeldTruth {
    /// Weld id in labels and vertex attributes; 0 is base metal.
    pub id: u16,
    /// Type of joint.
    pub joint: Joint,
    /// Cross-section of the bead.
    pub profile: BeadShape,
    /// Width between the toes on flat ground [mm].
    pub width_mm: f64,
    /// Height of the crown above the surface [mm].
    pub height_mm: f64,
    /// Depth of the bead mesh below the surface [mm].
    pub root_depth_mm: f64,
    /// Arc length of the centreline [mm].
    pub length_mm: f64,
    /// Volume that the bead adds to the part [mm³].
    pub volume_mm3: f64,
    /// Root mean square of the geodesic curvature [1/m].
    pub geodesic_curvature_rms_per_m: f64,
    /// Largest magnitude of the geodesic curvature [1/m].
    pub geodesic_curvature_max_per_m: f64,
    /// Mean exposure along the centreline, 0 to 1.
    pub exposure_mean: f64,
    /// Least exposure along the centreline, 0 to 1.
    pub exposure_min: f64,
    /// Mean tool access along the centreline, 0 to 1.
    pub access_mean: f64,
    /// Number of the weld's curve; the beads of an intermittent weld share one.
    pub run: usize,
    /// Height of the toes above the centreline [mm]: 0 on a face, more in a corner.
    pub toe_height_mm: f64,
    /// Least radius of the toes in the fields [mm]; 0 for sharp toes and in files of earlier versions.
    #[serde(default)]
    pub toe_radius_mm: f64,
    /// Angle between the surface and the bead at its toes [deg].
    pub toe_angle_deg: f64,
    /// Imperfections of the bead.
    pub imperfections: Vec<Imperfection>,
    /// Requested dials; the fields above are measured.
    pub requested: RequestedDials,
    /// Area under the bead [mm²]: between its toes along the centreline, with the round ends.
    pub footprint_mm2: f64,
    /// Centreline and frames.
    pub curve: CurveTruth,
}

/// An imperfection of a bead.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Imperfection {
    /// Name of the kind.
    pub kind: String,
    /// Number in ISO 6520-1.
    pub iso_6520: u16,
    /// Arc length of its centre [mm].
    pub arc_length_mm: f64,
    /// Offset of its centre to the left of the centreline [mm].
    pub offset_mm: f64,
    /// Diameter of a pore, drop or hole; for the others, length along the weld [mm].
    pub size_mm: f64,
    /// Depth below the surface without it [mm]; for spatter its height above, for an overlap its overhang.
    pub depth_mm: f64,
}

impl Imperfection {
    /// Returns true if it removes metal from the part.
    pub fn cuts(&self) -> bool {
        [DefectKind::Undercut, DefectKind::BurnThrough].iter().any(|kind| kind.iso_6520() == self.iso_6520)
    }

    fn of(defect: &Defect) -> Self {
        let kind = match defect.kind {
            DefectKind::SurfacePore => "surface-pore",
            DefectKind::Sagging => "sagging",
            DefectKind::Spatter => "spatter",
            DefectKind::Overlap => "overlap",
            DefectKind::Undercut => "undercut",
            DefectKind::BurnThrough => "burn-through",
        };
        Self {
            kind: kind.to_owned(),
            iso_6520: defect.kind.iso_6520(),
            arc_length_mm: defect.arc_length * 1e3,
            offset_mm: defect.offset * 1e3,
            size_mm: defect.size * 1e3,
            depth_mm: defect.depth * 1e3,
        }
    }
}

/// Requested dials of one weld.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RequestedDials {
    /// Arc length of the centreline [mm].
    pub length_mm: f64,
    /// Root mean square of the geodesic curvature [1/m]; absent along a seam or a cut, whose curvature is given.
    pub geodesic_curvature_rms_per_m: Option<f64>,
    /// Bound of the geodesic curvature [1/m]; absent in the same cases.
    pub geodesic_curvature_max_per_m: Option<f64>,
    /// Range of the least exposure, 0 to 1.
    pub exposure: [f64; 2],
    /// Length of the rays of the exposure [mm]; geometry farther away does not shade.
    pub exposure_reach_mm: f64,
    /// Least mean tool access, 0 to 1.
    pub access_mean: f64,
    /// Width of the bead [mm].
    pub width_mm: f64,
    /// Height of the bead [mm].
    pub height_mm: f64,
}

/// Centreline, one entry per point; vectors in the part's frame [m].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurveTruth {
    /// Points on the part's surface [m].
    pub position: Vec<DVec3>,
    /// Unit tangents.
    pub tangent: Vec<DVec3>,
    /// Unit normals of the surface, smoothed over half a width.
    pub normal: Vec<DVec3>,
    /// Unit side vectors, normal × tangent.
    pub side: Vec<DVec3>,
    /// Arc length from the start [m].
    pub arc_length: Vec<f64>,
    /// Geodesic curvature [1/m].
    pub geodesic_curvature: Vec<f64>,
    /// Exposure: cosine-weighted free share of the hemisphere, 0 to 1.
    pub exposure: Vec<f64>,
    /// Tool access: share of the tool's poses without collision, 0 to 1.
    pub access: Vec<f64>,
    /// Width of the bead [m].
    pub width: Vec<f64>,
    /// Height of the bead [m].
    pub height: Vec<f64>,
}

/// Exporter of `welds.json`.
pub(super) struct Truth;

impl Exporter for Truth {
    const FILE: &'static str = WELDS_FILE;
    const MEDIA_TYPE: &'static str = "application/json";

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        write_json(place, content.truth)
    }
}

impl Welds {
    /// Reads the ground truth of an asset folder.
    ///
    /// # Errors
    /// If the file is missing, damaged or of another format.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(WELDS_FILE);
        let what = format!(
            "a truth file of format {WELDS_FORMAT} (an asset of an earlier version is made again by `robofin weld`, a data \
             set by `robofin validate --repair`)"
        );
        let welds: Self = read_json(&path, &what)?;
        ensure!(
            welds.format == WELDS_FORMAT,
            "{}: format is {}, {WELDS_FORMAT:?} is expected",
            path.display(),
            quoted_near(&welds.format, [WELDS_FORMAT])
        );
        Ok(welds)
    }

    /// Collects the ground truth of all welds.
    pub fn of(welds: &[PlacedWeld]) -> Self {
        Self {
            format: WELDS_FORMAT.to_owned(),
            frame: "part frame, right-handed, z up; vectors and arc length in metres".to_owned(),
            welds: welds.iter().map(WeldTruth::of).collect(),
        }
    }
}

impl WeldTruth {
    fn of(PlacedWeld { id, weld, volume, toe_radius }: &PlacedWeld) -> Self {
        let points = &weld.curve.points;
        let count = points.len().max(1) as f64;
        let curvature = || points.iter().map(|p| p.geodesic_curvature);
        let exposure = || points.iter().map(|p| p.exposure);
        Self {
            id: *id,
            joint: weld.joint,
            profile: weld.profile.shape,
            width_mm: weld.profile.width * 1e3,
            height_mm: weld.profile.height * 1e3,
            root_depth_mm: weld.root_depth * 1e3,
            length_mm: weld.curve.length() * 1e3,
            volume_mm3: volume * 1e9,
            geodesic_curvature_rms_per_m: weld.curvature_rms,
            geodesic_curvature_max_per_m: curvature().map(f64::abs).fold(0.0, f64::max),
            exposure_mean: exposure().sum::<f64>() / count,
            exposure_min: exposure().fold(1.0, f64::min),
            access_mean: weld.mean_access,
            run: weld.run,
            toe_height_mm: weld.profile.toe_height * 1e3,
            toe_radius_mm: toe_radius * 1e3,
            toe_angle_deg: weld.profile.toe_angle().to_degrees(),
            imperfections: weld.defects.iter().map(Imperfection::of).collect(),
            requested: RequestedDials::of(weld),
            footprint_mm2: weld.footprint_area() * 1e6,
            curve: CurveTruth::of(&weld.curve),
        }
    }
}

impl RequestedDials {
    fn of(weld: &Weld) -> Self {
        let on_face = weld.joint == Joint::BeadOnPlate;
        Self {
            length_mm: weld.wanted.length * 1e3,
            geodesic_curvature_rms_per_m: on_face.then_some(weld.wanted.curvature_rms),
            geodesic_curvature_max_per_m: on_face.then_some(weld.request.curvature_max),
            exposure: weld.wanted.exposure,
            exposure_reach_mm: weld.request.exposure_reach * 1e3,
            access_mean: weld.request.min_access,
            width_mm: weld.request.width * 1e3,
            height_mm: weld.request.height * 1e3,
        }
    }
}

impl CurveTruth {
    fn of(curve: &WeldCurve) -> Self {
        let mut truth = Self::default();
        for point in &curve.points {
            truth.position.push(point.position);
            truth.tangent.push(point.tangent);
            truth.normal.push(point.normal);
            truth.side.push(point.side);
            truth.arc_length.push(point.arc_length);
            truth.geodesic_curvature.push(point.geodesic_curvature);
            truth.exposure.push(point.exposure);
            truth.access.push(point.access);
            truth.width.push(point.width);
            truth.height.push(point.height);
        }
        truth
    }
}
