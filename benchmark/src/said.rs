//! Answer of a study to a case, and its judgement.

use lab::Verdict;
use serde::{Deserialize, Serialize};
use virtual_lab::FrontEnd;

use super::cases::{Case, Family};

/// An effect that was named.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// The effect.
    pub name: String,
    /// Effects from which the data cannot distinguish it.
    pub alike: Vec<String>,
}

/// Answer to a case, from a study or a guess.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Said {
    /// The verdict; none where the measurements were refused.
    pub verdict: Option<Verdict>,
    /// Effects that were named.
    pub named: Vec<Named>,
    /// The effect of a hint.
    pub hint: Option<String>,
}

/// Kind of the right answer to a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Nothing is missing: nothing is hidden, or only what base parameters and poses absorb.
    Nothing,
    /// The hidden effects.
    Names,
    /// Something is missing that no effect of the library describes.
    Unknown,
}

/// Judgement of an answer. Every case has exactly one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judgement {
    /// As asked: just the hidden effects named without doubt, nothing said to be missing, or unknown.
    Right,
    /// Right but not certain: the hidden effect among indistinguishable ones, some of several with `partly`, or a hint.
    Class,
    /// Nothing false, but not what is hidden.
    Shy,
    /// Something said to be missing where nothing is, without a name.
    Alarm,
    /// An effect named that is not there.
    Wrong,
}

impl Judgement {
    /// In tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Class => "class",
            Self::Shy => "too shy",
            Self::Alarm => "false alarm",
            Self::Wrong => "wrong name",
        }
    }
}

/// Effects that describe what a front end does to the measurements: naming one is no error.
pub fn describing(front: FrontEnd) -> &'static [&'static str] {
    match front {
        FrontEnd::Frame => &["clock-offset", "path-offset", "scan-shift"],
        FrontEnd::Clock => &["clock-offset"],
        FrontEnd::Ripple => &["chatter"],
        FrontEnd::Shop => &["chatter", "clock-offset", "path-offset", "scan-shift"],
        _ => &[],
    }
}

impl Case {
    /// Kind of the right answer.
    pub fn asked(&self) -> Asked {
        match self.family {
            Family::L | Family::U => Asked::Unknown,
            Family::A => Asked::Nothing,
            _ if self.hidden.is_empty() => Asked::Nothing,
            _ => Asked::Names,
        }
    }

    /// True if naming the effect is right: it is hidden, or describes what the front end does to the measurements.
    pub fn is_there(&self, name: &str) -> bool {
        let hidden = self.asked() == Asked::Names && self.hidden.iter().any(|hidden| hidden == name);
        hidden || describing(self.design.front).contains(&name)
    }
}

impl Said {
    /// A guess without doubt.
    pub fn sure(verdict: Verdict, name: Option<&str>) -> Self {
        let named = name.map(|name| Named { name: name.to_owned(), alike: Vec::new() });
        Self { verdict: Some(verdict), named: named.into_iter().collect(), hint: None }
    }

    /// The effects that it stands by: none where it says that none of the library describes what is missing.
    fn claimed(&self) -> &[Named] {
        if self.verdict == Some(Verdict::Unknown) { &[] } else { &self.named }
    }

    /// Judgement of the answer to `case`.
    pub fn judged(&self, case: &Case) -> Judgement {
        let is_apt = |named: &Named| case.is_there(&named.name) || named.alike.iter().any(|name| case.is_there(name));
        let has_stray = !self.claimed().iter().all(is_apt);
        match case.asked() {
            Asked::Unknown => self.judged_unknown(has_stray),
            _ if has_stray || self.hint.as_ref().is_some_and(|hint| !case.is_there(hint)) => Judgement::Wrong,
            Asked::Nothing => self.judged_nothing(case),
            Asked::Names => self.judged_names(case),
        }
    }

    fn judged_unknown(&self, has_stray: bool) -> Judgement {
        match self.verdict {
            Some(Verdict::Unknown) => Judgement::Right,
            Some(Verdict::Ambiguous) => Judgement::Class,
            _ if has_stray || self.hint.is_some() => Judgement::Wrong,
            _ => Judgement::Shy,
        }
    }

    fn judged_nothing(&self, case: &Case) -> Judgement {
        // The library's effects do not describe these front ends in full: that something is missing is then true.
        let is_missing = !describing(case.design.front).is_empty();
        match self.verdict {
            Some(Verdict::Identified | Verdict::Hint | Verdict::NothingMissing | Verdict::NotTestable) => {
                Judgement::Right
            }
            Some(_) if is_missing => Judgement::Class,
            _ => Judgement::Alarm,
        }
    }

    fn judged_names(&self, case: &Case) -> Judgement {
        let named = self.claimed();
        let is_named = |hidden: &&String| named.iter().any(|named| named.name == **hidden);
        let is_among =
            |hidden: &&String| named.iter().any(|named| named.name == **hidden || named.alike.contains(hidden));
        let [exact, found] = [case.hidden.iter().filter(is_named).count(), case.hidden.iter().filter(is_among).count()];
        let doubts = matches!(self.verdict, Some(Verdict::Partly | Verdict::Ambiguous));
        match self.verdict {
            Some(Verdict::Identified) if exact == case.hidden.len() => Judgement::Right,
            _ if found == case.hidden.len() || (found > 0 && doubts) => Judgement::Class,
            _ if self.hint.as_ref().is_some_and(|hint| case.hidden.contains(hint)) => Judgement::Class,
            _ => Judgement::Shy,
        }
    }
}

#[cfg(test)]
#[path = "said_tests.rs"]
mod tests;
