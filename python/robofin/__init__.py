"""RoboFin: welded workpieces, signed distance fields, grinding and sanding in simulation.

SI units, right-handed frames with z up, inside is negative. Long calls release Python's lock. What is refused or fails
raises `RoboFinError` with the program's message; `WrongUse` is the part of it that the caller can put right.

    import robofin

    workpiece = robofin.weld(robofin.Mesh.bundled(), seed=7, voxel=5e-4)
    tool = robofin.Tool("wheel:radius=50mm,width=20mm")
    simulation = robofin.Simulation(workpiece, tool, robofin.Model("grinding"), force=15.0)
    path, _ = workpiece.weld_path(tool, feed=5e-3)
    record = simulation.run(path)
    print(record.removed_volume, "m³")
"""

from importlib.util import find_spec

from ._campaign import Campaign, Report, Study
from ._evaluation import Evaluation, Policy, baseline, evaluate
from ._program import dataset, demo, run
from ._robofin import (
    Batch,
    EnvironmentSnapshot,
    Field,
    Mesh,
    Model,
    Path,
    Record,
    RoboFinError,
    Simulation,
    SimulationSnapshot,
    Snapshot,
    Task,
    Tool,
    Trial,
    Workpiece,
    WrongUse,
    __version__,
    photograph,
    weld,
)
from ._robofin import effects_of_library as effects
from ._suites import Suite, suite

if find_spec("gymnasium"):
    from ._gymnasium import register

    register()

__all__ = [
    "Batch",
    "Campaign",
    "EnvironmentSnapshot",
    "Evaluation",
    "Field",
    "Mesh",
    "Model",
    "Path",
    "Policy",
    "Record",
    "Report",
    "RoboFinError",
    "Simulation",
    "SimulationSnapshot",
    "Snapshot",
    "Study",
    "Suite",
    "Task",
    "Tool",
    "Trial",
    "Workpiece",
    "WrongUse",
    "__version__",
    "baseline",
    "dataset",
    "demo",
    "effects",
    "evaluate",
    "photograph",
    "run",
    "suite",
    "weld",
]
