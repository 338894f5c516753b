//! The page in headless Chromium: open a campaign, turn the part, read values, cut a section, add an effect; the error
//! falls to that of a calibration. Also undo, a formula, a slider and the report; the browser's console stays empty.
//!
//! With `ROBOFIN_PICTURES=DIR` the pictures of the documents are written there.

#[path = "../common/mod.rs"]
mod common;
mod part;
mod sets;
mod weld;

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use common::devtools::Browser;
use common::{bundled, copy, serve};
use effects::{Library, Model};
use lab::{Calibration, CalibrationSummary, Order};
use part::{before_is_shown_beside_after, part_is_turned_read_and_cut, two_models_are_compared};
use serde_json::{Value, json};
use study::Measurements;

/// Longest time of a fit on this campaign on a busy machine [s].
const PATIENCE: u64 = 600;
/// Effect added in the test.
const EFFECT: &str = "grit-dulling";

/// Manifest of the next trial that the study proposes.
const PLAN: &str = "# A plan. Grind twice as long.";

/// Errors of a calibration by `robofin calibrate` with the fitted base model and one more effect.
fn calibrated(measurements: &Measurements) -> (f64, f64) {
    let library = Library::builtin();
    let fitted = |model: &Model| -> (Calibration, f64) {
        let mut data = measurements.data().unwrap();
        let start = data.start(model, library).unwrap();
        let calibration = data.calibrated((model, &start), library, (Order::Joint, &|_| {})).unwrap();
        let summary = CalibrationSummary::new(data.evidence(), &calibration, library).unwrap();
        let error = 1e6 * summary.waterfall.last().unwrap().calibration_rms;
        (calibration, error)
    };
    let process = measurements.data().unwrap().evidence().process();
    let (base, base_error) = fitted(&Model::new(process));
    let text = base.model.to_text(library);
    let with = Model::parse("base", &text, library).unwrap().with(EFFECT);
    (base_error, fitted(&Model::parse("with", &with.to_text(library), library).unwrap()).1)
}

/// Copies one bundled trial and declares its logs exact, so that the fit seeks neither frame nor clock; all three
/// trials take five times as long.
fn one_trial(campaign: &Path) {
    copy(&bundled().join("trial-1"), &campaign.join("trial-1"));
    let manifest = campaign.join("trial-1").join("trial.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    let exact = "\n[robot]\nframe_sigma_mm = 0\nyaw_sigma_mrad = 0\nclock_sigma_s = 0\n";
    fs::write(manifest, text + exact).unwrap();
}

/// Writes a study of the campaign up to a diagnosis, with the parts of its record that a page reads.
fn write_study(folder: &Path, campaign: &Path) {
    fs::create_dir_all(folder).unwrap();
    let suspect = |name: &str, probability: f64, delta_chi2: f64| {
        json!({
            "name": name, "title": Library::builtin().find(name).unwrap().title, "probability": probability,
            "indistinguishable_from": [], "parameters": {}, "delta_chi2": delta_chi2, "p_value": 0.01, "search": 1,
            "ruled_out": null, "evaluation_rms_before": null, "evaluation_rms_after": null,
        })
    };
    let mut record = study::StudyRecord::new(study::inputs_sha256(campaign).unwrap(), 1);
    record.diagnosis = Some(json!({
        "sentence": "The rate falls with what was ground.", "none_probability": 0.02, "error_unit": "m",
        "suspects": [suspect("wheel-crown", 0.05, 11.0), suspect(EFFECT, 0.93, 240.0)],
        "next_trial": { "summary": "Grind twice as long.", "force_n": [40.0] },
    }));
    fs::write(folder.join(study::STUDY_FILE), serde_json::to_string(&record).unwrap()).unwrap();
    fs::create_dir_all(folder.join(study::NEXT_TRIAL)).unwrap();
    fs::write(folder.join(study::NEXT_TRIAL).join("trial.toml"), PLAN).unwrap();
}

/// Writes a picture if `ROBOFIN_PICTURES` is set.
fn picture(browser: &mut Browser, name: &str) {
    if let Some(folder) = std::env::var_os("ROBOFIN_PICTURES") {
        browser.screenshot(&PathBuf::from(folder).join(name));
    }
}

/// Waits until no task runs and the current model has a given number.
fn settled(browser: &mut Browser, number: u32) {
    let is = format!(
        "document.body.dataset.idle === 'true' && document.querySelector('#stages [aria-current]')?.value === {number}"
    );
    browser.until(&is, PATIENCE);
    assert_eq!(browser.value("document.getElementById('fault').textContent"), "");
}

fn shown_error(browser: &mut Browser) -> f64 {
    browser.value("+document.querySelector('#error').dataset.value").as_f64().unwrap()
}

#[test]
fn a_cause_is_tried_and_the_error_falls_to_what_calibrate_gives() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("first-look");
    one_trial(&campaign);
    write_study(&folder.path().join("study"), &campaign);
    let (out, campaigns) = (folder.path().join("kept"), folder.path().to_owned());
    let server = serve(&campaigns, &out);
    browser.open(&server.url);
    assert_eq!(browser.value("location.search"), "", "the token stands in no address");
    picture(&mut browser, "workbench-home.png");
    files_are_dropped(&mut browser, &campaigns, &server.url);
    browser.click("a[href^='/bench/']");
    browser.until("document.getElementById('view')?.dataset.frames > 0", PATIENCE);
    settled(&mut browser, 1);
    part_is_turned_read_and_cut(&mut browser, &server, &campaigns);
    before_is_shown_beside_after(&mut browser);
    effect_is_added(&mut browser, &campaign);
    two_models_are_compared(&mut browser);
    slider_is_dragged(&mut browser);
    formula_is_typed(&mut browser);
    report_is_the_calibration(&mut browser, &out);
    fits_a_phone(&mut browser, "workbench-phone.png");
    assert_eq!(browser.console, [""; 0], "the console");
    everything_is_there_after_the_server_was_ended(&mut browser, &campaigns, &out);
}

