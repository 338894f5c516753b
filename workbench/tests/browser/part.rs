//! Steps of the test on the part: turn, read, cut, look at a region, follow the tool, compare two models.

use std::fs;
use std::path::Path;

use effects::{Library, Model};
use study::Measurements;

use crate::common::devtools::{Browser, VIEW_BYTES};
use crate::common::http::own;
use crate::common::{Server, bundled};
use crate::{bench, picture};

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

pub fn part_is_turned_read_and_cut(browser: &mut Browser, server: &Server, folder: &Path) {
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

/// Number of values in the left and the right half of the picture that differ from those kept before.
fn differing(browser: &mut Browser) -> [f64; 2] {
    let count = format!(
        "(() => {{ const halves = [0, 0];
        {VIEW_BYTES}.forEach((value, k) => {{
            if (Math.abs(value - globalThis.kept[k]) > 20) halves[+(k / 4 % 640 >= 320)] += 1;
        }});
        return halves; }})()"
    );
    let halves = browser.value(&count);
    [0, 1].map(|half| halves[half].as_f64().unwrap())
}

/// Shows the surface before left of a divider, and moves it with keys and pointer.
pub fn before_is_shown_beside_after(browser: &mut Browser) {
    browser.value("document.getElementById('view').dataset.fine = ''; document.getElementById('reset').click()");
    browser.until("document.getElementById('view').dataset.fine === 'true'", 60);
    browser.value(&format!("globalThis.kept = {VIEW_BYTES}; null"));
    browser.value("document.getElementById('view').dataset.fine = ''");
    browser.click("#before");
    // A picture that was under way has no divider.
    let drawn =
        "(({ fine, divided }) => fine === 'true' && divided === 'true')(document.getElementById('view').dataset)";
    browser.until(drawn, 60);
    let [left, right] = differing(browser);
    assert!(left > 100.0 && right == 0.0, "{left} and {right} values differ");
    browser.value("document.getElementById('view').scrollIntoView()");
    picture(browser, "workbench-before.png");
    let press = |key: &str| {
        format!(
            "document.getElementById('divider').dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}))"
        )
    };
    let now = |browser: &mut Browser| {
        browser.value("+document.getElementById('divider').getAttribute('aria-valuenow')").as_f64().unwrap()
    };
    browser.value(&press("ArrowRight"));
    assert_eq!(now(browser), 52.0);
    browser.value(&press("Home"));
    assert_eq!((now(browser), differing(browser)), (0.0, [0.0, 0.0]));
    browser.value(&press("End"));
    assert!(now(browser) == 100.0 && differing(browser)[1] > 100.0);
    let [x, y] = browser.middle("#divider");
    let width = browser.value("document.getElementById('view').getBoundingClientRect().width").as_f64().unwrap();
    browser.pointer([x - 2.0, y], [x - 0.75 * width, y]);
    assert_eq!(now(browser), 25.0);
    browser.click("#before");
    browser.until("document.getElementById('divider').hidden", 20);
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
    let own = &evidence.simulation.trials()[0];
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

/// Shows the model before beside the current one: the pictures differ, because the error is lower.
pub fn two_models_are_compared(browser: &mut Browser) {
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
