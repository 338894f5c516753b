//! Inputs and program versions of the report, and the diagnosis as JSON for programs.

use serde_json::Value;

use crate::{Cell, Page, Table};
use study::Provenance;

/// Appends hashes, seed and versions.
pub(super) fn add(page: &mut Page, provenance: &Provenance) {
    page.part("provenance", "Inputs, seed and versions");
    let mut facts = vec![("seed".to_owned(), provenance.seed.to_string())];
    facts.extend(provenance.date.iter().map(|date| ("date".to_owned(), date.clone())));
    facts.extend(provenance.versions.iter().cloned());
    facts.extend(provenance.options.iter().cloned());
    page.facts(&facts);
    if !provenance.inputs.is_empty() {
        let mut table = Table::new("Files that were read", &["file", "SHA-256"]);
        let row = |input: &study::Digest| vec![Cell::text(&input.file), Cell::text(&input.sha256)];
        table.rows = provenance.inputs.iter().map(row).collect();
        page.block(&format!("<div class=\"digests\">{}</div>", table.to_html()));
    }
}

/// Appends the diagnosis as JSON that programs find by its element id.
pub(super) fn add_diagnosis(page: &mut Page, diagnosis: &Value) {
    // "<" occurs in JSON only within strings, where this escape stands for the same character.
    let json = diagnosis.to_string().replace('<', "\\u003c");
    page.block(&format!("<script type=\"application/json\" id=\"diagnosis\">{json}</script>\n"));
}
