//! The page in headless Chromium: open a campaign, turn the part, read values, cut a section, add an effect; the error
//! falls to that of a calibration. Also undo, a formula, a slider and the report; the browser's console stays empty.
//!
//! With `ROBOFIN_PICTURES=DIR` the pictures of the documents are written there.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::devtools::Browser;
use common::http::own;
use common::{Server, bundled, copy, serve};
use effects::{Library, Model};
use lab::{Calibration, CalibrationSummary, Order};
use serde_json::{Value, json};
use study::Measurements;

/// Longest time of a fit on this campaign on a busy machine [s].
const PATIENCE: u64 = 600;
/// Turns the part for three seconds, and returns the frames per second.
const TURNING: &str = "(async () => {
    const view = document.getElementById('view');
    const [before, since] = [+view.dataset.frames, performance.now()];
    while (performance.now() - since < 3000) {
        view.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true }));
        await new Promise((done) => { setTimeout(done, 20); });
    }
    return [(view.dataset.frames - before) / 3, view.dataset.scale];
})()";
/// Effect added in the test.
const EFFECT: &str = "grit-dulling";

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
    }));
    fs::write(folder.join(study::STUDY_FILE), serde_json::to_string(&record).unwrap()).unwrap();
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
    effect_is_added(&mut browser, &campaign);
    two_models_are_compared(&mut browser);
    slider_is_dragged(&mut browser);
    formula_is_typed(&mut browser);
    report_is_the_calibration(&mut browser, &out);
    picture_on_a_phone(&mut browser);
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

/// Shows the way of the tool, and moves its bar to the middle of the pass: the force is that of the log.
fn tool_moves_along_its_way(browser: &mut Browser) {
    browser.click("#way");
    browser.until("!document.getElementById('time').hidden", 30);
    browser.value(
        "(() => { const bar = document.getElementById('moment'); bar.value = bar.max / 2;
        bar.dispatchEvent(new Event('input')); })()",
    );
    let moments = browser.value("+document.getElementById('moment').max").as_f64().unwrap();
    let force = browser.value("+document.getElementById('moment-words').dataset.force").as_f64().unwrap();
    let log = fs::read_to_string(bundled().join("trial-1").join("pass2_log.csv")).unwrap();
    let column = log.lines().next().unwrap().split(',').position(|name| name == "force_n").unwrap();
    let forces: Vec<f64> =
        log.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    assert!(moments > 50.0 && forces.contains(&force), "{force} N of {moments} moments");
    browser.until("document.getElementById('view').dataset.fine === 'true'", 60);
    picture(browser, "workbench-way.png");
    browser.click("#way");
}

/// Colours the part by the mean pressure of the pass.
fn condition_is_shown(browser: &mut Browser) {
    let choose = |mode: &str| {
        format!(
            "(() => {{ const mode = document.getElementById('mode'); mode.value = '{mode}';
            mode.dispatchEvent(new Event('change')); }})()"
        )
    };
    browser.value(&choose("covariate 0"));
    browser.until("document.getElementById('legend').textContent.includes('mean pressure [MPa]')", 60);
    picture(browser, "workbench-condition.png");
    browser.value(&choose("deviation"));
    browser.until("document.getElementById('legend').textContent.includes('simulated')", 60);
}

/// Drags a box over half of the track: each pass of the trial is listed, and conditions differ.
fn region_is_looked_at(browser: &mut Browser) {
    browser.click("#mark");
    browser.value("document.getElementById('view').scrollIntoView()");
    let [x, y] = browser.middle("#view");
    browser.pointer([x - 90.0, y + 40.0], [x, y - 40.0]);
    browser.until("document.querySelector('#region p[data-tiles]')", 30);
    let tiles = browser.value("+document.querySelector('#region p').dataset.tiles").as_f64().unwrap();
    let rows = |browser: &mut Browser, table: u32| {
        let count = format!("document.querySelectorAll('#region table:nth-of-type({table}) tbody tr').length");
        browser.value(&count).as_f64().unwrap()
    };
    let passes = browser.value("document.getElementById('pass').options.length").as_f64().unwrap();
    assert!(tiles > 3.0, "{tiles} tiles");
    assert_eq!((rows(browser, 1), rows(browser, 2)), (passes, 8.0));
    let place = "document.querySelector('#region table:nth-of-type(2)').textContent.includes('place along x')";
    assert_eq!(browser.value(place), true, "a box over one half lies at other x");
    browser.value("document.getElementById('region').scrollIntoView()");
    picture(browser, "workbench-region.png");
}

