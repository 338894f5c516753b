//! Match of a name to a quantity, in the conventions of robots, sensors and languages.

use super::Role;
use super::vocabulary::*;

/// Words of a name in lower case: split at punctuation, at capitals, and between letters and digits.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = vec![String::new()];
    let chars: Vec<char> = name.chars().collect();
    for (k, &c) in chars.iter().enumerate() {
        let before = k.checked_sub(1).map(|k| chars[k]);
        let next_is_lower = chars.get(k + 1).is_some_and(|next| next.is_lowercase());
        let is_cut = before.is_some_and(|before| {
            let is_hump = c.is_uppercase() && (before.is_lowercase() || before.is_uppercase() && next_is_lower);
            is_hump || before.is_ascii_digit() != c.is_ascii_digit()
        });
        if is_cut || !c.is_alphanumeric() {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|word| word.extend(c.to_lowercase()));
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Score of a name, without its unit, for a role, from 0 to 10; `None` if it does not fit.
pub(super) fn score(role: Role, name: &str, first_index: usize) -> Option<f64> {
    let words = words(name);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let score = match role {
        Role::Time => time(name, &words)?,
        Role::X | Role::Y | Role::Z => position(role, &words, first_index)?,
        Role::Force => force(&words)?,
        Role::Spindle => spindle(&words)?,
        Role::Nx | Role::Ny | Role::Nz => approach(role, &words)?,
        Role::Temperature => temperature(name, &words)?,
    };
    let score = if has(COMMANDED) { score - 4.0 } else { score };
    (score > 0.0).then_some(score)
}

fn any(words: &[String], list: &[&str]) -> bool {
    words.iter().any(|word| list.contains(&word.as_str()))
}

fn time(name: &str, words: &[String]) -> Option<f64> {
    if any(words, NOT_TIME) || !any(words, TIME) {
        return None;
    }
    // A single capital T is as often a temperature.
    Some(if name == "T" {
        5.0
    } else if words.len() == 1 {
        10.0
    } else {
        7.0
    })
}

/// The axis at the end of a name, or the index after a word for several values.
fn axis(words: &[String], named: &[&str]) -> Option<(usize, bool)> {
    let letters = ["x", "y", "z"];
    if let Some(axis) = letters.into_iter().position(|letter| words.iter().any(|word| word == letter)) {
        let is_alone = letters.into_iter().filter(|letter| words.iter().any(|word| word == letter)).count() == 1;
        return is_alone.then_some((axis, false));
    }
    let joined = |axis: usize| {
        let letter = letters[axis];
        words.iter().any(|word| {
            let rest = word.strip_prefix(letter).or_else(|| word.strip_suffix(letter));
            rest.is_some_and(|rest| ["pos", "tcp", "position", "koordinate", "coord", "ist"].contains(&rest))
        })
    };
    if let Some(axis) = (0..3).find(|&axis| joined(axis)) {
        return Some((axis, false));
    }
    let index: usize = words.last()?.parse().ok()?;
    any(words, named).then_some((index, true))
}

/// First index of multi-component positions: 0, or 1 if no name has 0.
pub(super) fn first_index<'a>(names: impl IntoIterator<Item = &'a str>) -> usize {
    let index = |name: &str| {
        let words = words(name);
        let is_position = any(&words, POSES) && !any(&words, NOT_POSITION);
        is_position.then(|| words.last()?.parse::<usize>().ok()).flatten()
    };
    names.into_iter().filter_map(index).min().unwrap_or(0).min(1)
}

fn position(role: Role, words: &[String], first_index: usize) -> Option<f64> {
    let wanted = [Role::X, Role::Y, Role::Z].into_iter().position(|axis| axis == role)?;
    let (axis, is_index) = axis(words, POSES)?;
    let wanted = if is_index { wanted + first_index } else { wanted };
    if axis != wanted || any(words, NOT_POSITION) {
        return None;
    }
    let hints = words.iter().filter(|word| POSITION.contains(&word.as_str())).count();
    let base = if words.len() == 1 {
        9.0
    } else if is_index {
        6.0
    } else {
        5.0
    };
    Some((base + 2.0 * hints as f64).min(10.0))
}

