"""The packages' public faces: every name is there, says what it is, and costs nothing until it is used."""

import ast
import inspect
import subprocess
import sys
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

import pytest

FACES = (
    "formats",
    "identification",
    "jobs",
    "storage",
)


@pytest.mark.parametrize("face", FACES)
def test_every_public_name_is_there_and_says_what_it_is(face: str) -> None:
    package = import_module(f"modallab.{face}")
    assert len(set(package.__all__)) == len(package.__all__) > 0
    for name in package.__all__:
        found = getattr(package, name)
        documented = found.__doc__ if inspect.isclass(found) or inspect.isfunction(found) else _beneath(package, name)
        assert documented, f"modallab.{face}.{name} has no docstring"


def _beneath(package: ModuleType, name: str) -> bool:
    """Whether a text stands beneath the definition of a type alias."""
    trees = [ast.parse(p.read_text(encoding="utf-8")) for p in Path(str(package.__file__)).parent.rglob("*.py")]
    for one, after in (pair for tree in trees for pair in pairwise(tree.body)):
        if isinstance(one, ast.Assign) and [ast.unparse(target) for target in one.targets] == [name]:
            return isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
    return False


@pytest.mark.parametrize("face", FACES)
def test_no_public_name_is_that_of_a_module(face: str) -> None:
    """Importing the module would put it in the name's place."""
    package = import_module(f"modallab.{face}")
    assert not {module.name for module in iter_modules(package.__path__)} & set(package.__all__)


@pytest.mark.parametrize("face", FACES)
def test_a_type_checker_sees_the_same_names(face: str) -> None:
    package = import_module(f"modallab.{face}")
    assert package.__file__ is not None
    tree = ast.parse(Path(package.__file__).read_text(encoding="utf-8"))
    (guarded,) = (node for node in tree.body if isinstance(node, ast.If))
    imports = [node for node in guarded.body if isinstance(node, ast.ImportFrom)]
    seen = {alias.name: node.module for node in imports for alias in node.names}
    assert set(seen) == set(package.__all__)
    for name, module in seen.items():
        assert getattr(package, name) is getattr(import_module(str(module)), name)


def test_another_name_is_an_error_as_of_any_module() -> None:
    with pytest.raises(AttributeError, match=r"'modallab\.jobs' has no attribute 'nonsense'"):
        _ = import_module("modallab.jobs").nonsense


def test_the_faces_import_nothing_heavy() -> None:
    names = [f"modallab.{face}" for face in FACES]
    code = f"import sys, importlib\nfor n in {names!r}: importlib.import_module(n)\n"
    code += "print([m for m in ('numpy', 'scipy', 'matplotlib', 'pydantic', 'h5py', 'sqlalchemy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
