//! The page on which a weld is made: a part, dials, a picture, figures, the command line.

use maud::{Markup, html};

use super::document;
use crate::home::Home;
use crate::weld::{DialRow, dials};

/// Flags of the dials that stand beside the picture; the others are below it.
const FIRST: [&str; 6] = ["length-mm", "curvature-per-m", "exposure", "width-mm", "height-mm", "convexity"];
/// A flag, its words, and its values on the command line with their words; the first one is usual.
type Choice = (&'static str, &'static str, &'static [(&'static str, &'static str)]);
/// Choices of the page.
const CHOICES: [Choice; 5] = [
    ("difficulty", "Difficulty", &[("medium", "medium"), ("easy", "easy"), ("hard", "hard")]),
    (
        "place",
        "Place",
        &[
            ("surface", "smooth surface"),
            ("seam", "seam: a fillet in a concave edge"),
            ("butt", "butt joint of two halves"),
            ("mixed", "seam or surface"),
        ],
    ),
    (
        "profile",
        "Profile",
        &[
            ("parabolic", "parabola"),
            ("circular-segment", "arc of a circle"),
            ("superellipse", "flat, with steep toes"),
        ],
    ),
    ("access-tool", "Tool whose access is measured", &[("wheel", "wheel"), ("pad", "pad")]),
    ("sign", "Open surface", &[("auto", "refuse"), ("winding", "accept the guess of its inside")]),
];

/// Builds the page.
pub(crate) fn weld(home: &Home) -> Markup {
    let (parts, is_cut) = home.welder.parts();
    let content = html! {
        header.bar {
            p { a href="/" { "All" } " / " strong { "Make a weld" } }
            p #work role="status" aria-live="polite" {}
        }
        main #weld {
            h1.hidden { "Make a weld" }
            p #fault role="alert" hidden {}
            div.columns {
                div {
                    div.controls {
                        label.wide { "Part " select #part-file { @for part in &parts {
                            option value=(part.id) data-stem=(part.stem()) { (part.name) }
                        } } }
                        @if is_cut { span.fine { "There are more meshes than are listed." } }
                    }
                    canvas #view width="640" height="480" tabindex="0" role="img"
                        aria-label="The part, its weld in orange. Arrow keys turn it, plus and minus zoom, 0 resets." {}
                    p.fine #about {}
                    (figures())
                }
                form #dials aria-label="dials" { (first_dials()) (more_dials()) }
            }
            (make())
        }
    };
    document("Make a weld", Some("weld.js"), content)
}

fn figures() -> Markup {
    html! {
        section aria-labelledby="figures-heading" {
            h2 #figures-heading { "What is reached" }
            p #failure role="status" aria-live="polite" {}
            div.scroll { table #figures {} }
            ul #remarks.fine {}
        }
    }
}

fn first_dials() -> Markup {
    html! {
        h2 { "Dials" }
        p.fine { "An empty field is chosen for the part; its value is shown in grey." }
        div.controls { @for (name, words, values) in CHOICES[..2].iter() { (choice(name, words, values)) } }
        div.controls {
            label { "Seed " input name="--seed" type="number" min="0" step="1" value="1" required; }
            button #next type="button" { "Another seed" }
            label { "Welds " input name="--count" type="number" min="1" max="1000" step="1" placeholder="1"; }
        }
        @for row in dials().filter(|row| FIRST.contains(&row.dial.key)) { (dial(&row)) }
    }
}

fn more_dials() -> Markup {
    html! {
        details {
            summary { "More dials" }
            div.controls { @for (name, words, values) in CHOICES[2..].iter() { (choice(name, words, values)) } }
            div.controls {
                label { "Voxels along the longest side "
                    input name="--resolution" type="number" min="8" max="4096" step="1" placeholder="256"; }
            }
            @for row in dials().filter(|row| !FIRST.contains(&row.dial.key)) { (dial(&row)) }
        }
        div.controls { button #clear type="button" { "Clear all dials" } }
    }
}

fn choice(name: &str, words: &str, values: &[(&str, &str)]) -> Markup {
    html! {
        label { (words) " " select name={ "--" (name) } {
            @for (value, words) in values { option value=(value) { (words) } }
        } }
    }
}

/// Builds a dial: a slider, and one field or two that it fills.
fn dial(row: &DialRow) -> Markup {
    let DialRow { dial, is_range, is_count } = row;
    let (name, step) = (format!("--{}", dial.key), if *is_count { "1" } else { "any" });
    let field = |words: &str, end: &str| {
        html! { input.field type="number" step=(step) data-end=(end) aria-label={ (dial.name) ", " (words) }; }
    };
    html! {
        div.dial data-name=(name) data-count=[is_count.then_some("yes")] {
            label for={ "dial-" (dial.key) } { (dial.name) " " span.fine { (dial.flag_unit()) } }
            span.fields {
                (field(if *is_range { "at least" } else { "value" }, "low"))
                @if *is_range { " to " (field("at most", "high")) }
            }
            input id={ "dial-" (dial.key) } type="range" min="0" max="1" step=(step);
        }
    }
}

fn make() -> Markup {
    html! {
        section aria-labelledby="make-heading" {
            h2 #make-heading { "Make the asset" }
            p { "This command line makes it without the page:" }
            pre #command tabindex="0" aria-label="command line" {}
            form #make.controls {
                label { "Name of its folder " input #name type="text" required autocomplete="off" maxlength="80"
                    aria-describedby="name-fault"; }
                button type="submit" { "Make it" }
                progress #progress aria-label="progress of the asset" hidden {}
                button #cancel type="button" hidden { "Cancel" }
            }
            p #name-fault.bad role="status" {}
            p #outcome role="status" aria-live="polite" {}
            pre #lines tabindex="0" aria-label="what the program printed" hidden {}
        }
    }
}
