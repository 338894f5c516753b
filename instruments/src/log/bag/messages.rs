//! Supported message types. Their definitions are those of the ROS packages `geometry_msgs`, `sensor_msgs`, `std_msgs`
//! and `tf2_msgs`, which are the same in all distributions of ROS 2.

use std::borrow::Cow;

use super::cdr::Cdr;

/// Values of one message, or of one transform of it.
pub(super) struct Sample {
    /// Suffix of the track's name after the topic: empty, or beginning with a slash.
    pub(super) suffix: String,
    /// Stamp in the message [ns], if non-zero.
    pub(super) stamp: Option<i64>,
    /// True if it is a pose.
    pub(super) is_pose: bool,
    pub(super) fields: Vec<Field>,
}

/// One value.
pub(super) struct Field {
    pub(super) name: Cow<'static, str>,
    pub(super) unit: Option<&'static str>,
    pub(super) value: f64,
}

/// A message type.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// Consists of `f64` only, after a header if the flag is set.
    Fixed(&'static Fixed),
    JointState,
    Transform,
    Transforms,
    Number {
        is_wide: bool,
    },
    Numbers {
        is_wide: bool,
    },
}

/// A message type that consists of `f64` only.
pub(super) struct Fixed {
    name: &'static str,
    is_stamped: bool,
    is_pose: bool,
    parts: Parts,
}

const XYZ: &[&str] = &["/x", "/y", "/z"];
const XYZW: &[&str] = &["/x", "/y", "/z", "/w"];
const ALONE: &[&str] = &[""];

const FIXED: [Fixed; 12] = [
    fixed("geometry_msgs/Wrench", &[("force", XYZ, Some("N")), ("torque", XYZ, Some("Nm"))]),
    stamped("geometry_msgs/WrenchStamped", &[("wrench/force", XYZ, Some("N")), ("wrench/torque", XYZ, Some("Nm"))]),
    pose(fixed("geometry_msgs/Pose", &[("position", XYZ, Some("m")), ("orientation", XYZW, None)])),
    pose(stamped("geometry_msgs/PoseStamped", &[("pose/position", XYZ, Some("m")), ("pose/orientation", XYZW, None)])),
    pose(fixed("geometry_msgs/Transform", &[("translation", XYZ, Some("m")), ("rotation", XYZW, None)])),
    fixed("geometry_msgs/Twist", &[("linear", XYZ, Some("m/s")), ("angular", XYZ, Some("rad/s"))]),
    stamped("geometry_msgs/TwistStamped", &[("twist/linear", XYZ, Some("m/s")), ("twist/angular", XYZ, Some("rad/s"))]),
    fixed("geometry_msgs/Vector3", &[("vector", XYZ, None)]),
    stamped("geometry_msgs/Vector3Stamped", &[("vector", XYZ, None)]),
    pose(fixed("geometry_msgs/Point", &[("point", XYZ, Some("m"))])),
    pose(stamped("geometry_msgs/PointStamped", &[("point", XYZ, Some("m"))])),
    stamped("sensor_msgs/Temperature", &[("temperature", ALONE, Some("°C")), ("variance", ALONE, None)]),
];

/// Vectors and quaternions in order: path, components, unit.
type Parts = &'static [(&'static str, &'static [&'static str], Option<&'static str>)];

const fn fixed(name: &'static str, parts: Parts) -> Fixed {
    Fixed { name, is_stamped: false, is_pose: false, parts }
}

const fn stamped(name: &'static str, parts: Parts) -> Fixed {
    Fixed { name, is_stamped: true, is_pose: false, parts }
}

const fn pose(fixed: Fixed) -> Fixed {
    Fixed { is_pose: true, ..fixed }
}

/// The types that are not `Fixed`.
const OTHERS: [(&str, Kind); 7] = [
    ("geometry_msgs/TransformStamped", Kind::Transform),
    ("tf2_msgs/TFMessage", Kind::Transforms),
    ("sensor_msgs/JointState", Kind::JointState),
    ("std_msgs/Float64", Kind::Number { is_wide: true }),
    ("std_msgs/Float32", Kind::Number { is_wide: false }),
    ("std_msgs/Float64MultiArray", Kind::Numbers { is_wide: true }),
    ("std_msgs/Float32MultiArray", Kind::Numbers { is_wide: false }),
];

/// Names of the supported types.
pub(super) fn names() -> Vec<&'static str> {
    FIXED.iter().map(|fixed| fixed.name).chain(OTHERS.iter().map(|(name, _)| *name)).collect()
}

