//! Flags of a bead's section and form.

use clap::{Args, ValueEnum};
use weldgen::bead::{BeadShape, Crater, FormRequest, MOST_DEFECTS, MOST_HOLES, Ripples, Weave};
use weldgen::dials;

use super::flags::metres;
use super::values::{number, positive, whole};

/// Heading of the help for a bead's sizes.
pub(super) const BEAD: &str = "Bead";
/// Heading of the help for irregularities of manual welding.
const FORM: &str = "Form";
/// Heading of the help for imperfections.
const IMPERFECTIONS: &str = "Imperfections";

/// The section of a bead, and what a welder's hand leaves on it.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct BeadFlags {
    /// Cross-section of a weld on a face.
    #[arg(long, value_enum, default_value_t, help_heading = BEAD)]
    profile: ProfileFlag,
    /// Rise of a fillet's face above the chord between its toes [widths]; below 0 it is concave.
    #[arg(
        long,
        value_name = "WIDTHS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::CONVEXITY.range),
        help_heading = BEAD
    )]
    pub(super) convexity: f64,
    /// Least radius of the toes in the field [mm]; without it they are sharp.
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = positive, help_heading = BEAD)]
    toe_radius_mm: Option<f64>,
    /// Distance between ripples [mm]; without it there are none.
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = positive, help_heading = FORM)]
    ripple_pitch_mm: Option<f64>,
    /// Height of ripples from trough to crest [bead heights].
    #[arg(
        long,
        value_name = "HEIGHTS",
        default_value_t = 0.1,
        allow_negative_numbers = true,
        value_parser = number(dials::RIPPLE_HEIGHT.range),
        help_heading = FORM
    )]
    ripple_height: f64,
    /// Distance by which ripples trail behind at the toes [bead widths].
    #[arg(
        long,
        value_name = "WIDTHS",
        default_value_t = 0.4,
        allow_negative_numbers = true,
        value_parser = number(dials::RIPPLE_CHEVRON.range),
        help_heading = FORM
    )]
    ripple_chevron: f64,
    /// Depth of the end crater [bead heights].
    #[arg(
        long,
        value_name = "HEIGHTS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::CRATER_DEPTH.range),
        help_heading = FORM
    )]
    crater: f64,
    /// Height of the hump at the start beyond the bead [bead heights].
    #[arg(
        long,
        value_name = "HEIGHTS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::START_HUMP.range),
        help_heading = FORM
    )]
    start_hump: f64,
    /// Largest offset of weaving to the sides [mm].
    #[arg(
        long,
        value_name = "MM",
        requires = "weave_pitch_mm",
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = FORM
    )]
    weave_mm: Option<f64>,
    /// Length of one weaving period [mm].
    #[arg(
        long,
        value_name = "MM",
        requires = "weave_mm",
        allow_negative_numbers = true,
        value_parser = positive,
        help_heading = FORM
    )]
    weave_pitch_mm: Option<f64>,
    /// Largest slow change of the bead's width [widths].
    #[arg(
        long,
        value_name = "WIDTHS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::WIDTH_VARIATION.range),
        help_heading = FORM
    )]
    width_variation: f64,
    /// Largest slow change of the bead's height [heights].
    #[arg(
        long,
        value_name = "HEIGHTS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::HEIGHT_VARIATION.range),
        help_heading = FORM
    )]
    height_variation: f64,
    /// Number of surface pores (ISO 6520-1: 2017).
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = up_to(MOST_DEFECTS),
        help_heading = IMPERFECTIONS
    )]
    pores: u32,
    /// Depth of a sag of the crown (ISO 6520-1: 509) [bead heights].
    #[arg(
        long,
        value_name = "HEIGHTS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::SAGGING.range),
        help_heading = IMPERFECTIONS
    )]
    sagging: f64,
    /// Overhang of a lobe of metal over a toe (ISO 6520-1: 506) [bead widths].
    #[arg(
        long,
        value_name = "WIDTHS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::OVERLAP.range),
        help_heading = IMPERFECTIONS
    )]
    overlap: f64,
    /// Depth of a groove along a toe (ISO 6520-1: 5012) [bead heights].
    #[arg(
        long,
        value_name = "HEIGHTS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number(dials::UNDERCUT.range),
        help_heading = IMPERFECTIONS
    )]
    undercut: f64,
    /// Number of holes burnt through bead and part, where it is thin (ISO 6520-1: 510).
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = up_to(MOST_HOLES),
        help_heading = IMPERFECTIONS
    )]
    burn_through: u32,
    /// Number of drops of spatter beside the bead (ISO 6520-1: 602).
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = up_to(MOST_DEFECTS),
        help_heading = IMPERFECTIONS
    )]
    spatter: u32,
}

/// Cross-section of a weld on a face.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum ProfileFlag {
    /// A parabola.
    #[default]
    Parabolic,
    /// The arc of a circle.
    CircularSegment,
    /// A flat crown with steep toes.
    Superellipse,
}

/// Parses a number of imperfections up to `most`.
fn up_to(most: u32) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync {
    whole([0, u64::from(most)])
}

impl BeadFlags {
    pub(super) fn shape(&self) -> BeadShape {
        match self.profile {
            ProfileFlag::Parabolic => BeadShape::Parabolic,
            ProfileFlag::CircularSegment => BeadShape::CircularSegment,
            ProfileFlag::Superellipse => BeadShape::Superellipse,
        }
    }

    /// Returns the least radius of the toes [m].
    pub(super) fn toe_radius(&self) -> Option<f64> {
        metres(self.toe_radius_mm)
    }

    /// Returns the requested form; limits that depend on the bead's width are checked once that is known.
    pub(super) fn request(&self) -> FormRequest {
        let (height, chevron) = (self.ripple_height, self.ripple_chevron);
        let crater = Crater { depth: self.crater, hump: self.start_hump };
        let weave = metres(self.weave_mm).zip(metres(self.weave_pitch_mm));
        FormRequest {
            ripples: metres(self.ripple_pitch_mm).map(|pitch| Ripples { pitch, height, chevron }),
            crater: (crater.depth > 0.0 || crater.hump > 0.0).then_some(crater),
            weave: weave.map(|(amplitude, pitch)| Weave { amplitude, pitch }),
            width_variation: self.width_variation,
            height_variation: self.height_variation,
            pores: self.pores,
            sagging: self.sagging,
            spatter: self.spatter,
            overlap: self.overlap,
            undercut: self.undercut,
            burn_through: self.burn_through,
        }
    }
}
