//! The workbench of the whole program: an asset that the page makes is the one that it showed, a cancelled one is gone,
//! and the images that the program makes are shown.

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::program::{bracket, names, robofin};

/// Time after which a run counts as hung.
const PATIENCE: Duration = Duration::from_secs(180);

/// A running workbench with its address and token.
struct Server {
    child: Child,
    address: String,
    token: String,
}

impl Server {
    fn start(folder: &Path, out: &Path) -> Self {
        let mut command = robofin(["workbench", "--port", "0", "--no-open", "--json", "--backend", "cpu"]);
        command.arg(folder).arg("--out").arg(out).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the program can be started");
        let answers = child.stdout.take().expect("piped");
        let answer = serde_json::Deserializer::from_reader(answers).into_iter::<Value>().next();
        let answer = answer.expect("an answer").expect("JSON");
        let url = answer["url"].as_str().expect("an address").to_owned();
        let (address, token) = url.strip_prefix("http://").and_then(|rest| rest.split_once("/?token=")).expect("a URL");
        Self { child, address: address.to_owned(), token: token.to_owned() }
    }

    /// Sends a request as the page does; returns the body of the answer.
    fn ask(&self, line: &str, body: &str) -> String {
        let port = self.address.rsplit(':').next().expect("a port");
        let mut stream = TcpStream::connect(&self.address).expect("the server listens");
        write!(
            stream,
            "{line} HTTP/1.1\r\nHost: {0}\r\nOrigin: http://{0}\r\nCookie: robofin-{port}={1}\r\nConnection: close\r\n\
             Content-Type: application/json\r\nContent-Length: {2}\r\n\r\n{body}",
            self.address,
            self.token,
            body.len()
        )
        .expect("the server reads");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("the server answers");
        let (head, body) = answer.split_once("\r\n\r\n").expect("a head and a body");
        assert!(head.starts_with("HTTP/1.1 2"), "{line}: {answer}");
        body.to_owned()
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.ask(line, "")).expect("JSON")
    }

    /// Waits until the run has ended; returns it.
    fn ended(&self) -> Value {
        let begun = Instant::now();
        loop {
            let run = self.json("GET /weld/run?since=0")["run"].take();
            if !run["outcome"].is_null() {
                return run;
            }
            assert!(begun.elapsed() < PATIENCE, "{run}");
            sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ended = self.child.kill();
        let _waited = self.child.wait();
    }
}

#[test]
fn the_page_makes_the_asset_that_it_shows() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path().join("it's parts");
    fs::create_dir(&folder).expect("a folder");
    fs::copy(bracket(), folder.join("part <b>.obj")).expect("a part");
    let server = Server::start(&folder, &place.path().join("kept"));
    let page = server.ask("GET /weld", "");
    let (before, _) = page.split_once("part &lt;b&gt;.obj").expect("the part is listed, as text");
    let part = before.rsplit("value=\"").next().and_then(|rest| rest.split('"').next()).expect("an id");
    let flags = json!({ "--length-mm": "30..40", "--width-mm": "8", "--seed": "3", "--resolution": "64" });
    let query = "--length-mm=30..40&--width-mm=8&--seed=3&--resolution=64";
    let shown = server.json(&format!("GET /weld/parts/{part}/figures?name=made&{query}"));
    assert!(shown["failure"].is_null(), "{shown}");
    server.ask("POST /weld/run", &json!({ "part": part, "name": "made", "flags": flags }).to_string());
    let run = server.ended();
    assert_eq!((&run["outcome"], &run["command"]), (&json!("made"), &shown["command"]), "{run}");
    let truth: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("made/welds.json")).expect("an asset")).expect("JSON");
    let (weld, figures) = (&truth["welds"][0], &shown["welds"][0]);
    for (own, name) in [
        ("length_mm", "lengthMm"),
        ("width_mm", "widthMm"),
        ("height_mm", "heightMm"),
        ("geodesic_curvature_rms_per_m", "curvatureRms"),
        ("geodesic_curvature_max_per_m", "curvatureMax"),
        ("exposure_min", "exposure"),
        ("access_mean", "access"),
    ] {
        assert_eq!(weld[own], figures[name], "{own}");
    }
    let slow = json!({ "--resolution": "640" });
    server.ask("POST /weld/run", &json!({ "part": part, "name": "slow", "flags": slow }).to_string());
    sleep(Duration::from_millis(500));
    server.ask("POST /weld/cancel", "");
    assert_eq!(server.ended()["outcome"], "cancelled");
    assert_eq!(names(&folder), ["made", "part <b>.obj"], "nothing is left of it");
}

#[test]
fn images_that_the_program_makes_are_shown_with_their_looks() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let folder = place.path().join("images");
    let mut command =
        robofin(["dataset", "images", "--limit", "6", "--size", "96x72", "--voxel-mm", "2", "--seed", "3"]);
    assert!(command.arg("--out").arg(&folder).output().expect("the program can be started").status.success());
    let server = Server::start(&folder, &place.path().join("kept"));
    let page = server.ask("GET /", "");
    let id = page.split("/set/").nth(1).and_then(|rest| rest.split('"').next()).expect("a link to the set");
    let set = server.json(&format!("GET /set/{id}/rows"));
    assert_eq!((&set["faults"], &set["failures"]), (&json!([]), &json!([])), "{set}");
    let rows = set["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 6);
    let all = rows.iter().flat_map(|row| row["looks"].as_array().expect("looks"));
    let drawn: std::collections::BTreeSet<&str> = all.map(|look| look.as_str().expect("a name")).collect();
    let known = robofin(["dataset", "images", "--help"]).output().expect("the program can be started");
    let known = String::from_utf8(known.stdout).expect("text");
    let accepted = known.split("[default: all]: ").nth(1).and_then(|rest| rest.split(", or none").next());
    let accepted: Vec<&str> = accepted.expect("the names of all looks").split(", ").collect();
    assert!(drawn.iter().all(|look| accepted.contains(look)), "{drawn:?} of {accepted:?}");
    for look in ["clutter", "spatter", "table", "tool"] {
        assert!(drawn.contains(look), "{look}: {drawn:?}");
    }
}
