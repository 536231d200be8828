"""What the tests of a file share is made once, however many processes run the tests."""

import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import files_together
import pytest

TESTS = "import pytest\n\n\n@pytest.mark.parametrize('n', range(12))\ndef test_it(n):\n    pass\n"


@pytest.mark.thorough("starts pytest with workers of its own")
def test_all_tests_of_a_file_are_run_by_one_process(tmp_path: Path) -> None:
    helpers = str(Path(files_together.__file__).parent)
    (tmp_path / "conftest.py").write_text("from files_together import pytest_xdist_make_scheduler\n")
    (tmp_path / "pytest.ini").write_text(f"[pytest]\npythonpath = {helpers}\n")
    for name in "abcd":
        (tmp_path / f"test_{name}.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", "-v", "-n", "2", "--dist", "loadscope", "-p", "no:schemathesis"]
    done = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=300)
    workers: defaultdict[str, set[str]] = defaultdict(set)
    for worker, file in re.findall(r"\[(gw\d)\].* (test_\w\.py)::", done.stdout):
        workers[file].add(worker)
    assert len(workers) == 4
    assert all(len(by) == 1 for by in workers.values())
    assert set.union(*workers.values()) == {"gw0", "gw1"}


def test_files_that_share_a_service_and_tests_that_share_nothing() -> None:
    def group(name: str) -> str:
        return files_together.group(f"tests/{name}")

    assert group("page/test_the_page.py::test_one") == group("page/test_service_gone.py::test_two[1]")
    assert group("gap/test_hum.py::test_one") == group("gap/test_hum.py::test_two[a::b]")
    assert group("gap/test_hum.py::test_one") != group("gap/test_itself.py::test_one")
    assert group("cli/test_ctrl_c.py::test_one[1]") != group("cli/test_ctrl_c.py::test_one[2]")
