//! The server: access control, and its error messages.

mod common;

use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::time::{Duration, Instant};

use common::http::{own, send};
use common::{TOKEN, bundled, copy, serve};
use serde_json::Value;
use workbench::{Options, Workbench, WorkbenchError};

#[test]
fn no_request_without_the_token_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let server = serve(folder.path(), &folder.path().join("out"));
    let host = format!("Host: {}\r\n", server.address);
    let cookie = format!("Cookie: robofin-{}={TOKEN}\r\n", server.address.port());
    let foreign = format!("{host}{cookie}Origin: http://evil.example\r\n");
    let rebound = format!("Host: evil.example\r\n{cookie}");
    let refused = [
        ("GET /", host.clone()),
        ("GET /asset/workbench.js", host.clone()),
        ("GET /bench/000000000000/state?since=0", host.clone()),
        ("GET /?token=ffffffffffffffffffffffffffffffff", host.clone()),
        ("POST /bench/000000000000/task", format!("{host}{cookie}")),
        ("POST /bench/000000000000/task", foreign.clone()),
        ("GET /weld", host.clone()),
        ("GET /weld/parts/bundled/picture", host.clone()),
        ("GET /weld/run?since=0", host.clone()),
        ("POST /weld/run", foreign.clone()),
        ("POST /weld/run", format!("{host}{cookie}")),
        ("POST /weld/cancel", foreign.clone()),
        ("GET /set/000000000000/rows", host.clone()),
        ("GET /set/000000000000/images/x/dose", host.clone()),
        ("GET /place/000000000000/next-trial.zip", host.clone()),
        ("POST /drop/begin?campaign=&trial=x", foreign.clone()),
        ("PUT /drop/file?campaign=&trial=x&file=y", host.clone()),
        ("GET /", foreign),
        ("GET /", rebound),
    ];
    for (line, headers) in refused {
        let answer = send(server.address, line, &headers, "");
        assert_eq!(answer.status, 403, "{line} with {headers}: {}", answer.body);
        assert!(!answer.body.contains(TOKEN) && !answer.head.contains(TOKEN));
    }
    let welcome = send(server.address, &format!("GET /?token={TOKEN}"), &host, "");
    assert_eq!(welcome.status, 303);
    assert!(welcome.head.contains("HttpOnly; SameSite=Strict"), "{}", welcome.head);
    assert_eq!(own(server.address, "GET /", "").status, 200);
}

#[test]
fn a_port_that_is_taken_and_a_folder_that_is_not_there_are_said() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let options = |folder: &std::path::Path, address: SocketAddr| Options {
        folder: folder.to_owned(),
        out: folder.join("out"),
        address,
        token: TOKEN.to_owned(),
        device: None,
    };
    let error = Workbench::bind(options(folder.path(), taken.local_addr().unwrap())).err().unwrap();
    assert!(matches!(error, WorkbenchError::Taken { .. }) && error.to_string().contains("--port"), "{error}");
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    let error = Workbench::bind(options(&folder.path().join("gone"), free)).err().unwrap();
    assert!(error.to_string().contains("gone: no such folder"), "{error}");
}

#[test]
fn the_first_page_lists_a_folder_at_once_and_hostile_names_are_text() {
    let folder = tempfile::tempdir().unwrap();
    let hostile = "<img src=x onerror=alert(1)> & 'quoted'";
    fs::create_dir(folder.path().join(hostile)).unwrap();
    fs::write(folder.path().join(hostile).join("study.json"), "{}").unwrap();
    fs::write(folder.path().join(hostile).join("report.html"), "<p>own</p>").unwrap();
    copy(&bundled(), &folder.path().join("first-look"));
    let server = serve(folder.path(), &folder.path().join("out"));
    let since = Instant::now();
    let page = own(server.address, "GET /", "");
    println!("the first page took {:.1} ms", since.elapsed().as_secs_f64() * 1e3);
    assert!(page.body.contains("first-look") && page.body.contains("3 trials"), "{}", page.body);
    assert!(!page.body.contains("<img src=x") && page.body.contains("&lt;img src=x"), "{}", page.body);
    assert!(page.head.contains("default-src 'none'"), "{}", page.head);
    let study = page.body.split("/place/").nth(1).unwrap().split('"').next().unwrap();
    let report = own(server.address, &format!("GET /place/{study}"), "");
    assert!(report.body == "<p>own</p>" && report.head.contains("sandbox allow-scripts"), "{}", report.head);
    for wrong in ["GET /place/..%2f..%2fetc", "GET /place/000000000000", "GET /asset/..%2flib.rs", "GET /nothing"] {
        assert_eq!(own(server.address, wrong, "").status, 404, "{wrong}");
    }
}

