"""The demo's campaign over devices gives the model the simulated bench gives.

The same seed once as `sim://`, once behind a simulated NI device server in another process, with hits struck by an
operator who types and, for the sine test, a serial generator. The models are compared mode by mode in joint sigmas.

    python benchmarks/devices_campaign.py                    # 9215: 2 kHz and 1 kHz as asked for
    python benchmarks/devices_campaign.py --system 9234      # impact at 2048 Hz, sine at 1 kHz delivered from 2048
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "helpers"))

from ni_server import NiServer

from modallab.acquisition.process.rig_process import RigProcess
from modallab.cli.demo import demo_plans
from modallab.core.block import Campaign
from modallab.core.events import HitRejected, HitRequested
from modallab.core.hardware import Excitation
from modallab.core.model import ModalModel
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import parse_rig
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.service.campaigns.local_session import record_campaign
from modallab.storage import Store, campaign_of

MODES = 3


def demo_rig() -> Rig:
    return parse_rig((files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "the demo's rig")


def rig_of(system: str, generator: str, dialect: str) -> Rig:
    rig = demo_rig()
    if system == "9234":
        assert rig.converter is not None
        channels = tuple(channel.model_copy(update={"range_v": 5.0}) for channel in rig.channels)
        rig = rig.model_copy(
            update={"channels": channels, "converter": rig.converter.model_copy(update={"range_v": 5.0, "bits": 24})}
        )
    if not generator:
        return rig
    return rig.model_copy(update={"excitation": Excitation(kind="generator", output=generator, dialect=dialect)})


def plans_of(system: str, quick: bool) -> Sequence[Plan]:
    impact, sine = demo_plans()
    assert isinstance(impact, ImpactPlan)
    assert isinstance(sine, SinePlan)
    if system == "9234":
        acceptance = impact.acceptance.model_copy(update={"max_force_n": 240.0})
        impact = impact.model_copy(update={"rate_hz": 2048.0, "acceptance": acceptance})
        sine = sine.model_copy(update={"rate_hz": 2048.0, "delivered_hz": 1000.0})
    if quick:
        impact = impact.model_copy(update={"points": (10,), "hits": 3})
        sine = sine.model_copy(update={"frequencies_hz": sine.frequencies_hz[2:20:3]})
    return impact, sine


def over_devices(system: str, seed: int, dialect: str, plans: Sequence[Plan], folder: Path) -> Campaign:
    """Record a campaign through the device server."""
    bench = f"sim://cantilever?seed={seed}&bad_hits=0"
    options = ["--bench", bench, *(["--generator", dialect] if dialect else [])]
    with NiServer(rig_of(system, "", dialect), system, *options) as server:
        rig = rig_of(system, server.generator, dialect)
        runs: list[str] = []
        with RigProcess(server.url, rig, folder) as process:
            for plan in plans:
                server.say(f"preamplifiers {plan.kind}")
                for event in process.run(plan):
                    if event.run not in runs:
                        runs.append(event.run)
                    if isinstance(event, HitRequested):
                        server.say(f"strike {event.point}")
                    elif isinstance(event, HitRejected):
                        print(f"  rejected: {event.reason}")
    with Store(folder) as store:
        return campaign_of(store, runs)


def models_of(campaign: Campaign) -> dict[str, ModalModel]:
    result = identify_campaign(campaign, IdentificationOptions())
    for item in result.unidentified:
        print(f"  no model: {item}")
    return {item.source: item.model for item in result.identified}


def compare(one: ModalModel, other: ModalModel) -> list[float]:
    """Differences of the first modes' frequency and damping, in joint sigmas."""
    found: list[float] = []
    for r in range(MODES):
        s = int(np.argmin(np.abs(other.frequency_hz - one.frequency_hz[r])))
        pairs = (
            (one.frequency_hz[r], one.frequency_sigma_hz[r], other.frequency_hz[s], other.frequency_sigma_hz[s]),
            (one.damping_ratio[r], one.damping_sigma[r], other.damping_ratio[s], other.damping_sigma[s]),
        )
        found += [float((a - b) / np.hypot(sa, sb)) for a, sa, b, sb in pairs]
        f, sf, z, sz = *pairs[0][:2], *pairs[1][:2]
        g, sg, y, sy = *pairs[0][2:], *pairs[1][2:]
        print(
            f"  mode {r + 1}: {f:.5f} +- {sf:.5f} and {g:.5f} +- {sg:.5f} Hz,"
            f" {100 * z:.4f} +- {100 * sz:.4f} and {100 * y:.4f} +- {100 * sy:.4f} %,"
            f" apart by {found[-2]:+.2f} and {found[-1]:+.2f} sigma"
        )
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--system", choices=("9215", "9234"), default="9215")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--dialect", default="keysight-33500", help="of the generator; empty: the analog output")
    parser.add_argument("--quick", action="store_true", help="fewer hits and frequencies")
    arguments = parser.parse_args()
    plans = plans_of(arguments.system, arguments.quick)
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        devices = over_devices(arguments.system, arguments.seed, arguments.dialect, plans, Path(folder) / "devices")
        print(f"over devices: {len(devices.blocks)} blocks in {time.monotonic() - began:.0f} s")
        for test in ("impact", "sine"):
            block = devices.of(test)[0]
            print(f"  {test}: asked {block.requested_rate_hz:g}, device {block.actual_rate_hz:g},"
                  f" delivered {block.rate_hz:g} Hz, {block.n_samples} samples, {block.duration_s:.6f} s")  # fmt: skip
        plain = [plan.model_copy(update={"rate_hz": r, "delivered_hz": None})
                 for plan, r in zip(plans, (2000.0, 1000.0), strict=True)]  # fmt: skip
        sim = record_campaign(
            f"sim://cantilever?seed={arguments.seed}&bad_hits=0", demo_rig(), plain, Path(folder) / "sim",
            lambda event: None,
        )  # fmt: skip
        one, other = models_of(sim), models_of(devices)
    worst = 0.0
    for test in ("impact", "sine"):
        print(f"{test} test, sim:// and devices:")
        worst = max(worst, *map(abs, compare(one[test], other[test])))
    print(f"largest difference: {worst:.2f} joint sigmas")
    return 0 if worst < 4 else 1


if __name__ == "__main__":
    sys.exit(main())
