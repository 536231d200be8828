"""Makes the environment in which the peers run, apart from the project's own.

    python benchmarks/identification/make_peers.py [folder]

It holds what `peers.txt` lists, from the package index pip is set up for. The folder is given to `compare.py --peers`.
"""

import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).parent


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else HERE / ".peers")
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    subprocess.run([str(python), "-m", "pip", "install", "--quiet", "-r", str(HERE / "peers.txt")], check=True)
    listed = subprocess.run([str(python), "-m", "pip", "freeze"], check=True, capture_output=True, text=True).stdout
    requested = ("sdypy", "sdynpy", "pyoma", "pyyeti", "numpy", "scipy")
    print(*[line for line in listed.splitlines() if line.lower().startswith(requested)], sep="\n")


if __name__ == "__main__":
    main()
