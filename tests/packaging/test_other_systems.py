"""Windows and macOS, as far as Linux can show them: nothing that only POSIX has is needed to import a command."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
POSIX_MODULES = {"fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "posix"}
POSIX_NAMES = {
    "os.fork", "os.forkpty", "os.killpg", "os.setsid", "os.getuid", "os.geteuid", "os.getpgid", "os.getpgrp",
    "os.sched_setaffinity", "os.sched_getaffinity", "os.mkfifo", "os.nice", "os.statvfs", "os.uname",
    "signal.SIGKILL", "signal.SIGHUP", "signal.SIGUSR1", "signal.SIGUSR2", "signal.SIGALRM", "signal.SIGSTOP",
    "signal.SIGCONT", "signal.setitimer", "signal.pause", "socket.AF_UNIX",
}  # fmt: skip
ASKS = ("sys.platform", "os.name", "hasattr(")
SOURCES = sorted(file for folder in ("src", "drivers") for file in (ROOT / folder).rglob("*.py"))

AS_ON_WINDOWS = """
import sys
from importlib import import_module
from types import ModuleType

commands = [f"modallab.cli.{name}" for name in ("demo", "identify", "gap", "import_", "serve", "export")]
# What others bring is imported as it is; only the project's own modules see another system.
for name in commands:
    import_module(name)
for name in [name for name in sys.modules if name.partition(".")[0] in ("modallab", "modallab_drivers")]:
    del sys.modules[name]
for name in ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty"):
    sys.modules[name] = None
sys.modules["msvcrt"] = ModuleType("msvcrt")
sys.platform = "win32"
for name in [*commands, "modallab_drivers.replay"]:
    import_module(name)
from modallab.cli.parser import build_parser
build_parser("0").parse_args(["demo"])
print("imported")
"""


@pytest.mark.thorough("imports the whole program twice")
def test_every_command_is_imported_where_posix_is_not() -> None:
    done = subprocess.run([sys.executable, "-c", AS_ON_WINDOWS], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "imported", done.stderr


@pytest.mark.parametrize("package", ["src", "drivers"])
def test_what_only_posix_has_is_used_where_the_system_was_asked_for(package: str) -> None:
    files = [file for file in SOURCES if file.is_relative_to(ROOT / package)]
    assert [found for file in files for found in unguarded(file)] == []


def unguarded(file: Path) -> Iterator[str]:
    """Each use of what only POSIX has outside a function or a branch that asks for the system."""
    text = file.read_text(encoding="utf-8")
    if not any(name.rpartition(".")[2] in text for name in POSIX_MODULES | POSIX_NAMES):
        return
    tree, lines = ast.parse(text), text.splitlines()
    asked = {
        id(inner)
        for outer in ast.walk(tree)
        if isinstance(outer, ast.FunctionDef | ast.If)
        and any(word in line for line in lines[outer.lineno - 1 : outer.end_lineno] for word in ASKS)
        for inner in ast.walk(outer)
    }
    for node in ast.walk(tree):
        if id(node) not in asked and (used := _posix(node)):
            yield f"{file.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}: {used}"


def _posix(node: ast.AST) -> str:
    if isinstance(node, ast.Import):
        return ", ".join(one.name for one in node.names if one.name in POSIX_MODULES)
    if isinstance(node, ast.ImportFrom):
        return node.module or "" if node.module in POSIX_MODULES else ""
    name = ast.unparse(node) if isinstance(node, ast.Attribute) else ""
    return name if name in POSIX_NAMES else ""
