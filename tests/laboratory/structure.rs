//! Tests of structure and Shapley shares of covariates on data with a known answer.

use glam::DVec2;
use lab::{CovariateField, ResidualGrid, StructureTest, covariate_study, spline_columns, structure_tests};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::PixelGrid;
use trials::measure::{SectionAxis, plateau_pixels};

/// Random number generator.
struct Chance(Pcg64Mcg);

impl Chance {
    fn of(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.0.random::<f64>()).sum::<f64>() - 6.0
    }
}

fn grid(residual: impl FnMut(usize, usize) -> f64) -> ResidualGrid {
    let (nx, ny) = (40, 10);
    let mut residual = residual;
    let residuals = (0..nx * ny).map(|cell| residual(cell % nx, cell / nx)).collect();
    ResidualGrid { nx, cells: (0..nx * ny).collect(), residuals }
}

fn noise(seed: u64) -> ResidualGrid {
    let mut chance = Chance::of(seed);
    grid(|_, _| chance.normal())
}

#[test]
fn noise_alone_alarms_in_few_of_many_data_sets() {
    let alarms = |seed: &u64| structure_tests(&[noise(*seed)], &[], 0, &[], *seed).iter().any(|test| test.rejects);
    let count = (0..60).filter(alarms).count();
    println!("{count} alarms in 60 data sets of noise");
    // At 5 % three are expected; eight or more have a probability below 1 %.
    assert!(count < 8, "{count}");
}

#[test]
fn noise_that_is_known_from_a_repeated_scan_alarms_as_seldom() {
    // The size that whitening assumes was estimated from 400 differences; the noise itself has a variance of one.
    let alarms = |seed: &u64| {
        let [mut data, mut repeat] = [noise(*seed), noise(1000 + *seed)];
        let size = (repeat.residuals.iter().map(|r| r * r).sum::<f64>() / repeat.residuals.len() as f64).sqrt();
        for grid in [&mut data, &mut repeat] {
            grid.residuals.iter_mut().for_each(|r| *r /= size);
        }
        [&[][..], &[repeat]].map(|repeats| structure_tests(&[data.clone()], repeats, 0, &[], *seed))
    };
    let rejects = |tests: &Vec<StructureTest>| tests.iter().any(|test| test.rejects);
    let found: Vec<[bool; 2]> = (0..200).map(|seed| alarms(&seed).each_ref().map(rejects)).collect();
    let [blind, known] = [0, 1].map(|k| found.iter().filter(|found| found[k]).count());
    println!("of 200 data sets {blind} alarm as if the noise were known exactly, {known} with the repeated scan");
    // At 5 % ten are expected; eighteen or more have a probability below 1 %.
    assert!(known < 18 && blind > known, "{known} and {blind}");
}

#[test]
fn correlation_that_the_repeated_scan_has_too_is_no_structure() {
    let smooth = |seed: u64| {
        let mut chance = Chance::of(seed);
        let mut before = 0.0;
        grid(|_, _| {
            before = 0.35 * before + 0.94 * chance.normal();
            before
        })
    };
    let rejects = |repeats: &[ResidualGrid]| {
        let tests = structure_tests(&[smooth(7)], repeats, 0, &[], 1);
        tests.iter().skip(1).filter(|test| test.rejects).count()
    };
    assert!(rejects(&[]) > 0);
    assert_eq!(rejects(&[smooth(8)]), 0);
}

#[test]
fn a_wave_below_the_noise_is_found_by_its_neighbours_and_not_by_its_size() {
    let mut chance = Chance::of(3);
    let wavy = grid(|i, _| 0.7 * (i as f64 / 6.0).sin() + 0.87 * chance.normal());
    let tests = structure_tests(&[wavy], &[], 0, &[], 1);
    println!("{tests:?}");
    assert!(!tests[0].rejects, "the sum of squares is that of noise");
    assert!(tests[1].rejects && tests[1].p_value <= 0.005);
}

const NOISE: f64 = 0.03;

/// Makes four scans of a track with correlated noise; the residual depends on the first of three covariates.
fn fields(slope: f64, seed: u64) -> Vec<CovariateField> {
    let (nx, ny) = (40, 8);
    let field = |scan: usize| {
        let mut chance = Chance::of(97 * seed + scan as u64);
        let mut wavy = || {
            let (phase, length) = (chance.between([0.0, 6.3]), chance.between([5.0, 12.0]));
            (0..nx * ny).map(|at| (phase + (at % nx) as f64 / length).sin()).collect::<Vec<f64>>()
        };
        let values = vec![wavy(), wavy(), vec![scan as f64; nx * ny]];
        let smooth = wavy();
        let residual = |at: usize| slope * values[0][at] + NOISE * (smooth[at] + chance.normal());
        CovariateField {
            nx,
            cells: (0..nx * ny).collect(),
            residuals: (0..nx * ny).map(residual).collect(),
            sigmas: vec![NOISE; nx * ny],
            blocks: (0..nx * ny).map(|at| at % nx / 4 + 10 * (at / nx / 4)).collect(),
            values,
        }
    };
    (0..4).map(field).collect()
}

