"""The fit in pieces: what the whole gives, bits that depend on the blocks alone, and what Dask needs of its objects."""

import pickle
import sys
import threading

import chladni
import numpy as np
import pytest
from test_chladni import FREQUENCY_HZ, mobility

RESPONSES = 26
REFERENCES = [f"{node}:+Z" for node in (1, 2)]


@pytest.fixture(scope="module")
def values():
    shapes = np.random.default_rng(5).standard_normal((3, RESPONSES))
    return mobility(shapes, shapes[:, :2])


def rows(values, start, stop, frequency_hz=FREQUENCY_HZ):
    names = [f"{node + 1}:+Z" for node in range(start, stop)]
    return chladni.FrfSet(frequency_hz, values[start:stop], responses=names, references=REFERENCES)


def blocks(values, count):
    ends = np.linspace(0, RESPONSES, count + 1).astype(int)
    return [rows(values, *block) for block in zip(ends, ends[1:])]


def reduced(values, count, poles=None):
    return [chladni.reduce_block(frf, number, poles=poles) for number, frf in enumerate(blocks(values, count))]


def in_pieces(values, count):
    found = None
    while not isinstance(found, chladni.Model):
        found = chladni.solve_poles(chladni.merge(reduced(values, count, found)))
    return found


@pytest.fixture(scope="module")
def whole(values):
    return chladni.fit(rows(values, 0, RESPONSES))


@pytest.fixture(scope="module")
def poles(values):
    return chladni.solve_poles(chladni.merge(reduced(values, 13)))


def test_1_7_and_all_blocks_find_what_the_whole_finds(values, whole):
    one = in_pieces(values, 1)
    for count in (7, RESPONSES):
        model = in_pieces(values, count)
        assert np.allclose(model.frequency_hz, one.frequency_hz, rtol=1e-12, atol=0)
        assert np.allclose(model.loss_factor, one.loss_factor, rtol=1e-12, atol=0)
        assert np.allclose(model.shapes, one.shapes, rtol=0, atol=1e-10 * np.abs(one.shapes).max())
    assert one.trust == whole.trust == ["sure"] * 3 and one.responses == whole.responses
    assert np.all(np.abs(one.frequency_hz - whole.frequency_hz) < 0.05 * whole.frequency_std_hz)
    assert np.all(np.abs(one.loss_factor - whole.loss_factor) < 0.05 * whole.loss_factor_std)


@pytest.mark.parametrize("second", [False, True])
def test_order_grouping_and_pickling_do_not_change_a_byte(values, poles, second):
    parts = reduced(values, 13, poles if second else None)
    straight = chladni.merge(parts)
    mixed = [pickle.loads(pickle.dumps(parts[n])) for n in np.random.default_rng(2).permutation(13)]
    grouped = chladni.merge(chladni.merge(mixed[n : n + 4]) for n in range(0, 13, 4))
    assert grouped.to_bytes() == straight.to_bytes()
    assert chladni.Partial.from_bytes(bytearray(straight.to_bytes())).to_bytes() == straight.to_bytes()
    solved = [chladni.solve_poles(partial) for partial in (straight, grouped)]
    assert type(solved[0]) is (chladni.Model if second else chladni.Poles)
    assert pickle.dumps(solved[0]) == pickle.dumps(solved[1])


def test_objects_say_what_they_hold(values, poles, whole):
    parts = reduced(values, 13)
    assert parts[3].blocks == 1 and parts[3].frfs == 4 and parts[3].poles is None
    assert 3 in parts[3] and 4 not in parts[3]
    assert repr(parts[3]) == "Partial(1 block, 4 FRFs, first pass)"
    second = chladni.merge(reduced(values, 13, poles))
    assert second.blocks == 13 and second.frfs == 2 * RESPONSES and "13 blocks" in repr(second) and "second pass" in repr(second)
    assert np.array_equal(second.poles.frequency_hz, poles.frequency_hz)
    assert np.allclose(poles.frequency_hz, whole.frequency_hz, rtol=1e-4) and np.allclose(poles.loss_factor, whole.loss_factor, rtol=0.02)
    assert "fast chain" in poles.evidence and repr(poles).startswith("Poles(3 in the band from 5")


def test_poles_and_models_pickle(values, poles, whole):
    again = pickle.loads(pickle.dumps(poles))
    assert again.to_bytes() == poles.to_bytes() and isinstance(again, chladni.Poles)
    model = pickle.loads(pickle.dumps(whole))
    assert model.to_json() == whole.to_json() and np.array_equal(model.shapes, whole.shapes)
    for call in (chladni.reduce_block, chladni.merge, chladni.solve_poles, chladni.residues_block):
        assert pickle.loads(pickle.dumps(call)) is call


def test_residues_of_a_block_are_those_of_the_whole(values, whole):
    all_of_it = chladni.residues_block(rows(values, 0, RESPONSES), whole)
    assert np.allclose(all_of_it.frequency_hz, whole.frequency_hz, rtol=1e-14, atol=0)
    # the sign of an unscaled shape is free
    assert np.allclose(np.abs(all_of_it.shapes), np.abs(whole.shapes), rtol=0, atol=1e-6 * np.abs(whole.shapes).max())
    block = chladni.residues_block(rows(values, 10, 20), whole)
    assert np.allclose(block.frequency_hz, whole.frequency_hz, rtol=1e-14) and np.allclose(block.loss_factor_std, whole.loss_factor_std, rtol=1e-14)
    residues = lambda model, part: np.einsum("ni,nj->nij", model.shapes[:, part], model.participations)
    expected = residues(whole, slice(10, 20))
    assert np.allclose(residues(block, slice(None)), expected, rtol=0, atol=3e-3 * np.abs(expected).max())
    assert block.responses == whole.responses[10:20]


