//! Content of the page: every number, escaped text, full values of rounded numbers.

use lab::Verdict;
use report::study::page;
use serde_json::Value;
use study::{Conclusion, Maps};

use crate::study::grinding;

/// Parses the JSON block of a page.
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
    values.extend(report.suspects.iter().flat_map(|s| [s.probability, s.delta_chi2]));
    values.extend(report.suspects.iter().filter_map(|s| s.evaluation_rms_after));
    values.extend(report.parameters.iter().map(|p| p.value));
    values.extend(report.parameters.iter().filter_map(|p| p.interval).flatten());
    values.extend(report.volumes.iter().flat_map(|v| [v.measured, v.base, v.uncertainty]));
    values.extend(report.covariates.iter().flat_map(|c| [c.share, c.drop, c.p_value, c.p_value_of_all]));
    values.extend(report.detectable.iter().filter_map(|d| d.size));
    values.extend(report.tests.iter().map(|t| t.statistic));
    let next = report.next_trial.as_ref().expect("a next trial");
    let choice = next.choice.as_ref().expect("a menu");
    let worths = [choice.worth].into_iter().chain(choice.runners_up.iter().map(|line| line.worth));
    values.push(next.probability_right);
    values.extend(
        worths.flat_map(|worth| [worth.minutes, worth.expected_information_nats, 60.0 * worth.nats_per_minute]),
    );
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
        ">on its greatest value</td>",
        ">not identifiable from these data</td>",
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

/// Returns the text after a mark, up to another one, without tags.
fn text_between<'a>(html: &'a str, from: &str, to: &str) -> &'a str {
    let (_, rest) = html.split_once(from).expect(from);
    rest.split_once(to).expect(to).0
}

#[test]
fn each_error_at_a_glance_stands_beside_the_floor_of_the_same_passes() {
    let mut report = grinding(2, 60, 40);
    let floor = report.waterfall.steps.last_mut().expect("the floor");
    (floor.calibration, floor.evaluation) = (Some(2.1e-6), Some(2.6e-6));
    let html = page(&report);
    let glance = text_between(&html, "<dl class=\"glance\">", "</dl>");
    let floors: Vec<&str> = glance.split("noise floor <span data-value=\"").skip(1).collect();
    let passes = glance.split("<dd class=\"of\">").skip(1).map(|rest| rest.split(';').next().unwrap_or_default());
    assert_eq!(
        passes.take(4).collect::<Vec<_>>(),
        ["evaluation passes", "calibration passes", "evaluation passes", "calibration passes"]
    );
    assert_eq!(floors.len(), 4, "{glance}");
    assert!(floors[0].contains(">2.60 µm<") && floors[1].contains(">2.10 µm<"), "{glance}");
    report.waterfall.steps.last_mut().expect("the floor").evaluation = None;
    let html = page(&report);
    let glance = text_between(&html, "<dl class=\"glance\">", "</dl>");
    assert_eq!(
        glance.matches("noise floor").count(),
        2,
        "the floor of calibration passes is not that of others: {glance}"
    );
}

#[test]
fn a_comparison_has_no_suspects_no_next_trial_and_no_columns_of_an_effect() {
    let mut report = grinding(2, 60, 40);
    assert!(page(&report).contains("with effect [mm³]"));
    report.volumes.iter_mut().for_each(|volume| volume.with_effect = None);
    report.waterfall.steps.iter_mut().for_each(|step| step.unexplained = None);
    report.conclusion = Conclusion::Differs;
    let html = page(&report);
    assert!(!html.contains("with effect [mm³]") && html.contains("model [mm³]"));
    assert!(!html.contains("still unexplained"), "no step has such a share");
    assert!(!html.contains("id=\"suspects\"") && !html.contains("id=\"next\""), "nothing was searched for");
}

#[test]
fn both_tables_state_one_error_for_the_volume_of_a_pass() {
    let mut report = grinding(2, 60, 40);
    for volume in &mut report.volumes {
        volume.base = 1.0614 * volume.measured;
    }
    for step in &mut report.waterfall.steps {
        step.volume_errors = vec![Some((0.0614, 0.02)); 2];
    }
    let html = page(&report);
    assert!(html.contains(">6.1 ± 2.0 %</td>") && html.contains(">6.1 %</td>"));
    assert_eq!(html.matches("the volume that each pass removed, with scans").count(), 2, "one name in both captions");
}

#[test]
fn units_have_raised_powers_and_shares_no_negative_zero() {
    let mut report = grinding(1, 60, 40);
    report.compared.notes = vec!["dulling.volume is on its greatest value, 300 mm^3".into()];
    report.volumes[0].base = report.volumes[0].measured * (1.0 - 4e-4);
    let html = page(&report);
    assert!(html.contains(">mm³/(N m)</td>") && html.contains("300 mm³"));
    assert!(!html.contains("mm^3") && !html.contains("−0.0 %") && !html.contains("-0.0 %"));
}

#[test]
fn without_rivals_the_page_says_what_another_trial_would_buy() {
    let mut report = grinding(1, 60, 40);
    report.next_trial = None;
    let next = |report| text_between(&page(&report), "id=\"next\"", "<h2").to_owned();
    for (verdict, words) in [
        (Verdict::Identified, "intervals of its parameters about 0.7 times as wide"),
        (Verdict::NothingMissing, "least detectable sizes"),
        (Verdict::NotTestable, "other forces, feeds and spindle speeds"),
        (Verdict::Unknown, "what the remaining error depends on"),
    ] {
        let text = next(study::StudyReport { conclusion: Conclusion::Searched(verdict), ..report.clone() });
        assert!(text.contains(words) && text.contains("grit-dulling.rate"), "{verdict:?}: {text}");
        assert!(!text.contains("Chance that it names"), "{text}");
    }
}

#[test]
fn the_name_of_the_band_lies_within_its_drawing() {
    let html = page(&grinding(1, 60, 40));
    let (drawing, _) = html.split_once("band [µm]</text>").expect("the band has a name");
    let number = |text: &str| text.split(['"', ' ']).next().and_then(|n| n.parse::<f64>().ok()).expect("a number");
    let view = drawing.rsplit("viewBox=\"").next().expect("a drawing");
    let height = number(view.split(' ').nth(3).expect("four numbers"));
    let baseline = number(drawing.rsplit(" y=\"").next().expect("a place"));
    // Descenders of a font reach less than 0.3 of its size, here 11 px.
    assert!(baseline + 0.3 * 11.0 <= height, "the text at {baseline} is cut at {height}");
}
