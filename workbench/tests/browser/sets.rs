//! Data sets in the browser: a table is filtered and sorted, an item opened; labels are laid over images.

use std::fs;

use serde_json::json;

use crate::common::devtools::Browser;
use crate::common::serve;
use crate::common::sets::{HOSTILE, line, row, write_assets, write_images};
use crate::{fits_a_phone, picture};

/// Gives a field a value, as a user does.
fn fill(browser: &mut Browser, selector: &str, value: &str) {
    browser.value(&format!(
        "(() => {{ const field = document.querySelector({}); field.value = {};
        field.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()",
        json!(selector),
        json!(value)
    ));
}

fn shown(browser: &mut Browser) -> f64 {
    browser.value("+document.getElementById('shown').dataset.count").as_f64().unwrap()
}

fn first_item(browser: &mut Browser) -> String {
    let first = browser.value("document.querySelector('#items tbody th').textContent");
    first.as_str().unwrap().to_owned()
}

#[test]
fn assets_are_filtered_sorted_and_opened() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut rows = vec![row("a-0000", HOSTILE, 61.5, "train"), row("b-0000", "plate.obj", 20.0, "test")];
    rows.extend((0..98).map(|k| row(&format!("c-{k:04}"), "plate.obj", 21.0 + f64::from(k) / 10.0, "train")));
    write_assets(&folder.path().join("set"), &rows);
    let server = serve(folder.path(), &folder.path().join("out"));
    browser.open(&server.url);
    browser.follow("a[href^='/set/']");
    browser.until("document.querySelectorAll('#items tbody tr').length === 50", 20);
    assert_eq!(shown(&mut browser), 100.0);
    assert_eq!(browser.value("document.querySelector('#items tbody .name').textContent"), HOSTILE, "markup is text");
    assert_eq!(browser.value("document.querySelectorAll('#items tbody img').length"), 25, "one item in two has one");
    assert!(browser.value("document.getElementById('failures').textContent").as_str().unwrap().contains("<b>623</b>"));
    picture(&mut browser, "workbench-assets.png");
    fill(&mut browser, "[name=source]", "ü\"");
    assert_eq!((shown(&mut browser), first_item(&mut browser).as_str()), (1.0, "a-0000"));
    fill(&mut browser, "[name=source]", "");
    fill(&mut browser, "[name='length at most']", "22");
    fill(&mut browser, "[name=split]", "train");
    assert_eq!(shown(&mut browser), 11.0, "c-0000 to c-0010");
    browser.value("document.querySelector('#filters [type=reset]').click()");
    browser.until("document.getElementById('shown').dataset.count === '100'", 20);
    let length =
        "[...document.querySelectorAll('#items thead button')].find((b) => b.textContent.startsWith('length'))";
    browser.value(&format!("{length}.click()"));
    assert_eq!(first_item(&mut browser), "b-0000");
    browser.value(&format!("{length}.click()"));
    assert_eq!(first_item(&mut browser), "a-0000");
    assert_eq!(browser.value("document.querySelector('[aria-sort=descending]').textContent"), "length [mm] \u{25be}");
    browser.click("#following");
    assert_eq!(browser.value("document.getElementById('page').textContent"), "page 2 of 2");
    browser.click("#items tbody button");
    browser.until("!document.getElementById('item').hidden", 20);
    let item = browser.value("document.getElementById('item').textContent");
    assert!(item.as_str().unwrap().contains("exposure min"), "{item}");
    fits_a_phone(&mut browser, "workbench-assets-phone.png");
    assert_eq!(browser.console, [""; 0], "the console");
}

#[test]
fn labels_lie_over_images_as_strongly_as_the_slider_says() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("images");
    let lines: Vec<_> = (0..30)
        .map(|k| {
            line(
                &format!("ü'{k:02}"),
                if k < 5 { "tee" } else { "lap" },
                &json!({ "rust": if k == 7 { Some(1) } else { None } }),
            )
        })
        .collect();
    write_images(&set, &lines);
    let server = serve(folder.path(), &folder.path().join("out"));
    browser.open(&server.url);
    browser.follow("a[href^='/set/']");
    browser.until("document.querySelectorAll('#images figure').length === 24", 20);
    for layer in ["appearance", "dose", "instances", "depth", "amodal"] {
        fill(&mut browser, "#layer", layer);
        browser.until("document.querySelector('#images .over')?.complete && document.querySelector('#images .over').naturalWidth === 64", 20);
    }
    fill(&mut browser, "#layer", "appearance");
    browser.until("document.querySelector('#images .over')?.naturalWidth === 64", 20);
    picture(&mut browser, "workbench-images.png");
    fill(&mut browser, "#blend", "25");
    assert_eq!(browser.value("getComputedStyle(document.querySelector('#images .over')).opacity"), "0.25");
    fill(&mut browser, "[name=workpiece]", "tee");
    assert_eq!(shown(&mut browser), 5.0);
    fill(&mut browser, "[name=workpiece]", "");
    fill(&mut browser, "[name=looks]", "rust");
    assert_eq!(shown(&mut browser), 1.0);
    let card = browser.value("document.querySelector('#images figure').textContent");
    assert!(card.as_str().unwrap().contains("ü'07") && card.as_str().unwrap().contains("25 %"), "{card}");
    fits_a_phone(&mut browser, "workbench-images-phone.png");
    assert_eq!(browser.console, [""; 0], "the console");
    fs::remove_file(set.join("train/images/ü'07.png")).unwrap();
    fill(&mut browser, "#layer", "dose");
    browser.until("document.querySelector('#images .bad')?.textContent.includes('missing')", 20);
}