/// Drops the files of a trial on the first page, reads the draft, and keeps the trial with its own `trial.toml`.
fn files_are_dropped(browser: &mut Browser, folder: &Path, url: &str) {
    let source = bundled().join("trial-2");
    let mut files = Vec::new();
    for entry in fs::read_dir(&source).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name != "trial.toml" {
            files.push(json!([name, fs::read_to_string(source.join(&name)).unwrap()]));
        }
    }
    let dropped = format!(
        "(() => {{ const data = new DataTransfer();
        for (const [name, text] of {}) data.items.add(new File([text], name));
        document.getElementById('drop').dispatchEvent(new DragEvent('drop', {{ dataTransfer: data }})); }})()",
        json!(files)
    );
    browser.value(&dropped);
    browser
        .value("document.getElementById('campaign').value = 'second'; document.getElementById('trial').value = 'two'");
    browser.click("#files button");
    browser.until("!document.getElementById('draft').hidden", 60);
    picture(browser, "workbench-drop.png");
    let draft = browser.value("document.getElementById('draft-text').value");
    assert!(draft.as_str().unwrap().contains("before.csv"), "{draft}");
    let own = json!(fs::read_to_string(source.join("trial.toml")).unwrap());
    browser.value(&format!("document.getElementById('draft-text').value = {own}"));
    browser.click("#draft button");
    browser.until("document.getElementById('open-trial')?.getAttribute('href').startsWith('/bench/')", 60);
    assert!(folder.join("second").join("two").join("trial.toml").is_file());
    browser.open(url);
}

/// Returns the page's address of the bench.
fn bench(browser: &mut Browser) -> String {
    browser.value("document.getElementById('bench').dataset.address").as_str().unwrap().to_owned()
}

fn effect_is_added(browser: &mut Browser, campaign: &Path) {
    let base = shown_error(browser);
    browser.until("document.querySelectorAll('#suspects tbody tr').length === 2", 20);
    let first = browser.value("document.querySelector('#suspects tbody th').textContent");
    assert_eq!(first, EFFECT, "the likeliest is first");
    next_trial_is_downloaded(browser);
    browser.click("#suspects tbody button");
    browser.until("!document.getElementById('progress').hidden", 20);
    settled(browser, 2);
    let with = shown_error(browser);
    let measurements = Measurements::read(campaign).unwrap();
    let (base_expected, expected) = calibrated(&measurements);
    println!("the error falls from {base:.3} to {with:.3} µm; calibrate gives {base_expected:.3} and {expected:.3} µm");
    assert_eq!((base, with), (base_expected, expected));
    assert!(with < base);
    browser.until("document.querySelector('#panel-waterfall svg')", 20);
    assert!(browser.value("document.getElementById('panel-waterfall').textContent").as_str().unwrap().contains(EFFECT));
    browser.value("scrollTo(0, 0)");
    picture(browser, "workbench.png");
    browser.click("#undo");
    settled(browser, 1);
    assert_eq!(shown_error(browser), base);
    browser.click("#redo");
    settled(browser, 2);
    assert_eq!(shown_error(browser), with);
}

