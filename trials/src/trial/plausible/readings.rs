//! Force, feed and spindle speed of a log against the stated values of its pass; a wrong unit or sign is named.

use std::path::Path;

use sdf_bake::PixelGrid;

use super::super::error::{Place, TrialError};
use super::super::log::{Log, RPM};
use super::super::manifest::TRIAL_FILE;
use super::super::poses::{Motion, NOISE_SIGMAS, force_noise};
use super::super::{Pass, Trial};

/// Factor between a logged and a stated value above which one of them is wrong: √10, the logarithmic middle between a
/// right value and the nearest confusions of units (kgf or daN 0.1, lbf 0.22, rad/s 0.105, mm/min 60, kN 0.001).
const WRONG: f64 = 3.162_277_660_168_379_5;
/// Factor between logged speed and feed for a note.
const ODD_SPEED: f64 = 1.25;
/// Tolerance factor between a ratio and a unit's own ratio: errors of sensors and drives are smaller.
const NAMED: f64 = 1.25;
/// Factors around a thousand that indicate metres, micrometres or milliseconds.
const THOUSAND: std::ops::Range<f64> = 500.0..2000.0;
/// Share of the map's length below which a path is in metres, and multiple above which it is in micrometres: the
/// logarithmic middle between a path over the map and one that is a thousand times shorter or longer.
const LENGTHS: (f64, f64) = (1.0 / 31.6, 31.6);
/// Speeds of a tool's rim [m/s]. The first is for a note (the highest class of EN 12413, for bonded wheels, is 125
/// m/s); above the second no grinding wheel has run (research with CBN wheels: 280 m/s).
const RIM_SPEED: (f64, f64) = (125.0, 280.0);
/// Ratio of rim speed to feed below which a tool hardly grinds: Malkin and Guo (2008) give 60 and more for grinding.
const SPEED_RATIO: f64 = 60.0;
/// Units of force by their size in newtons.
const FORCES: [(f64, &str); 6] =
    [(1e-3, "kN"), (1e3, "mN"), (1e-6, "MN"), (1e6, "µN"), (0.101_97, "kgf or daN"), (0.224_81, "lbf")];
/// Units of spindle speed by their size in revolutions per minute.
const SPEEDS: [(f64, &str); 4] =
    [(0.104_72, "rad/s"), (1.0 / 60.0, "revolutions per second"), (6.0, "°/s"), (1e-3, "1000 rpm")];
/// Units of feed by their size in mm/s.
const FEEDS: [(f64, &str); 4] = [(60.0, "mm/min"), (0.1, "cm/s"), (0.06, "m/min"), (1e-3, "m/s")];

/// Refuses readings in another unit or with another sign; returns notes on oddities.
pub(super) fn check(pass: &Pass, trial: &Trial, log: &Path) -> Result<Vec<String>, TrialError> {
    let place = || Place::file(log);
    check_feed(pass, &trial.scans.before.pixels, &place)?;
    check_force(pass, &place)?;
    check_spindle(pass, &place)?;
    let path = pass.tool_path(&trial.tool);
    let jump = path.jumps.first().map(|jump| {
        format!("{} jumps of the clock, the first of {:.3} s before {:.3} s", path.jumps.len(), jump.gap, jump.time)
    });
    let speed = (!is_within(path.feed / pass.feed, ODD_SPEED)).then(|| {
        let (logged, feed) = (path.feed * 1e3, pass.feed * 1e3);
        format!("the tool moves at {logged:.2} mm/s where the feed is {feed} mm/s: is the clock right?")
    });
    let no_contact = || "the force never rises above its noise: no contact".to_owned();
    let contact = path.contact.is_none().then(no_contact);
    let spindle = Motion::of(&pass.log).spindle_speed.abs() / RPM;
    let odd_spindle = spindle > 0.0 && !is_within(spindle * RPM / pass.spindle_speed, ODD_SPEED);
    let other = odd_spindle.then(|| {
        format!(
            "the column spindle_rpm is {} where {TRIAL_FILE} says {}",
            shown(spindle),
            shown(pass.spindle_speed / RPM)
        )
    });
    let still = (pass.spindle_speed > 0.0 && Motion::of(&pass.log).spindle_speed == 0.0)
        .then(|| format!("spindle_rpm is 0 where {TRIAL_FILE} says {:.0}", pass.spindle_speed / RPM));
    Ok([jump, contact, speed, still, other].into_iter().flatten().collect())
}

