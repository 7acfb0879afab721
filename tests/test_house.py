"""Limits of the source that keep it readable: sizes of functions, and branches on kinds outside the tables of laws."""

import ast
import importlib
import inspect
import pickle
import re
import threading
import typing
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import pymdr as mdr
from pymdr.interpretation.surface import LINE_FIELDS
from pymdr.interpretation.theories import THEORIES
from pymdr.interpretation.validity import BODY_SOURCES, NORMAL_FIELDS, SOURCES
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.codec import tables
from pymdr.quantities import QUANTITIES
from pymdr.solving.study import Answer, Study

SOURCE = Path(mdr.__file__).parent
DOCS = Path(__file__).parents[1] / "docs"
MOST_ARGUMENTS, MOST_LINES = 8, 100
COMMANDS = "workbench/cli/"
TO_SPLIT: set[str] = set()
"""Functions above a limit that are still to be split; names only leave this set."""

# Branches on profiles, bodies, rheologies and laws outside the places that define them. Lower these numbers when one goes; never raise them.
MOST_BRANCHES = 106
MOST_CACHES = 158

OF_KINDS = ("problem/", "solving/laws.py", "interpretation/theories.py", "independent/")
"""The values and their codec, the tables of laws, and the solutions that share nothing with them."""
BASES = {"AdhesionLaw", "Material", "Rheology", "SpringsAndDashpots", "Function"}
KINDS = BASES | {
    kind.__name__
    for table in ("PROFILES", "MATERIALS", "RHEOLOGIES", "ADHESION", "FRICTION")
    for kind in getattr(tables, table).values()
}


@cache
def modules():
    """Every module of the package by its place."""
    files = sorted(SOURCE.rglob("*.py"))
    return [
        (file.relative_to(SOURCE).as_posix(), ast.parse(file.read_text(encoding="utf-8"))) for file in files
    ]


