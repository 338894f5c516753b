//! Form of the page: well-formed, self-contained, small, reproducible.

use report::study::page;

use crate::study::{bare, grinding, sanding};

/// Elements without an end tag.
const VOID: [&str; 4] = ["meta", "img", "br", "hr"];

/// Returns the names of the tags in order; the text of scripts and styles is skipped.
fn tags(html: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        found.push(tag);
        rest = &rest[end + 1..];
        for raw in ["script", "style"] {
            if tag == raw || tag.starts_with(&format!("{raw} ")) {
                rest = &rest[rest.find(&format!("</{raw}>")).expect("a raw text ends")..];
            }
        }
    }
    found
}

#[test]
fn every_element_is_closed_in_order() {
    for report in [grinding(2, 60, 40), sanding(), bare("table")] {
        let html = page(&report);
        let mut open: Vec<&str> = Vec::new();
        for tag in tags(&html).into_iter().filter(|tag| !tag.starts_with('!') && !tag.ends_with('/')) {
            let name = tag.trim_start_matches('/').split([' ', '\n']).next().unwrap();
            if tag.starts_with('/') {
                assert_eq!(open.pop(), Some(name), "</{name}> closes what is open");
            } else if !VOID.contains(&name) {
                open.push(name);
            }
        }
        assert!(open.is_empty(), "{open:?}");
    }
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let html = page(&grinding(1, 60, 40));
    for tag in tags(&html) {
        for source in ["src=\"", "href=\""].iter().filter_map(|key| tag.split_once(key)) {
            assert!(source.1.starts_with("data:") || source.1.starts_with('#'), "<{tag:.80}>");
        }
    }
    for word in ["http:", "https:", "@import", "url(", "fetch("] {
        assert!(!html.contains(word), "{word}");
    }
}

#[test]
fn eight_large_scans_stay_below_five_megabytes() {
    let html = page(&grinding(8, 560, 160));
    println!("8 scans of 560 x 160: {:.2} MB", html.len() as f64 * 1e-6);
    assert!(html.len() < 5_000_000, "{}", html.len());
}

#[test]
fn the_same_study_gives_the_same_bytes() {
    assert_eq!(page(&grinding(2, 60, 40)), page(&grinding(2, 60, 40)));
}

#[test]
fn what_a_study_has_not_leaves_no_empty_table() {
    let html = page(&bare("table"));
    assert!(html.contains("There are no maps") && html.contains("No step of the model was computed."));
    assert!(
        !html.contains("<tbody>\n</tbody>")
            && !html.contains("<table>\n</table>")
            && !html.contains("NaN")
            && !html.contains("<svg")
    );
    let html = page(&sanding());
    assert!(html.contains("intersection over union") && !html.contains("Residual maps"));
}
