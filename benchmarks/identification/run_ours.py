"""The project on one case, as run_peer.py runs a peer: reads FRFs from a file, prints the result as JSON.

    python run_ours.py CASE.npz ORDER

ORDER 0 leaves the order to the project, as a user would.
"""

import json
import sys
import time

import numpy as np
from cases import Case, Structure
from ours import identified
from run_peer import peak_mib

from modallab.core.model import ModalModel


def loudest(model: ModalModel) -> list[dict[str, list[float]]]:
    """Each mode's modal constants from the input that drives it hardest, real and imaginary parts."""
    inputs = np.argmax(np.sum(np.abs(model.modal_constants), axis=1), axis=1)
    columns = [constants[:, i] for constants, i in zip(model.modal_constants, inputs, strict=True)]
    return [{"real": c.real.tolist(), "imag": c.imag.tolist()} for c in columns]


def main() -> None:
    path, order = sys.argv[1], int(sys.argv[2])
    data = np.load(path)
    nothing = Structure(np.zeros(0), np.zeros(0), np.zeros((0, 0)), tuple(int(d) for d in data["drive"]))
    case = Case(data["frequency_hz"], data["mobility"], nothing, np.zeros(0))
    begin = time.process_time()
    model = identified(case, order or None)
    took = time.process_time() - begin
    found = {"f": [], "zeta": []}
    if model is not None:
        found = {"f": model.frequency_hz.tolist(), "zeta": model.damping_ratio.tolist(), "shapes": loudest(model)}
    print(json.dumps(found | {"cpu_s": took, "mib": peak_mib()}))


if __name__ == "__main__":
    main()
