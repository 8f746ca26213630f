"""The stubs say what the compiled part has, no more and no less."""

from __future__ import annotations

import ast
import builtins
import inspect
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import taxel
import taxel.ray
from taxel import _taxel


def test_the_stubs_name_everything() -> None:
    tree = ast.parse((Path(taxel.__file__).parent / "_taxel.pyi").read_text(encoding="utf-8"))
    protocols = {node.name for node in tree.body if isinstance(node, ast.ClassDef) and node.name.startswith("_")}
    told = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    there = {name for name in vars(_taxel) if not name.startswith("__") and name not in ("MARKS",)}
    assert told.keys() - protocols == there
    for name, node in told.items():
        if isinstance(node, ast.ClassDef) and name not in protocols:
            members = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
            found = {member for member in vars(getattr(_taxel, name)) if not member.startswith("_")}
            assert members - {"__new__", "__init__"} == found, name
        elif isinstance(node, ast.FunctionDef):
            parameters = [argument.arg for argument in node.args.args + node.args.kwonlyargs]
            assert parameters == list(inspect.signature(getattr(_taxel, name)).parameters), name


def sections(thing: Callable[..., object]) -> dict[str, str]:
    """The sections of a docstring in numpy's style, by their headings."""
    parts = re.split(r"^(\w+)\n-+$", inspect.getdoc(thing) or "", flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


FUNCTIONS = [getattr(taxel, name) for name in taxel.__all__ if inspect.isfunction(getattr(taxel, name))]
METHODS = [taxel.Pipeline.process, taxel.Pipeline.stream, taxel.Pipeline.look_for_faults, taxel.Live.next, taxel.plot.heatmap, taxel.plot.over_time]


@pytest.mark.parametrize("function", [*FUNCTIONS, *METHODS, taxel.ray.process], ids=lambda function: function.__qualname__)
def test_a_docstring_tells_parameters_results_and_errors(function: Callable[..., object]) -> None:
    told = sections(function)
    named = {
        name.strip().lstrip("*")
        for line in re.findall(r"^(\S.*)$", told["Parameters"], flags=re.MULTILINE)
        for name in line.split(" : ")[0].split(",")
    }
    parameters = set(inspect.signature(function).parameters) - {"self"}
    assert named == parameters
    assert "Returns" in told or "Yields" in told
    # What stands there, and when: a name alone tells nothing.
    assert all(re.search(r"^ +\S", told[name], flags=re.MULTILINE) for name in ("Returns", "Yields", "Raises") if name in told)
    raised = re.findall(r"^(\S.*)$", told["Raises"], flags=re.MULTILINE)
    for name in ", ".join(raised).split(", "):
        kind = getattr(taxel if name.startswith("taxel.") else builtins, name.removeprefix("taxel."))
        assert issubclass(kind, BaseException)


def test_everything_public_says_what_it_is() -> None:
    for name in taxel.__all__:
        thing = getattr(taxel, name)
        if name in ("MARKS", "__version__", "plot"):
            continue
        assert inspect.getdoc(thing), name
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert inspect.getdoc(value), f"{name}.{member}"
