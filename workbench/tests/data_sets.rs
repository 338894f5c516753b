//! Data sets over HTTP: broken catalogues, hostile names, a set of a thousand items.

mod common;

use std::fs;
use std::net::SocketAddr;
use std::path::Path;
use std::time::Instant;

use common::http::own;
use common::sets::{HOSTILE, line, row, write_assets, write_images};
use common::{Server, serve};
use serde_json::{Value, json};

/// Serves a folder, and returns the address of its only data set.
fn opened(folder: &Path) -> (Server, String) {
    let server = serve(folder, &folder.join("out"));
    let page = own(server.address, "GET /", "").body;
    let id = page.split("/set/").nth(1).unwrap_or_else(|| panic!("{page}")).split('"').next().unwrap().to_owned();
    (server, format!("/set/{id}"))
}

fn get(address: SocketAddr, path: &str) -> (u16, String) {
    let answer = own(address, &format!("GET {path}"), "");
    (answer.status, answer.body)
}

fn rows(address: SocketAddr, set: &str) -> Value {
    let (status, body) = get(address, &format!("{set}/rows"));
    assert_eq!(status, 200, "{body}");
    serde_json::from_str(&body).unwrap()
}

#[test]
fn a_thousand_assets_are_listed_with_what_is_broken() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let own_rows: Vec<Value> = (0..1000).map(|k| row(&format!("{k:04}"), HOSTILE, 30.0, "train")).collect();
    write_assets(&set, &own_rows);
    let whole = fs::read_to_string(set.join("manifest.jsonl")).unwrap();
    fs::write(set.join("manifest.jsonl"), format!("{whole}{{\"id\": \"half\n")).unwrap();
    fs::remove_dir_all(set.join("assets/0007")).unwrap();
    let (server, address) = opened(folder.path());
    let since = Instant::now();
    let found = rows(server.address, &address);
    println!("1000 assets were listed in {:.0} ms", since.elapsed().as_secs_f64() * 1e3);
    assert_eq!(found["rows"].as_array().unwrap().len(), 1000);
    assert_eq!(found["rows"][0][1], HOSTILE);
    let faults: Vec<&str> = found["faults"].as_array().unwrap().iter().map(|fault| fault.as_str().unwrap()).collect();
    assert!(faults[0].starts_with("manifest.jsonl, line 1001:"), "{faults:?}");
    assert!(faults[1].starts_with("1 items of manifest.jsonl have no folder"), "{faults:?}");
    assert_eq!(get(server.address, &format!("{address}/items/0001/preview.png")).0, 200);
    for (path, status) in [
        ("items/0007/preview.png", 404),
        ("items/0002/preview.png", 404),
        ("items/..%2f..%2fout/preview.png", 404),
        ("items/..%2fdataset.json", 404),
        ("items/gone", 404),
        ("images/0001/photograph", 404),
    ] {
        let (found, body) = get(server.address, &format!("{address}/{path}"));
        assert_eq!(found, status, "{path}: {body}");
    }
}

#[test]
fn labels_come_only_from_the_set_itself() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("secret.png"), "secret").unwrap();
    let set = folder.path().join("images");
    let mut lines = vec![line("good", "tee", &json!({})), line("broken", "tee", &json!({}))];
    lines.push(line("away", "tee", &json!({})));
    lines[2]["appearance"] = json!("../secret.png");
    lines[2]["dose"] = json!(folder.path().join("secret.png"));
    write_images(&set, &lines);
    fs::write(set.join("dose/broken.png"), "no picture").unwrap();
    let (server, address) = opened(folder.path());
    let found = rows(server.address, &address);
    assert_eq!((found["rows"].as_array().unwrap().len(), &found["faults"]), (3, &json!([])));
    for (path, status, words) in [
        ("good/photograph", 200, "PNG"),
        ("good/depth", 200, "PNG"),
        ("broken/dose", 422, "dose/broken.png"),
        ("away/appearance", 422, "leads out of the data set"),
        ("away/dose", 422, "leads out of the data set"),
        ("gone/dose", 404, "there is no image"),
        ("..%2f..%2fsecret.png/dose", 404, "there is no image"),
        ("good/secret", 400, "secret"),
    ] {
        let (found, body) = get(server.address, &format!("{address}/images/{path}"));
        assert!(found == status && body.contains(words), "{path}: {found} {body}");
    }
}

#[test]
fn a_set_that_cannot_be_read_says_what_is_wrong() {
    for (marker, words) in
        [("no JSON", "dataset.json"), (r#"{"format":"other/1"}"#, "robofin-dataset and robofin-images are accepted")]
    {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("set")).unwrap();
        fs::write(folder.path().join("set/dataset.json"), marker).unwrap();
        let (server, address) = opened(folder.path());
        let (status, page) = get(server.address, &address);
        assert!(status == 200 && page.contains(words), "{page}");
        assert_eq!(get(server.address, &format!("{address}/rows")).0, 422);
    }
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("set")).unwrap();
    fs::write(folder.path().join("set/dataset.json"), r#"{"format":"robofin-images/3"}"#).unwrap();
    let (server, address) = opened(folder.path());
    let faults = rows(server.address, &address)["faults"].to_string();
    assert!(faults.contains("no image was finished") && faults.contains("failures.jsonl"), "{faults}");
}
