"""Who strikes the simulated bench from outside: when, where and how, and a hand on the beam."""

import json
import socket

import numpy as np
import pytest

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Bench
from modallab.cli.demo import demo_rig
from modallab.core.errors import ConfigurationError
from modallab.signals.conversion import Conversion

RIG = demo_rig()


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def opened(port: int) -> tuple[Bench, Conversion]:
    bench = open_bench(f"sim://cantilever?seed=1&zeta=0.005&operator={port}", RIG)
    delivery = bench.configure(AcquisitionRequest("impact", 2000.0))
    bench.start()
    return bench, Conversion.of(RIG, "impact", delivery.units, delivery.scale, delivery.dtype)


def send(port: int, **act: object) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        out.sendto(json.dumps(act).encode(), ("127.0.0.1", port))


def test_nothing_is_struck_when_asked_and_everything_when_sent() -> None:
    port = free_port()
    bench, conversion = opened(port)
    bench.prompt_hit(3)
    assert conversion.force_n(bench.read(4000, 1.0).samples).max() < 1
    send(port, act="strike", point=3, peak_n=60.0, after_s=0.25)
    force = conversion.force_n(bench.read(2000, 1.0).samples)
    assert force.max() == pytest.approx(60, rel=0.05)
    assert np.argmax(force > 2) == pytest.approx(500, abs=60)
    bench.close()


def test_a_double_and_an_oblique_hit() -> None:
    port = free_port()
    bench, conversion = opened(port)
    send(port, act="strike", point=10, peak_n=60.0, after_s=0.1, rebound_s=0.04, rebound_share=0.5)
    force = conversion.force_n(bench.read(1000, 1.0).samples)
    assert np.argmax(force[260:]) + 260 - np.argmax(force) == pytest.approx(80, abs=2)
    moved: list[float] = []
    for angle in (0.0, 60.0):
        bench.stop()
        bench.start()
        send(port, act="strike", point=10, peak_n=60.0, after_s=0.1, oblique_deg=angle)
        si = conversion.to_si(bench.read(2000, 1.0).samples)
        assert si[0].max() == pytest.approx(60, rel=0.05)
        moved.append(float(si[10].std()))
    assert moved[1] / moved[0] == pytest.approx(0.5, rel=0.01)
    bench.close()


def test_a_hand_brings_the_beam_to_rest() -> None:
    port = free_port()
    bench, conversion = opened(port)
    send(port, act="strike", point=10, peak_n=60.0)
    rings = conversion.to_si(bench.read(4000, 1.0).samples)[10, 2000:].std()
    send(port, act="hold", seconds=2.0)
    bench.read(6000, 1.0)
    assert conversion.to_si(bench.read(2000, 1.0).samples)[10].std() < 0.01 * rings
    bench.close()


def test_what_is_no_act_is_rejected() -> None:
    port = free_port()
    bench, _ = opened(port)
    send(port, act="jump")
    with pytest.raises(ConfigurationError, match="no act of an operator"):
        bench.read(100, 1.0)
    bench.close()


def test_one_port_serves_one_bench() -> None:
    port = free_port()
    bench, _ = opened(port)
    with pytest.raises(ConfigurationError, match=f"operator is {port}"):
        open_bench(f"sim://cantilever?operator={port}", RIG)
    bench.close()
