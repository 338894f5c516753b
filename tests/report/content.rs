//! What a reader finds: every number, safe text, the full values behind rounded ones.

use robofin::study_report::{Maps, page};
use serde_json::Value;

use crate::study::grinding;

/// The JSON block of a page.
fn diagnosis(html: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"diagnosis\">";
    let (_, rest) = html.split_once(start).expect("the block is there");
    serde_json::from_str(rest.split_once("</script>").expect("it ends").0).expect("it is JSON")
}

#[test]
fn the_answer_of_the_diagnosis_comes_back_from_the_page() {
    let report = grinding(1, 60, 40);
    let html = page(&report);
    assert_eq!(diagnosis(&html), report.diagnosis);
    assert!(!html.contains("alert(1)</script>"), "a string cannot end the block");
}

#[test]
fn full_values_stand_behind_the_cells() {
    let report = grinding(2, 60, 40);
    let html = page(&report);
    let mut values: Vec<f64> = report.waterfall.steps.iter().filter_map(|step| step.evaluation).collect();
    values.extend(report.waterfall.steps.iter().flat_map(|s| s.volume_errors.iter().flatten().map(|v| v.0)));
    values.extend(report.waterfall.steps.iter().filter_map(|step| step.plateau_slope));
    values.extend(report.suspects.iter().flat_map(|s| [s.probability, s.gain]));
    values.extend(report.suspects.iter().filter_map(|s| s.evaluation_after));
    values.extend(report.parameters.iter().map(|p| p.value));
    values.extend(report.parameters.iter().filter_map(|p| p.interval).flatten());
    values.extend(report.volumes.iter().flat_map(|v| [v.measured, v.base, v.uncertainty]));
    values.extend(report.covariates.iter().flat_map(|c| [c.share, c.drop, c.p_value, c.p_value_of_all]));
    values.extend(report.detectable.iter().filter_map(|d| d.size));
    values.extend(report.tests.iter().map(|t| t.statistic));
    values.extend(report.next_trial.iter().filter_map(|next| next.chance));
    assert!(values.len() > 40, "{}", values.len());
    for value in values {
        let json = serde_json::to_string(&value).expect("a number");
        assert!(html.contains(&format!("data-value=\"{json}\"")), "{json} is not on the page");
    }
}

#[test]
fn shown_numbers_are_in_their_units() {
    let html = page(&grinding(2, 60, 40));
    for shown in [
        ">13.7</td>",
        ">2.42</td>",
        ">94.1 %</td>",
        ">0.01234</td>",
        ">6.1 ± 2.0 %</td>",
        ">0.93</td>",
        ">6000</td>",
        ">1.73</td>",
        ">on a bound</td>",
        ">not identifiable</td>",
        ">held fixed</td>",
        ">none shows</td>",
        "&lt; 0.001",
    ] {
        assert!(html.contains(shown), "{shown}");
    }
    assert!(html.contains("&lt;12&gt; pixels &amp; 3 spikes") && html.contains("&lt;named&gt; &amp; edited"));
}

#[test]
fn figures_of_a_map_are_those_of_its_judged_pixels() {
    let report = grinding(1, 80, 40);
    let Maps::Heights(maps) = &report.scans[0].maps else { panic!("heights") };
    let judged = maps.base.iter().zip(&maps.judged).filter(|(r, judged)| **judged && r.is_finite()).map(|(r, _)| *r);
    let all: Vec<f64> = judged.collect();
    let rms = (all.iter().map(|r| r * r).sum::<f64>() / all.len() as f64).sqrt();
    let within = all.iter().filter(|r| r.abs() <= 3.0 * maps.noise_floor).count() as f64 / all.len() as f64;
    let html = page(&report);
    assert!(html.contains(&format!(">{:.2}</td>", rms * 1e6)), "{rms}");
    assert!(html.contains(&format!(">{:.1} %</td>", within * 100.0)), "{within}");
    assert!(html.contains("±6.3 µm"), "the band is stated");
}
