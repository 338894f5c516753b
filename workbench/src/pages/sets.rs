//! The pages of data sets: frames that the scripts fill.

use maud::{Markup, html};

use super::document;
use crate::error::Refusal;
use crate::place::Place;
use crate::sets::SetKind;

/// Labels that can lie over an image, by their names in addresses.
const LAYERS: [(&str, &str); 5] = [
    ("appearance", "classes by appearance"),
    ("dose", "classes by dose"),
    ("instances", "base metal and welds"),
    ("depth", "depth"),
    ("amodal", "whole workpiece, as if nothing hid it"),
];

/// Builds the page of a data set, or of one whose marker cannot be read.
pub(crate) fn set(place: &Place, kind: Result<&SetKind, &Refusal>) -> Markup {
    let (script, body) = match kind {
        Ok(SetKind::Assets) => (Some("assets.js"), assets()),
        Ok(SetKind::Images) => (Some("images.js"), images()),
        Err(refusal) => (None, html! { p.bad { (refusal.1) } }),
    };
    let content = html! {
        header.bar {
            p { a href="/" { "All" } " / " strong { (place.title()) } " " span #count role="status" aria-live="polite" {} }
        }
        main #set data-address={ "/set/" (place.id) } {
            h1.hidden { (place.title()) }
            div #fault role="alert" hidden {}
            (body)
        }
    };
    document(&place.title(), script, content)
}

fn assets() -> Markup {
    html! {
        form #filters aria-label="filters" {
            div.controls #word-filters {}
            details { summary { "Ranges of numbers" } div #ranges {} }
            div.controls {
                button type="reset" { "Clear filters" }
                label { input #pictures type="checkbox" checked; " pictures" }
            }
        }
        p #shown role="status" aria-live="polite" {}
        div.scroll { table #items { caption.hidden { "Items" } thead {} tbody {} } }
        (pager())
        section #item hidden aria-live="polite" {}
        (failures())
    }
}

fn images() -> Markup {
    html! {
        form #filters aria-label="filters and labels" {
            div.controls {
                @for (name, words) in [("split", "Split"), ("workpiece", "Workpiece"), ("treatment", "Coating"), ("looks", "Look")] {
                    label { (words) " " select name=(name) {} }
                }
                label { "Name " input name="id" type="text" autocomplete="off" placeholder="part of it"; }
            }
            div.controls {
                label { "Labels " select #layer {
                    option value="" { "none" }
                    @for (name, words) in LAYERS { option value=(name) { (words) } }
                } }
                label { "strength " input #blend type="range" min="0" max="100" value="60" aria-valuetext="60 %"; }
                span #classes {}
            }
        }
        p #shown role="status" aria-live="polite" {}
        div #images {}
        (pager())
        (failures())
    }
}

fn pager() -> Markup {
    html! {
        nav.controls aria-label="pages" {
            button #previous type="button" { "Previous" }
            span #page {}
            button #following type="button" { "Next" }
        }
    }
}

fn failures() -> Markup {
    html! {
        section #failures hidden aria-labelledby="failures-heading" {
            h2 #failures-heading {}
            div.scroll { table { thead {} tbody {} } }
        }
    }
}
