//! Signs and units, guessed from values.

use super::{Candidate, Confidence, Role};
use crate::log::Channels;

/// Maximum distance of a robot's tool from its base [m].
const FARTHEST: f64 = 6.0;
/// Coordinates from this value on are in millimetres, because no robot reaches so many metres.
const SURELY_MM: f64 = 20.0;
/// Maximum feed of a tool [m/s].
const FASTEST: f64 = 5.0;
/// Difference of two readings, as a share of a force's range, up to which they count as one.
const SAME_READING: f64 = 0.25;
/// Spindle speeds from this value on are in rpm: in rad/s it would be 19 000 rpm.
const SURELY_RPM: f64 = 2000.0;

/// The candidates of every role.
type Roles = [(Role, Vec<Candidate>)];

/// Sets unit, sign and reason of every candidate.
pub(super) fn understand(channels: &Channels, roles: &mut Roles) {
    let seconds = time_step(channels, roles);
    let positions: Vec<usize> = roles
        .iter()
        .filter(|(role, _)| matches!(role, Role::X | Role::Y | Role::Z))
        .filter_map(|(_, candidates)| candidates.first().map(|best| best.channel))
        .collect();
    for (role, candidates) in roles {
        for candidate in candidates {
            let values = &channels.values[candidate.channel];
            let (unit, reason, is_sure) = match (candidate.unit.as_str(), *role) {
                ("", Role::Time) => time_unit(values),
                ("", Role::X | Role::Y | Role::Z) => length_unit(channels, &positions, seconds),
                ("", Role::Force) => ("N", "no unit is given, and newtons are usual".to_owned(), true),
                ("", Role::Spindle) => speed_unit(&candidate.name, values),
                ("", Role::Temperature) => temperature_unit(values),
                ("", Role::Nx | Role::Ny | Role::Nz) => ("1", "the three make a unit vector".to_owned(), true),
                (own, _) => {
                    candidate.reason = format!("the name fits, and the file gives the unit {own}");
                    sign(candidate, *role, values);
                    continue;
                }
            };
            candidate.unit = unit.to_owned();
            candidate.reason = format!("the name fits; {reason}");
            if !is_sure {
                candidate.confidence = Confidence::Doubtful;
            }
            sign(candidate, *role, values);
        }
    }
}

/// Keeps the candidates of an approach axis only if the best three form unit vectors.
pub(super) fn drop_what_is_no_axis(channels: &Channels, roles: &mut Roles) {
    let is_axis = |role: &Role| matches!(role, Role::Nx | Role::Ny | Role::Nz);
    let best: Vec<&Vec<f64>> = roles
        .iter()
        .filter(|(role, _)| is_axis(role))
        .filter_map(|(_, candidates)| candidates.first().map(|best| &channels.values[best.channel]))
        .collect();
    let is_unit = match best[..] {
        [x, y, z] => x.iter().zip(y).zip(z).all(|((x, y), z)| {
            let length = (x * x + y * y + z * z).sqrt();
            length.is_nan() || (length - 1.0).abs() < 0.1
        }),
        _ => false,
    };
    if !is_unit {
        roles.iter_mut().filter(|(role, _)| is_axis(role)).for_each(|(_, candidates)| candidates.clear());
    }
}

/// Finite values in increasing order.
fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Quantile of sorted values; 0 without values.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted.get((last as f64 * share).round() as usize).copied().unwrap_or(0.0)
}

/// Median difference between consecutive rows.
fn middle_step(values: &[f64]) -> f64 {
    quantile(&sorted(values.windows(2).map(|pair| pair[1] - pair[0])), 0.5)
}

/// Median time step of the best time candidate, if its unit is known [s].
fn time_step(channels: &Channels, roles: &Roles) -> Option<f64> {
    let best = roles.iter().find(|(role, _)| *role == Role::Time)?.1.first()?;
    let values = &channels.values[best.channel];
    let unit = if best.unit.is_empty() { time_unit(values).0 } else { best.unit.as_str() };
    let scale = match unit {
        "s" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        _ => return None,
    };
    Some(middle_step(values) * scale).filter(|step| *step > 0.0)
}

/// Plausible periods are 0.1 ms to 1 s.
fn time_unit(values: &[f64]) -> (&'static str, String, bool) {
    let step = middle_step(values);
    if step.is_nan() || step <= 0.0 {
        return ("s", "its values do not increase, so it may not be a time".to_owned(), false);
    }
    let (unit, is_sure) = match step {
        _ if step < 0.9 => ("s", true),
        _ if step <= 1.1 => ("s", false),
        _ if step < 2000.0 => ("ms", true),
        _ if step < 1e5 => ("us", false),
        _ => ("ns", true),
    };
    let doubt = if is_sure { "" } else { ", but other units are possible" };
    (unit, format!("steps of {step:.4} are those of {unit}{doubt}"), is_sure)
}

