"""The package: import time, types, the README."""

import doctest
import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import drystone as ds
import pytest

HERE = Path(__file__).resolve().parent


def test_the_version_is_that_of_the_distribution() -> None:
    assert ds.__version__ == importlib.metadata.version("drystone")


def test_all_names_are_there_and_have_a_description() -> None:
    for name in ds.__all__:
        assert hasattr(ds, name)
        if name != "__version__":
            assert getattr(ds, name).__doc__
    for kind in (ds.World, ds.Batch, ds.Body, ds.Joint, ds.Scene, ds.Shape, ds.Snapshot, ds.Events):
        for name in dir(kind):
            if not name.startswith("_"):
                assert getattr(kind, name).__doc__, f"{kind.__name__}.{name}"


def test_numpy_is_imported_at_first_use_alone() -> None:
    code = "import sys, drystone; drystone.World().step(); assert 'numpy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_import_takes_less_than_50_ms() -> None:
    """The best of some: other programs on the machine only add to it."""
    code = (
        "import time; t = time.perf_counter(); import drystone; print(time.perf_counter() - t)"
    )
    times = [
        float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True).stdout)
        for _ in range(5)
    ]
    assert min(times) < 0.050, times


def test_the_tour_of_the_readme_runs() -> None:
    readme = HERE.parent / "README.md"
    found = doctest.testfile(str(readme), module_relative=False, optionflags=doctest.ELLIPSIS)
    assert found.attempted > 10 and found.failed == 0


@pytest.mark.parametrize("name", sorted(p.name for p in (HERE.parent / "examples").glob("*.py")))
def test_examples_run(name: str) -> None:
    path = HERE.parent / "examples" / name
    done = subprocess.run(
        [sys.executable, str(path)], capture_output=True, text=True, env=dict(os.environ)
    )
    assert done.returncode == 0, done.stderr
