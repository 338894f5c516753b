//! Rows of numbers: positions, and rotations as quaternions, rotation vectors or angles, identified by a header.

use glam::{DQuat, DVec3};

use super::number::shown;
use super::reading::Reading;
use super::rotation::{from_kuka, from_vector, unit};
use super::{Format, Point, Program, QuaternionOrder, Source, WriteError};
use crate::log::{self, Channels};
use crate::misread::{Misread, Place};

/// Largest coordinate that counts as metres without a unit.
const PLAUSIBLE: f64 = 20.0;
const RPM: f64 = std::f64::consts::TAU / 60.0;
const ACCEPTED: &str = "columns x, y, z with qx, qy, qz, qw, or rx, ry, rz, or a, b, c are expected";

/// Known column names, for suggestions in errors.
const KNOWN: [&str; 12] = ["x", "y", "z", "qx", "qy", "qz", "qw", "pos_x", "position_x", "feed", "time", "spindle"];

/// Rows of numbers.
pub(super) struct PoseList;

/// Columns by their quantity.
struct Columns {
    position: [usize; 3],
    rotation: Rotation,
    feed: Option<usize>,
    time: Option<usize>,
    spindle: Option<usize>,
}

/// Form of the rotations.
enum Rotation {
    None,
    /// x, y, z, w.
    Quaternion([usize; 4]),
    /// Axis times angle.
    Vector([usize; 3]),
    /// KUKA's A, B, C.
    Kuka([usize; 3]),
}

impl Format for PoseList {
    fn name(&self) -> &'static str {
        "pose list"
    }

    fn recognises(&self, _text: &str) -> bool {
        true
    }

    fn read(&self, source: &Source) -> Result<Program, Misread> {
        let channels = log::read_text(source.file, source.text)?;
        let mut reading = Reading::new(source, self.name());
        let columns = match channels.names.iter().any(|name| name.starts_with("column_")) {
            true => numbered(source, &channels)?,
            false => named(source, &channels)?,
        };
        reading.program.notes.extend(channels.notes.iter().cloned());
        let scale = length_scale(source, &channels, &columns, &mut reading.program.notes)?;
        let (feed, time, turn) =
            (factor(&channels, columns.feed), factor(&channels, columns.time), rpm(&channels, &columns));
        let angle = angle_scale(&channels, &columns.rotation);
        for row in 0..channels.rows() {
            let line = channels.lines[row];
            let at = |column: usize| channels.values[column][row];
            let given = |column: Option<usize>, scale: f64| column.map(|k| scale * at(k)).filter(|v| v.is_finite());
            let rotation = columns.rotation.at(at, angle);
            let rotation = rotation.or_else(|found| reading.bad(line, found, "a unit quaternion is expected"))?;
            reading.push(Point {
                position: scale * DVec3::from_array(columns.position.map(at)),
                rotation,
                feed: given(columns.feed, feed),
                time: given(columns.time, time),
                spindle: given(columns.spindle, turn),
                line,
            })?;
        }
        reading.finish()
    }

    fn write(&self, points: &[Point]) -> Result<String, WriteError> {
        let has = |of: fn(&Point) -> bool| points.iter().any(of);
        let optional = [
            (has(|point| point.rotation.is_some()), ",qx,qy,qz,qw"),
            (has(|point| point.feed.is_some()), ",feed_mm_s"),
            (has(|point| point.time.is_some()), ",time_s"),
            (has(|point| point.spindle.is_some()), ",spindle_rpm"),
        ];
        let heads = optional.iter().filter(|(has, _)| *has).map(|(_, head)| *head);
        let mut text = String::from("x_mm,y_mm,z_mm") + &heads.collect::<String>() + "\n";
        for point in points {
            let mut cells: Vec<String> = (1e3 * point.position).to_array().map(|number| shown(number, 4)).to_vec();
            if optional[0].0 {
                let turn = point.rotation.map(|rotation| rotation.normalize().to_array());
                cells.extend((0..4).map(|k| turn.map_or(String::new(), |turn| shown(turn[k], 9))));
            }
            let numbers = [(point.feed, 1e3), (point.time, 1.0), (point.spindle, 1.0 / RPM)];
            for ((number, scale), (has, _)) in numbers.into_iter().zip(&optional[1..]) {
                if *has {
                    cells.push(number.map_or(String::new(), |number| shown(number * scale, 6)));
                }
            }
            text.push_str(&(cells.join(",") + "\n"));
        }
        Ok(text)
    }
}

