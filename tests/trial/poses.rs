//! A log as the tool's path.

use glam::DVec3;
use trials::trial::{HeldTool, ToolPath};

use crate::files::grinding;

#[test]
fn contact_feed_and_axis_come_from_the_log() {
    let trial = grinding();
    let path = trial.passes[0].tool_path(&trial.tool);
    let contact = path.contact.expect("a contact");
    assert!((contact.start - 0.2).abs() < 0.021 && (contact.end - 2.2).abs() < 0.021, "{contact:?}");
    assert!((path.feed - 0.005).abs() < 1e-6, "{}", path.feed);
    assert!(path.jumps.is_empty() && (path.duration() - 2.4).abs() < 1e-12);
    let pose = path.at(1.01);
    assert!((pose.centre.x - (0.002 + 0.005 * 0.81)).abs() < 1e-12 && pose.axis == DVec3::Y);
    assert_eq!(path.at(99.0).centre, path.poses.last().unwrap().centre);
}

#[test]
fn a_tilted_approach_tilts_the_axis_with_it() {
    let mut trial = grinding();
    let approach = DVec3::new(0.0, 0.6, 0.8);
    for row in &mut trial.passes[0].log.rows {
        row.approach = approach;
    }
    let pose = trial.passes[0].tool_path(&trial.tool).at(1.0);
    assert!((pose.axis - DVec3::new(0.0, 0.8, -0.6)).length() < 1e-12, "{}", pose.axis);
    let pad = ToolPath::of(&trial.passes[0].log, &HeldTool::pad(0.01), 15.0).at(1.0);
    assert!((pad.axis - approach).length() < 1e-12);
}

#[test]
fn gaps_in_the_clock_and_passes_in_the_air_are_seen() {
    let mut trial = grinding();
    for row in trial.passes[0].log.rows.iter_mut().skip(50) {
        row.time += 0.5;
    }
    let path = trial.passes[0].tool_path(&trial.tool);
    assert_eq!(path.jumps.len(), 1);
    assert!(path.jumps[0].row == 50 && (path.jumps[0].gap - 0.52).abs() < 1e-9, "{:?}", path.jumps);
    for row in &mut trial.passes[0].log.rows {
        row.force = 0.0;
    }
    assert_eq!(trial.passes[0].tool_path(&trial.tool).contact, None);
}
