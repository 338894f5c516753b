//! Removal of held-out rows does not influence any fit.

use lab::{Evidence, RowEvidence, Split};
use trials::trial::Role;

use crate::hidden::{fit, model, table};
use crate::synthetic::{Hidden, MANIFEST, NOISE, Work, csv, work};

/// Returns the text of a table in which every fourth row has another recipe.
fn with_recipes(rows: &[Work]) -> String {
    let line = |(k, line): (usize, &str)| match k {
        0 => format!("{line},recipe\n"),
        _ => format!("{line},{}\n", if (k - 1) % 4 == 0 { "coarse" } else { "fine" }),
    };
    csv(rows).lines().enumerate().map(line).collect()
}

/// Returns the indices of the held-out rows.
fn held_out(rows: &[Work]) -> Vec<usize> {
    let table = table(MANIFEST, &csv(rows));
    (0..table.rows.len()).filter(|&at| table.rows[at].role == Role::Evaluation).collect()
}

#[test]
fn changed_evaluation_rows_leave_every_calibration_residual_as_it_was() {
    let rows = work(Hidden::Dulling, NOISE, 21);
    let mut other = rows.clone();
    let group = format!("{MANIFEST}group = {{ column = \"recipe\" }}\n");
    let grouped = table(&group, &with_recipes(&rows));
    let evaluates = |at: &usize| grouped.rows[*at].role == Role::Evaluation;
    // Rows held out in both tables.
    let held: Vec<usize> = held_out(&rows).into_iter().filter(evaluates).collect();
    assert!(held.len() > 5, "{held:?}");
    for (k, row) in other.iter_mut().enumerate().filter(|(k, _)| held.contains(k)) {
        row.depth *= 0.1 + 0.37 * k as f64;
    }
    for (manifest, text, changed) in
        [(MANIFEST, csv(&rows), csv(&other)), (&group, with_recipes(&rows), with_recipes(&other))]
    {
        let (a, b) = (table(manifest, &text), table(manifest, &changed));
        let (a, b) = (RowEvidence::new(&a).unwrap(), RowEvidence::new(&b).unwrap());
        assert_eq!(a.noise.to_bits(), b.noise.to_bits());
        assert_eq!(a.notes, b.notes);
        let (model_a, model_b) = (model(&a, Some("grit-dulling")), model(&b, Some("grit-dulling")));
        assert_eq!(model_a.values(), model_b.values());
        let residuals = |evidence: &RowEvidence, split| evidence.residuals(&model_a, split).unwrap();
        assert_eq!(residuals(&a, Split::Calibration), residuals(&b, Split::Calibration));
        assert_ne!(residuals(&a, Split::Evaluation), residuals(&b, Split::Evaluation));
        assert_eq!(fit(&a, Some("grit-dulling")).at, fit(&b, Some("grit-dulling")).at);
    }
}

#[test]
fn the_tool_wears_in_evaluation_rows_too() {
    let rows = work(Hidden::Dulling, NOISE, 23);
    let mut longer = rows.clone();
    let held = held_out(&rows);
    let first = held[0];
    longer.iter_mut().enumerate().filter(|(k, _)| held.contains(k)).for_each(|(_, row)| row.duration *= 3.0);
    let (a, mut b) = (table(MANIFEST, &csv(&rows)), table(MANIFEST, &csv(&longer)));
    b.rows.iter_mut().zip(&a.rows).for_each(|(b, a)| b.role = a.role);
    let (a, b) = (RowEvidence::new(&a).unwrap(), RowEvidence::new(&b).unwrap());
    let model = model(&a, Some("grit-dulling"));
    let (short, long) = (a.predicted(&model).unwrap(), b.predicted(&model).unwrap());
    assert_eq!(short[..first], long[..first]);
    assert!(a.of(Split::Calibration).iter().filter(|&&at| at > first).all(|&at| long[at] < short[at]));
}

#[test]
fn a_role_column_decides_and_blocks_follow_the_order() {
    let rows = work(Hidden::Nothing, NOISE, 25);
    let line = |(k, line): (usize, &str)| match k {
        0 => format!("{line},split\n"),
        _ => format!("{line},{}\n", if k > 60 { "Evaluation" } else { "calibration" }),
    };
    let text: String = csv(&rows).lines().enumerate().map(line).collect();
    let table = table(&format!("{MANIFEST}role = {{ column = \"split\" }}\n"), &text);
    let evidence = RowEvidence::new(&table).unwrap();
    assert_eq!(evidence.of(Split::Calibration), (0..60).collect::<Vec<_>>());
    assert_eq!(evidence.of(Split::Evaluation), (60..90).collect::<Vec<_>>());
    let blocks = evidence.blocks(Split::Calibration);
    assert_eq!(blocks.len(), 60);
    assert!(blocks.is_sorted() && blocks[0] == blocks[4] && blocks[4] != blocks[5]);
}
