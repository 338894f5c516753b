"""A tool that another simulation carries: wrenches against closed forms, removal against a pass, an arm in MuJoCo."""

import importlib.util
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import robofin
from robofin.robot import ContactTool, MujocoTool, NewtonTool

EXAMPLE = Path(__file__).parents[1] / "examples/robot_in_the_loop.py"
#: Upper face of the plate of `field`, and a point in its middle [m].
TOP = 0.006
MIDDLE = np.array([0.03, 0.02, TOP])
LEVEL = np.eye(3)
STEP = 1e-3

has_mujoco = importlib.util.find_spec("mujoco") is not None
needs_mujoco = pytest.mark.skipif(not has_mujoco, reason="the adapter is NOT TESTED: mujoco is missing")
needs_newton = pytest.mark.skipif(not importlib.util.find_spec("newton"),
                                  reason="the adapter of Newton is NOT TESTED: newton is missing")
needs_arm = pytest.mark.skipif(not (has_mujoco and importlib.util.find_spec("robosuite")),
                               reason="the example with an arm is NOT TESTED: mujoco or robosuite is missing")


def sanding_tool(field: robofin.Field, tool: str, **keywords: float) -> ContactTool:
    """A tool that removes coating alone, so that its surface stays as it is."""
    return ContactTool(robofin.Workpiece(field), robofin.Tool(tool), robofin.Model("sanding"), **keywords)


def pressed(contact: ContactTool, position: np.ndarray, rotation: np.ndarray = LEVEL) -> np.ndarray:
    """Wrench of a tool that stands at a pose."""
    return contact.step(position.tolist(), rotation.tolist(), STEP)


def stiffness() -> float:
    return robofin.Model("sanding").values["winkler.stiffness"]


def test_a_level_pad_is_pushed_up_with_stiffness_times_area_times_depth(field: robofin.Field) -> None:
    radius, depth = 8e-3, 2e-4
    wrench = pressed(sanding_tool(field, "pad:radius=8mm"), MIDDLE - [0, 0, depth])
    force = stiffness() * np.pi * radius**2 * depth
    np.testing.assert_allclose(wrench[:3], [0, 0, force], rtol=2e-3, atol=1e-3 * force)
    np.testing.assert_allclose(wrench[3:], 0.0, atol=1e-3 * force * radius)


def test_a_tilted_pad_is_turned_back_with_the_moment_of_the_closed_form(field: robofin.Field) -> None:
    radius, depth, tilt = 8e-3, 4e-4, 0.02
    cosine, sine = np.cos(tilt), np.sin(tilt)
    turned = np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])
    wrench = pressed(sanding_tool(field, "pad:radius=8mm"), MIDDLE - [0, 0, depth], turned)
    # The forward edge is deeper. The patch on the plate lies beside the middle of the tilted face by depth times tan(tilt).
    moment = stiffness() * np.pi * radius**2 * (sine * radius**2 / 4.0 + depth**2 * sine / cosine)
    assert wrench[4] == pytest.approx(-moment, rel=0.01)
    assert wrench[2] == pytest.approx(stiffness() * np.pi * radius**2 * depth * cosine, rel=0.01)


def test_a_ball_is_pushed_out_with_the_force_of_the_closed_form(field: robofin.Field) -> None:
    radius, depth = 20e-3, 3e-4
    wrench = pressed(sanding_tool(field, "sphere:radius=20mm"), MIDDLE + [0, 0, radius - depth])
    force = np.pi * stiffness() * depth**2 * (radius - 2.0 * depth / 3.0)
    assert wrench[2] == pytest.approx(force, rel=5e-3)
    assert np.linalg.norm(wrench[:2]) < 1e-2 * force


def test_the_wrench_opposes_penetration_and_vanishes_in_the_air(field: robofin.Field) -> None:
    contact = sanding_tool(field, "pad:radius=8mm")
    depths = [-1e-3, 1e-4, 2e-4, 3e-4, -1e-3]
    found = [pressed(contact, MIDDLE - [0, 0, depth])[2] for depth in depths]
    assert found[0] == 0.0 and found[-1] == 0.0
    assert 0.0 < found[1] < found[2] < found[3]


def test_friction_acts_against_the_slip_of_the_rim(field: robofin.Field) -> None:
    radius, depth, friction = 20e-3, 2e-4, 0.3
    at = MIDDLE + [0, 0, radius - depth]
    smooth, rough = (pressed(sanding_tool(field, "wheel:radius=20mm,width=10mm", friction=share), at)
                     for share in (0.0, friction))
    # The lowest point of a wheel that spins about +y moves along -x, so the part pushes it along +x. The rim's direction
    # differs by up to 0.14 rad at the ends of the patch.
    assert rough[0] - smooth[0] == pytest.approx(friction * smooth[2], rel=5e-3)
    assert rough[2] == pytest.approx(smooth[2], rel=5e-3)
    # Against the spin.
    assert rough[4] - smooth[4] == pytest.approx(-friction * smooth[2] * (radius - depth), rel=2e-2)


