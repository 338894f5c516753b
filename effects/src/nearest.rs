//! Suggestions for mistyped names.

/// Greatest number of names that a message proposes.
const MOST_PROPOSED: usize = 3;

/// Hint for an unknown name: the similar known names, or all known names if none is similar.
pub fn hint(name: &str, known: &[&str]) -> String {
    let begun = known.iter().copied().filter(|known| name.len() >= 3 && known.starts_with(name));
    let mut proposed = near(name, known.iter().copied());
    let new: Vec<&str> = begun.filter(|begun| !proposed.contains(begun)).collect();
    proposed.extend(new);
    proposed.truncate(MOST_PROPOSED);
    match proposed[..] {
        [] => format!("known are {}", known.join(", ")),
        _ => format!("did you mean `{}`?", proposed.join("` or `")),
    }
}

/// Returns the known names within an edit distance of a third of the letters of `name`, nearest first.
pub(super) fn near<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Vec<&'n str> {
    let scored = known.map(|known| (distance(name, known), known));
    let mut near: Vec<_> = scored.filter(|(off, _)| *off <= name.len() / 3).collect();
    near.sort_by_key(|(off, _)| *off);
    near.into_iter().map(|(_, known)| known).collect()
}

/// Edit distance between two names (Levenshtein 1966).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