/// Downloads the next trial that the study proposes.
fn next_trial_is_downloaded(browser: &mut Browser) {
    let words = browser.value("document.getElementById('next-trial').textContent");
    assert!(words.as_str().unwrap().contains("Grind twice as long."), "{words}");
    let bytes = browser.value(
        "fetch(document.querySelector('#next-trial a').href).then(async (answer) => [...new Uint8Array(await answer.arrayBuffer())])",
    );
    let bytes: Vec<u8> = serde_json::from_value(bytes).unwrap();
    let mut packed = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let mut text = String::new();
    packed.by_name("next-trial/trial.toml").unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(text, PLAN);
}

fn slider_is_dragged(browser: &mut Browser) {
    let drag = "(() => { const s = document.querySelector('#sliders input'); \
                s.value = +s.value + 0.05 * (s.max - s.min); s.dispatchEvent(new Event('input', {bubbles: true})); })()";
    browser.value(drag);
    browser.until("document.getElementById('held-words')?.dataset.isFine === 'true'", PATIENCE);
    let words = browser.value("document.getElementById('held-words').textContent");
    let coarse = browser.value("document.getElementById('held-words').dataset.coarse");
    println!("the slider was answered after {coarse} s: {words}");
    browser.until("document.body.dataset.idle === 'true'", PATIENCE);
}

fn formula_is_typed(browser: &mut Browser) {
    let typed = |line: &str| {
        format!(
            "(() => {{ const f = document.getElementById('formula-line'); f.value = {}; \
             f.dispatchEvent(new Event('input', {{bubbles: true}})); }})()",
            json!(line)
        )
    };
    browser.value(&typed("rate + ground_volume"));
    browser.until("document.getElementById('formula-words').className === 'bad'", 20);
    browser.value(&typed("rate * exp(-ground_volume / a)"));
    browser.until("document.getElementById('formula-words').className === 'good'", 20);
    assert_eq!(browser.value("document.querySelector('#own button').disabled"), false);
}

fn report_is_the_calibration(browser: &mut Browser, out: &Path) {
    let page = bench(browser);
    let html = browser.value(&format!("fetch('{page}/stage/2/report.html').then((answer) => answer.text())"));
    let kept = fs::read_dir(out).unwrap().next().unwrap().unwrap().path();
    let file = fs::read_to_string(kept.join("2").join("report.html")).unwrap();
    assert!(html.as_str().unwrap() == file && file.contains("Calibrated"), "the report is the file");
    let commands = browser.value("document.getElementById('commands').textContent");
    let commands = commands.as_str().unwrap();
    assert!(commands.contains(&format!("robofin effects add replay/2.toml {EFFECT}")), "{commands}");
    let numbers: Value =
        serde_json::from_str(&fs::read_to_string(kept.join("2").join("calibration.json")).unwrap()).unwrap();
    assert!(numbers["chi2"].is_number());
}

/// Narrows the page to the width of a phone: nothing reaches beyond it.
fn fits_a_phone(browser: &mut Browser, name: &str) {
    let size = json!({ "width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": false });
    browser.call("Emulation.setDeviceMetricsOverride", size);
    let beyond = browser.value("document.documentElement.scrollWidth - document.documentElement.clientWidth");
    picture(browser, name);
    let elements = "[...document.querySelectorAll('*')].filter((e) => getComputedStyle(e.parentElement ?? e).overflowX === 'visible' \
                    && e.getBoundingClientRect().right > document.documentElement.clientWidth).map((e) => `${e.tagName} ${e.id}`)";
    assert_eq!(beyond, 0, "pixels beyond the page: {}", browser.value(elements));
    browser.call("Emulation.clearDeviceMetricsOverride", json!({}));
}

fn everything_is_there_after_the_server_was_ended(browser: &mut Browser, folder: &Path, out: &Path) {
    // The first server still locks the folder: a second one must be refused with a message.
    let second = serve(folder, out);
    browser.open(&second.url);
    browser.click("a[href^='/bench/']");
    browser.until("document.getElementById('fault')?.textContent.includes('another workbench is open')", PATIENCE);
    let moved = folder.with_extension("after");
    copy(out, &moved);
    fs::read_dir(&moved).unwrap().for_each(|own| {
        let _absent = fs::remove_file(own.unwrap().path().join(".workbench.lock"));
    });
    let third = serve(folder, &moved);
    browser.open(&third.url);
    browser.click("a[href^='/bench/']");
    browser.until("document.querySelectorAll('#stages li').length === 2", PATIENCE);
    assert!(browser.value("document.getElementById('panel-waterfall').textContent").as_str().is_some());
    fs::remove_dir_all(moved).unwrap();
}