def ground(contact: ContactTool, steps: int) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """A wheel that goes down on the plate and along it, by steps of a millisecond: times, centres and wrenches."""
    times = STEP * np.arange(steps)
    lift = np.interp(times, [0.0, 0.2], [1e-4, -3e-5]) + 5e-6 * np.sin(2 * np.pi * 9.0 * times)
    centres = np.array([0.022, 0.02, TOP + 0.02]) + np.stack([10e-3 * times, 0.0 * times, lift], axis=1)
    return times, centres, [pressed(contact, centre) for centre in centres]


def test_the_removal_is_that_of_a_pass_along_the_recorded_motion(field: robofin.Field) -> None:
    tool, model = robofin.Tool("wheel:radius=20mm,width=10mm"), robofin.Model("grinding")
    contact = ContactTool(robofin.Workpiece(field), tool, model)
    times, centres, wrenches = ground(contact, 1200)
    up, across = np.tile([0.0, 0.0, 1.0], (1200, 1)), np.tile([0.0, 1.0, 0.0], (1200, 1))
    path = robofin.Path(times, centres - 0.02 * up, up, across)
    simulation = robofin.Simulation(robofin.Workpiece(field), tool, model, controller="replay")
    record = simulation.run(path)
    # The pass takes steps of up to 0.3 mm, the tool steps of 0.01 mm.
    assert contact.removed_volume == pytest.approx(record.removed_volume, rel=0.02)
    rate = model.values["preston-threshold.grind_rate"]
    assert contact.removed_volume == pytest.approx(rate * contact.impulse, rel=1e-2)
    assert contact.time == pytest.approx(1.2)
    assert contact.impulse == pytest.approx(STEP * sum(wrench[2] for wrench in wrenches), rel=0.05)


def test_the_workpiece_is_a_copy_that_shows_what_was_removed(field: robofin.Field) -> None:
    given = robofin.Workpiece(field)
    contact = ContactTool(given, robofin.Tool("wheel:radius=20mm,width=10mm"), robofin.Model("grinding"))
    ground(contact, 600)
    half = contact.workpiece().field.volume()
    assert given.field == field
    assert field.volume() - half == pytest.approx(contact.removed_volume, rel=0.03)
    assert contact.workpiece().field.volume() == half


def test_the_same_motion_gives_the_same_bytes(field: robofin.Field) -> None:
    tools = [ContactTool(robofin.Workpiece(field), robofin.Tool("wheel:radius=20mm,width=10mm"), robofin.Model("grinding"),
                         friction=0.2) for _ in range(2)]
    first, second = (np.array(ground(tool, 300)[2]) for tool in tools)
    np.testing.assert_array_equal(first, second)
    assert tools[0].workpiece().field == tools[1].workpiece().field


@pytest.mark.parametrize(("change", "message"), [
    (lambda tool: tool.step([0.0, 0.0, float("nan")], LEVEL.tolist(), STEP), "finite position"),
    (lambda tool: tool.step(MIDDLE.tolist(), (-LEVEL).tolist(), STEP), "right-handed"),
    (lambda tool: tool.step(MIDDLE.tolist(), (2 * LEVEL).tolist(), STEP), "length 1"),
    (lambda tool: tool.step(MIDDLE.tolist(), LEVEL.tolist(), 0.0), "duration is 0"),
])
def test_poses_that_cannot_be_are_refused(field: robofin.Field, change: Callable[[ContactTool], object],
                                          message: str) -> None:
    with pytest.raises(robofin.WrongUse, match=message):
        change(sanding_tool(field, "pad:radius=8mm"))


def test_friction_is_not_negative(field: robofin.Field) -> None:
    with pytest.raises(robofin.WrongUse, match="friction is -0.1"):
        sanding_tool(field, "pad:radius=8mm", friction=-0.1)


#: A pad of 2 kg on a vertical slide.
SLIDE = """
<mujoco><option timestep="0.001"/><worldbody><body pos="0.23 -0.08 0.5"><joint name="slide" type="slide" axis="0 0 1"
damping="150"/><inertial pos="0 0 0.01" mass="2" diaginertia="1e-3 1e-3 1e-3"/><site name="tool"/></body></worldbody></mujoco>
"""


@needs_mujoco
def test_a_pad_on_a_slide_comes_to_rest_where_the_contact_carries_its_weight(field: robofin.Field) -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string(SLIDE)
    data = mujoco.MjData(model)
    # The plate lies 0.4 m up, turned by a quarter about z.
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    place = np.array([0.23, -0.08, 0.4]) - turn @ [0.03, 0.02, 0.0]
    contact = sanding_tool(field, "pad:radius=8mm")
    tool = MujocoTool(contact, model, data, "tool", position=place, rotation=turn)
    data.qpos[0] = 0.4 + TOP + 5e-4 - 0.5
    for _ in range(2000):
        mujoco.mj_step1(model, data)
        wrench = tool.step()
        mujoco.mj_step2(model, data)
    weight = 2.0 * 9.81
    assert wrench[2] == pytest.approx(weight, rel=1e-3) and np.abs(data.qvel).max() < 1e-6
    depth = 0.4 + TOP - (0.5 + data.qpos[0])
    assert depth == pytest.approx(weight / (stiffness() * np.pi * 8e-3**2), rel=5e-3)


