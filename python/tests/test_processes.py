"""Fits that are stopped, and fits in other processes."""

import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import chladni
import numpy as np
import pytest
from test_chladni import FREQUENCY_HZ, mobility

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture(scope="module")
def frf():
    shapes = np.random.default_rng(7).standard_normal((3, 6))
    return chladni.FrfSet(FREQUENCY_HZ, mobility(shapes, shapes[:, :2]))


def stages_of(frf):
    stages = []
    chladni.fit(frf, progress=stages.append)
    return stages


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signal that a process can send to itself")
def test_ctrl_c_stops_a_fit_at_its_next_stage(frf):
    # shells start jobs in the background without it
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    seen = []

    def interrupt(stage):
        seen.append(stage)
        if len(seen) == 1:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.5)  # time for the thread that is handed signals

    try:
        with pytest.raises(KeyboardInterrupt):
            chladni.fit(frf, progress=interrupt)
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == stages_of(frf)[:1]


def test_a_fit_stops_where_its_callback_raises():
    noise = np.random.default_rng(1)
    values = mobility(noise.standard_normal((3, 40)), noise.standard_normal((3, 4)))
    large = chladni.FrfSet(FREQUENCY_HZ, values)

    def fail(_):
        raise KeyError("mine")

    began = time.perf_counter()
    chladni.fit(large)
    whole = time.perf_counter() - began
    began = time.perf_counter()
    with pytest.raises(KeyError, match="mine"):
        chladni.fit(large, progress=fail)
    assert time.perf_counter() - began < 0.5 * whole


def test_solving_pieces_stops_where_its_callback_raises():
    simulated, _ = chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)
    partial = chladni.reduce_block(simulated, 0)

    all_stages = []
    chladni.solve_poles(partial, progress=all_stages.append)
    stages = []

    def fail(stage):
        stages.append(stage)
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        chladni.solve_poles(partial, progress=fail)
    assert stages == all_stages[:1] and len(all_stages) > 1


WITHOUT_THREADS = """
import resource
import chladni, numpy as np
f = np.arange(20.0, 240.0, 0.5)
w = 2 * np.pi * f
frf = chladni.FrfSet(f, (1j * w / ((2 * np.pi * 100) ** 2 * (1 + 0.01j) - w**2))[None, None])
with open("/proc/self/statm") as sizes:
    here = int(sizes.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (here + 2**20, resource.RLIM_INFINITY))
try:
    chladni.fit(frf)
except OSError as error:
    print(str(error).split(":")[0])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux says what a process takes, and takes a limit for it")
def test_a_system_that_starts_no_thread_is_an_error():
    run = subprocess.run([sys.executable, "-c", WITHOUT_THREADS], capture_output=True, text=True, timeout=120)
    assert run.stdout == "the system starts no more threads\n", run.stderr


def test_a_callback_may_fit_itself(frf):
    inner = []

    def nested(_):
        if not inner:
            inner.append(None)
            inner.append(chladni.fit(frf))

    outer = chladni.fit(frf, progress=nested)
    assert np.array_equal(inner[1].frequency_hz, outer.frequency_hz)


@pytest.mark.parametrize("progress", ["yes", 5, 0, [], ""])
def test_progress_that_cannot_be_called_is_refused(frf, progress):
    with pytest.raises(chladni.ChladniError) as refused:
        chladni.fit(frf, progress=progress)
    assert refused.value.field == "progress" and refused.value.found == repr(progress)


FORKED = """
import multiprocessing
import chladni, numpy as np
from concurrent.futures import ProcessPoolExecutor
f = np.arange(20.0, 240.0, 0.5)
w = 2 * np.pi * f
frf = chladni.FrfSet(f, (1j * w / ((2 * np.pi * 100) ** 2 * (1 + 0.01j) - w**2))[None, None])

def fitted(frf):
    stages = []
    found = chladni.fit(frf, progress=stages.append).frequency_hz
    chladni.cmif(frf), chladni.solve_poles(chladni.reduce_block(frf, 0))
    return found.tolist(), len(stages)

def grandchild(frf):
    with multiprocessing.get_context("fork").Pool(1) as pool:
        return pool.apply(fitted, (frf,))

before = fitted(frf)
context = multiprocessing.get_context("fork")
with ProcessPoolExecutor(2, mp_context=context) as pool:
    assert list(pool.map(fitted, [frf] * 4)) == [before] * 4
child = context.Process(target=lambda: fitted(frf))
child.start()
child.join()
assert child.exitcode == 0 and fitted(frf) == before
queue = context.Queue()
child = context.Process(target=lambda: queue.put(grandchild(frf) == fitted(frf) == before))
child.start()
assert queue.get()
child.join()
print("fitted")
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_children_of_a_fork_fit_after_their_parent():
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED], capture_output=True, text=True, timeout=120)
    assert run.stdout == "fitted\n", run.stderr


def same_files(one, other, tmp_path):
    files = [tmp_path / "one.h5", tmp_path / "other.h5"]
    for frf, file in zip((one, other), files):
        frf.save(file, force=True)
    return files[0].read_bytes() == files[1].read_bytes()


def test_frf_sets_pickle_with_all_that_they_hold(tmp_path):
    simulated, _ = chladni.simulate(FIXTURES / "panel-driving-points.toml", seed=3)
    noise = np.random.default_rng(2).standard_normal((3, 1, 4096))
    answer = np.cumsum(noise, axis=2)
    blows = chladni.estimate(noise, answer, 1000.0, exponential_window_per_s=1 / 3, kind="accelerance", reference_unit="V")
    single = chladni.FrfSet(blows.frequency_hz, np.array(blows.values, dtype=np.complex64), nodes_m=[[0, 0, 0], [0.1, 0, 0.3]])
    for frf in (simulated, blows, single):
        again = pickle.loads(pickle.dumps(frf))
        assert again.values.dtype == frf.values.dtype and np.array_equal(again.values, frf.values, equal_nan=True)
        assert not again.values.flags.writeable and again.findings == frf.findings and repr(again) == repr(frf)
        assert again.responses == frf.responses and again.references == frf.references and again.reference_unit == frf.reference_unit
        assert np.array_equal(again.nodes_m, frf.nodes_m) and same_files(frf, again, tmp_path)
    assert chladni.fit(pickle.loads(pickle.dumps(simulated))).to_json() == chladni.fit(simulated).to_json()
    function, (arrays, names, places, _, findings) = single.__reduce__()
    with pytest.raises(chladni.ChladniError, match="damaged"):
        function(arrays, names, places, ("h1", ("none", None), None, [1.0, 1.0, 1.0], [1, 1], 1), findings)
