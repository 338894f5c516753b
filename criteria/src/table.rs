//! Macro that declares constants together with the table of them.

use super::Criterion;

/// Declares constants and a list of them as [`Criterion`].
macro_rules! criteria {
    ($list:ident; $(#[doc = $meaning:literal] $name:ident: $kind:ty = $value:literal, $unit:literal, $source:literal;)+) => {
        $(
            #[doc = concat!($meaning, " Unit: ", $unit, ". Source: ", $source, ".")]
            pub const $name: $kind = $value;
        )+

        /// These criteria, in order of declaration.
        pub(crate) const $list: &[Criterion] = &[$(Criterion {
            name: stringify!($name),
            value: $name as f64,
            unit: $unit,
            meaning: $meaning.trim_ascii(),
            source: $source,
        }),+];
    };
}

/// Concatenates two lists.
pub(super) const fn joined<const COUNT: usize>(first: &[Criterion], second: &[Criterion]) -> [Criterion; COUNT] {
    let mut all = [first[0]; COUNT];
    let mut k = 0;
    while k < COUNT {
        all[k] = if k < first.len() { first[k] } else { second[k - first.len()] };
        k += 1;
    }
    all
}
