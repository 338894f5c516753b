"""The notebooks: each runs from its first cell to its last, and is kept without outputs."""

import importlib.util
import json
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
#: Packages that a notebook needs beyond those of all.
NEEDED = {"train-a-policy": ["torch"]}
#: Longest time of one cell [s]; a notebook takes less than two minutes on two free cores.
PATIENCE = 900


def missing(names: list[str]) -> list[str]:
    return [name for name in names if not importlib.util.find_spec(name)]


def test_there_are_the_notebooks_that_the_documentation_names() -> None:
    documented = (FOLDER.parents[1] / "docs/python.md").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) == 4
    assert all(f"notebooks/{notebook.name}" in documented for notebook in NOTEBOOKS)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(notebook: Path) -> None:
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path) -> None:
    lacking = missing(["nbclient", "ipykernel", "PIL", *NEEDED.get(notebook.stem, [])])
    if lacking:
        pytest.skip(f"{notebook.name} is NOT TESTED: {', '.join(lacking)} missing")
    import nbclient
    import nbformat

    read = nbformat.read(notebook, as_version=4)
    resources = {"metadata": {"path": str(FOLDER)}}
    # A cell that raises ends the run with its traceback.
    nbclient.NotebookClient(read, timeout=PATIENCE, kernel_name="python3", resources=resources).execute()
    assert all(cell.execution_count for cell in read.cells if cell.cell_type == "code")