def test_damaged_bytes_are_refused(values, poles):
    part = reduced(values, 13)[0]
    for kind, data in ((chladni.Partial, part.to_bytes()), (chladni.Poles, poles.to_bytes())):
        for bad, said in (
            (data[:-1], "cut off"),
            (data[:-1] + bytes([data[-1] ^ 1]), "damaged"),
            (data.replace(b'"version":8', b'"version":1', 1), "another version"),
            (b"", "first line"),
        ):
            with pytest.raises(chladni.ChladniError, match=said) as refused:
                kind.from_bytes(bad)
            assert refused.value.code == 65 and refused.value.kind == "bad_data" and refused.value.found
    with pytest.raises(chladni.ChladniError, match="another kind") as refused:
        chladni.Poles.from_bytes(part.to_bytes())
    assert (refused.value.field, refused.value.found, refused.value.expected) == ("format", "chladni.partial", "chladni.poles")
    pickled = pickle.dumps(part)
    at = len(pickled) // 2
    with pytest.raises(chladni.ChladniError, match="damaged"):
        pickle.loads(pickled[:at] + bytes([pickled[at] ^ 1]) + pickled[at + 1 :])


def test_pieces_that_do_not_belong_together_are_refused_with_the_fields_of_the_contract(values, poles):
    parts = reduced(values, 13)
    with pytest.raises(chladni.ChladniError) as twice:
        chladni.merge([parts[2], parts[2]])
    assert (twice.value.field, twice.value.found) == ("number of the block", "2") and twice.value.help
    # exceptions of a worker come to whoever asked as pickles
    carried = pickle.loads(pickle.dumps(twice.value))
    assert (carried.code, carried.field, carried.help, str(carried)) == (65, twice.value.field, twice.value.help, str(twice.value))
    with pytest.raises(chladni.ChladniError) as seed:
        chladni.merge([parts[0], chladni.reduce_block(rows(values, 2, 4), 1, seed=1)])
    assert seed.value.field == "seed" and seed.value.found == "1"
    with pytest.raises(chladni.ChladniError) as axis:
        chladni.reduce_block(rows(values, 0, 2, FREQUENCY_HZ + 1), 0, poles=poles)
    assert axis.value.field == "frequency axis"
    with pytest.raises(chladni.ChladniError) as half:
        chladni.solve_poles(reduced(values, 13, poles)[0])
    assert half.value.field == "number of FRFs" and half.value.found == "4"
    with pytest.raises(chladni.ChladniError, match="nothing to merge"):
        chladni.merge([])
    with pytest.raises(TypeError):
        chladni.merge([poles])
    with pytest.raises(chladni.ChladniError) as word:
        chladni.solve_poles(parts[0], damping="much")
    assert word.value.field == "damping" and word.value.found == "much"


def test_band_and_seed_of_the_first_pass_go_with_the_poles(values):
    part = chladni.reduce_block(rows(values, 0, RESPONSES), 0, band=(30, 130), seed=3)
    stages = []
    poles = chladni.solve_poles(part, progress=stages.append)
    assert len(poles.frequency_hz) == 2 and stages
    model = chladni.solve_poles(chladni.reduce_block(rows(values, 0, RESPONSES), 0, poles=poles))
    assert len(model) == 2 and np.allclose(model.to_dict()["band_hz"], [30, 130], atol=0.2)
    with pytest.raises(chladni.ChladniError) as other:
        chladni.reduce_block(rows(values, 0, RESPONSES), 0, poles=poles, band=(30, 200))
    assert other.value.field == "band"


def test_missing_blocks_are_named(values, recwarn):
    def passed(numbers, poles=None, **keywords):
        parts = (chladni.reduce_block(rows(values, n, n + 8), n // 8, poles=poles, **keywords) for n in numbers)
        return chladni.solve_poles(chladni.merge(parts))

    whole = passed((0, 8), passed((0, 8), blocks=2), blocks=2)
    untold = passed((0, 8), passed((0, 8)))
    assert not recwarn and not any(finding["code"] == "blocks-missing" for model in (whole, untold) for finding in model.findings)
    with pytest.warns(UserWarning, match="1 of 3 blocks is missing: 1"):
        poles = passed((0, 16), blocks=3)
    model = passed((0, 16), poles, blocks=3)
    assert any("1 of 3 blocks is missing: 1" in sentence for sentence in model.warnings)
    assert model.findings[-1]["code"] == "blocks-missing" and model.findings[-1]["values"] == {"missing": 1, "blocks": 3}
    with pytest.raises(chladni.ChladniError) as beyond:
        chladni.reduce_block(rows(values, 0, 8), 3, blocks=3)
    assert beyond.value.field == "number" and "below 3" in beyond.value.expected


@pytest.mark.parametrize("call", ["reduce_block", "merge", "solve_poles", "residues_block"])
def test_other_threads_run_meanwhile(values, whole, call):
    frf = rows(values, 0, RESPONSES)
    parts = reduced(values, 13)
    arguments = {"reduce_block": (frf, 0), "merge": (parts,), "solve_poles": (chladni.merge(parts),), "residues_block": (frf, whole)}[call]
    go, done = threading.Event(), []
    other = threading.Thread(target=lambda: (go.wait(), done.append(True)))
    interval = sys.getswitchinterval()
    other.start()
    sys.setswitchinterval(1000)  # a lock that is not given up stays where it is
    try:
        go.set()
        for _ in range(200):
            getattr(chladni, call)(*arguments)
            if done:
                break
        ran = bool(done)
    finally:
        sys.setswitchinterval(interval)
        other.join()
    assert ran
