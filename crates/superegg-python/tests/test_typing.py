"""The stub is the compiled module, every public name is documented, and its documentation names its parameters."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import superegg as se
from superegg import _superegg

STUB = Path(se.__file__).with_name("_superegg.pyi")


def parameters(node: ast.FunctionDef) -> list[tuple[str, bool]]:
    """The parameters, each with whether it has a default."""
    names = [argument.arg for argument in node.args.args]
    plain = len(names) - len(node.args.defaults)
    return [(name, i >= plain) for i, name in enumerate(names) if name not in ("self", "cls")]


def actual(function: object) -> list[tuple[str, bool]]:
    signature = inspect.signature(function)  # type: ignore[arg-type]
    found = [(name, p.default is not p.empty) for name, p in signature.parameters.items()]
    return [(name, has) for name, has in found if name not in ("self", "cls")]


def public(of: object) -> set[str]:
    return {name for name in vars(of) if not name.startswith("_")}


def test_the_stub_is_the_module():
    tree = ast.parse(STUB.read_text())
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    assert public(_superegg) == set(functions) | set(classes)
    for name, node in functions.items():
        assert parameters(node) == actual(getattr(_superegg, name)), name
    for name, node in classes.items():
        if name == "FormatError":
            continue
        cls = getattr(_superegg, name)
        members = {member.name: member for member in node.body if isinstance(member, ast.FunctionDef)}
        assert public(cls) == {member for member in members if not member.startswith("_")}, name
        for member, of in members.items():
            if any(isinstance(d, ast.Name) and d.id == "property" for d in of.decorator_list):
                assert inspect.isgetsetdescriptor(vars(cls)[member]), f"{name}.{member}"
            elif member == "__new__":
                assert parameters(of) == actual(cls), name
            else:
                assert parameters(of) == actual(getattr(cls, member)), f"{name}.{member}"


def documented():
    for name in se.__all__:
        value = getattr(se, name)
        if inspect.isclass(value):
            yield name, value
            for member, of in vars(value).items():
                is_own = inspect.isfunction(of) or isinstance(of, property) or hasattr(of, "func")
                if is_own and not member.startswith("_"):
                    yield f"{name}.{member}", of
        elif inspect.isfunction(value):
            yield name, value


@pytest.mark.parametrize(("name", "value"), list(documented()))
def test_every_public_name_is_documented(name, value):
    text = inspect.getdoc(value)
    assert text, name
    if not inspect.isfunction(value):
        return
    # A table of parameters is whole.
    table = re.search(r"^Parameters\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", text, re.DOTALL | re.MULTILINE)
    if table:
        for parameter in inspect.signature(value).parameters:
            word = parameter.rstrip("_")
            if word != "self" and not re.search(rf"\b{word}\b", table.group(1)):
                assert word in text, f"{name}: {word}"


def test_every_function_says_what_it_returns_and_takes():
    """Annotations are whole, since type checkers read them from the source."""
    for name, value in documented():
        function = value.fget if isinstance(value, property) else value
        if inspect.isfunction(function):
            signature = inspect.signature(function)
            assert signature.return_annotation is not signature.empty, name
            for parameter in signature.parameters.values():
                assert parameter.name == "self" or parameter.annotation is not parameter.empty, f"{name}({parameter})"
