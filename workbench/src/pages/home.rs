//! The list of a folder's content.

use maud::{Markup, html};

use super::document;
use crate::home::Home;
use crate::next_trial::has_plan;
use crate::place::{Kind, Place};

/// Builds the page of a folder.
pub(crate) fn home(home: &Home) -> Markup {
    let (places, is_cut) = home.places();
    let content = html! {
        main {
            header { h1 { "Workbench" } p.lead { (home.title()) } }
            @if places.is_empty() { (empty()) }
            @for (kind, heading) in Kind::ALL {
                @let own: Vec<&Place> = places.iter().filter(|place| place.kind == kind).collect();
                @if !own.is_empty() { (list(heading, &own)) }
            }
            section {
                h2 { "Make a weld" }
                p { a href="/weld" { "Weld a part" } ": dials, a picture that follows them, and the asset." }
            }
            (drop())
            @if is_cut { p { "The folder holds more folders than are looked through; start the workbench in one below." } }
            p.fine { "What is tried is kept in " code { (home.out()) } "." }
        }
    };
    document(&home.title(), Some("home.js"), content)
}

fn empty() -> Markup {
    html! {
        p { "No trials, studies, assets or data sets are here, or in the four folders below." }
        p {
            "An example to try is made by " code { "robofin trial synth --size small --out trials" } "."
        }
    }
}

/// Builds the forms for a trial from files.
fn drop() -> Markup {
    html! {
        section #drop aria-labelledby="drop-heading" {
            h2 #drop-heading { "Begin a trial" }
            p { "Drop the scans and logs of one trial here: the surface before, a repeat if there is one, and of each pass "
                "the log and the scan after it." }
            form #files.controls {
                label { "Campaign " input #campaign type="text" autocomplete="off" placeholder="this folder"; }
                label { "Trial " input #trial type="text" autocomplete="off" required placeholder="plate-7"; }
                label { "Files " input #chosen type="file" multiple; }
                button type="submit" { "Look at the files" }
            }
            div #drop-said role="status" aria-live="polite" {}
            form #draft hidden {
                div #draft-seen {}
                label for="draft-text" { "trial.toml, as far as the files say" }
                textarea #draft-text rows="24" spellcheck="false" {}
                button type="submit" { "Keep the trial" }
            }
        }
    }
}

fn list(heading: &str, places: &[&Place]) -> Markup {
    html! {
        section {
            h2 { (heading) }
            ul.places { @for place in places { li { (link(place)) } } }
        }
    }
}

fn link(place: &Place) -> Markup {
    let (kind, is_page) = match place.kind {
        Kind::Campaign | Kind::Table => ("bench", true),
        Kind::DataSet => ("set", true),
        _ => ("place", Home::shown_file(place).is_file()),
    };
    html! {
        @if is_page { a href={ "/" (kind) "/" (place.id) } { (place.title()) } } @else { span { (place.title()) } }
        @if has_plan(&place.path) { " " a href={ "/place/" (place.id) "/next-trial.zip" } download { "its next trial" } }
        @if place.trials > 0 { " " span.fine { (place.trials) @if place.trials == 1 { " trial" } @else { " trials" } } }
    }
}