fn force(words: &[String]) -> Option<f64> {
    if any(words, NOT_FORCE) || !any(words, FORCE) {
        return None;
    }
    let is = |word: &str| words.iter().any(|own| own == word);
    if is("fz") || is("fn") || is("normalkraft") {
        return Some(10.0);
    }
    if is("fx") || is("fy") {
        return Some(5.0);
    }
    match axis(words, &["force", "f", "wrench", "kraft"]) {
        Some((2, _)) => Some(9.0),
        Some((0 | 1, _)) => Some(5.0),
        Some(_) => None,
        None if any(words, &["x", "y", "z"]) => None,
        None if words.len() == 1 => Some(9.0),
        None => Some(if is("normal") { 9.0 } else { 7.0 }),
    }
}

fn spindle(words: &[String]) -> Option<f64> {
    if any(words, NOT_SPINDLE) || !any(words, SPINDLE) {
        return None;
    }
    // Several indexed speeds are those of joints.
    if words.last().is_some_and(|word| word.parse::<u64>().is_ok()) && !any(words, SURELY_SPINDLE) {
        return None;
    }
    let is = |word: &str| words.iter().any(|own| own == word);
    Some(match () {
        () if any(words, SURELY_SPINDLE) => 10.0,
        () if (is("spindle") || is("spindel")) && words.len() <= 2 => 9.0,
        () if words.len() == 1 && is("n") => 8.0,
        () if words.len() == 1 && !is("n") => 6.0,
        () if is("n") => return None,
        () => 5.0,
    })
}

fn approach(role: Role, words: &[String]) -> Option<f64> {
    let wanted = [Role::Nx, Role::Ny, Role::Nz].into_iter().position(|axis| axis == role)?;
    if words.len() == 1 && words[0] == ["nx", "ny", "nz"][wanted] {
        return Some(10.0);
    }
    let (axis, is_index) = axis(words, &[])?;
    let others = ["force", "f", "tcp", "torque"];
    (axis == wanted && !is_index && any(words, APPROACH) && !any(words, &others)).then_some(8.0)
}

fn temperature(name: &str, words: &[String]) -> Option<f64> {
    if name == "T" {
        return Some(6.0);
    }
    if any(words, NOT_TEMPERATURE) || !any(words, TEMPERATURE) {
        return None;
    }
    Some(if words.len() == 1 { 10.0 } else { 8.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_cut_into_words() {
        let cases: [(&str, &[&str]); 8] = [
            ("actual_TCP_pose_0", &["actual", "tcp", "pose", "0"]),
            ("TCP.X", &["tcp", "x"]),
            ("posX", &["pos", "x"]),
            ("XPos", &["x", "pos"]),
            ("/ft/wrench/force/z", &["ft", "wrench", "force", "z"]),
            ("TCPForce", &["tcp", "force"]),
            ("Fz", &["fz"]),
            ("RIst.X", &["r", "ist", "x"]),
        ];
        for (name, wanted) in cases {
            assert_eq!(words(name), wanted, "{name}");
        }
    }

    #[test]
    fn a_measured_value_goes_before_the_one_asked_for() {
        let score = |name| score(Role::X, name, 0).unwrap_or(0.0);
        assert!(score("actual_TCP_pose_0") > score("target_TCP_pose_0"));
        assert_eq!(score("actual_TCP_force_0"), 0.0);
        assert_eq!(score("actual_TCP_pose_3"), 0.0);
        assert_eq!(first_index(["t", "pose_1", "pose_2", "pose_3"]), 1);
        assert_eq!(first_index(["q_1", "pose_0", "pose_1"]), 0);
    }
}