/// True if a ratio is between `1 / factor` and `factor`.
fn is_within(ratio: f64, factor: f64) -> bool {
    (1.0 / factor..=factor).contains(&ratio)
}

/// The units that explain a ratio of a column and a key.
fn guess((ratio, column, key): (f64, &str, &str), units: &[(f64, &str)]) -> Option<String> {
    let named = |size: f64, of: String| {
        let near = |(factor, _): &&(f64, &str)| is_within(size / factor, NAMED);
        units.iter().find(near).map(|(_, unit)| format!("{of} in {unit}"))
    };
    let column = named(ratio, format!("the column {column}"));
    let key = named(1.0 / ratio, format!("{key} of {TRIAL_FILE}"));
    let words: Vec<String> = column.into_iter().chain(key).collect();
    (!words.is_empty()).then(|| format!("is {}?", words.join(" or ")))
}

/// A ratio in words: a number of times larger or smaller.
fn compared(ratio: f64) -> String {
    let shown = |times: f64| if times < 20.0 { format!("{times:.1}") } else { format!("{times:.0}") };
    if ratio < 1.0 { format!("{} times smaller", shown(1.0 / ratio)) } else { format!("{} times larger", shown(ratio)) }
}

/// The force in contact [N]: the median of the rows above half of the greatest force; `None` if all is noise. Five rows
/// of a hundred may be peaks.
fn pressing(log: &Log) -> Option<f64> {
    let mut sizes: Vec<f64> = log.rows.iter().map(|row| row.force.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = *sizes.get(sizes.len() * 19 / 20)?;
    let strong = log.rows.iter().map(|row| row.force).filter(|force| force.abs() >= 0.5 * most).collect();
    let level = crate::measure::median(strong)?;
    (level.abs() > NOISE_SIGMAS * force_noise(log.rows.iter().map(|row| row.force))).then_some(level)
}

/// The logged force against the setpoint.
fn check_force(pass: &Pass, place: &dyn Fn() -> Place) -> Result<(), TrialError> {
    let Some(level) = pressing(&pass.log) else { return Ok(()) };
    let setpoint = pass.force_setpoint;
    let ratio = level / setpoint;
    if is_within(ratio, WRONG) {
        return Ok(());
    }
    let size = ratio.abs();
    let shown = shown(level);
    let unit = guess((size, "force_n", "force_setpoint_n"), &FORCES);
    let found = match (ratio < 0.0, is_within(size, WRONG)) {
        (true, true) => format!("force_n is {shown} N while the tool presses, and force_setpoint_n is {setpoint} N"),
        _ => format!(
            "force_n is {shown} N while the tool presses, {} than force_setpoint_n = {setpoint} N",
            compared(size)
        ),
    };
    let sign = (ratio < 0.0).then(|| "has the sensor the other sign?".to_owned());
    let none = (ratio > 0.0 && unit.is_none()).then(|| "is it another unit, or another setpoint?".to_owned());
    let guesses: Vec<String> = sign.into_iter().chain(unit).chain(none).collect();
    Err(place()
        .bad(found, format!("newtons, positive while the tool presses, are expected: {}", guesses.join(" and "))))
}

/// A number with three significant digits.
fn shown(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.digits$}")
}