@needs_newton
def test_a_pad_on_a_slide_of_newton_comes_to_rest_where_the_contact_carries_its_weight(field: robofin.Field) -> None:
    import newton
    import warp

    builder = newton.ModelBuilder()
    # The body hangs upside down, so that its frame and the tool's differ; the slide is vertical.
    start, flip = 0.4 + TOP + 5e-4, warp.quat(1.0, 0.0, 0.0, 0.0)
    body = builder.add_link(xform=warp.transform((0.23, -0.08, start + 0.02), flip), mass=2.0, com=(0.0, 0.0, 0.01),
                            inertia=warp.mat33(np.eye(3) * 1e-3))
    slide = builder.add_joint_prismatic(-1, body, axis=(0.0, 0.0, 1.0),
                                        parent_xform=warp.transform((0.23, -0.08, start + 0.02), warp.quat_identity()),
                                        child_xform=warp.transform((0.0, 0.0, 0.0), flip))
    builder.add_articulation([slide])
    model = builder.finalize(device="cpu")
    solver, now, then = newton.solvers.SolverFeatherstone(model), model.state(), model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, now)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    place = np.array([0.23, -0.08, 0.4]) - turn @ [0.03, 0.02, 0.0]
    contact = sanding_tool(field, "pad:radius=8mm")
    tool = NewtonTool(contact, model, body, at=(0.0, 0.0, 0.02), axes=np.diag([1.0, -1.0, -1.0]), position=place,
                      rotation=turn)
    for _ in range(2000):
        now.clear_forces()
        wrench = tool.step(now, STEP)
        forces = now.body_f.numpy()
        forces[body, 2] -= 150.0 * float(now.joint_qd.numpy()[0])
        now.body_f.assign(forces)
        solver.step(now, then, None, None, STEP)
        now, then = then, now
    weight = 2.0 * 9.81
    assert wrench[2] == pytest.approx(weight, rel=1e-3) and abs(float(now.joint_qd.numpy()[0])) < 1e-5
    depth = 0.4 + TOP - (float(now.body_q.numpy()[body, 2]) - 0.02)
    # Newton keeps poses in 32 bits: 0.4 m to 3e-8 m.
    assert depth == pytest.approx(weight / (stiffness() * np.pi * 8e-3**2), rel=5e-3)


@needs_newton
def test_a_wrench_at_a_tool_beside_the_centre_of_mass_is_moved_there(field: robofin.Field) -> None:
    import newton
    import warp

    builder = newton.ModelBuilder()
    depth, half = 2e-4, np.sqrt(0.5)
    # A quarter turn about z: the body's x is the world's y. The centre of mass is 0.1 m ahead along it.
    body = builder.add_body(xform=warp.transform((0.03, 0.02, TOP - depth), warp.quat(0.0, 0.0, half, half)), mass=1.0,
                            com=(0.1, 0.0, 0.0), inertia=warp.mat33(np.eye(3)))
    model = builder.finalize(device="cpu")
    state = model.state()
    wrench = NewtonTool(sanding_tool(field, "pad:radius=8mm"), model, body).step(state, STEP)
    given = state.body_f.numpy()[body]
    np.testing.assert_allclose(given[:3], wrench[:3], rtol=1e-6)
    # From the centre of mass the tool lies 0.1 m along -y, so a force along +z turns about -x.
    assert given[3] - wrench[3] == pytest.approx(-0.1 * wrench[2], rel=1e-4)
    assert given[4:] == pytest.approx(wrench[4:], abs=1e-4)


@needs_arm
def test_an_arm_grinds_a_weld_as_a_pass_along_its_motion_would() -> None:
    words = ["--seconds", "1.5", "--force", "25"]
    output = subprocess.run([sys.executable, str(EXAMPLE), *words], capture_output=True, text=True, check=True).stdout
    lines = output.splitlines()
    assert lines[0].startswith("force in contact: mean") and lines[1].startswith("removed ")
    assert float(lines[1].split()[1]) > 1.0
    share = float(lines[3].split("mm³, ")[1].split(" %")[0])
    assert abs(share) < 2.0, output


@needs_mujoco
def test_the_example_is_strictly_typed() -> None:
    configuration = str(EXAMPLE.parents[1] / "pyproject.toml")
    output = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--config-file", configuration, str(EXAMPLE)],
                            capture_output=True, text=True, cwd=EXAMPLE.parents[1] / "tests")
    assert output.returncode == 0, output.stdout
