use super::holes::Closed;
use super::skin::Corners;
use crate::clean::EdgeMap;
use crate::Mesh;
pub(super) struct Bodies;
impl Bodies { pub(super) fn of(_: &Mesh, _: &EdgeMap, _: bool) -> Option<Self> { None } }
pub(super) struct Walls { pub(super) kept: Mesh, pub(super) sign_only: Vec<Corners>, pub(super) distance_only: Vec<Corners> }
pub(super) fn within(_: &Closed, _: &EdgeMap, _: &Bodies, _: f64) -> Option<Walls> { None }
