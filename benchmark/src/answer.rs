//! Answer of a study to a case, and its judgement.

use lab::Verdict;
use serde::{Deserialize, Serialize};
use virtual_lab::FrontEnd;

use super::cases::{Case, Family};

/// A named effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedEffect {
    /// Its name.
    pub name: String,
    /// Effects from which the data cannot distinguish it.
    pub alike: Vec<String>,
}

/// Answer to a case, from a study or a baseline.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseAnswer {
    /// The verdict; `None` if the measurements were refused.
    pub verdict: Option<Verdict>,
    /// Named effects.
    pub named: Vec<NamedEffect>,
    /// Effect of a hint.
    pub hint: Option<String>,
}

/// Kind of the right answer to a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpectedAnswer {
    /// Nothing is missing: nothing is hidden, or only an effect that base parameters and poses absorb.
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
    /// Right: exactly the hidden effects are named with certainty, or nothing is reported missing, or the verdict is
    /// unknown, as the case requires.
    Right,
    /// Right but not certain: the hidden effect among indistinguishable ones, some of several with `partly`, or a hint.
    Class,
    /// No false statement, but not the hidden effect.
    Shy,
    /// Something is reported missing where nothing is, without a name.
    Alarm,
    /// An effect is named that does not act.
    Wrong,
}

impl Judgement {
    /// Word in tables.
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

/// Effects that describe a front end's errors in the measurements: to name one is no error.
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
    pub fn asked(&self) -> ExpectedAnswer {
        match self.family {
            Family::L | Family::U => ExpectedAnswer::Unknown,
            Family::A => ExpectedAnswer::Nothing,
            _ if self.hidden.is_empty() => ExpectedAnswer::Nothing,
            _ => ExpectedAnswer::Names,
        }
    }

    /// True if it is right to name the effect: it is hidden, or describes the front end's errors.
    pub fn is_there(&self, name: &str) -> bool {
        let hidden = self.asked() == ExpectedAnswer::Names && self.hidden.iter().any(|hidden| hidden == name);
        hidden || describing(self.design.front).contains(&name)
    }
}

impl CaseAnswer {
    /// A guess without uncertainty.
    pub fn sure(verdict: Verdict, name: Option<&str>) -> Self {
        let named = name.map(|name| NamedEffect { name: name.to_owned(), alike: Vec::new() });
        Self { verdict: Some(verdict), named: named.into_iter().collect(), hint: None }
    }

    /// Effects that the answer claims: none if it says that no effect of the library describes the data.
    fn claimed(&self) -> &[NamedEffect] {
        if self.verdict == Some(Verdict::Unknown) { &[] } else { &self.named }
    }

    /// Judgement of the answer to `case`.
    pub fn judged(&self, case: &Case) -> Judgement {
        let is_apt =
            |named: &NamedEffect| case.is_there(&named.name) || named.alike.iter().any(|name| case.is_there(name));
        let has_stray = !self.claimed().iter().all(is_apt);
        match case.asked() {
            ExpectedAnswer::Unknown => self.judged_unknown(has_stray),
            _ if has_stray || self.hint.as_ref().is_some_and(|hint| !case.is_there(hint)) => Judgement::Wrong,
            ExpectedAnswer::Nothing => self.judged_nothing(case),
            ExpectedAnswer::Names => self.judged_names(case),
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
        // The library's effects do not describe these front ends completely, so that the verdict "something is missing"
        // is right.
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
#[path = "answer_tests.rs"]
mod tests;