/// A name in lower-case letters and digits, without its unit and reduced to its last two words.
fn plain(name: &str) -> String {
    let (base, _) = log::split_unit(name);
    let words: Vec<String> = base.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase).collect();
    let filler = ["pos", "position", "pose", "p", "tcp", "translation", "t", "actual", "target"];
    let kept: Vec<&String> = words.iter().filter(|word| !word.is_empty() && !filler.contains(&word.as_str())).collect();
    match kept[..] {
        [] => words.concat(),
        [.., turn, last] if ["orientation", "rotation", "quat", "quaternion", "q"].contains(&turn.as_str()) => {
            format!("q{last}")
        }
        [.., last] => last.clone(),
    }
}

fn named(source: &Source, channels: &Channels) -> Result<Columns, Misread> {
    let names: Vec<String> = channels.names.iter().map(|name| plain(name)).collect();
    let find = |wanted: &[&str]| names.iter().position(|name| wanted.contains(&name.as_str()));
    let three = |wanted: [&[&str]; 3]| Some([find(wanted[0])?, find(wanted[1])?, find(wanted[2])?]);
    let bad = |found: String| Place::file(source.file).bad::<Misread>(found, ACCEPTED);
    let Some(position) = three([&["x", "tx", "px"], &["y", "ty", "py"], &["z", "tz", "pz"]]) else {
        let is_joint = names.iter().any(|name| matches!(name.as_str(), "j1" | "a1" | "q6" | "joint1" | "axis1" | "j0"));
        return Err(bad(match is_joint {
            true => "joint angles, which need the robot's kinematics to be a path".to_owned(),
            false => format!("no columns x, y, z in {}", files::input::quoted_names(&channels.names, KNOWN)),
        }));
    };
    let four = |[x, y, z]: [usize; 3], w: &[&str]| Some([x, y, z, find(w)?]);
    let by_letter = three([&["qx"], &["qy"], &["qz"]]).and_then(|turn| four(turn, &["qw"]));
    // ABB counts q1 to q4 from w on.
    let by_number = three([&["q2"], &["q3"], &["q4"]]).and_then(|turn| four(turn, &["q1"]));
    let rotation = match by_letter.or(by_number) {
        Some(turn) => Rotation::Quaternion(turn),
        None => match (three([&["rx"], &["ry"], &["rz"]]), three([&["a"], &["b"], &["c"]])) {
            (Some(turn), _) => Rotation::Vector(turn),
            (None, Some(turn)) => Rotation::Kuka(turn),
            (None, None) if names.iter().any(|name| name.starts_with('q')) => {
                return Err(bad("an incomplete quaternion".to_owned()));
            }
            (None, None) => Rotation::None,
        },
    };
    let feed = find(&["feed", "speed", "v", "velocity", "vorschub"]);
    let (time, spindle) = (find(&["time", "t", "timestamp", "zeit"]), find(&["spindle", "rpm", "n"]));
    Ok(Columns { position, rotation, feed, time, spindle })
}

/// Columns without names: three for a position, or seven for a pose whose order is given.
fn numbered(source: &Source, channels: &Channels) -> Result<Columns, Misread> {
    let bad = |found: String, accepted: &str| Err(Place::file(source.file).bad(found, accepted));
    let rotation = match (channels.names.len(), source.options.quaternions) {
        (3, _) => Rotation::None,
        (7, Some(QuaternionOrder::WLast)) => Rotation::Quaternion([3, 4, 5, 6]),
        (7, Some(QuaternionOrder::WFirst)) => Rotation::Quaternion([4, 5, 6, 3]),
        (7, None) => {
            let found = "quaternions without a header, whose w may come first or last".to_owned();
            return bad(
                found,
                "a header x y z qx qy qz qw in the order of the columns, or the order as a parameter, is expected",
            );
        }
        (6, _) => return bad("six columns without a header, which may be joint angles".to_owned(), ACCEPTED),
        (count, _) => return bad(format!("{count} columns without a header"), ACCEPTED),
    };
    Ok(Columns { position: [0, 1, 2], rotation, feed: None, time: None, spindle: None })
}

