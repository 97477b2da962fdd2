"""The stub says what is there: names, arguments with their defaults, and what each is for."""

import ast
import inspect
from pathlib import Path

import chladni
import numpy as np
import pytest

STUB = ast.parse((Path(chladni.__file__).parent / "__init__.pyi").read_text())
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}


def members(cls):
    """Methods, properties and attributes of a class of the stub."""
    found = {node.name: node for node in cls.body if isinstance(node, ast.FunctionDef)}
    return found | {node.target.id: node for node in cls.body if isinstance(node, ast.AnnAssign)}


def is_property(node):
    return any(isinstance(one, ast.Name) and one.id == "property" for one in node.decorator_list)


def arguments(node):
    """(name, whether it has a default) of a function of the stub, keyword-only ones apart."""
    plain, defaults = node.args.posonlyargs + node.args.args, len(node.args.defaults)
    plain = [(arg.arg, k >= len(plain) - defaults) for k, arg in enumerate(plain)]
    return [one for one in plain if one[0] not in ("self", "cls")], [
        (arg.arg, default is not None) for arg, default in zip(node.args.kwonlyargs, node.args.kw_defaults)
    ]


def test_every_public_name_has_its_stub_and_the_other_way_round():
    assert set(FUNCTIONS) | set(CLASSES) | {"__version__"} == set(chladni.__all__)
    for name, node in CLASSES.items():
        real = {member for member in dir(getattr(chladni, name)) if not member.startswith("_")}
        # attributes of exceptions and results are set when one is made
        known = {member for member in members(node) if not member.startswith("_")}
        inherited = set(dir(ValueError)) if name == "ChladniError" else set()
        assert real - inherited <= known, f"{name}: without stub: {real - inherited - known}"
        methods = {m for m, one in members(node).items() if isinstance(one, ast.FunctionDef) and m != "__init__"}
        assert all(hasattr(getattr(chladni, name), method) for method in methods), name


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_arguments_are_those_of_the_stub(name):
    real = inspect.signature(getattr(chladni, name)).parameters.values()
    plain, keywords = arguments(FUNCTIONS[name])
    forwarded = any(one.kind is one.VAR_KEYWORD for one in real)
    by_name = {one.name: one for one in real if one.kind is not one.VAR_KEYWORD}
    for argument, optional in plain + keywords:
        if argument not in by_name:
            assert forwarded, f"{name}({argument})"
            continue
        assert (by_name[argument].default is not inspect.Parameter.empty) == optional, f"{name}({argument})"
        assert (by_name[argument].kind is inspect.Parameter.KEYWORD_ONLY) == ((argument, optional) in keywords), f"{name}({argument})"
    assert set(by_name) <= {argument for argument, _ in plain + keywords}, name


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_functions_say_what_goes_in_and_comes_out(name):
    said = inspect.getdoc(getattr(chladni, name))
    plain, keywords = arguments(FUNCTIONS[name])
    for argument, _ in plain + keywords:
        assert argument in said.split("Parameters\n----------")[1], f"{name}: {argument}"
    returns = FUNCTIONS[name].returns
    assert "Returns\n-------" in said or (isinstance(returns, ast.Constant) and returns.value is None), name


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_editors_show_the_words_of_the_compiled_half(name):
    """Editors cannot read the source of the compiled half: its words stand in the stub, too."""
    cls, node = getattr(chladni, name), CLASSES[name]
    if cls.__module__ == "chladni._compare" or name == "ChladniError":
        return
    assert ast.get_docstring(node) == inspect.getdoc(cls)
    for member, one in members(node).items():
        if isinstance(one, ast.FunctionDef) and not member.startswith("__"):
            assert ast.get_docstring(one) == inspect.getdoc(getattr(cls, member)), f"{name}.{member}"


def test_words_of_the_stub_are_those_that_are_understood():
    """The error for a wrong word lists the right ones: those of the `Literal` types."""
    frf = chladni.FrfSet(np.array([1.0, 2.0]), np.array([[[1j, 2j]]]))
    for name, call in (
        ("FitMethod", lambda word: chladni.fit(frf, method=word)),
        ("ShapeModel", lambda word: chladni.fit(frf, shapes=word)),
        ("RfpWeight", lambda word: chladni.fit(frf, method="rfp", rfp_weight=word)),
    ):
        with pytest.raises(chladni.ChladniError) as wrong:
            call("magic")
        said = str(wrong.value) + str(wrong.value.expected)
        missing = [word for word in words(name) if word not in said]
        assert not missing, f"{name}: {missing} not in {said}"


def words(alias):
    """The words of a `Literal` of the stub."""
    node = next(node for node in STUB.body if isinstance(node, ast.AnnAssign) and node.target.id == alias)
    return [constant.value for constant in ast.walk(node.value) if isinstance(constant, ast.Constant)]
