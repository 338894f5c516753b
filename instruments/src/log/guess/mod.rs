//! Guesses of the quantities in a log's channels, with unit and reason.
//!
//! Names decide first, in the conventions listed in `vocabulary`; values decide on signs and units that no header
//! gives. All guesses are uncertain: every candidate has a sentence for the person who checks it.

mod names;
mod table;
mod values;
mod vocabulary;

use super::{Channels, unit};

/// Maximum number of candidates reported per role.
const MOST_CANDIDATES: usize = 3;
/// Difference of scores below which a guess is doubtful.
const CLOSE: f64 = 2.5;
/// Score from which a name alone suffices.
const GOOD: f64 = 8.0;

/// A quantity in the log of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Time,
    /// x of the tool.
    X,
    /// y of the tool.
    Y,
    /// z of the tool.
    Z,
    /// Normal force, positive in contact.
    Force,
    /// Spindle speed.
    Spindle,
    /// x of the approach axis.
    Nx,
    /// y of the approach axis.
    Ny,
    /// z of the approach axis.
    Nz,
    /// Temperature of a pyrometer.
    Temperature,
}

/// Confidence in a guess.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Confidence {
    /// Another candidate or another unit is nearly as good.
    Doubtful,
    /// The name fits, and the unit follows from the values.
    Likely,
    /// Name and unit are given in the file.
    Clear,
}

/// A channel that may have a role.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Index in [`Channels::names`].
    pub channel: usize,
    /// Its name there.
    pub name: String,
    /// Unit of its values in the spelling of [`Channels::units`]; `1` for an axis.
    pub unit: String,
    /// −1 if the values must be inverted, as for a sensor that reads negative in contact.
    pub sign: i8,
    /// Confidence in the candidate.
    pub confidence: Confidence,
    /// Reason, in one sentence without a full stop.
    pub reason: String,
    /// Score of the name, from 0 to 12.
    score: f64,
}

/// The candidates of every role, best first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guesses {
    candidates: Vec<(Role, Vec<Candidate>)>,
}

impl Role {
    /// In the order of tables.
    pub const ALL: [Self; 10] = [
        Self::Time,
        Self::X,
        Self::Y,
        Self::Z,
        Self::Force,
        Self::Spindle,
        Self::Nx,
        Self::Ny,
        Self::Nz,
        Self::Temperature,
    ];

    /// Its key in `[log.columns]`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Force => "force",
            Self::Spindle => "spindle",
            Self::Nx => "nx",
            Self::Ny => "ny",
            Self::Nz => "nz",
            Self::Temperature => "temperature",
        }
    }

    /// True if every log of a pass must have it.
    pub fn is_required(self) -> bool {
        matches!(self, Self::Time | Self::X | Self::Y | Self::Z | Self::Force | Self::Spindle)
    }

    /// Possible units.
    fn units(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["s", "ms", "us", "ns", "min", "h"],
            Self::X | Self::Y | Self::Z => &["m", "mm", "um"],
            Self::Force => &["N", "kN"],
            Self::Spindle => &["rpm", "rad/s", "Hz"],
            Self::Nx | Self::Ny | Self::Nz => &["1"],
            Self::Temperature => &["°C", "K"],
        }
    }
}

impl Guesses {
    /// The candidates of a role, best first; at most three.
    pub fn of(&self, role: Role) -> &[Candidate] {
        self.candidates.iter().find(|(own, _)| *own == role).map_or(&[], |(_, candidates)| candidates)
    }

    /// The best candidate of a role.
    pub fn best(&self, role: Role) -> Option<&Candidate> {
        self.of(role).first()
    }
}

/// Guesses the quantity of each channel.
pub fn guess(channels: &Channels) -> Guesses {
    let mut guesses = Guesses::default();
    let first_index = names::first_index(channels.names.iter().map(|name| unit::split(name).0));
    for role in Role::ALL {
        let mut found: Vec<Candidate> =
            (0..channels.names.len()).filter_map(|k| candidate(channels, role, (k, first_index))).collect();
        found.sort_by(|one, other| other.score.total_cmp(&one.score).then(one.channel.cmp(&other.channel)));
        found.truncate(MOST_CANDIDATES);
        guesses.candidates.push((role, found));
    }
    values::drop_what_is_no_axis(channels, &mut guesses.candidates);
    values::understand(channels, &mut guesses.candidates);
    for (_, candidates) in &mut guesses.candidates {
        doubt(candidates);
    }
    guesses
}

/// A channel as a candidate, if its name and its unit fit.
fn candidate(channels: &Channels, role: Role, (channel, first_index): (usize, usize)) -> Option<Candidate> {
    let name = &channels.names[channel];
    let (base, _) = unit::split(name);
    let own = channels.units[channel].as_deref();
    let mut score = names::score(role, base, first_index)?;
    match own {
        Some(own) if role.units().contains(&own) => score += 2.0,
        // A header may give an unknown unit; a known unit of another dimension excludes the channel.
        Some(own) if unit::known(own).is_some() => return None,
        _ => {}
    }
    if !channels.values[channel].iter().any(|value| value.is_finite()) {
        return None;
    }
    Some(Candidate {
        channel,
        name: name.clone(),
        unit: own.unwrap_or_default().to_owned(),
        sign: 1,
        confidence: if own.is_some() && score >= GOOD { Confidence::Clear } else { Confidence::Likely },
        reason: String::new(),
        score,
    })
}

/// Lowers the confidence if the next candidate is nearly as good, or the name is weak.
fn doubt(candidates: &mut [Candidate]) {
    let Some((best, others)) = candidates.split_first_mut() else { return };
    if let Some(next) = others.first().filter(|next| best.score - next.score < CLOSE) {
        best.confidence = Confidence::Doubtful;
        best.reason.push_str(&format!("; {:?} may be it as well", next.name));
    }
    for candidate in std::iter::once(best).chain(others) {
        if candidate.score < GOOD - 2.0 {
            candidate.confidence = Confidence::Doubtful;
        }
    }
}

#[cfg(test)]
mod tests;