/// SI value of one unit of length.
fn length_scale(
    source: &Source,
    channels: &Channels,
    columns: &Columns,
    notes: &mut Vec<String>,
) -> Result<f64, Misread> {
    let bad = |found: &str| {
        Place::file(source.file).bad::<Misread>(found, "x, y, z in one unit, as x_mm or x [m], are expected")
    };
    let units: Vec<Option<&str>> = columns.position.iter().map(|&k| channels.units[k].as_deref()).collect();
    match units[..] {
        [x, y, z] if x != y || y != z => Err(bad("x, y, z in different units")),
        [Some("m"), ..] => Ok(1.0),
        [Some("mm"), ..] => Ok(1e-3),
        [Some("um"), ..] => Ok(1e-6),
        [Some(_), ..] => Err(bad("x, y, z in a unit that is not a length")),
        _ => {
            let farthest =
                columns.position.iter().flat_map(|&k| &channels.values[k]).fold(0.0_f64, |far, v| far.max(v.abs()));
            match source.options.length_unit {
                Some(unit) => Ok(unit),
                None if farthest > PLAUSIBLE => Err(bad("coordinates without a unit that are too far for metres")),
                None => {
                    notes.push("coordinates have no unit and are taken as metres".to_owned());
                    Ok(1.0)
                }
            }
        }
    }
}

/// SI value of one unit of a speed or a time.
fn factor(channels: &Channels, column: Option<usize>) -> f64 {
    match column.and_then(|k| channels.units[k].as_deref()) {
        Some("mm/s" | "ms") => 1e-3,
        Some("us") => 1e-6,
        Some("ns") => 1e-9,
        _ => 1.0,
    }
}

/// SI value of one unit of the spindle's speed.
fn rpm(channels: &Channels, columns: &Columns) -> f64 {
    match columns.spindle.and_then(|k| channels.units[k].as_deref()) {
        Some("rad/s") => 1.0,
        _ => RPM,
    }
}

/// Radians per unit of an angle: without a unit in the header, KUKA's angles are in degrees, rotation vectors in
/// radians.
fn angle_scale(channels: &Channels, rotation: &Rotation) -> f64 {
    let (first, is_degrees) = match rotation {
        Rotation::Vector(turn) => (turn[0], false),
        Rotation::Kuka(turn) => (turn[0], true),
        Rotation::None | Rotation::Quaternion(_) => return 1.0,
    };
    match channels.units[first].as_deref() {
        Some("deg") => 1_f64.to_radians(),
        Some("rad") => 1.0,
        _ if is_degrees => 1_f64.to_radians(),
        _ => 1.0,
    }
}

impl Rotation {
    /// The rotation of a row, `None` if its cells are empty; the error describes an invalid rotation.
    fn at(&self, cell: impl Fn(usize) -> f64, angle: f64) -> Result<Option<DQuat>, String> {
        let three = |turn: &[usize; 3]| turn.map(|k| angle * cell(k));
        let rotation = match self {
            Self::None => return Ok(None),
            Self::Quaternion(turn) => DQuat::from_array(turn.map(&cell)),
            Self::Vector(turn) => from_vector(DVec3::from_array(three(turn))),
            Self::Kuka(turn) => from_kuka(three(turn)),
        };
        match unit(rotation) {
            Some(rotation) => Ok(Some(rotation)),
            None if rotation.is_nan() => Ok(None),
            None => Err(format!("a quaternion of length {:.4}", rotation.length())),
        }
    }
}