fn length_unit(channels: &Channels, positions: &[usize], seconds: Option<f64>) -> (&'static str, String, bool) {
    let all = |k: &usize| channels.values[*k].iter().copied().filter(|value| value.is_finite());
    let farthest = positions.iter().flat_map(all).map(f64::abs).fold(0.0, f64::max);
    if channels.format.starts_with("bag") {
        return ("m", "ROS gives lengths in metres (REP 103)".to_owned(), true);
    }
    if positions.iter().any(|&k| channels.names[k].starts_with("actual_TCP_pose")) {
        return ("m", "RTDE gives poses in metres".to_owned(), true);
    }
    let speeds = positions.iter().map(|&k| channels.values[k].windows(2).map(|pair| (pair[1] - pair[0]).abs()));
    let steps = sorted(speeds.flatten());
    let speed = seconds.map(|seconds| quantile(&steps, 0.9) / seconds);
    match speed {
        _ if farthest > SURELY_MM => ("mm", format!("coordinates up to {farthest:.1} are too far for metres"), true),
        Some(speed) if speed > FASTEST => ("mm", format!("{speed:.1} m/s would be too fast for a feed"), true),
        _ if farthest > FARTHEST => {
            ("mm", format!("coordinates up to {farthest:.1} are far for metres, but near for mm"), false)
        }
        _ => {
            ("m", format!("coordinates up to {farthest:.3} are metres if the robot's base is the origin, or mm"), false)
        }
    }
}

fn speed_unit(name: &str, values: &[f64]) -> (&'static str, String, bool) {
    let lower = name.to_lowercase();
    let fastest = quantile(&sorted(values.iter().map(|value| value.abs())), 0.9);
    if lower.contains("rpm") || lower.contains("drehzahl") {
        return ("rpm", "the name says revolutions per minute".to_owned(), true);
    }
    if fastest > SURELY_RPM {
        return ("rpm", format!("values of {fastest:.0} are too many for rad/s"), true);
    }
    if lower.contains("omega") || lower.contains('ω') {
        return ("rad/s", "the name is that of an angular speed".to_owned(), true);
    }
    let rpm = fastest * 60.0 / std::f64::consts::TAU;
    ("rpm", format!("values of {fastest:.0} may be rpm or rad/s ({rpm:.0} rpm)"), false)
}

fn temperature_unit(values: &[f64]) -> (&'static str, String, bool) {
    let all = sorted(values.iter().copied());
    let least = quantile(&all, 0.0);
    match least > 250.0 && quantile(&all, 0.05) < 330.0 {
        true => ("K", format!("it starts near {least:.0}, which is a room in kelvin"), false),
        false => ("°C", "its values are those of degrees Celsius".to_owned(), true),
    }
}

/// Sets the sign that makes a force positive in contact.
fn sign(candidate: &mut Candidate, role: Role, values: &[f64]) {
    if role != Role::Force {
        return;
    }
    let rows = (values.len() / 20).clamp(1, 100);
    let begin = quantile(&sorted(values.iter().copied().take(rows)), 0.5);
    let end = quantile(&sorted(values.iter().rev().copied().take(rows)), 0.5);
    let all = sorted(values.iter().copied());
    let (low, high) = (quantile(&all, 0.01), quantile(&all, 0.99));
    // Readings near zero are those in the air. A sensor that never reads zero has an offset; the offset is visible in a
    // log that begins and ends alike.
    let has_offset =
        low.abs().min(high.abs()) > SAME_READING * low.abs().max(high.abs()) && low.signum() == high.signum();
    let is_alike = (begin - end).abs() < SAME_READING * (high - low) && begin.abs() <= 2.0 * (high - low);
    let air = if has_offset && is_alike { begin } else { 0.0 };
    let (below, above) = ((air - low).max(0.0), (high - air).max(0.0));
    let negative = below > above;
    candidate.sign = if negative { -1 } else { 1 };
    let reading = if negative { "negative" } else { "positive" };
    candidate.reason.push_str(&format!("; it goes from {low:.1} to {high:.1}, so pressing on reads {reading}"));
    if below.min(above) > 0.5 * below.max(above) {
        candidate.confidence = Confidence::Doubtful;
        candidate.reason.push_str(", but it goes both ways from its start");
    }
}
