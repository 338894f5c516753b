"""Passes and steps against closed forms, snapshots against themselves."""

import time

import numpy as np
import pytest

import robofin

TOOL = robofin.Tool("wheel:radius=50mm,width=10mm")
NORMALS = [[0, 0, 1], [0, 0, 1]]


def path(feed: float = 5e-3) -> robofin.Path:
    return robofin.Path.along([[0.02, 0.02, 0.006], [0.04, 0.02, 0.006]], NORMALS, feed)


def simulation(field: robofin.Field, model: robofin.Model | None = None, **keywords: object) -> robofin.Simulation:
    model = model or robofin.Model("grinding")
    return robofin.Simulation(robofin.Workpiece(field), TOOL, model, **keywords)  # type: ignore[arg-type]


def step_along(work: robofin.Simulation, steps: range) -> list[robofin.Record]:
    place = lambda k: ([0.02 + 5e-4 * (k + 1), 0.02, 0.006], [0, 0, 1], [0, 1, 0])
    return [work.step(place(k), 0.04, force=15.0) for k in steps]


def test_a_pass_removes_what_the_law_says(field: robofin.Field) -> None:
    work = simulation(field, force=12.0)
    record = work.run(path())
    rate = robofin.Model("grinding").values["preston-threshold.grind_rate"]
    assert record.removed_volume == pytest.approx(rate * 12.0 * record.duration, rel=3e-3)
    assert field.volume() - work.workpiece.field.volume() == pytest.approx(record.removed_volume, rel=0.02)
    assert record.positions.shape == (len(record.times), 3)
    assert work.passes == 1 and np.median(record.forces) == pytest.approx(12.0, rel=1e-3)


def test_steps_remove_what_the_law_says_and_end_as_a_pass(field: robofin.Field) -> None:
    work = simulation(field, controller="admittance", period=4e-3)
    records = step_along(work, range(25))
    rate = robofin.Model("grinding").values["preston-threshold.grind_rate"]
    impulse = sum(record.impulse for record in records)
    assert sum(record.removed_volume for record in records) == pytest.approx(rate * impulse, rel=1e-2)
    assert work.travel < 0.0 and work.passes == 0
    work.end_pass()
    assert work.passes == 1


def test_a_moment_that_is_put_back_goes_on_to_the_same_bytes(field: robofin.Field) -> None:
    dulling = robofin.Model("grinding").with_effect("grit-dulling", dulling_volume="20 mm^3")
    work = simulation(field, dulling, controller="admittance", period=4e-3)
    step_along(work, range(6))
    moment, before = work.snapshot(), work.workpiece.field
    first = [record.removed_volume for record in step_along(work, range(6, 14))]
    ended = work.workpiece.field
    work.restore(moment)
    assert work.workpiece.field == before
    assert [record.removed_volume for record in step_along(work, range(6, 14))] == first
    assert work.workpiece.field == ended and ended != before
    assert ended.to_nanovdb() == work.workpiece.field.to_nanovdb()


def test_workpieces_share_bricks_until_they_change(field: robofin.Field) -> None:
    workpiece = robofin.Workpiece(field)
    moment = workpiece.snapshot()
    robofin.Simulation(workpiece, TOOL, robofin.Model("grinding")).run(path())
    assert workpiece.field != field
    workpiece.restore(moment)
    assert workpiece.field == field


def test_an_effect_by_name_and_its_formula_do_the_same(field: robofin.Field) -> None:
    base = robofin.Model("grinding")
    listed = base.with_effect("pressure-exponent")
    assert "pressure-exponent" in listed.text and listed.process == "grinding"
    typed = base.with_formula("rate * (1 + a * slip_speed)", a="0.02 s/m")
    assert typed.values["formula.a"] == pytest.approx(0.02)
    plain, faster = (simulation(field, model).run(path()).removed_volume for model in (base, typed))
    # The rim of a wheel of 50 mm at 6000 rpm moves at 31.4 m/s.
    assert faster / plain == pytest.approx(1 + 0.02 * 31.4, rel=0.01)
    assert base.with_value("winkler.stiffness", "30 MPa/mm").values["winkler.stiffness"] == 3e10


def test_models_and_steps_that_cannot_be_used_are_refused(field: robofin.Field) -> None:
    with pytest.raises(robofin.RoboFinError, match="grit-dulling"):
        robofin.Model("grinding").with_effect("grit-duling")
    with pytest.raises(robofin.WrongUse, match=r"mm\^3 is accepted"):
        robofin.Model("grinding").with_effect("grit-dulling", dulling_volume="3 mm")
    with pytest.raises(robofin.WrongUse, match="grinding"):
        robofin.Model("milling")
    with pytest.raises(robofin.WrongUse, match="wheel"):
        robofin.Tool("chisel:radius=5mm")
    with pytest.raises(robofin.WrongUse, match="duration"):
        simulation(field).step(([0, 0, 0], [0, 0, 1], [0, 1, 0]), 0.0)
    with pytest.raises(robofin.WrongUse, match="along each other"):
        simulation(field).step(([0, 0, 0], [0, 0, 1], [0, 0, 1]), 0.1)
    with pytest.raises(robofin.RoboFinError, match="force setpoint"):
        simulation(field, force=-1.0).run(path())


def test_other_threads_run_during_a_pass(field: robofin.Field) -> None:
    import threading

    counted, ended = [0], threading.Event()

    def count() -> None:
        while not ended.is_set():
            counted[0] += 1
            time.sleep(0)

    other = threading.Thread(target=count)
    other.start()
    before = counted[0]
    simulation(field, controller="admittance", period=5e-4).run(path())
    during = counted[0] - before
    ended.set()
    other.join()
    assert during > 10
