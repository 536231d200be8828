"""A replay plays what was recorded, and nothing else."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modallab.bench.loader import open_bench
from modallab.bench.protocol import AcquisitionRequest, Burst
from modallab.core.block import Block, Campaign
from modallab.core.errors import (
    BenchTimeoutError,
    ConfigurationError,
    DeviceGoneError,
    FormatError,
    SamplesLostError,
    UnsupportedError,
)
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign

RATE_HZ = 2000.0
N = 600


@pytest.fixture
def blocks(rig: Rig) -> tuple[Block, ...]:
    rng = np.random.default_rng(3)
    names = tuple(c.name for c in rig.channels)
    return tuple(
        Block(
            name=f"impact_p10_{n + 1}",
            test="impact",
            order=n,
            rate_hz=RATE_HZ,
            samples=rng.integers(-900, 900, (len(names), N), dtype=np.int16),
            scale=np.full(len(names), 10 / 2**15),
            units=("V",) * len(names),
            channels=names,
            drive_point=10,
            first_sample=5000 + 4000 * n,
        )
        for n in range(3)
    )


def save(rig: Rig, blocks: tuple[Block, ...], folder: Path) -> str:
    write_campaign(Campaign(rig, blocks), folder / "campaign.h5")
    return f"replay://{folder}?speed=0"


def test_every_sample_comes_back_and_no_gap_is_spliced(rig: Rig, blocks: tuple[Block, ...], tmp_path: Path):
    bench = open_bench(save(rig, blocks, tmp_path), rig)
    bench.configure(AcquisitionRequest("impact", RATE_HZ))
    bench.start()
    for n, block in enumerate(blocks):
        chunk = bench.read(N, 1.0)
        assert chunk.first_sample == 4000 * n
        np.testing.assert_array_equal(chunk.samples, block.samples)
    with pytest.raises(BenchTimeoutError, match="ended"):
        bench.read(1, 1.0)


def test_a_read_over_the_end_of_a_block_is_lost_samples_and_the_next_block_follows(
    rig: Rig, blocks: tuple[Block, ...], tmp_path: Path
):
    bench = open_bench(save(rig, blocks, tmp_path), rig)
    bench.configure(AcquisitionRequest("impact", RATE_HZ))
    bench.start()
    bench.read(N - 10, 1.0)
    with pytest.raises(SamplesLostError, match=r"ends at sample 600, 10 samples ahead; 4000 comes next"):
        bench.read(11, 1.0)
    assert bench.read(5, 1.0).first_sample == 4000


def test_blocks_whose_places_were_not_counted_are_never_joined(rig: Rig, blocks: tuple[Block, ...], tmp_path: Path):
    uncounted = tuple(replace(block, first_sample=0) for block in blocks)
    bench = open_bench(save(rig, uncounted, tmp_path), rig)
    bench.configure(AcquisitionRequest("impact", RATE_HZ))
    bench.start()
    assert [bench.read(N, 1.0).first_sample for _ in blocks] == [0, N + 1, 2 * (N + 1)]


def test_another_rate_another_test_and_output_are_rejected(rig: Rig, blocks: tuple[Block, ...], tmp_path: Path):
    bench = open_bench(save(rig, blocks, tmp_path), rig)
    with pytest.raises(ConfigurationError, match=r"1000 Hz.*2000 Hz"):
        bench.configure(AcquisitionRequest("impact", 1000.0))
    with pytest.raises(ConfigurationError, match="no sine test"):
        bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.configure(AcquisitionRequest("impact", RATE_HZ))
    bench.start()
    with pytest.raises(UnsupportedError, match="no output"):
        bench.play(Burst(20.0, 0.5, 0.1, 1.0))


def test_its_speed_is_kept(rig: Rig, blocks: tuple[Block, ...], tmp_path: Path):
    url = save(rig, blocks, tmp_path).replace("speed=0", "speed=4")
    took_s: list[float] = []
    for _ in range(5):
        bench = open_bench(url, rig)
        assert bench.info.real_time
        bench.configure(AcquisitionRequest("impact", RATE_HZ))
        bench.start()
        began = time.monotonic()
        bench.read(N, 1.0)
        took_s.append(time.monotonic() - began)
        with pytest.raises(BenchTimeoutError):
            bench.read(N, 0.001)
    # A busy machine makes some of them late, and none early.
    assert min(took_s) == pytest.approx(N / RATE_HZ / 4, abs=0.05)


def test_what_is_no_recording_is_rejected(rig: Rig, blocks: tuple[Block, ...], tmp_path: Path):
    with pytest.raises(DeviceGoneError):
        open_bench(f"replay://{tmp_path / 'nowhere'}", rig)
    (tmp_path / "campaign.h5").write_bytes(b"no campaign")
    with pytest.raises(FormatError):
        open_bench(f"replay://{tmp_path}", rig)
    with pytest.raises(ConfigurationError, match="speed"):
        open_bench(f"replay://{tmp_path}?speed=fast", rig)
    with pytest.raises(ConfigurationError, match="pace"):
        open_bench(f"replay://{tmp_path}?pace=1", rig)
    fewer = rig.model_copy(update={"channels": rig.channels[:5]})
    with pytest.raises(ConfigurationError, match="rig file field channels"):
        open_bench(save(rig, blocks, tmp_path), fewer)
