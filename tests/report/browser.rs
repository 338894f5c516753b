//! The page in headless Chromium: empty error console, all numbers in the document, values under the pointer, A4.

use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use report::study::page;
use serde_json::Value;

use crate::study::{bare, grinding, sanding};

/// Names of the executable on different systems.
const PROGRAMS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Reports a skipped test, bypassing the test harness's capture; fails if outside programs are required.
fn untested(cause: &str) {
    let promised = std::env::var_os("ROBOFIN_REQUIRE_OUTSIDE").is_some_and(|value| value == "1");
    assert!(!promised, "ROBOFIN_REQUIRE_OUTSIDE=1, but the report cannot be opened: {cause}");
    writeln!(std::io::stderr(), "NOT TESTED: the report in a browser: {cause}").expect("standard error is open");
}

/// Returns a Chromium that starts; `None` after reporting a skipped test.
fn chromium() -> Option<&'static str> {
    let starts = |program: &&&str| Command::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    let found = PROGRAMS.iter().find(starts).copied();
    if found.is_none() {
        untested("no chromium is installed (apt-get install chromium)");
    }
    found
}

/// Opens a file in a browser with a temporary profile.
fn open<A: AsRef<OsStr>>(program: &str, file: &Path, arguments: &[A]) -> Output {
    let profile = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::new(program);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--enable-logging=stderr"]);
    command.arg("--virtual-time-budget=5000").arg(format!("--user-data-dir={}", profile.path().display()));
    let output = command.args(arguments).arg(format!("file://{}", file.display())).output().expect("it ran before");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Returns the console messages of the page.
fn console(output: &Output) -> Vec<String> {
    let text = String::from_utf8_lossy(&output.stderr);
    text.lines().filter(|line| line.contains("CONSOLE")).map(str::to_owned).collect()
}

/// Writes a page to a folder that is kept after the test.
fn written(name: &str, html: &str) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&file, html).expect("the page can be written");
    file
}

fn numbers(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Number(number) => found.push(number.to_string()),
        Value::Array(items) => items.iter().for_each(|item| numbers(item, found)),
        Value::Object(items) => items.values().for_each(|item| numbers(item, found)),
        _ => {}
    }
}

#[test]
fn a_browser_opens_the_pages_without_an_error_and_finds_the_numbers() {
    let Some(program) = chromium() else { return };
    let reports = [
        ("report-grinding.html", grinding(8, 280, 80)),
        ("report-sanding.html", sanding()),
        ("report-bare.html", bare("table")),
    ];
    for (name, report) in reports {
        let file = written(name, &page(&report));
        let output = open(program, &file, &["--dump-dom"]);
        assert_eq!(console(&output), [""; 0], "{name}");
        let dom = String::from_utf8(output.stdout).expect("a document is text");
        let mut expected = Vec::new();
        numbers(&report.diagnosis, &mut expected);
        for number in &expected {
            assert!(dom.contains(number.as_str()), "{name}: {number} is not in the document");
        }
        assert!(dom.contains(report.conclusion.word()) && dom.contains(&report.sentence), "{name}");
    }
}

/// Shows that the test above can fail: an error in a script is detected.
#[test]
fn an_error_on_the_console_would_be_seen() {
    let Some(program) = chromium() else { return };
    let html = page(&bare("table")).replace("\"use strict\";", "\"use strict\"; undefinedName.call();");
    let output = open(program, &written("report-broken.html", &html), &["--dump-dom"]);
    assert!(console(&output).iter().any(|line| line.contains("undefinedName")), "{:?}", console(&output));
}

#[test]
fn the_pointer_reads_the_value_of_its_pixel() {
    let Some(program) = chromium() else { return };
    let report = grinding(1, 80, 40);
    // Moves the pointer to the middle of pixel (33, 21), counted from the lower left.
    let probe = "<script>const m = document.querySelector('image.map'), b = m.getBoundingClientRect();\
        m.dispatchEvent(new PointerEvent('pointermove', {bubbles: true, clientX: b.left + b.width * 33.5 / 80, \
        clientY: b.bottom - b.height * 21.5 / 40}));</script></body>";
    let html = page(&report).replace("</body>", probe);
    let output = open(program, &written("report-pointer.html", &html), &["--dump-dom"]);
    assert_eq!(console(&output), [""; 0]);
    let dom = String::from_utf8(output.stdout).expect("a document is text");
    let study::Maps::Heights(maps) = &report.scans[0].maps else { panic!("heights") };
    let value = maps.base[21 * 80 + 33] * 1e6;
    let says = format!("x 8.25 mm, y \u{2212}4.75 mm\nbase model: {value:.1} µm").replace(": -", ": \u{2212}");
    assert!(dom.contains(&says), "{says:?} in {:?}", dom.split("id=\"tip\"").nth(1));
}

#[test]
fn it_prints_on_a4() {
    let Some(program) = chromium() else { return };
    let file = written("report-print.html", &page(&grinding(4, 280, 80)));
    let pdf = file.with_extension("pdf");
    let output = open(program, &file, &[format!("--print-to-pdf={}", pdf.display()), "--no-pdf-header-footer".into()]);
    assert_eq!(console(&output), [""; 0]);
    let bytes = fs::read(&pdf).expect("a PDF");
    let text = String::from_utf8_lossy(&bytes);
    let pages = text.matches("/Type /Page\n").count();
    println!("four scans print on {pages} pages");
    assert!((4..=16).contains(&pages), "{pages} pages");
    // A4 in points.
    assert!(text.contains("/MediaBox [0 0 594.9") || text.contains("/MediaBox [0 0 595"), "A4");
}
