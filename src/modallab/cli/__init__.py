"""The command line. Nothing heavy is imported before a command is chosen."""

import sys
from collections.abc import Sequence
from importlib import import_module

from modallab import __version__
from modallab.cli.outputs import check_outputs
from modallab.cli.parser import build_parser
from modallab.core.blas_threads import limit_to_one_thread
from modallab.core.errors import ModallabError


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code: 0 good, 2 for anything the user can correct."""
    limit_to_one_thread()
    try:
        arguments = build_parser(__version__).parse_args(argv)
        check_outputs(arguments)
        return int(import_module(f"modallab.cli.{arguments.module}").run(arguments))
    except ModallabError as error:
        print(f"modallab: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("modallab: stopped by the operator", file=sys.stderr)
        return 130
