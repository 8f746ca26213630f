"""The stubs say what the compiled part has, no more and no less."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

import taxel
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


def test_everything_public_says_what_it_is() -> None:
    for name in taxel.__all__:
        thing = getattr(taxel, name)
        if name in ("MARKS", "__version__", "plot"):
            continue
        assert inspect.getdoc(thing), name
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert inspect.getdoc(value), f"{name}.{member}"
