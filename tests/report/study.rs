//! Invented studies for the page: a bead ground twice, a sanded panel, a table of rows.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec2;
use lab::{
    Correlation, Detectable, EffectSummary, MenuChoice, MenuLine, NextTrial, ParameterState, ParameterSummary, Sides,
    StructureTest, Unfitted, Verdict, Worth,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::PixelGrid;
use serde_json::json;
use study::*;
use trials::measure::Registration;
use trials::trial::Role;

use crate::proposal::proposal;

const FLOOR: f64 = 2.1e-6;
const UM: f64 = 1e-6;

/// Makes a campaign of `scans` scans of `nx` by `ny` pixels with a dulled wheel.
pub fn grinding(scans: usize, nx: usize, ny: usize) -> StudyReport {
    let pass = |k: usize| format!("plate-{:02}, pass {}", k / 2 + 1, k % 2 + 1);
    let role = |k: usize| if k % 4 < 3 { Role::Calibration } else { Role::Evaluation };
    let passes: Vec<String> = (0..scans).map(pass).collect();
    let maps = (0..scans).map(|k| ScanComparison { pass: pass(k), role: role(k), maps: heights(k, nx, ny) });
    StudyReport {
        compared: Compared {
            campaign: "bracket welds, week 14".into(),
            model: "Preston with threshold; then grit-dulling".into(),
            tool: "wheel, radius 50 mm, width 20 mm".into(),
            passes: (0..scans).map(|k| compared_pass(pass(k), role(k), k)).collect(),
            pitch: Some(0.25e-3),
            voxel: Some(0.25e-3),
            blur: Some(118e-6),
            method: vec![
                "Each scan is laid on the surface that the tool left alone, with offset, tilt and lateral shift free in every fit.".into(),
                "The noise floor is that of the repeated scan before the first pass.".into(),
            ],
            notes: vec!["plate-02/before.csv: <12> pixels & 3 spikes were left out".into()],
        },
        conclusion: Conclusion::Searched(Verdict::Identified),
        sentence: "The wheel dulls with the volume it removes: adding grit-dulling takes the error of the evaluation passes from 13.7 to 2.4 µm, 1.15 times the noise floor.".into(),
        tests: vec![
            StructureTest { name: "excess of whitened squares".into(), statistic: 84.31, p_value: 1e-9, rejects: true },
            StructureTest { name: "neighbouring tiles agree (Moran)".into(), statistic: 0.412, p_value: 2e-4, rejects: true },
            StructureTest { name: "runs along sections".into(), statistic: -1.27, p_value: 0.204, rejects: false },
        ],
        waterfall: waterfall(&passes[..scans.min(4)]),
        volumes: passes.iter().enumerate().map(|(k, pass)| volume(pass, k)).collect(),
        scans: maps.collect(),
        sections: vec![section(Direction::Across(20e-3)), section(Direction::Across(70e-3)), section(Direction::AlongCrest)],
        covariates: covariates(),
        tiles: Vec::new(),
        suspects: suspects(),
        unfitted: vec![unfitted()],
        parameters: parameters(),
        correlations: correlations(),
        detectable: detectable(),
        next_trial: Some(next_trial()),
        proposal: Some(proposal()),
        provenance: provenance(),
        diagnosis: diagnosis(),
    }
}

fn compared_pass(name: String, role: Role, k: usize) -> ComparedPass {
    let alignment = Registration {
        offset: 12.31 * UM,
        tilt: DVec2::new(1.21e-4, -0.43e-4),
        shift: DVec2::new(14.2 * UM, -6.7 * UM),
        turn: 0.4e-3,
        centre: DVec2::ZERO,
        sigma: 2.24 * UM,
        pixels: 10_331 + k,
    };
    ComparedPass {
        name,
        role,
        force: Some([15.0, 20.0][k % 2]),
        feed: Some(5.0e-3),
        spindle_speed: Some(6000.0 * TAU / 60.0),
        noise_floor: Some(FLOOR),
        alignment: Some(alignment),
    }
}

/// Makes residual maps: a trough and a ripple in the track that the effect explains, with noise and holes.
fn heights(seed: usize, nx: usize, ny: usize) -> Maps {
    let pixels = PixelGrid { origin: DVec2::new(0.0, -10e-3), pitch: 0.25e-3, nx, ny };
    let mut random = Pcg64Mcg::seed_from_u64(seed as u64);
    let mut maps = (Vec::new(), Vec::new(), Vec::new());
    for at in 0..pixels.len() {
        let (u, v) = ((at % nx) as f64 / nx as f64, (at / nx) as f64 / ny as f64 - 0.5);
        let missing = random.random::<f64>() < 0.01 || at % nx == 0;
        let noise = FLOOR * ((0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0);
        let touched = v.abs() < 0.22;
        let shape =
            if touched { 28.0 * UM * (u - 0.35) * (1.0 - 8.0 * v * v) + 3.0 * UM * (60.0 * u).sin() } else { 0.0 };
        let value = |height: f64| if missing { f64::NAN } else { height };
        maps.0.push(value(shape + noise));
        maps.1.push(value(0.06 * shape + noise));
        maps.2.push(touched);
    }
    Maps::Heights(HeightMaps {
        pixels,
        base: maps.0,
        with_effect: Some(maps.1),
        judged: maps.2,
        judged_as: "that the tool touched".into(),
        noise_floor: FLOOR,
    })
}

fn waterfall(passes: &[String]) -> Waterfall {
    let step = |name: &str, um: [f64; 2], volume: f64, unexplained: Option<f64>| WaterfallStep {
        name: name.into(),
        calibration: Some(um[0] * UM),
        evaluation: Some(um[1] * UM),
        volume_errors: passes
            .iter()
            .enumerate()
            .map(|(k, _)| Some((volume * (1.0 + 0.1 * k as f64), 0.0203)))
            .collect(),
        unexplained,
        plateau_slope: Some(um[0] * 1e-5),
        overlap: None,
    };
    let floor = WaterfallStep {
        name: "noise floor".into(),
        calibration: Some(FLOOR),
        evaluation: Some(FLOOR),
        ..WaterfallStep::default()
    };
    let steps = vec![
        step("raw", [311.7, 287.3], 0.1531, None),
        step("registered", [48.13, 44.61], 0.0921, None),
        step("base model", [12.41, 13.73], 0.0614, Some(1.0)),
        step("+ grit-dulling", [2.317, 2.419], -0.0042, Some(0.0131)),
        floor,
    ];
    Waterfall {
        misfit: Misfit::heights(),
        passes: passes.to_vec(),
        steps,
        notes: vec!["The two effects share 31 % of the fall.".into()],
    }
}

fn volume(pass: &str, k: usize) -> PassVolume {
    let measured = (140.0 + 3.7 * k as f64) * 1e-9;
    PassVolume {
        pass: pass.into(),
        measured,
        uncertainty: 2.84e-9,
        base: 1.0614 * measured,
        with_effect: Some(0.9958 * measured),
    }
}

fn section(direction: Direction) -> ScanSection {
    let count = 160;
    let position: Vec<f64> = (0..count).map(|i| -10e-3 + 0.125e-3 * i as f64).collect();
    let bead = |y: f64| (1.6e-3 * (1.0 - (y / 4e-3).powi(2))).clamp(0.0, 0.9e-3);
    let ripple = |y: f64| 18.0 * UM * (-(y / 3e-3).powi(2)).exp();
    let heights = |share: f64| position.iter().map(|&y| bead(y) - share * ripple(y)).collect::<Vec<f64>>();
    let mut measured = heights(0.0);
    measured.iter_mut().enumerate().for_each(|(i, h)| *h += FLOOR * (i as f64 * 12.9898).sin());
    measured[40..44].fill(f64::NAN);
    ScanSection {
        pass: "plate-01, pass 2".into(),
        direction,
        base: heights(1.0),
        with_effect: Some(heights(0.06)),
        position,
        measured,
        noise_floor: FLOOR,
    }
}

fn covariates() -> Vec<CovariatePlot> {
    let bins = |low: f64, high: f64, slope: f64| -> Vec<Bin> {
        let bin = |i: usize| {
            let u = f64::from(i as u32) / 9.0;
            let residual = 0.01 * (slope * (u - 0.4) + 0.4 * (7.0 * u).sin());
            Bin { covariate: low + u * (high - low), residual, band: [residual - 0.011, residual + 0.011] }
        };
        (0..10).map(bin).collect()
    };
    let plot = |name: &str, unit, range: [f64; 2], slope, share, p_value| CovariatePlot {
        name: name.into(),
        unit,
        bins: bins(range[0], range[1], slope),
        with_effect: bins(range[0], range[1], 0.05 * slope),
        share,
        drop: 0.8 * share,
        p_value,
        p_value_of_all: (3.0 * p_value).min(1.0),
    };
    vec![
        plot("contact pressure", DisplayUnit::new("MPa", 1e6), [0.1e6, 0.62e6], 6.0, 0.117, 0.083),
        plot("removed volume", DisplayUnit::new("mm³", 1e-9), [0.0, 280e-9], 24.0, 0.731, 0.0004),
        plot("slip speed", DisplayUnit::new("m/s", 1.0), [29.0, 31.4], 1.0, 0.021, 0.41),
    ]
}

fn suspects() -> Vec<EffectSummary> {
    let suspect =
        |name: &str, title: &str, probability, gain, after: f64, like: &[&str], ruled_out: &str| EffectSummary {
            name: name.into(),
            title: title.into(),
            probability,
            indistinguishable_from: like.iter().map(|&l| l.to_owned()).collect(),
            parameters: BTreeMap::new(),
            delta_chi2: gain,
            p_value: 0.0025,
            search: 1,
            ruled_out: Some(ruled_out.to_owned()).filter(|reason| !reason.is_empty()),
            evaluation_rms_before: Some(13.73 * UM),
            evaluation_rms_after: Some(after * UM),
        };
    vec![
        suspect("grit-dulling", "wheel dulls with removed volume", 0.9413, 1843.2, 2.419, &["thermal-softening"], ""),
        suspect(
            "wheel-loading",
            "chips clog the wheel",
            0.0511,
            1829.7,
            2.633,
            &[],
            "it predicts data left out of the fit worse than grit-dulling",
        ),
        suspect(
            "tool-tilt",
            "axis tilted against the path",
            0.0021,
            211.4,
            11.93,
            &[],
            "its best size lies beyond its range",
        ),
    ]
}

fn unfitted() -> Unfitted {
    Unfitted {
        name: "wheel-crown".into(),
        title: "wheel is crowned".into(),
        search: 1,
        reason: "no fall of χ²: no fit of it is better than the model without it".into(),
    }
}

fn parameters() -> Vec<ParameterSummary> {
    let free = |name: &str, unit: &str, value: f64, spread: f64, state| ParameterSummary {
        name: name.into(),
        value,
        interval: Some([value - spread, value + spread]),
        unit: unit.into(),
        state,
        listed_to: None,
    };
    let fixed = free("contact.stiffness", "N/mm^3", 3.2, 0.0, ParameterState::Fixed);
    vec![
        free("preston.k", "mm^3/(N m)", 0.01234, 0.00031, ParameterState::Identifiable),
        free("preston.threshold", "MPa", 0.0512, 0.0097, ParameterState::OnGreatest),
        free("grit-dulling.rate", "1/mm^3", 0.002107, 0.000121, ParameterState::NotIdentifiable),
        ParameterSummary { interval: None, ..fixed },
    ]
}

fn correlations() -> Vec<Correlation> {
    let pair = |one: &str, other: &str, value: f64| Correlation {
        between: [one, other].map(str::to_owned),
        value: Some(value),
    };
    vec![
        pair("preston.k", "preston.threshold", 0.932),
        pair("preston.k", "grit-dulling.rate", -0.417),
        pair("preston.threshold", "grit-dulling.rate", -0.288),
    ]
}

fn detectable() -> Vec<Detectable> {
    let row = |effect: &str, parameter: &str, size: Option<f64>| Detectable {
        effect: effect.into(),
        parameter: parameter.into(),
        unit: "%".into(),
        size,
        sides: Sides::Above,
        testable: size.is_some(),
    };
    vec![row("speed-exponent", "exponent", None), row("tool-tilt", "tilt", Some(1.73))]
}

fn next_trial() -> NextTrial {
    let runner_up = MenuLine { summary: "the same passes at 2 times the force".into(), worth: worth(36.25, 0.43) };
    NextTrial {
        summary: "Grind one more plate with a freshly dressed wheel, and change the force within the pass.".into(),
        force_n: vec![10.0, 20.0],
        feed_mm_s: vec![5.0],
        spindle_rpm: Vec::new(),
        separates: vec!["grit-dulling".into(), "wheel-loading".into()],
        expected_delta_chi2: 31.0,
        probability_right: 0.973,
        choice: Some(MenuChoice {
            worth: worth(31.4, 0.41),
            discrimination_nats: 0.5,
            entropy_nats: 0.69,
            menu: 48,
            runners_up: vec![runner_up],
            then: None,
            scans_per_surface: 1,
            plan: Vec::new(),
        }),
    }
}

fn worth(minutes: f64, expected_information_nats: f64) -> Worth {
    Worth { minutes, workpieces: 1, expected_information_nats, nats_per_minute: expected_information_nats / minutes }
}

fn provenance() -> Provenance {
    let digest = |file: &str, letter: &str| Digest { file: file.into(), sha256: letter.repeat(64) };
    Provenance {
        inputs: vec![digest("plate-01/before.csv", "a"), digest("plate-01/pass1_log.csv", "7")],
        seed: 20_417,
        versions: vec![("RoboFin".into(), "0.1.0".into()), ("effects".into(), "41 of the library".into())],
        options: vec![("--voxel-mm".into(), "0.25".into())],
        date: None,
    }
}

fn diagnosis() -> serde_json::Value {
    json!({
        "verdict": "identified",
        "effects": [{
            "name": "grit-dulling", "probability": 0.9413, "indistinguishable_from": [],
            "parameters": {"rate": 2107000.0000000005},
            "evaluation_rms_before": 13.73e-6, "evaluation_rms_after": 2.419e-6
        }],
        "noise_floor": 2.1e-6, "base_rms": 12.41e-6,
        "next_trial": {"summary": "dress the wheel </script><script>alert(1)</script>"},
        "proposal": null, "detectable": []
    })
}

/// Makes a sanded panel: exposure masks, no heights.
pub fn sanding() -> StudyReport {
    let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 120, ny: 60 };
    let disc = |at: usize, radius: f64| {
        let (x, y) = ((at % 120) as f64 - 60.0, (at / 120) as f64 - 30.0);
        x * x / 4.0 + y * y < radius * radius
    };
    let maps = ExposureMaps {
        pixels,
        measured: (0..pixels.len()).map(|at| (at % 97 != 0).then_some(disc(at, 22.0))).collect(),
        base: (0..pixels.len()).map(|at| disc(at, 18.0)).collect(),
        with_effect: None,
    };
    let mut report = bare("panels, new sheet each");
    report.waterfall.misfit = Misfit { name: "pixels that disagree".into(), unit: DisplayUnit::new("%", 0.01) };
    report.scans =
        vec![ScanComparison { pass: "panel-1, pass 1".into(), role: Role::Evaluation, maps: Maps::Exposure(maps) }];
    report
}

/// Makes a study with nothing but its verdict, as of a table of rows.
pub fn bare(campaign: &str) -> StudyReport {
    StudyReport {
        compared: Compared { campaign: campaign.into(), ..Compared::default() },
        conclusion: Conclusion::Searched(Verdict::NotTestable),
        sentence: "One force and one feed: no effect can be told from a change of k.".into(),
        tests: Vec::new(),
        waterfall: Waterfall { misfit: Misfit::heights(), passes: Vec::new(), steps: Vec::new(), notes: Vec::new() },
        volumes: Vec::new(),
        scans: Vec::new(),
        sections: Vec::new(),
        covariates: Vec::new(),
        tiles: Vec::new(),
        suspects: Vec::new(),
        unfitted: Vec::new(),
        parameters: Vec::new(),
        correlations: Vec::new(),
        detectable: Vec::new(),
        next_trial: None,
        proposal: None,
        provenance: Provenance::default(),
        diagnosis: json!({"verdict": "not-testable"}),
    }
}