@cache
def functions():
    return [
        (place, node)
        for place, tree in modules()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


def names(node):
    """All names in an expression, the last part of dotted ones."""
    for part in ast.walk(node):
        if isinstance(part, ast.Name):
            yield part.id
        elif isinstance(part, ast.Attribute):
            yield part.attr


PUZZLING = {"told", "tell", "asked", "apart", "ways", "ground", "hanging", "sideways", "found", "share"} | {
    "held",
    "lost",
    "reach",
    "room",
    "rooms",
    "way",
}
"""Parts of names that do not say what a value is: verb forms, and words that are no terms of the field."""
PLAIN = {"energy_lost", "_ROOM_TEMPERATURE", "held_rubber_foot"}
"""Names with such a part that say what a value is."""


def identifiers(code):
    """Names of variables, parameters, attributes, functions and classes in compiled code."""
    yield from (code.co_name, *code.co_names, *code.co_varnames, *code.co_cellvars)
    for constant in code.co_consts:
        if inspect.iscode(constant):
            yield from identifiers(constant)


def test_names_say_what_values_are():
    root, part = (
        DOCS.parent,
        re.compile(
            rf"(?i)_({(words := '|'.join(PUZZLING))})(?=_|\b)|(?<![a-z])({words})(?=_|,? (=|in )|[\[.,:)])"
        ),
    )
    files = (
        file
        for folder in ("src", "tests", "examples", "docs", "benchmarks", "plugins")
        for file in (root / folder).rglob("*.py")
    )
    puzzling = {
        f"{file.relative_to(root).as_posix()}: {name}"
        for file in files
        if part.search(text := file.read_text(encoding="utf-8"))
        for name in (file.stem, *identifiers(compile(text, file.name, "exec")))
        if PUZZLING & set(name.lower().split("_")) and name not in PLAIN and not name.startswith("test_")
    }
    assert sorted(puzzling) == []


def texts(tree):
    """Literal texts of a module that are no docstrings, with what stands in braces as ``{...}``."""
    spare = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            spare |= {id(part) for part in node.values}
            yield "".join(
                part.value if isinstance(part, ast.Constant) else f"{{{ast.unparse(part.value)}}}"
                for part in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in spare:
            yield node.value


def test_messages_begin_with_what_they_are_about():
    # a case has keys, and who calls a class sees its name in the traceback
    public = "|".join(sorted(name for name in mdr.__all__ if callable(getattr(mdr, name))))
    begins = re.compile(rf"({public}|\{{type\((self|law|leg|value)\)\.__name__\}})(: |\.[a-z{{]\S* )")
    named = [f"{place}: {text}" for place, tree in modules() for text in texts(tree) if begins.match(text)]
    assert named == []


def is_to_split(place, node):
    return bool({node.name, f"{place} {node.name}"} & TO_SPLIT)


def branches_on_kinds(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
            tested = node.args[1]
        elif isinstance(node, ast.MatchClass):
            tested = node.cls
        elif isinstance(node, ast.Compare) and all(isinstance(op, ast.Is | ast.IsNot) for op in node.ops):
            tested = ast.Tuple(node.comparators)
        else:
            continue
        if KINDS & set(names(tested)):
            yield node


def test_functions_have_few_arguments():
    def count(node):
        arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        return sum(one.arg not in ("self", "cls") for one in arguments)

    many = [
        f"{place} {node.name}: {count(node)}"
        for place, node in functions()
        if count(node) > MOST_ARGUMENTS and not place.startswith(COMMANDS) and not is_to_split(place, node)
    ]
    assert many == []


def test_functions_are_short():
    def lines(node):
        return node.end_lineno - node.lineno + 1

    assert [
        f"{place} {node.name}: {lines(node)}"
        for place, node in functions()
        if lines(node) > MOST_LINES and not is_to_split(place, node)
    ] == []


def test_few_branches_on_kinds():
    count = Counter(
        {
            place: sum(1 for _ in branches_on_kinds(tree))
            for place, tree in modules()
            if not place.startswith(OF_KINDS)
        }
    )
    assert count.total() <= MOST_BRANCHES, count.most_common(40)


def test_few_caches():
    names_of_caches = {"lru_cache", "cached_property", "WeakKeyDictionary", "cache"}
    result = sum(
        len(names_of_caches & set(names(decorator)))
        for place, tree in modules()
        for node in ast.walk(tree)
        for decorator in getattr(node, "decorator_list", [])
    )
    assert result <= MOST_CACHES


def all_studies(base=Study):
    for study in base.__subclasses__():
        yield study
        yield from all_studies(study)


def test_every_study_has_a_name_for_messages():
    for public in mdr.__all__:
        getattr(mdr, public)
    unnamed = {
        study.__name__
        for study in all_studies()
        if study.__module__.startswith("pymdr")
        and not study.__subclasses__()
        and not isinstance(inspect.getattr_static(study, "subject", None), str)
    }
    assert unnamed == set()


def test_yield_names_what_it_has():
    ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    result = mdr.first_yield(ball, strength="1 GPa")
    with pytest.raises(mdr.QuantityError, match=r"a first yield has"):
        result["slip"]


def test_unknown_loads_are_refused():
    surface = mdr.RoughSurface(hurst=0.7, rms="1 um", size="1 mm", shortest="20 um")
    with pytest.raises(TypeError, match=r"press_rough\(\) got an unexpected keyword argument 'force'"):
        mdr.press_rough(surface, mdr.Elastic("1 GPa", 0.3), force="1 N")
    with pytest.raises(TypeError, match=r"press\(\) got an unexpected keyword argument 'force'"):
        mdr.press(surface, mdr.Elastic("1 GPa", 0.3), force="1 N")
    ball = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5))
    with pytest.raises(TypeError, match=r"sweep\(\) got an unexpected keyword argument 'stiffness'"):
        mdr.sweep(ball, mdr.indent("1 um"), {"body.young": [1e6]}, stiffness="1 N/m")


@pytest.mark.parametrize(
    ("verb", "wrong", "right"),
    [
        (mdr.fit_map, "fitrange", "fit_range"),
        (mdr.fit_each, "fitrange", "fit_range"),
        (mdr.pull_off_curve, "pre_load", "preload"),
        (mdr.sweep, "machine_stifness", "machine_stiffness"),
        (mdr.press, "normalforce", "normal_force"),
        (mdr.press_rough, "indentaton", "indentation"),
        (mdr.ramp, "travl", "travel"),
        (mdr.cycle, "twst", "twist"),
        (mdr.Result.field, "superpose", "superposed"),
        (mdr.Result.stress_to_csv, "superpose", "superposed"),
        (mdr.fit, "fitrange", "fit_range"),
        (mdr.solve, "machine_stifness", "machine_stiffness"),
    ],
)
def test_options_are_in_the_signature_and_others_are_refused(verb, wrong, right):
    parameters = inspect.signature(verb).parameters
    assert parameters[right].kind is inspect.Parameter.KEYWORD_ONLY
    assert all(one.kind is not one.VAR_KEYWORD for one in parameters.values())
    words = rf"^{verb.__name__}\(\) got an unexpected keyword argument '{wrong}'; write {right}= \(arguments: .*\b{right}\b"
    with pytest.raises(TypeError, match=words):
        verb(**{wrong: None})


def public_callables():
    """All functions of the public face, and all public methods of its classes and of what its functions return."""
    faces = [getattr(mdr, name) for name in mdr.__all__]
    classes = {face for face in faces if inspect.isclass(face)} | set(all_studies(Answer))
    yield from (face for face in faces if inspect.isfunction(face))
    yield mdr.Stepper
    for cls in classes:
        for name in dir(cls):
            method = getattr(cls, name, None)  # fields without default are no attributes of the class
            if method is mdr.Stepper.advance:  # a step takes a microsecond
                continue
            if not name.startswith("_") and (inspect.isfunction(method) or inspect.ismethod(method)):
                yield method


def test_threads_that_import_a_function_at_once_take_the_same_one(monkeypatch):
    monkeypatch.delitem(vars(mdr), "solve", raising=False)
    monkeypatch.setitem(vars(mdr), "_functions", {})
    together = threading.Barrier(8)

    def taken(_):
        together.wait()
        return mdr.solve

    with ThreadPoolExecutor(8) as pool:
        several = list(pool.map(taken, range(8)))
    assert len(set(map(id, several))) == 1
    assert pickle.loads(pickle.dumps(several[0])) is several[0]


def test_all_public_functions_name_their_arguments_to_who_misspells_one():
    for function in public_callables():
        with pytest.raises(TypeError, match=r"^\w+\(\) got an unexpected keyword .* \(arguments: ") as error:
            function(misspelt_=1)
        assert str(error.value).startswith(f"{function.__name__}() got"), function


def test_hints_of_all_public_names_and_methods_are_types():
    for face in [getattr(mdr, name) for name in mdr.__all__ if name != "__version__"] + list(
        all_studies(Answer)
    ):
        typing.get_type_hints(face)
    for method in public_callables():
        assert typing.get_type_hints(method), method
    assert (
        typing.get_type_hints(mdr.Result.plot)["return"]
        is importlib.import_module("matplotlib.figure").Figure
    )


def test_what_is_called_without_arguments_says_what_it_needs():
    silent = {mdr.Level, mdr.Status, mdr.Result}  # users do not make these
    for name in mdr.__all__:
        face = getattr(mdr, name)
        if not callable(face) or face in silent or (inspect.isclass(face) and issubclass(face, Exception)):
            continue
        if all(one.default is not one.empty for one in inspect.signature(face).parameters.values()):
            continue
        with pytest.raises(
            TypeError, match=rf"^{name}\(\) needs \w+.* \(arguments: .*\); for example mdr\.{name}\("
        ):
            face()
    words = r'^JKR\(\) needs work in J/m\^2 \(arguments: .*\); for example mdr.JKR\("50 mJ/m\^2"\)$'
    with pytest.raises(TypeError, match=words):
        mdr.JKR(range="3 nm")
    with pytest.raises(TypeError, match=r"^Mass\(\) needs mass in kg "):
        mdr.Mass("bob")


def test_public_functions_pickle_and_keep_their_help():
    for name in mdr.__all__:
        function = getattr(mdr, name)
        if inspect.isfunction(function):
            assert pickle.loads(pickle.dumps(function)) is function
            assert inspect.getdoc(function)
            assert all(
                one.kind is not one.VAR_KEYWORD and one.default is not ...
                for one in inspect.signature(function).parameters.values()
            )


def test_the_radius_of_a_field_is_called_r():
    with pytest.raises(TypeError, match=r"write r= \(arguments: name, r, step, "):
        mdr.Result.field(None, "pressure", radius=1e-3)


OF_VALUES = {"sum", "interpolated"}
"""Kinds that users do not write: of added profiles, and of saved functions."""


def registered():
    """Every kind of the package that a case file can name, with its class; those registered by tests are not of the package."""
    return sorted(
        (kind, cls)
        for table in tables.TABLES.values()
        for kind, cls in table.items()
        if cls.__module__.startswith("pymdr.") and kind not in OF_VALUES
    )


@pytest.mark.parametrize(
    ("kind", "cls"), registered(), ids=lambda value: value if isinstance(value, str) else ""
)
def test_every_kind_is_exported_and_explained(kind, cls):
    name = cls.__name__
    assert getattr(mdr, name, None) is cls or callable(getattr(mdr, kind, None)), f"{name} is no public name"
    pages = (text for page in DOCS.glob("*.md") for text in [page.read_text(encoding="utf-8")])
    assert any(re.search(rf"\b{name}\b|\b{kind}\b", text) for text in pages), f"no page explains {name}"
    log = (DOCS.parent / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(rf"\b{name}\b|\b{kind}\b", log), f"CHANGELOG.md does not name {name}"


def rows_of(table):
    """Kinds and classes of one table that the package defines."""
    return [(kind, cls) for kind, cls in registered() if cls in table.values()]


@pytest.mark.parametrize(
    ("table", "page"),
    [
        (tables.PROFILES, "profiles.md"),
        (tables.MATERIALS, "bodies.md"),
        (tables.RHEOLOGIES, "viscoelasticity.md"),
        (tables.ADHESION, "adhesion.md"),
    ],
    ids=("profile", "body", "rheology", "law of adhesion"),
)
def test_additions_are_in_every_file_that_the_page_on_contributing_lists(table, page):
    text, cases, reference = (
        (DOCS / name).read_text(encoding="utf-8") for name in (page, "case_files.md", "reference.md")
    )
    public = (SOURCE / "__init__.pyi").read_text(encoding="utf-8")
    for kind, cls in rows_of(table):
        name = cls.__name__
        assert f"`{kind}`" in cases, f"docs/case_files.md lacks {kind}"
        assert re.search(rf"^   {name}$", reference, re.MULTILINE), f"docs/reference.md lacks {name}"
        assert f" as {name}\n" in public, f"__init__.pyi lacks {name}"
        assert re.search(rf"\b({name}|{kind})\b", text), f"docs/{page} lacks {name}"


def test_every_body_has_compliances_and_every_law_of_adhesion_a_theory():
    for _, cls in rows_of(tables.MATERIALS):
        assert cls in surface_compliances.registry, f"surface_compliances of {cls.__name__}"
        assert set(BODY_SOURCES.get(cls, ())) <= set(SOURCES), f"sources of {cls.__name__}"
    for _, cls in rows_of(tables.ADHESION):
        assert set(THEORIES[cls].references) <= set(SOURCES), f"sources of {cls.__name__}"


def test_every_field_has_a_unit_and_errors():
    rough = mdr.Contact(mdr.Function(lambda r: np.float32(0.5) * np.float32(r) ** 2), mdr.Elastic(1.0, 0.3))
    plain = mdr.solve(rough, mdr.indent(1e-3))
    sticky = mdr.solve(replace(rough, adhesion=mdr.JKR(1e-9)), mdr.indent(1e-3))
    explained = inspect.getdoc(mdr.Result.field)
    for name in (*NORMAL_FIELDS, *LINE_FIELDS):
        assert name in QUANTITIES
        assert f'"{name}"' in explained
        for result in (plain, sticky) if name in NORMAL_FIELDS else ():
            assert result.claims[name].error.max() > 1e-9, (
                f"{name} has no error in interpretation/accuracy.py"
            )
