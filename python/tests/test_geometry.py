"""Meshes and fields against exact geometry."""

from pathlib import Path

import numpy as np
import pytest

import robofin


def test_a_mesh_from_arrays_has_the_size_of_its_box(plate: robofin.Mesh) -> None:
    assert plate.volume == pytest.approx(0.06 * 0.04 * 0.006, rel=1e-12)
    assert plate.area == pytest.approx(2 * (0.06 * 0.04 + 0.06 * 0.006 + 0.04 * 0.006), rel=1e-12)
    assert plate.positions.shape == (8, 3) and plate.triangles.shape == (12, 3)
    np.testing.assert_array_equal(plate.bounds, [[0, 0, 0], [0.06, 0.04, 0.006]])


def test_distances_gradients_and_normals_above_a_plate_are_exact(field: robofin.Field) -> None:
    random = np.random.default_rng(1)
    points = random.uniform([0.01, 0.01, 0.005], [0.05, 0.03, 0.007], (5000, 3))
    np.testing.assert_allclose(field.sample(points), points[:, 2] - 0.006, atol=1e-8)
    np.testing.assert_allclose(field.gradient(points), np.tile([0, 0, 1], (5000, 1)), atol=1e-4)
    np.testing.assert_allclose(field.normal(points), np.tile([0, 0, 1], (5000, 1)), atol=1e-4)
    assert field.sample(points).dtype == np.float32
    assert field.volume() == pytest.approx(0.06 * 0.04 * 0.006, rel=2e-3)


def test_arguments_may_be_lists_views_and_other_numbers(field: robofin.Field) -> None:
    points = np.random.default_rng(2).uniform(0.01, 0.03, (40, 6))
    expected = field.sample(np.ascontiguousarray(points[:, ::2]))
    np.testing.assert_array_equal(field.sample(points[:, ::2]), expected)
    np.testing.assert_array_equal(field.sample(points[:, ::2].tolist()), expected)
    np.testing.assert_array_equal(field.sample([[0, 0, 1]]), [field.band])


def test_arrays_are_shared_with_other_libraries_by_dlpack(field: robofin.Field) -> None:
    values = field.sample(np.random.default_rng(3).uniform(0.01, 0.03, (40, 3)))
    assert values.__dlpack_device__() == (1, 0), "the CPU"
    np.testing.assert_array_equal(np.from_dlpack(values), values)
    assert np.shares_memory(np.from_dlpack(values), values)


def test_torch_shares_the_memory_of_an_array(field: robofin.Field) -> None:
    torch = pytest.importorskip("torch", reason="sharing with PyTorch is NOT TESTED: torch is missing")
    values = field.sample(np.random.default_rng(3).uniform(0.01, 0.03, (40, 3)))
    shared = torch.from_dlpack(values)
    assert shared.data_ptr() == values.ctypes.data and shared.dtype == torch.float32
    shared[7] = 0.5
    assert values[7] == 0.5


def test_a_field_is_read_as_it_was_written(field: robofin.Field, tmp_path: Path) -> None:
    field.write(tmp_path / "plate.nvdb")
    again = robofin.Field.read(tmp_path / "plate.nvdb")
    assert again == field and again.voxel == 5e-4
    assert robofin.Field.read(tmp_path / "plate.nvdb").to_nanovdb() == field.to_nanovdb()
    places, values = field.bricks()
    assert places.shape == (len(values), 3) and values.shape[1] == 512
    with pytest.raises(robofin.WrongUse, match=r"plate\.nvdb"):
        field.write(tmp_path / "plate.nvdb")
    field.write(tmp_path / "plate.nvdb", force=True)
    with pytest.raises(robofin.RoboFinError, match="it has|has phi"):
        robofin.Field.read(tmp_path / "plate.nvdb", grid="density")


def test_the_surface_lies_on_the_zero_set(field: robofin.Field) -> None:
    surface = field.surface()
    assert np.abs(field.sample(surface.positions)).max() < 0.05 * field.voxel
    assert surface.volume == pytest.approx(field.volume(), rel=2e-3)


def test_what_cannot_be_used_is_refused_with_what_is_accepted(plate: robofin.Mesh, field: robofin.Field) -> None:
    with pytest.raises(robofin.WrongUse, match=r"\[n, 3\] is accepted"):
        field.sample(np.zeros((4, 2)))
    with pytest.raises(robofin.WrongUse, match="name vertex 9, and there are 8"):
        robofin.Mesh(plate.positions, [[0, 1, 9]])
    with pytest.raises(robofin.WrongUse, match="missing.stl: no such file"):
        robofin.Mesh.read("missing.stl")
    with pytest.raises(robofin.RoboFinError, match="voxel"):
        robofin.Field.bake(plate, 1e-7)
    with pytest.raises(robofin.WrongUse, match="winding"):
        robofin.Field.bake(plate, 1e-3, sign="maybe")
    with pytest.raises(robofin.WrongUse, match="dose and removed"):
        field.channel("colour", [[0, 0, 0]])
