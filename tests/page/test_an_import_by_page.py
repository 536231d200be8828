"""A table of another program, taken by the page's form with what it does not say, is identified on the page."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from page_browser import Watched
from scipy.signal import cont2discrete, lfilter
from service_process import ServiceProcess

Open = Callable[..., Watched]
RATE_HZ, COUNT = 2048, 4096
FREQUENCY_HZ, DAMPING = 40.0, 0.01


def table() -> str:
    """A hit, with decimal commas, responses in g, and a temperature that no rig has."""
    t = np.arange(COUNT) / RATE_HZ
    force = np.where((t > 0.25) & (t < 0.254), 100 * np.sin(np.pi * (t - 0.25) / 0.004) ** 2, 0.0)
    pole = 2 * np.pi * FREQUENCY_HZ
    b, a, _ = cont2discrete(([1.0, 0, 0], [1, 2 * DAMPING * pole, pole**2]), 1 / RATE_HZ, "foh")
    motion = lfilter(np.ravel(b), a, force) / 9.80665
    noise = np.random.default_rng(1).normal(0, 1e-3, (3, COUNT))
    rows = np.vstack([t, force + noise[0], motion + noise[1], 0.5 * motion + noise[2], np.full(COUNT, 21.5)])
    lines = (";".join(f"{value:.9f}" for value in row).replace(".", ",") for row in rows.T)
    return "\n".join(["Zeit [s];Kraft [N];a10 [g];a06 [g];Temperatur [°C]", *lines, ""])


@pytest.mark.thorough("starts a service, and identifies what was imported")
def test_a_foreign_table_becomes_a_model(operator: Open, served: ServiceProcess, tmp_path: Path) -> None:
    ada = operator()
    ada.view("Campaigns")
    ada.page.click("summary:text-is('Facts missing in the files')")
    said = {"channels": "force, a06, a10", "variable": "force=Kraft", "drive_point": "10"}
    for name, text in said.items():
        ada.page.fill(f"#f-query-{name}", text)
    (tmp_path / "hit.csv").write_text(table(), encoding="utf-8")
    ada.page.set_input_files("#file", tmp_path / "hit.csv")
    ada.page.wait_for_selector(".drop p:text-is('hit.csv is there.')")
    (campaign,) = served.client.campaigns()
    assert served.client.run(campaign.runs[0]).accepted == 1
    ada.page.click("button[aria-label='Open hit.csv']")
    ada.page.click("a:text-is('Model')")
    ada.page.click("button:text-is('Identify')")
    row = ada.page.locator("[aria-labelledby=p-modes-of-the-impact-test] tbody tr")
    row.first.wait_for()
    assert row.count() == 1
    assert row.first.inner_text().split()[1].startswith(("40.0", "39.99"))