/// The speed of the log against the feed of the pass.
fn check_feed(pass: &Pass, map: &PixelGrid, place: &dyn Fn() -> Place) -> Result<(), TrialError> {
    let speed = Motion::of(&pass.log).feed;
    let ratio = speed / pass.feed;
    if is_within(ratio, WRONG) || !ratio.is_finite() {
        return Ok(());
    }
    let shown = format!("the tool moves at {:.3e} mm/s where the feed is {:.3} mm/s", speed * 1e3, pass.feed * 1e3);
    let reach = pass.log.rows.iter().map(|row| (row.position - pass.log.rows[0].position).length()).fold(0.0, f64::max);
    let maps = reach / (map.pitch * map.nx.max(map.ny) as f64);
    let accepted = if speed == 0.0 {
        "a tool that moves is expected: do x_mm and y_mm change?".to_owned()
    } else if THOUSAND.contains(&ratio) && maps > LENGTHS.1 {
        "positions in mm are expected: these look like µm".to_owned()
    } else if THOUSAND.contains(&(1.0 / ratio)) && maps < LENGTHS.0 {
        "positions in mm are expected: these look like m".to_owned()
    } else if THOUSAND.contains(&(1.0 / ratio)) {
        "times in s are expected: these look like ms".to_owned()
    } else {
        let key = feed_unit(ratio).unwrap_or_else(|| "is feed_mm_s in another unit, or is the clock wrong?".to_owned());
        format!("feed_mm_s in mm/s, positions in mm and times in s are expected: {key}")
    };
    Err(place().bad(shown, accepted))
}

/// The unit of `feed_mm_s` that explains a ratio of logged speed and feed.
fn feed_unit(ratio: f64) -> Option<String> {
    let near = |(factor, _): &&(f64, &str)| is_within(1.0 / ratio / factor, NAMED);
    FEEDS.iter().find(near).map(|(_, unit)| format!("is feed_mm_s of {TRIAL_FILE} in {unit}?"))
}

/// The logged spindle speed against the stated one.
fn check_spindle(pass: &Pass, place: &dyn Fn() -> Place) -> Result<(), TrialError> {
    let logged = Motion::of(&pass.log).spindle_speed;
    let ratio = logged / pass.spindle_speed;
    let is_turning = logged != 0.0 && pass.spindle_speed > 0.0;
    // Drives report both directions of rotation with either sign.
    if !is_turning || is_within(ratio.abs(), WRONG) {
        return Ok(());
    }
    let ratio = ratio.abs();
    let (logged, stated) = (logged / RPM, pass.spindle_speed / RPM);
    let unit = guess((ratio, "spindle_rpm", "spindle_rpm"), &SPEEDS)
        .unwrap_or_else(|| "is one of them another unit?".to_owned());
    Err(place().bad(
        format!(
            "the column spindle_rpm is {}, {} than spindle_rpm = {} of {TRIAL_FILE}",
            shown(logged),
            compared(ratio),
            shown(stated)
        ),
        format!("revolutions per minute are expected in both: {unit}"),
    ))
}

/// The rim speed against that of grinding and sanding tools; returns a note if it is unusual.
pub(super) fn check_rim(pass: &Pass, trial: &Trial) -> Result<Option<String>, TrialError> {
    let radius = trial.tool.shape.rim_radius();
    let rim = pass.spindle_speed * radius;
    let stated = format!(
        "spindle_rpm = {} and radius_mm = {} make a rim speed of {} m/s",
        shown(pass.spindle_speed / RPM),
        shown(radius * 1e3),
        shown(rim)
    );
    if rim > RIM_SPEED.1 {
        return Err(Place::file(&trial.folder.join(TRIAL_FILE)).bad(
            stated,
            format!("at most {} m/s is expected: is one of them another unit, such as °/s or µm?", RIM_SPEED.1),
        ));
    }
    let slow = rim > 0.0 && rim < SPEED_RATIO * pass.feed;
    Ok(if rim > RIM_SPEED.0 {
        Some(format!("{stated}, and bonded wheels run at {} m/s at most", RIM_SPEED.0))
    } else if slow {
        Some(format!("{stated}, {:.0} times the feed: is spindle_rpm in rad/s?", rim / pass.feed))
    } else {
        None
    })
}