/// Returns the state of a bench after its measurements are read.
fn read(address: SocketAddr, bench: &str) -> Value {
    let end = Instant::now() + Duration::from_secs(600);
    loop {
        let answer = own(address, &format!("GET {bench}/state?since=0"), "");
        let state: Value = serde_json::from_str(&answer.body).unwrap_or_else(|_| panic!("{}", answer.body));
        if state["phase"] != "reading" {
            return state;
        }
        assert!(Instant::now() < end, "{state}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_broken_campaign_says_where_it_is_broken_and_opens_once_it_is_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("campaign");
    copy(&bundled().join("trial-1"), &campaign.join("trial-1"));
    let scan = campaign.join("trial-1").join("pass1_after.csv");
    let whole = fs::read(&scan).unwrap();
    fs::write(&scan, "no,heights\nat,all\n").unwrap();
    let server = serve(folder.path(), &folder.path().join("out"));
    let page = own(server.address, "GET /", "");
    let bench = format!("/bench/{}", page.body.split("/bench/").nth(1).unwrap().split('"').next().unwrap());
    let state = read(server.address, &bench);
    assert_eq!(state["phase"], "closed");
    assert!(state["fault"].as_str().unwrap().contains("pass1_after.csv"), "{state}");
    assert!(!folder.path().join("out").exists(), "nothing is begun on what cannot be read");
    fs::write(&scan, whole).unwrap();
    let state = read(server.address, &bench);
    assert_eq!(state["phase"], "open", "{state}");
    let cancelled = own(server.address, &format!("POST {bench}/task"), r#"{"task":"cancel"}"#);
    assert_eq!(cancelled.status, 202);
    let unknown = own(server.address, &format!("POST {bench}/task"), r#"{"task":"delete-all"}"#);
    assert_eq!(unknown.status, 422, "{}", unknown.body);
    assert!(unknown.body.contains("delete-all"), "{}", unknown.body);
    let far = own(server.address, &format!("POST {bench}/task"), r#"{"task":"go-to","number":7}"#);
    assert_eq!(far.status, 422, "{}", far.body);
    assert_ne!(own(server.address, "GET /", "").body.len(), 0, "it goes on");
}

#[test]
fn formulas_are_checked_as_they_are_typed() {
    let folder = tempfile::tempdir().unwrap();
    copy(&bundled().join("trial-1"), &folder.path().join("first-look").join("trial-1"));
    let server = serve(folder.path(), &folder.path().join("out"));
    let page = own(server.address, "GET /", "");
    let bench = format!("/bench/{}", page.body.split("/bench/").nth(1).unwrap().split('"').next().unwrap());
    let cancel = || own(server.address, &format!("POST {bench}/task"), r#"{"task":"cancel"}"#);
    assert_eq!(read(server.address, &bench)["phase"], "open");
    cancel();
    let check = |line: &str| -> Value {
        let line = line.replace(' ', "%20").replace('+', "%2B");
        serde_json::from_str(&own(server.address, &format!("GET {bench}/formula?line={line}"), "").body).unwrap()
    };
    let good = check("rate * exp(-ground_volume / a)");
    assert_eq!(good["unknowns"][0][0], "a", "{good}");
    let wrong = check("rate + ground_volume * a + b * pressure + force");
    assert!(wrong["fault"].is_string(), "{wrong}");
    let unread = check("rate * (");
    assert!(unread["fault"].is_string(), "{unread}");
}

#[test]
fn dropped_files_become_a_trial_once_they_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let server = serve(folder.path(), &folder.path().join("out"));
    let ask = |what: &str, body: &str| own(server.address, what, body);
    let place = "campaign=new%20wheel&trial=plate-1";
    assert_eq!(ask(&format!("PUT /drop/file?{place}&file=before.csv"), "1").status, 409, "nothing was begun");
    for hostile in ["campaign=..&trial=x", "campaign=&trial=..%2Fx", "campaign=a&trial="] {
        let answer = ask(&format!("POST /drop/begin?{hostile}"), "");
        assert!(answer.status == 422 && answer.body.contains("accepted"), "{hostile}: {}", answer.body);
    }
    assert_eq!(ask(&format!("POST /drop/begin?{place}"), "").status, 201);
    let empty = ask(&format!("POST /drop/draft?{place}"), "");
    assert!(empty.status == 422 && !empty.body.contains(".robofin-dropped"), "{}", empty.body);
    let source = bundled().join("trial-1");
    for entry in fs::read_dir(&source).unwrap() {
        let (name, path) = (entry.as_ref().unwrap().file_name(), entry.unwrap().path());
        if name != "trial.toml" {
            let text = fs::read_to_string(path).unwrap();
            let line = format!("PUT /drop/file?{place}&file={}", name.to_str().unwrap());
            assert_eq!(ask(&line, &text).status, 201, "{line}");
        }
    }
    assert_eq!(ask(&format!("PUT /drop/file?{place}&file=..%2Fx.csv"), "1").status, 422);
    let draft = ask(&format!("POST /drop/draft?{place}"), "");
    let draft: Value = serde_json::from_str(&draft.body).unwrap_or_else(|_| panic!("{}", draft.body));
    assert!(draft["text"].as_str().unwrap().contains("before.csv"), "{draft}");
    assert!(!draft["open"].as_array().unwrap().is_empty(), "the tool is in no file");
    let save = |text: &str| ask(&format!("POST /drop/save?{place}"), &serde_json::json!({ "text": text }).to_string());
    let broken = save("format = 7");
    assert!(broken.status == 422 && broken.body.contains("trial.toml"), "{}", broken.body);
    let kept = folder.path().join("new wheel").join("plate-1");
    assert!(!kept.exists(), "what cannot be read is kept aside");
    let saved = save(&fs::read_to_string(source.join("trial.toml")).unwrap());
    assert_eq!(saved.status, 200, "{}", saved.body);
    assert!(saved.body.contains("/bench/"), "{}", saved.body);
    for entry in fs::read_dir(&source).unwrap() {
        let name = entry.unwrap().file_name();
        assert_eq!(fs::read(source.join(&name)).unwrap(), fs::read(kept.join(&name)).unwrap(), "{name:?}");
    }
    assert!(!folder.path().join(".robofin-dropped").exists());
    assert!(ask(&format!("POST /drop/begin?{place}"), "").body.contains("exists"));
}
