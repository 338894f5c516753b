//! The dials of the page as flags of `robofin weld`: one list of words is the settings and the command line.

use std::collections::BTreeMap;

use sdf_bake::SignChoice;
use weldgen::access::{ToolKind, ToolShape};
use weldgen::bead::{BeadShape, Crater, FormRequest, Ripples, Weave};
use weldgen::dials::{CURVATURE_RMS, DIALS, Dial, EXPOSURE, LENGTH, Unit};
use weldgen::{Difficulty, Placement, Stitch, WeldSettings};

use crate::error::Refusal;

/// Least, greatest and usual number of voxels along the longest side.
const ACROSS: [u32; 3] = [8, 4096, 256];
/// Greatest number of welds.
const MOST_WELDS: u16 = 1000;
/// Dials that accept a range.
const RANGES: [Dial; 3] = [LENGTH, CURVATURE_RMS, EXPOSURE];
/// Dials that are set together.
const TOGETHER: [[&str; 2]; 2] = [["weave-mm", "weave-pitch-mm"], ["stitch-mm", "stitch-pitch-mm"]];
/// Ripples whose height and chevron are not set, as with `robofin weld`.
const RIPPLE: [f64; 2] = [0.1, 0.4];

/// A choice of a flag: its value on the command line, and what it sets.
type Choices<T> = [(&'static str, T)];
const DIFFICULTIES: &Choices<Difficulty> =
    &[("medium", Difficulty::Medium), ("easy", Difficulty::Easy), ("hard", Difficulty::Hard)];
const PLACES: &Choices<Placement> = &[
    ("surface", Placement::Surface),
    ("seam", Placement::Seam),
    ("butt", Placement::Butt),
    ("mixed", Placement::Mixed),
];
const PROFILES: &Choices<BeadShape> = &[
    ("parabolic", BeadShape::Parabolic),
    ("circular-segment", BeadShape::CircularSegment),
    ("superellipse", BeadShape::Superellipse),
];
const TOOLS: &Choices<ToolKind> = &[("wheel", ToolKind::Wheel), ("pad", ToolKind::Pad)];
const SIGNS: &Choices<SignChoice> = &[("auto", SignChoice::Auto), ("winding", SignChoice::Winding)];

/// Flags of a weld.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Flags {
    /// Names without hyphens before them, and values.
    words: BTreeMap<String, String>,
    /// Settings of the weld.
    pub(super) settings: WeldSettings,
    /// Seed of every random choice.
    pub(super) seed: u64,
    /// Voxels along the longest side.
    pub(super) across: u32,
    /// Rule of the inside.
    pub(super) sign: SignChoice,
}

impl Flags {
    /// Reads the pairs of a request whose names begin with two hyphens; other pairs are not flags.
    ///
    /// # Errors
    /// The first flag that is unknown or has a value that is not accepted.
    pub(crate) fn read(pairs: impl IntoIterator<Item = (String, String)>) -> Result<Self, Refusal> {
        let named = pairs.into_iter().filter_map(|(name, value)| Some((name.strip_prefix("--")?.to_owned(), value)));
        let words: BTreeMap<String, String> = named.filter(|(_, value)| !value.trim().is_empty()).collect();
        Self::parse(words).map_err(Refusal::wrong)
    }

    fn parse(words: BTreeMap<String, String>) -> Result<Self, String> {
        let mut left = words.clone();
        let seed = number(&mut left, "seed", [0, u64::MAX])?.unwrap_or(1);
        let count = number(&mut left, "count", [1, u64::from(MOST_WELDS)])?.and_then(|count| u16::try_from(count).ok());
        let across = number(&mut left, "resolution", [u64::from(ACROSS[0]), u64::from(ACROSS[1])])?;
        let sign = choice(&mut left, "sign", SIGNS)?;
        let chosen = WeldSettings {
            count,
            difficulty: choice(&mut left, "difficulty", DIFFICULTIES)?,
            placement: choice(&mut left, "place", PLACES)?,
            shape: choice(&mut left, "profile", PROFILES)?,
            tool: ToolShape { kind: choice(&mut left, "access-tool", TOOLS)?, ..ToolShape::default() },
            ..WeldSettings::default()
        };
        let values = left.iter().map(|(name, value)| dial(name, value)).collect::<Result<Values, String>>()?;
        for [one, other] in TOGETHER {
            if values.0.contains_key(one) != values.0.contains_key(other) {
                return Err(format!("--{one} and --{other} are set together, or neither"));
            }
        }
        let across = across.and_then(|across| u32::try_from(across).ok()).unwrap_or(ACROSS[2]);
        Ok(Self { words, settings: values.settings(chosen), seed, across, sign })
    }

    /// Returns the words of the command line after the program's name.
    pub(super) fn command(&self, part: &str, out: &str) -> Vec<String> {
        let fixed = ["weld", part, "--out", out, "--usd", "off"].map(str::to_owned);
        let own = self.words.iter().flat_map(|(name, value)| [format!("--{name}"), value.clone()]);
        fixed.into_iter().chain(own).collect()
    }
}

/// Values of dials by their flags, as users write them.
struct Values(BTreeMap<String, [f64; 2]>);

impl FromIterator<(String, [f64; 2])> for Values {
    fn from_iter<I: IntoIterator<Item = (String, [f64; 2])>>(pairs: I) -> Self {
        Self(pairs.into_iter().collect())
    }
}

impl Values {
    fn range(&self, name: &str) -> Option<[f64; 2]> {
        let unit = if name.ends_with("-mm") { 1e-3 } else { 1.0 };
        self.0.get(name).map(|range| range.map(|value| value * unit))
    }

    /// Value of a dial [SI].
    fn one(&self, name: &str) -> Option<f64> {
        self.range(name).map(|[value, _]| value)
    }

    fn share(&self, name: &str) -> f64 {
        self.one(name).unwrap_or(0.0)
    }

    fn count(&self, name: &str) -> u32 {
        // The dial's range has whole numbers that fit.
        self.share(name) as u32
    }

    fn settings(&self, chosen: WeldSettings) -> WeldSettings {
        let stitch = self.one("stitch-mm").zip(self.one("stitch-pitch-mm"));
        let tool = chosen.tool;
        WeldSettings {
            stitch: stitch.map(|(length, pitch)| Stitch { length, pitch }),
            convexity: self.share("convexity"),
            form: self.form(),
            toe_radius: self.one("toe-radius-mm"),
            length: self.range("length-mm"),
            width: self.one("width-mm"),
            height: self.one("height-mm"),
            curvature: self.range("curvature-per-m"),
            curvature_max: self.one("curvature-max-per-m"),
            correlation: self.one("correlation-mm"),
            exposure: self.range("exposure"),
            exposure_reach: self.one("exposure-reach-mm"),
            tool: ToolShape {
                radius: self.one("access-radius-mm").unwrap_or(tool.radius),
                width: self.one("access-width-mm").unwrap_or(tool.width),
                ..tool
            },
            min_access: self.one("min-access"),
            ..chosen
        }
    }

    fn form(&self) -> FormRequest {
        let (height, chevron) = (self.one("ripple-height"), self.one("ripple-chevron"));
        let ripple =
            |pitch| Ripples { pitch, height: height.unwrap_or(RIPPLE[0]), chevron: chevron.unwrap_or(RIPPLE[1]) };
        let crater = Crater { depth: self.share("crater"), hump: self.share("start-hump") };
        let weave = self.one("weave-mm").zip(self.one("weave-pitch-mm"));
        FormRequest {
            ripples: self.one("ripple-pitch-mm").map(ripple),
            crater: (crater.depth > 0.0 || crater.hump > 0.0).then_some(crater),
            weave: weave.map(|(amplitude, pitch)| Weave { amplitude, pitch }),
            width_variation: self.share("width-variation"),
            height_variation: self.share("height-variation"),
            pores: self.count("pores"),
            sagging: self.share("sagging"),
            spatter: self.count("spatter"),
            overlap: self.share("overlap"),
            undercut: self.share("undercut"),
            burn_through: self.count("burn-through"),
        }
    }
}

/// Takes a whole number out of the words.
fn number(words: &mut BTreeMap<String, String>, name: &str, [least, most]: [u64; 2]) -> Result<Option<u64>, String> {
    let Some(text) = words.remove(name) else { return Ok(None) };
    let read = text.trim().parse().ok().filter(|value| (least..=most).contains(value));
    read.map(Some).ok_or_else(|| format!("--{name} {text:?}: a whole number from {least} to {most} is accepted"))
}

/// Takes a choice out of the words; the first one is usual.
fn choice<T: Copy>(words: &mut BTreeMap<String, String>, name: &str, all: &Choices<T>) -> Result<T, String> {
    let Some(text) = words.remove(name) else { return Ok(all[0].1) };
    let names = || all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let found = all.iter().find(|(own, _)| *own == text);
    found.map(|(_, value)| *value).ok_or_else(|| format!("--{name} {text:?}: {} are accepted", names()))
}

/// Reads a value of a dial, or a range of one that accepts it.
fn dial(name: &str, text: &str) -> Result<(String, [f64; 2]), String> {
    let known = DIALS.iter().find(|dial| dial.key == name);
    let dial = known.ok_or_else(|| format!("--{name}: there is no such dial of a weld"))?;
    let parts: Vec<&str> = text.split("..").collect();
    let ends = match parts[..] {
        [one] => [one, one],
        [low, high] if RANGES.contains(dial) => [low, high],
        _ => return Err(refused(dial, text)),
    };
    let is_whole = |value: &f64| !is_count(dial) || value.fract() == 0.0;
    let read = ends.map(|end| end.trim().parse::<f64>().ok().filter(|value| dial.accepts(*value)).filter(is_whole));
    match read {
        [Some(low), Some(high)] if low <= high => Ok((name.to_owned(), [low, high])),
        _ => Err(refused(dial, text)),
    }
}

fn refused(dial: &Dial, text: &str) -> String {
    let many = if RANGES.contains(dial) { ", or two of them as LOW..HIGH," } else { "" };
    let whole = if is_count(dial) { "whole number" } else { "number" };
    format!("--{} {text:?}: a {whole} {}{many} is accepted", dial.key, dial.accepted())
}

/// Returns true for a dial of whole numbers.
fn is_count(dial: &Dial) -> bool {
    dial.unit == Unit::One && dial.range[1] > 1.0
}

/// A dial for the page.
pub(crate) struct DialRow {
    /// The dial.
    pub(crate) dial: &'static Dial,
    /// True if it accepts a range.
    pub(crate) is_range: bool,
    /// True if it takes whole numbers.
    pub(crate) is_count: bool,
}

/// Returns the dials for the page.
pub(crate) fn dials() -> impl Iterator<Item = DialRow> {
    DIALS.iter().map(|dial| DialRow { dial, is_range: RANGES.contains(dial), is_count: is_count(dial) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(pairs: &[(&str, &str)]) -> Result<Flags, String> {
        let pairs = pairs.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        Flags::read(pairs).map_err(|refusal| refusal.1)
    }

    #[test]
    fn flags_are_settings_and_the_command_line() {
        let pairs = [("--length-mm", "20..40"), ("--seed", "7"), ("--place", "butt"), ("--pores", "3"), ("zoom", "2")];
        let flags = read(&pairs).unwrap();
        assert_eq!(flags.settings.length, Some([0.02, 0.04]));
        assert_eq!((flags.seed, flags.settings.form.pores, flags.across), (7, 3, 256));
        assert_eq!(flags.settings.placement, Placement::Butt);
        let words = flags.command("it's.obj", "out").join(" ");
        assert_eq!(words, "weld it's.obj --out out --usd off --length-mm 20..40 --place butt --pores 3 --seed 7");
        assert_eq!(read(&[("--width-mm", " ")]).unwrap(), read(&[]).unwrap(), "an empty field sets nothing");
    }

    #[test]
    fn what_is_not_accepted_is_refused_with_what_would_be() {
        for (name, value, words) in [
            ("--length-mm", "-3", "above zero"),
            ("--length-mm", "40..20", "LOW..HIGH"),
            ("--width-mm", "1..2", "a number above zero is accepted"),
            ("--exposure", "NaN", "within 0 to 1"),
            ("--pores", "1.5", "whole number"),
            ("--seed", "-1", "a whole number from 0"),
            ("--count", "0", "from 1 to 1000"),
            ("--difficulty", "brutal", "medium, easy, hard are accepted"),
            ("--weave-mm", "1", "--weave-pitch-mm are set together"),
            ("--force", "x", "no such dial"),
            ("--out", "../x", "no such dial"),
        ] {
            let refused = read(&[(name, value)]).unwrap_err();
            assert!(refused.contains(words), "{name} {value}: {refused}");
        }
    }

    #[test]
    fn every_dial_changes_the_settings() {
        let plain = read(&[]).unwrap().settings;
        for row in dials() {
            let value = if row.dial.accepts(0.07) && !row.is_count { "0.07" } else { "1" };
            let mut pairs = vec![(format!("--{}", row.dial.key), value.to_owned())];
            // Some dials act beside another one.
            let beside = match row.dial.key {
                "ripple-height" | "ripple-chevron" => Some("ripple-pitch-mm"),
                "weave-mm" => Some("weave-pitch-mm"),
                "weave-pitch-mm" => Some("weave-mm"),
                "stitch-mm" => Some("stitch-pitch-mm"),
                "stitch-pitch-mm" => Some("stitch-mm"),
                _ => None,
            };
            let other: Vec<(String, String)> =
                beside.map(|key| (format!("--{key}"), "2".to_owned())).into_iter().collect();
            pairs.extend(other.clone());
            let without =
                if beside == Some("ripple-pitch-mm") { Flags::read(other).unwrap().settings } else { plain.clone() };
            assert_ne!(Flags::read(pairs).unwrap().settings, without, "{}", row.dial.key);
        }
    }
}
