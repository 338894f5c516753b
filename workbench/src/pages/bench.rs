//! The page of a campaign or table: empty frames that the scripts fill.

use maud::{Markup, html};

use super::document;
use crate::place::{Kind, Place};

/// Colour modes of the part and their names in addresses.
const MODES: [(&str, &str); 5] = [
    ("deviation", "measured \u{2212} simulated"),
    ("noise", "measured \u{2212} simulated, in noise floors"),
    ("removed", "removed depth"),
    ("photograph", "photograph"),
    ("dose", "dose of the coating"),
];

/// Builds the page of a campaign or table.
pub(crate) fn bench(place: &Place) -> Markup {
    let content = html! {
        header.bar {
            p { a href="/" { "All" } " / " strong { (place.title()) } " " span #about {} }
            p #work role="status" aria-live="polite" {}
            progress #progress max="1" value="0" aria-label="progress of the work" hidden {}
            button #cancel type="button" hidden { "Cancel" }
        }
        main #bench data-address={ "/bench/" (place.id) } {
            h1.hidden { (place.title()) }
            p #fault role="alert" hidden {}
            div.columns {
                div { @if place.kind == Kind::Campaign { (part()) } (held()) }
                div { (model()) (suspects()) (formula()) (sliders()) }
            }
            section #panel-waterfall aria-label="How the error falls" {}
            section #panel-failures aria-label="Where the model fails" {}
            section #panel-parameters aria-label="Parameters" {}
            section #panel-method aria-label="Method" {}
            (ledger())
        }
        div #tip aria-hidden="true" {}
        script src="/asset/hover.js" defer {}
    };
    document(&place.title(), Some("workbench.js"), content)
}

fn part() -> Markup {
    html! {
        section #part aria-labelledby="part-heading" {
            h2 #part-heading { "The part" }
            div.controls {
                label { "Trial " select #trial {} }
                label { "after " select #pass {} }
                label { "shows " select #mode {
                    @for (name, words) in MODES { option value=(name) { (words) } }
                    optgroup label="condition in the pass" { @for at in 0..study::TILE_COVARIATES {
                        option value={ "covariate " (at) } { (study::tile_covariate(at).0) }
                    } }
                } }
                label { "surface " select #whose {
                    option value="simulated" { "simulated" } option value="measured" { "measured" }
                } }
                label { "beside " select #beside { option value="" { "nothing" } } }
            }
            (views())
            div #legend aria-label="legend" {}
            div.controls {
                button #turn type="button" aria-pressed="true" { "Turn and read" }
                button #cut type="button" aria-pressed="false" { "Section: drag a line" }
                button #mark type="button" aria-pressed="false" { "Region: drag a box" }
                button #way type="button" aria-pressed="false" { "Way of the tool" }
                button #before type="button" aria-pressed="false" { "Before beside after" }
                button #reset type="button" { "From above" }
            }
            div #time hidden {
                input #moment type="range" min="0" max="0" step="1" value="0" aria-label="moment of the pass";
                canvas #force width="640" height="70" role="img" {}
                p #moment-words role="status" {}
            }
            dl #reading aria-live="polite" { dt { "Click on the part to read values." } }
            form #line.controls {
                @for (name, words) in [("x0", "from x"), ("y0", "y"), ("x1", "to x"), ("y1", "y")] {
                    label { (words) " " input name=(name) type="number" step="any" required size="6"; " mm" }
                }
                button type="submit" value="cut" { "Cut" }
                button type="submit" value="region" { "Look at the box" }
            }
            figure #section aria-live="polite" {}
            div #region.scroll aria-live="polite" {}
        }
    }
}

fn views() -> Markup {
    html! {
        div #views {
            div.stage {
                canvas #view width="640" height="480" tabindex="0" role="img"
                    aria-label="The workpiece. Arrow keys turn it, plus and minus zoom, Enter reads the middle." {}
                div #divider role="slider" tabindex="0" aria-orientation="horizontal" aria-valuemin="0"
                    aria-valuemax="100" aria-valuenow="50" hidden
                    aria-label="Divider: left of it the surface before the first pass, right of it that after" {}
            }
            canvas #other width="640" height="480" role="img" hidden aria-label="The same view with another model" {}
        }
    }
}

fn held() -> Markup {
    html! {
        section #held aria-live="polite" hidden {
            h2 { "Set by hand" }
            p #held-words {}
            table #held-others {}
            button #keep type="button" { "Make it the model" }
        }
    }
}

fn model() -> Markup {
    html! {
        section aria-labelledby="model-heading" {
            h2 #model-heading { "The model" }
            dl.glance #errors {}
            ol #stages aria-label="Models that were made" {}
            div.controls {
                button #undo type="button" title="Ctrl+Z" { "Undo" }
                button #redo type="button" title="Ctrl+Shift+Z" { "Redo" }
                a #report target="_blank" rel="noopener" hidden { "Report" }
            }
        }
    }
}

fn suspects() -> Markup {
    html! {
        section aria-labelledby="suspects-heading" {
            h2 #suspects-heading { "Suspects" }
            p #suspects-words { "No search was made yet." }
            div.scroll { table #suspects {} }
            p #next-trial hidden {}
            div.controls {
                button #search type="button" { "Search the library" }
                form #add.controls {
                    label { "or add " select name="effect" #effect required {} }
                    button type="submit" { "Add and fit" }
                }
            }
        }
    }
}

fn formula() -> Markup {
    html! {
        section aria-labelledby="formula-heading" {
            h2 #formula-heading { "A formula of your own" }
            form #own {
                label { "Formula " input name="line" #formula-line type="text" autocomplete="off" spellcheck="false"
                    placeholder="rate * exp(-ground_volume / a)" aria-describedby="formula-words"; }
                button type="submit" disabled { "Add and fit" }
            }
            p #formula-words role="status" { "Unknown names are fitted; units are checked as you type." }
        }
    }
}

fn sliders() -> Markup {
    html! {
        section aria-labelledby="sliders-heading" {
            h2 #sliders-heading { "Parameters by hand" }
            p.fine { "Drag one: the others follow at once on a coarse lattice, then on the fine one." }
            div #sliders {}
        }
    }
}

fn ledger() -> Markup {
    html! {
        section aria-labelledby="ledger-heading" {
            h2 #ledger-heading { "What was done" }
            p { "These command lines make it again without the page: " a #replay download="replay.sh" { "replay.sh" } }
            pre #commands {}
        }
    }
}
