"""The recipe for Dask, as it stands in `examples`: workers of little memory, any number of them, the fit of the whole."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("h5py", reason="the recipe for Dask reads HDF5 with h5py, which is not installed")
pytest.importorskip("distributed", reason="the recipe for Dask is left out: dask[distributed] is not installed")

EXAMPLE = Path(__file__).parents[2] / "examples" / "dask_fit.py"


def test_a_dask_cluster_of_any_size_fits_what_one_machine_fits(tmp_path):
    command = [sys.executable, str(EXAMPLE), "--gigabytes", "0.02", "--blocks", "19", "--workers", "1", "2", "--compare"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    assert len(re.search("sha256 of the model: (.*)", run.stdout)[1].split(", ")) == 1
    assert "2 workers against 1" in run.stdout
    assert float(re.search("least MAC (.*)", run.stdout)[1]) > 0.9999