impl Kind {
    /// The type with this name, with or without `msg` in it.
    pub(super) fn of(name: &str) -> Option<Self> {
        let name = name.replace("/msg/", "/");
        let fixed = FIXED.iter().find(|fixed| fixed.name == name).map(Self::Fixed);
        fixed.or_else(|| OTHERS.iter().find(|(other, _)| *other == name).map(|(_, kind)| *kind))
    }

    /// Decodes the values of a message; the error describes the fault.
    pub(super) fn decode(self, data: &[u8]) -> Result<Vec<Sample>, String> {
        let mut cdr = Cdr::new(data)?;
        let samples = match self {
            Self::Fixed(fixed) => vec![fixed.decode(&mut cdr)?],
            Self::JointState => vec![joints(&mut cdr)?],
            Self::Transform => vec![transform(&mut cdr)?],
            Self::Transforms => (0..cdr.length(8)?).map(|_| transform(&mut cdr)).collect::<Result<_, _>>()?,
            Self::Number { is_wide } => {
                let value = if is_wide { cdr.f64()? } else { f64::from(cdr.f32()?) };
                vec![Sample::plain(vec![Field { name: "data".into(), unit: None, value }])]
            }
            Self::Numbers { is_wide } => vec![numbers(&mut cdr, is_wide)?],
        };
        cdr.finish()?;
        Ok(samples)
    }
}

impl Sample {
    fn plain(fields: Vec<Field>) -> Self {
        Self { suffix: String::new(), stamp: None, is_pose: false, fields }
    }
}

impl Fixed {
    fn decode(&self, cdr: &mut Cdr) -> Result<Sample, String> {
        let stamp = if self.is_stamped { header(cdr)? } else { None };
        let fields = parts(self.parts, cdr)?;
        Ok(Sample { suffix: String::new(), stamp, is_pose: self.is_pose, fields })
    }
}

fn parts(parts: Parts, cdr: &mut Cdr) -> Result<Vec<Field>, String> {
    let named = parts.iter().flat_map(|(path, ends, unit)| ends.iter().map(move |end| (format!("{path}{end}"), *unit)));
    named.map(|(name, unit)| Ok(Field { name: name.into(), unit, value: cdr.f64()? })).collect()
}

/// Reads a `std_msgs/Header`: its stamp, if non-zero.
fn header(cdr: &mut Cdr) -> Result<Option<i64>, String> {
    let (seconds, nanoseconds) = (i64::from(cdr.u32()?.cast_signed()), i64::from(cdr.u32()?));
    cdr.string()?;
    let stamp = seconds * 1_000_000_000 + nanoseconds;
    Ok((stamp != 0).then_some(stamp))
}

/// Reads a `TransformStamped`; its track is named after the child frame.
fn transform(cdr: &mut Cdr) -> Result<Sample, String> {
    const PARTS: Parts = &[("transform/translation", XYZ, Some("m")), ("transform/rotation", XYZW, None)];
    let stamp = header(cdr)?;
    let child = cdr.string()?;
    Ok(Sample { suffix: format!("/{child}"), stamp, is_pose: true, fields: parts(PARTS, cdr)? })
}

fn joints(cdr: &mut Cdr) -> Result<Sample, String> {
    let stamp = header(cdr)?;
    let names: Vec<String> = (0..cdr.length(4)?).map(|_| cdr.string()).collect::<Result<_, _>>()?;
    let mut fields = Vec::new();
    for quantity in ["position", "velocity", "effort"] {
        let values = cdr.numbers(true)?;
        if !values.is_empty() && values.len() != names.len() {
            return Err(format!("{} values of {quantity} for {} joints", values.len(), names.len()));
        }
        let named = names.iter().zip(values);
        fields.extend(named.map(|(name, value)| Field {
            name: format!("{quantity}/{name}").into(),
            unit: None,
            value,
        }));
    }
    Ok(Sample { stamp, ..Sample::plain(fields) })
}

/// Reads a `MultiArray`: its layout is a list of label, size and stride, and an offset.
fn numbers(cdr: &mut Cdr, is_wide: bool) -> Result<Sample, String> {
    for _ in 0..cdr.length(12)? {
        cdr.string()?;
        cdr.u32()?;
        cdr.u32()?;
    }
    cdr.u32()?;
    let values = cdr.numbers(is_wide)?.into_iter().enumerate();
    let fields = values.map(|(k, value)| Field { name: format!("data/{k}").into(), unit: None, value });
    Ok(Sample::plain(fields.collect()))
}