#[test]
fn what_the_residual_depends_on_explains_it_and_the_rest_does_not() {
    let study = covariate_study(&fields(0.1, 1), 1.0, 1);
    println!(
        "{:.3} together, {:?}",
        study.joint_share,
        study.covariates.iter().map(|c| (c.share, c.drop, c.p_value)).collect::<Vec<_>>()
    );
    let [own, other, scan] = &study.covariates[..] else { panic!("three vary") };
    assert!(own.share > 0.7 && own.p_value <= 0.01 && own.p_value_of_all <= 0.01, "{own:?}");
    assert!(own.drop > 0.2 && own.drop > 2.0 * other.drop, "{} {}", own.drop, other.drop);
    assert!(other.share < 0.5 * own.share && scan.share < 0.2, "{other:?} {scan:?}");
    let (first, last) = (own.bins[0], own.bins[own.bins.len() - 1]);
    assert!((first.residual + 0.1).abs() < 0.03 && (last.residual - 0.1).abs() < 0.03, "{first:?} {last:?}");
    assert!(own.bins.iter().all(|bin| bin.band[0] <= bin.residual && bin.residual <= bin.band[1]));
}

#[test]
fn shared_noise_alone_is_no_dependence() {
    let least = |seed: u64| {
        let study = covariate_study(&fields(0.0, seed), 1.0, seed);
        study.covariates.iter().map(|c| c.p_value_of_all).fold(1.0, f64::min)
    };
    let alarms = (0..20).filter(|&seed| least(seed) <= 0.05).count();
    println!("{alarms} alarms in 20 sets of shared noise");
    // At 5 % one is expected; five or more have a probability below 0.3 %.
    assert!(alarms < 5, "{alarms}");
}

#[test]
fn a_covariate_that_is_constant_in_a_scan_needs_many_scans() {
    let mut few = fields(0.0, 2);
    few.truncate(2);
    few[1].residuals.iter_mut().for_each(|residual| *residual += 0.2);
    let study = covariate_study(&few, 1.0, 1);
    let scan = study.covariates.iter().find(|c| c.covariate == 2).expect("it varies");
    assert!(scan.share > 0.5 && scan.p_value > 0.3, "two scans cannot tell: {scan:?}");
}

#[test]
fn columns_are_straight_beyond_the_outer_knots_and_smooth_between() {
    let values: Vec<f64> = (0..=1000).map(|k| f64::from(k) / 1000.0).collect();
    let columns = spline_columns(&values);
    assert_eq!(columns.len(), 5);
    for column in &columns {
        let bend = |k: usize| column[k + 1] - 2.0 * column[k] + column[k - 1];
        assert!((1..48).chain(953..1000).all(|k| bend(k).abs() < 1e-12));
        assert!((2..999).all(|k| (bend(k + 1) - bend(k)).abs() < 1e-7), "no kink");
    }
}

#[test]
fn few_values_give_few_columns() {
    assert!(spline_columns(&[3.0; 20]).is_empty());
    let two: Vec<f64> = (0..20).map(|k| f64::from(k % 2)).collect();
    assert_eq!(spline_columns(&two).len(), 1);
}

#[test]
fn height_and_slope_of_a_tilted_plateau_come_back() {
    let pixels = PixelGrid { origin: DVec2::new(0.0, -5e-3), pitch: 0.25e-3, nx: 30, ny: 41 };
    let place = |at: usize| pixels.position(at % 30, at / 30);
    // A track 6 mm wide along x, deepest in the middle, with a crest that rises along x.
    let removed: Vec<f64> = (0..pixels.len()).map(|at| 1e-4 * (1.0 - (place(at).y / 3e-3).powi(2)).max(0.0)).collect();
    let plateau = plateau_pixels(pixels, &removed, 1e-6, SectionAxis::Y);
    let half = (0..pixels.len()).filter(|&at| place(at).y.abs() <= 3e-3 / 2f64.sqrt()).count();
    assert_eq!(plateau.mean_weights(|_| true).len(), half);
    let height = |at: usize| 20e-6 + 3e-3 * place(at).x + 2e-3 * place(at).y;
    let sum = |weights: Vec<(usize, f64)>| weights.into_iter().map(|(at, weight)| weight * height(at)).sum::<f64>();
    let slope = sum(plateau.slope_weights(|at| at % 7 > 0));
    assert!((slope - 2e-3).abs() < 1e-12, "{slope}");
    let mean = sum(plateau.mean_weights(|_| true));
    assert!((mean - height(pixels.at(0, 20)) - 3e-3 * 14.5 * 0.25e-3).abs() < 1e-12, "{mean}");
    assert!(plateau.holds(pixels.at(7, 20)) && !plateau.holds(pixels.at(7, 2)));
    assert!(plateau_pixels(pixels, &removed, 1e-3, SectionAxis::Y).is_empty());
}
