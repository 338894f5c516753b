//! A weld in the browser: dials, a picture that follows them, a failure in words, a run that is made, cancelled, refused.

use std::fs;
use std::path::Path;

use files::program::Program;
use serde_json::json;

use crate::common::devtools::{Browser, VIEW_BYTES};
use crate::common::serve;
use crate::{fits_a_phone, picture};

/// Stands in for the program, which this crate does not build: prints its words, then does as the asset's name says.
const SCRIPT: &str = "for last in \"$@\"; do case \"$before\" in --out) out=\"$last\";; esac; before=\"$last\"; done\n\
                      echo \"      weld  $*\" >&2\n\
                      case \"$out\" in\n\
                      *slow*) sleep 60 & trap 'kill $!; exit 143' TERM; wait $!;;\n\
                      *wrong*) echo 'error: no place for the weld' >&2; exit 1;;\n\
                      *) mkdir -p \"$out\"; echo '{}' > \"$out/asset.json\";;\n\
                      esac\n";

/// Waits until the picture shows what was last asked for.
fn settled(browser: &mut Browser) {
    browser.until("document.getElementById('view')?.dataset.fine === 'true'", 120);
    browser.value("document.getElementById('view').dataset.fine = ''");
}

fn turn(browser: &mut Browser, selector: &str, value: &str) {
    browser.value(&format!(
        "(() => {{ const field = document.querySelector({}); field.value = {};
        field.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()",
        json!(selector),
        json!(value)
    ));
    settled(browser);
}

fn figure(browser: &mut Browser, key: &str) -> f64 {
    browser.value(&format!("+document.querySelector('#figures [data-key={key}]').dataset.value")).as_f64().unwrap()
}

/// Number of pixels in the colour of weld metal.
fn weld_pixels(browser: &mut Browser) -> f64 {
    let count = format!(
        "(() => {{ const data = {VIEW_BYTES};
        let count = 0;
        for (let k = 0; k < data.length; k += 4) if (data[k] > 1.6 * data[k + 2] + 40) count += 1;
        return count; }})()"
    );
    browser.value(&count).as_f64().unwrap()
}

fn make(browser: &mut Browser, name: &str) {
    browser.value(&format!("document.getElementById('name').value = {}", json!(name)));
    browser.click("#make button[type=submit]");
}

fn ended(browser: &mut Browser, how: &str) -> String {
    browser.until(&format!("document.getElementById('outcome').dataset.is === '{how}'"), 60);
    browser.value("document.getElementById('outcome').textContent").as_str().unwrap().to_owned()
}

#[test]
fn a_weld_is_dialled_and_its_asset_is_made() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join(".program");
    fs::write(&script, SCRIPT).unwrap();
    Program { file: script.clone(), start: vec!["sh".into(), script.into()] }.host();
    fs::write(folder.path().join("it's <b>.obj"), "v 0 0 0\nf 1 1 1\n").unwrap();
    let server = serve(folder.path(), &folder.path().join("out"));
    browser.open(&server.url);
    browser.follow("a[href='/weld']");
    settled(&mut browser);
    assert_eq!(browser.value("document.getElementById('failure').textContent.startsWith('Difficulty')"), true);
    let usual = weld_pixels(&mut browser);
    assert!(usual > 500.0, "{usual} pixels of weld metal");
    turn(&mut browser, "[data-name='--length-mm'] [type=range]", "40");
    assert!((figure(&mut browser, "lengthMm") - 40.0).abs() < 1e-6);
    println!("a dial was answered after {} ms", browser.value("document.getElementById('view').dataset.milliseconds"));
    turn(&mut browser, "[data-name='--width-mm'] .field", "8");
    assert!((figure(&mut browser, "widthMm") - 8.0).abs() < 1e-9);
    picture(&mut browser, "workbench-weld.png");
    let command = browser.value("document.getElementById('command').textContent");
    assert!(command.as_str().unwrap().contains("--length-mm 40 --place surface"), "{command}");
    turn(&mut browser, "[data-name='--exposure'] .field", "0.999");
    turn(&mut browser, "[data-name='--length-mm'] .field", "4000");
    let words = browser.value("document.getElementById('failure').textContent");
    assert!(words.as_str().unwrap().starts_with("No weld: "), "{words}");
    assert!(weld_pixels(&mut browser) < 20.0, "a weld is drawn where there is none");
    picture(&mut browser, "workbench-weld-failure.png");
    browser.click("#clear");
    settled(&mut browser);
    assets_are_made(&mut browser, folder.path());
    fits_a_phone(&mut browser, "workbench-weld-phone.png");
    assert_eq!(browser.console, [""; 0], "the console");
    broken_part_is_described(&mut browser);
}

fn assets_are_made(browser: &mut Browser, folder: &Path) {
    make(browser, "first");
    let words = ended(browser, "made");
    assert!(words.contains("Made in") && folder.join("first/asset.json").is_file(), "{words}");
    browser.until("document.querySelector('#outcome a')?.getAttribute('href').startsWith('/place/')", 20);
    make(browser, "wrong");
    assert_eq!(ended(browser, "failed"), "error: no place for the weld");
    make(browser, "slow");
    ended(browser, "runs");
    browser.until("!document.getElementById('cancel').hidden", 20);
    picture(browser, "workbench-weld-run.png");
    browser.click("#cancel");
    assert!(ended(browser, "cancelled").contains("nothing is left"));
    assert!(!folder.join("slow").exists());
}

/// A mesh that cannot be read is described in its reader's words.
fn broken_part_is_described(browser: &mut Browser) {
    browser.value(
        "(() => { const part = document.getElementById('part-file'); part.selectedIndex = 1;
        part.dispatchEvent(new Event('change')); })()",
    );
    browser.until("!document.getElementById('fault').hidden", 60);
    let words = browser.value("document.getElementById('fault').textContent");
    assert!(words.as_str().unwrap().starts_with("it's <b>.obj: "), "{words}");
}
