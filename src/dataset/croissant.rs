//! Metadata in Croissant 1.0 (Akhtar et al. 2024, <https://docs.mlcommons.org/croissant/docs/croissant-spec.html>).

use std::collections::BTreeMap;

use anyhow::Result;
use serde_json::{Map, Value, json};

use super::Recipe;
use super::catalogue::{ROWS_FILE, TABLE_FILE};
use super::table::Table;
use crate::asset::{EXPORTS, Export, FileRecord};
use crate::store::catalogue::{CONTACT_FILE, FAILURES_FILE};

/// Files of the set itself, with their media types.
const FILES: [(&str, &str); 4] = [
    (TABLE_FILE, "text/csv"),
    (ROWS_FILE, "application/jsonlines"),
    (FAILURES_FILE, "application/jsonlines"),
    (CONTACT_FILE, "image/png"),
];

/// Terms of the vocabulary that map to themselves in `cr:`.
const TERMS: [&str; 23] = [
    "citeAs",
    "column",
    "equivalentProperty",
    "extract",
    "field",
    "fileProperty",
    "fileObject",
    "fileSet",
    "format",
    "includes",
    "isLiveDataset",
    "jsonPath",
    "key",
    "md5",
    "parentField",
    "path",
    "recordSet",
    "references",
    "regex",
    "repeated",
    "replace",
    "samplingRate",
    "source",
];

/// Writes the metadata; `records` holds size and hash of the other files of the catalogue.
///
/// # Errors
/// Never: the metadata are plain data.
pub(super) fn write(recipe: &Recipe, table: &Table, records: &BTreeMap<&str, FileRecord>) -> Result<Vec<u8>> {
    let object = |&(name, media): &(&str, &str)| {
        let record = records.get(name);
        json!({
            "@type": "cr:FileObject",
            "@id": name,
            "name": name,
            "contentUrl": name,
            "encodingFormat": media,
            "contentSize": record.map(|record| format!("{} B", record.bytes)),
            "sha256": record.map(|record| &record.sha256),
        })
    };
    let set = |&Export { file: name, media_type: media, .. }: &Export| {
        json!({
            "@type": "cr:FileSet",
            "@id": format!("assets/{name}"),
            "name": format!("assets/{name}"),
            "description": format!("{name} of every item"),
            "encodingFormat": media,
            "includes": format!("assets/*/{name}"),
        })
    };
    let of_items = EXPORTS.iter().filter(|export| export.always).map(set);
    let distribution: Vec<Value> = FILES.iter().map(object).chain(of_items).collect();
    let metadata = json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": "welded-workpieces",
        "description": "CAD parts with weld beads: meshes, signed distance fields, weld labels and the exact truth of each weld",
        "version": recipe.version,
        "license": recipe.licence,
        "distribution": distribution,
        "recordSet": [{
            "@type": "cr:RecordSet",
            "@id": "items",
            "name": "items",
            "description": "One record for each item",
            "key": { "@id": "items/id" },
            "field": table.columns.iter().map(|column| field(table, column)).collect::<Vec<_>>(),
        }],
    });
    Ok((serde_json::to_string_pretty(&metadata)? + "\n").into_bytes())
}

fn field(table: &Table, column: &str) -> Value {
    let name = format!("items/{column}");
    json!({
        "@type": "cr:Field",
        "@id": name,
        "name": name,
        "description": column,
        "dataType": if table.is_numeric(column) { "sc:Float" } else { "sc:Text" },
        "source": { "fileObject": { "@id": TABLE_FILE }, "extract": { "column": column } },
    })
}

/// Returns the context that the specification prescribes.
fn context() -> Value {
    let mut context: Map<String, Value> =
        TERMS.iter().map(|&term| (term.to_owned(), format!("cr:{term}").into())).collect();
    let others = json!({
        "@language": "en",
        "@vocab": "https://schema.org/",
        "conformsTo": "dct:conformsTo",
        "cr": "http://mlcommons.org/croissant/",
        "data": { "@id": "cr:data", "@type": "@json" },
        "dataType": { "@id": "cr:dataType", "@type": "@vocab" },
        "dct": "http://purl.org/dc/terms/",
        "examples": { "@id": "cr:examples", "@type": "@json" },
        "rai": "http://mlcommons.org/croissant/RAI/",
        "sc": "https://schema.org/",
        "separator": "cr:separator",
        "subField": "cr:subField",
        "transform": "cr:transform",
    });
    context.extend(others.as_object().into_iter().flatten().map(|(term, value)| (term.clone(), value.clone())));
    context.into()
}
