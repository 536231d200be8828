"""Records of all kinds, each labelled as another test: how many are identified without a word.

    python benchmarks/identification/mislabelled.py --records 200

Each record is a set of blocks of a closed-form structure driven by a hit, a sine, a stepped sine, random drive, bursts,
a periodic random signal, multisines of random and of Schroeder's phases, a chirp, a static force let go, or by nothing:
ringing down, or at rest. It prints, per kind and label, how many were rejected, and how many gave a model: those are
answers without notice. Rightly labelled sets are run as well: each must give a model or a reason other than its label.
"""

import argparse
import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "helpers"))
import drives

from modallab.core.errors import ModallabError
from modallab.core.units import TESTS, Test
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign


def outcome(kind: drives.Kind, label: Test, seed: int) -> str:
    """Rejected for its kind, rejected for another reason, or a model."""
    try:
        result = identify_campaign(drives.campaign(kind, label, seed), IdentificationOptions())
    except ModallabError as error:
        return "rejected as mislabelled" if "looks like" in str(error) else f"rejected: {str(error)[:60]}"
    return "a model with a note" if any("looks" in n for n in result.identified[0].model.notes) else "a model"


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=200)
    parser.add_argument("--right", type=int, default=20, help="rightly labelled sets")
    arguments = parser.parse_args()
    pairs = [(kind, label) for kind, right in drives.RIGHT.items() for label in TESTS if label not in right]
    wrong = Counter((*pairs[i % len(pairs)], outcome(*pairs[i % len(pairs)], i)) for i in range(arguments.records))
    for (kind, label, what), count in sorted(wrong.items()):
        print(f"{kind:14} labelled {label:14} {what:24} {count}")
    unnoticed = sum(count for (*_, what), count in wrong.items() if what == "a model")
    print(f"answers without notice: {unnoticed} of {arguments.records} (goal 0)")
    rightly = [(kind, label) for kind, right in drives.RIGHT.items() for label in right]
    for i in range(arguments.right):
        kind, label = rightly[i % len(rightly)]
        print(f"{kind:14} rightly labelled {label:14} {outcome(kind, label, 1000 + i)}", flush=True)


if __name__ == "__main__":
    main()
