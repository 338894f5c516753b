//! The workpiece as a model for robot simulators: MJCF (MuJoCo) and URDF (ROS).
//!
//! Both name two mesh files beside them, one to look at and one to collide with, and state mass, centre of mass and the
//! full inertia tensor. Units are metres and kilograms; the frame is the part's own. The part is fixed to the world.

use glam::DVec3;
use roxmltree::{Document, Node};

use crate::mass::MassProperties;

/// Name of the mesh file to look at.
pub const VISUAL_FILE: &str = "visual.stl";
/// Name of the mesh file to collide with.
pub const COLLISION_FILE: &str = "collision.stl";

/// Mass, centre of mass and inertia that a model states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedMass {
    /// Mass [kg].
    pub mass: f64,
    /// Centre of mass [m].
    pub centre: DVec3,
    /// Inertia about the centre: xx, yy, zz, xy, xz, yz [kg m²].
    pub inertia: [f64; 6],
}

impl StatedMass {
    pub(crate) fn of(mass: &MassProperties) -> Self {
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = mass.inertia;
        Self { mass: mass.mass, centre: mass.centre, inertia: [xx, yy, zz, xy, xz, yz] }
    }

    /// Returns the greatest difference from exact values: of mass and inertia relative to mass and largest moment, of
    /// the centre relative to the radius of gyration.
    pub fn apart(&self, exact: &MassProperties) -> f64 {
        let largest = exact.principal_moments[2];
        let inertia = self.inertia.iter().zip(Self::of(exact).inertia).map(|(a, b)| (a - b).abs() / largest);
        let centre = self.centre.distance(exact.centre) / (largest / exact.mass).sqrt();
        inertia.fold((self.mass / exact.mass - 1.0).abs().max(centre), f64::max)
    }
}

/// Writes the part as MJCF: a body without joint, so fixed to the world.
pub fn write_mjcf(mass: &MassProperties) -> String {
    let stated = StatedMass::of(mass);
    format!(
        r#"<mujoco model="workpiece">
  <asset>
    <mesh name="visual" file="{VISUAL_FILE}"/>
    <mesh name="collision" file="{COLLISION_FILE}"/>
  </asset>
  <worldbody>
    <!-- Without a joint the part is fixed to the world; a freejoint element inside the body lets it move. -->
    <body name="workpiece">
      <inertial pos="{}" mass="{}" fullinertia="{}"/>
      <geom name="visual" type="mesh" mesh="visual" contype="0" conaffinity="0" group="2" rgba="0.56 0.58 0.6 1"/>
      <geom name="collision" type="mesh" mesh="collision" group="3"/>
    </body>
  </worldbody>
</mujoco>
"#,
        spaced(&stated.centre.to_array()),
        stated.mass,
        spaced(&stated.inertia)
    )
}

/// Writes the part as URDF: a link fixed to the link `world`.
pub fn write_urdf(mass: &MassProperties) -> String {
    let StatedMass { mass, centre, inertia: [xx, yy, zz, xy, xz, yz] } = StatedMass::of(mass);
    format!(
        r#"<?xml version="1.0"?>
<robot name="workpiece">
  <link name="world"/>
  <link name="workpiece">
    <inertial>
      <origin xyz="{}" rpy="0 0 0"/>
      <mass value="{mass}"/>
      <inertia ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"/>
    </inertial>
    <visual>
      <geometry><mesh filename="{VISUAL_FILE}"/></geometry>
      <material name="steel"><color rgba="0.56 0.58 0.6 1"/></material>
    </visual>
    <collision>
      <geometry><mesh filename="{COLLISION_FILE}"/></geometry>
    </collision>
  </link>
  <joint name="world_to_workpiece" type="fixed">
    <parent link="world"/>
    <child link="workpiece"/>
  </joint>
</robot>
"#,
        spaced(&centre.to_array())
    )
}

fn spaced(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// Reads the mass that an MJCF file states; `None` if the text is no such file or names other meshes.
pub fn read_mjcf(text: &str) -> Option<StatedMass> {
    let file = Document::parse(text).ok()?;
    let inertial = element(file.root_element(), "inertial")?;
    let named: Vec<&str> = file.descendants().filter_map(|node| node.attribute("file")).collect();
    Some(StatedMass {
        mass: inertial.attribute("mass")?.parse().ok()?,
        centre: DVec3::from(numbers(inertial.attribute("pos")?)?),
        inertia: numbers(inertial.attribute("fullinertia")?)?,
    })
    .filter(|_| named == [VISUAL_FILE, COLLISION_FILE])
}

/// Reads the mass that a URDF file states; `None` if the text is no such file or names other meshes.
pub fn read_urdf(text: &str) -> Option<StatedMass> {
    let file = Document::parse(text).ok()?;
    let [origin, mass, inertia] = ["origin", "mass", "inertia"].map(|name| element(file.root_element(), name));
    let named: Vec<&str> = file.descendants().filter_map(|node| node.attribute("filename")).collect();
    let value = |name: &str| inertia?.attribute(name)?.parse::<f64>().ok();
    Some(StatedMass {
        mass: mass?.attribute("value")?.parse().ok()?,
        centre: DVec3::from(numbers(origin?.attribute("xyz")?)?),
        inertia: [value("ixx")?, value("iyy")?, value("izz")?, value("ixy")?, value("ixz")?, value("iyz")?],
    })
    .filter(|_| named == [VISUAL_FILE, COLLISION_FILE])
}

fn element<'a>(root: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    root.descendants().find(|node| node.has_tag_name(name))
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let values: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    values.try_into().ok()
}