fn part_is_turned_read_and_cut(browser: &mut Browser, server: &Server, folder: &Path) {
    browser.until("document.getElementById('whose').value === 'simulated'", 20);
    browser.value("document.getElementById('view').scrollIntoView()");
    let [x, y] = browser.middle("#view");
    let frames = browser.value("+document.getElementById('view').dataset.frames").as_f64().unwrap();
    browser.pointer([x, y], [x + 90.0, y - 25.0]);
    browser.until(&format!("+document.getElementById('view').dataset.frames > {frames}"), 30);
    browser.until("document.getElementById('view').dataset.fine === 'true'", 60);
    println!("turning: frames a second and share of 640 × 480 along each side: {}", browser.value(TURNING));
    browser.value("document.getElementById('view').dataset.fine = ''; document.getElementById('reset').click()");
    browser.until("document.getElementById('view').dataset.fine === 'true'", 60);
    browser.pointer([x, y + 20.0], [x, y + 20.0]);
    browser.until("document.querySelector('#reading [data-key=zMm]')", 30);
    let read = |browser: &mut Browser, key: &str| {
        browser.value(&format!("+document.querySelector('#reading [data-key={key}]').dataset.value")).as_f64().unwrap()
    };
    let [at_x, at_y, at_z, removed] = ["xMm", "yMm", "zMm", "removedUm"].map(|key| read(browser, key));
    value_is_that_of_the_field(folder, [at_x, at_y, at_z], removed);
    browser.click("#cut");
    browser.value("document.getElementById('view').scrollIntoView()");
    let [x, y] = browser.middle("#view");
    browser.pointer([x - 20.0, y + 60.0], [x + 20.0, y - 50.0]);
    browser.until("document.querySelector('#section svg')", 30);
    let rms = browser.value("+document.querySelector('#section figcaption').dataset.rms").as_f64().unwrap();
    assert!(rms > 0.1 && rms < 1e3, "{rms} µm along the section");
    browser.value("document.getElementById('view').scrollIntoView()");
    picture(browser, "workbench-part.png");
    tool_moves_along_its_way(browser);
    region_is_looked_at(browser);
    condition_is_shown(browser);
    browser.click("#turn");
    let page = bench(browser);
    let answer = own(
        server.address,
        &format!(
            "GET {page}/frame?trial=9&pass=0&whose=measured&mode=removed&azimuth=0&elevation=60&zoom=1&right=0&up=0&width=64&height=48&fine=false"
        ),
        "",
    );
    assert_eq!(answer.status, 404, "{}", answer.body);
}

/// Simulates the fitted model of the page again, and compares the position and value at a pixel with its field.
fn value_is_that_of_the_field(folder: &Path, at_mm: [f64; 3], removed_um: f64) {
    let kept = fs::read_dir(folder.join("kept")).unwrap().next().unwrap().unwrap().path();
    let text = fs::read_to_string(kept.join("1").join("model.toml")).unwrap();
    let library = Library::builtin();
    let model = Model::parse("model.toml", &text, library).unwrap();
    let measurements = Measurements::read(&folder.join("first-look")).unwrap();
    let data = measurements.data().unwrap();
    let (_, evidence) = data.scans().unwrap();
    let model = effects::CompiledModel::new(&model, library, lab::Evidence::rows(evidence)).unwrap();
    let own = &evidence.simulation.trials[0];
    let mut state = own.start(&model, trial_simulation::Simulation::fresh_states(&model), 0);
    for _ in &own.trial.passes {
        own.run_pass(&model, &mut state, &mut |_| {}).unwrap();
    }
    let point = glam::DVec3::from(at_mm) * 1e-3;
    let distance = f64::from(state.part.sample(point));
    assert!(distance.abs() < 1e-3 * state.part.voxel, "{point} is {distance} m from the field's surface");
    let before = render::Field::new(&own.part);
    let depth = 1e6 * render::removed_depth(&before, point, state.part.normal(point));
    // The picture's normal is interpolated between cells, the field's is not: on a bead they differ by a degree.
    assert!((depth - removed_um).abs() < 0.02 * depth, "{removed_um} µm were read, and the field has {depth} µm");
}

fn effect_is_added(browser: &mut Browser, campaign: &Path) {
    let base = shown_error(browser);
    browser.until("document.querySelectorAll('#suspects tbody tr').length === 2", 20);
    let first = browser.value("document.querySelector('#suspects tbody th').textContent");
    assert_eq!(first, EFFECT, "the likeliest is first");
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

/// Shows the model before beside the current one: the pictures differ, because the error is lower.
fn two_models_are_compared(browser: &mut Browser) {
    browser.value("document.getElementById('view').scrollIntoView()");
    assert_eq!(browser.value("document.getElementById('beside').options.length"), 2);
    let frames = browser.value("+document.getElementById('view').dataset.frames").as_f64().unwrap();
    browser.value(
        "(() => { const one = document.getElementById('beside'); one.value = '1'; one.dispatchEvent(new Event('change')); })()",
    );
    // A picture that was under way, a coarse one and a fine one.
    let drawn = format!("+document.getElementById('view').dataset.frames >= {frames} + 2");
    browser.until(&format!("{drawn} && document.getElementById('view').dataset.fine === 'true'"), 60);
    assert_eq!(browser.value("document.getElementById('other').dataset.model"), "1");
    let differ = "(() => { const pixels = ['view', 'other'].map((id) =>
            document.getElementById(id).getContext('2d').getImageData(0, 0, 640, 480).data);
        return pixels[0].filter((value, at) => Math.abs(value - pixels[1][at]) > 20).length; })()";
    let differ = browser.value(differ).as_f64().unwrap();
    assert!(differ > 1000.0, "{differ} values of 640 × 480 × 4 differ");
    picture(browser, "workbench-beside.png");
    browser.value(
        "(() => { const one = document.getElementById('beside'); one.value = ''; one.dispatchEvent(new Event('change')); })()",
    );
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

fn picture_on_a_phone(browser: &mut Browser) {
    let size = json!({ "width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": false });
    browser.call("Emulation.setDeviceMetricsOverride", size);
    let wide = browser.value("document.documentElement.scrollWidth").as_f64().unwrap();
    picture(browser, "workbench-phone.png");
    let beyond = "[...document.querySelectorAll('*')].filter((e) => e.getBoundingClientRect().right > 390 \
                  && getComputedStyle(e.parentElement ?? e).overflowX === 'visible').map((e) => `${e.tagName} ${e.id}`)";
    assert!(wide <= 390.0, "the page is {wide} px wide: {}", browser.value(beyond));
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
