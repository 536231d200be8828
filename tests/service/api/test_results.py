"""Models, comparisons and diagnoses as resources: the same as the jobs gave, and whether they are still current."""

import time
from collections.abc import Iterator
from copy import deepcopy
from io import BytesIO
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from furnished import furnish
from lab import RIG, Lab
from scipy import io

import modallab as ml
from modallab.core.documents.models import ComparisonView, ModelsView
from modallab.core.rig import Rig
from modallab.formats.importer import import_sources
from modallab.jobs.leases import JobLeases
from modallab.storage.campaigns import campaign_of

API = "/api/v1"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory, link_rig: Rig) -> Iterator[Lab]:
    made = furnish(tmp_path_factory.mktemp("results") / "data", link_rig)
    yield made
    made.close()


@pytest.fixture(scope="module")
def campaign(lab: Lab) -> str:
    return next(c.id for c in lab.service.repository.campaigns(None, 10) if c.runs)


@pytest.fixture(scope="module")
def run(lab: Lab, campaign: str) -> str:
    return lab.service.repository.campaign(campaign).runs[0]


def test_a_model_is_that_of_its_job_and_lists_are_without_it(lab: Lab, campaign: str, run: str) -> None:
    with lab.client() as client:
        answer = client.get(f"{API}/campaigns/{campaign}/model").json()
        assert client.get(f"{API}/runs/{run}/model").json() == answer
        found = ModelsView.model_validate(answer)
        job = client.get(f"{API}/jobs/{found.job}").json()
        listed = client.get(f"{API}/campaigns/{campaign}/jobs").json()["items"]
        of_run = client.get(f"{API}/runs/{run}/jobs").json()["items"]
    (document,) = job["result"]["document"]["models"]
    (model,) = found.models
    np.testing.assert_array_equal(model.model.frequency_hz, document["frequency_hz"])
    np.testing.assert_array_equal(model.frac, document["frac"])
    assert model.assessment is not None
    assert len(model.assessment.confidence) == model.model.n_modes
    assert found.runs == (run,)
    assert {one["id"] for one in listed} == {one["id"] for one in of_run}
    assert all(one["result"] is None for one in listed + of_run)


def test_a_run_compared_with_itself_does_not_differ(lab: Lab, run: str) -> None:
    with lab.client() as client:
        answer = client.get(f"{API}/comparison", params={"one": run, "other": run})
        missing = client.get(f"{API}/comparison", params={"one": run, "other": "no-such-run"})
    same = ComparisonView.model_validate(answer.json())
    assert same.modes == tuple((n, n) for n in range(len(same.modes)))
    np.testing.assert_array_equal(same.difference_percent, 0)
    np.testing.assert_allclose(same.mac, 1, atol=1e-12)
    assert same.alone == ((), ())
    assert missing.status_code == 404


def test_what_is_not_there_yet_says_how_to_get_it(lab: Lab, campaign: str) -> None:
    with lab.client() as client:
        gap = client.get(f"{API}/campaigns/{campaign}/gap")
        empty = next(c.id for c in lab.service.repository.campaigns(None, 10) if not c.runs)
        model = client.get(f"{API}/campaigns/{empty}/model")
    assert gap.status_code == model.status_code == 404
    assert f"POST to {API}/campaigns/{campaign}/diagnoses" in gap.json()["remedy"]


def test_the_newest_model_of_every_test_is_there_whichever_job_computed_it(lab: Lab, campaign: str, run: str) -> None:
    impact = lab.service.jobs.list(kind="identify").jobs[0]
    before = lab.service.jobs.get(impact.id).result
    assert isinstance(before, dict)
    after = deepcopy(before)
    after["document"]["models"][0]["test"] = "sine"
    job = lab.service.jobs.submit("identify", {"test": "sine"}, (run,), lab.service.store.revision((run,)))
    lab.service.repository.add_job(campaign, job, "Ada")
    leases = JobLeases(lab.service.engine, "tester")
    taken = next(one for one in leases.lease_jobs({"identify", "report"}, 10) if one.job.id == job.id)
    assert leases.complete(taken, after)
    with lab.client() as client:
        found = ModelsView.model_validate(client.get(f"{API}/campaigns/{campaign}/model").json())
        curves = client.get(f"{API}/campaigns/{campaign}/curves").json()
    assert [(one.model.test, one.job) for one in found.models] == [("impact", impact.id), ("sine", job.id)]
    assert found.job == job.id
    assert len(curves["tests"]) == 2


def test_a_parameter_that_an_address_does_not_know_is_rejected_with_those_it_knows(lab: Lab, campaign: str) -> None:
    with lab.client() as client:
        wrong = client.get(f"{API}/campaigns/{campaign}/export", params={"format": "uff"})
        none = client.get(f"{API}/campaigns/{campaign}/model", params={"test": "sine"})
        right = client.get(f"{API}/campaigns", params={"limit": 1, "text": "model"})
    assert (wrong.status_code, none.status_code, right.status_code) == (422, 422, 200)
    (error,) = wrong.json()["errors"]
    assert error["where"] == "query.format"
    assert "it takes to" in error["what"]


def test_a_campaign_as_a_folder_of_tables_comes_as_a_zip(lab: Lab, campaign: str, run: str) -> None:
    with lab.client() as client:
        answer = client.get(f"{API}/campaigns/{campaign}/export", params={"to": "csv"}).raise_for_status()
    assert f'filename="{campaign}.csv.zip"' in answer.headers["content-disposition"]
    with ZipFile(BytesIO(answer.content)) as packed:
        assert len([name for name in packed.namelist() if name.endswith(".csv")]) == len(lab.store.blocks(run))
    # It is deleted once the answer has gone out.
    end = time.monotonic() + 30.0
    while list(lab.store.folder.glob("modallab-export-*")):
        assert time.monotonic() < end
        time.sleep(0.02)


def test_who_asks_again_for_a_lease_learns_that_it_is_his(lab: Lab) -> None:
    with lab.client() as client:
        take, named = f"{API}/rigs/{RIG}/lease", {"operator": "Emmy"}
        lease = client.post(take, json=named).raise_for_status().json()["id"]
        again = client.post(take, json=named).json()
        other = client.post(take, json={"operator": "Otto"}).json()
        client.delete(take, headers={"Modallab-Lease": lease}).raise_for_status()
    assert "the lease is yours" in again["detail"]
    assert "recover" in again["remedy"]
    assert "Emmy holds" in other["detail"]


def test_a_model_is_not_current_once_another_block_counts(lab: Lab, run: str) -> None:
    """The run has ended: a verdict moves nothing, and needs no lease."""
    with lab.client() as client:
        place, headers = f"{API}/runs/{run}", {"Modallab-Operator": "Emmy"}
        assert client.get(f"{place}/model").json()["current"]
        for accepted in (False, True):
            verdict = {"accepted": accepted, "reason": "a slip"}
            client.put(f"{place}/blocks/0/verdict", json=verdict, headers=headers).raise_for_status()
            assert client.get(f"{place}/model").json()["current"] is accepted
        # What waits is ordered again besides, by the service itself.
        entry = next(e for e in client.get(f"{API}/audit").json()["items"] if e["operator"] != "service")
    assert (entry["operator"], entry["action"]) == ("Emmy", "verdict")


@pytest.mark.parametrize(("to", "ending"), [("hdf5", ".h5"), ("uff", ".uff")])
def test_a_campaign_is_exported_as_a_file_that_holds_its_blocks(
    lab: Lab, campaign: str, run: str, tmp_path: Path, to: str, ending: str
) -> None:
    with lab.client() as client:
        answer = client.get(f"{API}/campaigns/{campaign}/export", params={"to": to}).raise_for_status()
    assert f'filename="{campaign}{ending}"' in answer.headers["content-disposition"]
    file = tmp_path / f"export{ending}"
    file.write_bytes(answer.content)
    found = import_sources([file], lab.store.catalogue.run(run).rig)
    assert len(found.blocks) == len(lab.store.blocks(run))
    # It is deleted once the answer has gone out.
    end = time.monotonic() + 30.0
    while list(lab.store.folder.glob("modallab-export-*")):
        assert time.monotonic() < end
        time.sleep(0.02)


def test_campaigns_are_found_by_name_note_and_rig(lab: Lab) -> None:
    with lab.client() as client:

        def found(**query: str) -> list[str]:
            return [c["name"] for c in client.get(f"{API}/campaigns", params=query).json()["items"]]

        assert found(text="A MODEL") == ["with a model"]
        assert found(text="with") == found(rig=RIG) == ["with nothing", "with a model"]
        assert found(text="100%") == found(rig="another") == []


def test_what_cannot_be_exported_says_why(lab: Lab, campaign: str) -> None:
    with lab.client() as client:
        unknown = client.get(f"{API}/campaigns/{campaign}/export", params={"to": "docx"})
        empty = next(c.id for c in lab.service.repository.campaigns(None, 10) if not c.runs)
        nothing = client.get(f"{API}/campaigns/{empty}/export")
    assert (unknown.status_code, nothing.status_code) == (422, 409)
    assert "hdf5" in unknown.text


@pytest.mark.parametrize("to", ["hdf5", "uff"])
def test_what_is_exported_comes_back_as_a_campaign_that_gives_the_same_frf(
    lab: Lab, campaign: str, run: str, to: str
) -> None:
    with lab.client() as client:
        file = client.get(f"{API}/campaigns/{campaign}/export", params={"to": to}).raise_for_status().content
        asked = {"name": f"from {to}", "rig": RIG, "format": to}
        made = client.post(f"{API}/imports", params=asked, content=file).raise_for_status()
        (copy,) = made.json()["runs"]
        assert client.get(made.headers["Location"]).json() == made.json()
        there = client.get(f"{API}/runs/{copy}").json()
        before, after = (client.get(f"{API}/runs/{name}/frf").json() for name in (run, copy))
        followed = client.get(f"{API}/events", params={"run": copy}).json()["items"]
    assert (there["state"], there["campaign"], there["blocks"]) == ("done", made.json()["id"], 6)
    assert [(event["kind"], event["content"]["state"]) for event in followed] == [("state", "done")]
    assert before["averages"] == after["averages"]
    exact = to == "hdf5"
    for part in ("re", "im"):
        np.testing.assert_allclose(
            np.array(after["values"][part]), np.array(before["values"][part]), rtol=0 if exact else 1e-4, atol=1e-7
        )
    ours, theirs = (lab.store.catalogue.blocks(name) for name in (run, copy))
    if exact:
        assert {b.crc32 for b in theirs} == {b.crc32 for b in ours if b.note.accepted}
        assert lab.store.catalogue.run(copy).plan == lab.store.catalogue.run(run).plan
    assert not list(lab.store.folder.glob("modallab-import-*"))


def test_a_file_that_is_sent_again_with_its_key_is_one_campaign(lab: Lab, campaign: str) -> None:
    asked = {"name": "once", "rig": RIG}
    with lab.client() as client:
        file = client.get(f"{API}/campaigns/{campaign}/export").raise_for_status().content
        key = {"Idempotency-Key": "key-of-this-file"}
        first, again = (
            client.post(f"{API}/imports", params=asked, content=file, headers=key).raise_for_status() for _ in range(2)
        )
        another = client.post(f"{API}/imports", params=asked | {"name": "twice"}, content=file, headers=key)
        found = client.get(f"{API}/campaigns", params={"text": "once"}).json()["items"]
    assert first.json() == again.json()
    assert first.headers["Location"] == again.headers["Location"]
    assert again.headers["Idempotency-Replayed"] == "true"
    assert (another.status_code, another.json()["code"]) == (422, "idempotency-key")
    assert [c["id"] for c in found] == [first.json()["id"]]


def test_a_map_says_what_the_arrays_of_a_file_are(lab: Lab, link_rig: Rig, tmp_path: Path) -> None:
    count, times = len(link_rig.responses), np.arange(1024) / 1024.0
    force = np.where(np.arange(1024) == 100, 50.0, 0.0)
    acc = np.outer(np.sin(60 * times) * (times > 0.1), np.arange(1, count + 1))
    io.savemat(tmp_path / "x.mat", {"q": times, "hammer": force, "readings": acc})
    said = "{time: q, force: hammer, responses: readings, axes: [samples, outputs], response_unit: m/s^2}"
    asked = {"name": "mapped", "rig": RIG, "format": "mat", "drive_point": link_rig.points[0].id}
    with lab.client() as client:
        file = (tmp_path / "x.mat").read_bytes()
        made = client.post(f"{API}/imports", params=asked | {"map": said}, content=file)
        assert made.status_code == 201, made.text
        (block,) = lab.store.catalogue.blocks(made.json()["runs"][0])
        wrong = [
            client.post(f"{API}/imports", params=asked | {"map": "{time: q"}, content=file),
            client.post(f"{API}/imports", params=asked | {"map": "{tyme: q, responses: readings}"}, content=file),
            client.post(f"{API}/imports", params=asked | {"format": "uff", "map": said}, content=file),
        ]
    assert block.count == 1024
    assert [(a.status_code, a.json()["code"]) for a in wrong] == [(422, "format"), (422, "format"), (422, "data")]


def test_what_the_command_line_takes_of_a_file_rest_takes_too(lab: Lab, link_rig: Rig) -> None:
    names, rng = [c.name for c in link_rig.channels], np.random.default_rng(1)
    columns = [*names[:3], "inside"]
    rows = [f"{k / 1024:.9f}," + ",".join(f"{v:.6f}" for v in rng.normal(size=4)) for k in range(512)]
    body = "\n".join(["time [s]," + ",".join(columns), *rows]) + "\n"
    asked = {"name": "part", "rig": RIG, "format": "csv", "channels": names[:3], "level": "high", "set_up": "left"}
    with lab.client() as client:
        made = client.post(f"{API}/imports", params=asked | {"test": "random"}, content=body.encode())
        assert made.status_code == 201, made.text
        wrong = client.post(f"{API}/imports", params=asked | {"variable": ["force"]}, content=body.encode())
    (run,) = made.json()["runs"]
    (block,) = lab.store.catalogue.blocks(run)
    campaign = campaign_of(lab.store, [run])
    assert (campaign.blocks[0].channels, block.note.level) == (tuple(names[:3]), "high")
    assert campaign.provenance["setup"] == "left"
    assert (wrong.status_code, "CHANNEL=NAME" in wrong.json()["detail"]) == (422, True)


def test_what_cannot_be_imported_says_why_and_leaves_nothing(lab: Lab) -> None:
    before = len(lab.service.repository.campaigns(None, 100)), len(lab.store.catalogue.runs())
    asked = {"name": "x", "rig": RIG}
    with lab.client() as client:
        answers = [
            client.post(f"{API}/imports", params=asked, content=b"no file at all"),
            client.post(f"{API}/imports", params=asked),
            client.post(f"{API}/imports", params=asked | {"format": "docx"}, content=b"x"),
            client.post(f"{API}/imports", params=asked | {"rig": "none"}, content=b"x"),
        ]
    assert [(a.status_code, a.json()["code"]) for a in answers] == [
        (422, "format"), (422, "data"), (422, "data"), (404, "not-found"),
    ]  # fmt: skip
    assert before == (len(lab.service.repository.campaigns(None, 100)), len(lab.store.catalogue.runs()))
    assert not list(lab.store.folder.glob("modallab-import-*"))


def test_an_answer_to_a_change_without_an_operator_says_so(lab: Lab) -> None:
    with lab.client() as client:
        unnamed = client.post(f"{API}/campaigns", json={"name": "whose", "rig": RIG})
        named = client.post(
            f"{API}/campaigns", json={"name": "hers", "rig": RIG}, headers={"Modallab-Operator": "Emmy"}
        )
    assert "Modallab-Operator" in unnamed.headers["Modallab-Notes"]
    assert "Modallab-Notes" not in named.headers


def test_a_model_is_put_to_use(lab: Lab, campaign: str) -> None:
    """Participation, nodes, deflection, FRFs, changes and responses are those of the same model in Python."""
    at = f"{API}/campaigns/{campaign}/model"
    with lab.client() as client:
        shares = client.get(f"{at}/participation", params={"at": 10, "of": 3, "low_hz": 3, "high_hz": 200}).json()
        assert sum(shares["share"]) + shares["outside"] == pytest.approx(1)
        later = client.get(f"{at}/participation", params={"at": 10, "of": 3, "begin_s": 0.5, "end_s": 0.5}).json()
        assert later["share"][0] > shares["share"][0]
        assert any("point 10" in said for said in client.get(f"{at}/nodes").json()["advice"])
        size = client.get(f"{at}/reduction").json()
        assert size["measured_numbers"] > size["model_numbers"]
        assert np.array(size["error"]).shape == np.array(size["frac"]).shape == (10, 3)
        shape = client.get(f"{at}/deflection", params={"hz": 30, "at": 10}).json()
        assert len(shape["points"]) == len(shape["values"]["re"]) == len(shape["sigma"])
        assert all(0 < off < np.hypot(*v) for off, *v in zip(shape["sigma"], *shape["values"].values(), strict=True))
        frf = client.get(f"{at}/frf", params={"outputs": [3, 8], "inputs": 6, "lines": 50}).json()
        assert np.shape(frf["values"]["re"]) == (2, 1, len(frf["frequency_hz"]))
        mass = {"kind": "element", "at": 10, "mass_kg": 0.05}
        before = client.get(f"{API}/campaigns/{campaign}/model").json()["models"][0]["model"]["frequency_hz"]
        # A narrow peak is not missed between even lines.
        assert max(min(abs(hz / line - 1) for line in frf["frequency_hz"]) for hz in before) < 5e-3
        heavy = client.post(f"{at}/modifications", json={"changes": [mass]}).json()
        assert all(a < b for a, b in zip(heavy["frequency_hz"], before, strict=False))
        assert heavy["changes"] == ["mass 0.05 kg at 10"]
        shapes = client.get(f"{at}/shapes").json()
        assert shapes["points"] == [*range(1, 11), 0]
        assert np.shape(shapes["motion"]["re"]) == (len(before), 11, 3)
        # The mass brings in a mode from beyond the band.
        assert np.shape(heavy["motion"]["re"]) == (len(heavy["frequency_hz"]), 11, 3)
        assert len(heavy["frequency_hz"]) - len(before) in (0, 1)
        assert np.abs(np.array(shapes["motion"]["re"])[:, :, 2]).max(axis=1) == pytest.approx(1, rel=1e-3)
        assert heavy["frf"] is None
        asked = {"changes": [mass], "frf": {"at": 10, "of": 3, "lines": 40}, "check": campaign}
        looked = client.post(f"{at}/modifications", json=asked).json()
        lines = looked["frf"]["frequency_hz"]
        assert [len(looked["frf"][name]["re"]) for name in ("before", "after")] == [len(lines)] * 2
        assert max(min(abs(hz / line - 1) for line in lines) for hz in before) < 5e-3
        assert looked["checked"][0]["words"].startswith("Mode 1: predicted ")
        assert not looked["checked"][0]["inside"]
        force = {"at": [10], "forces_n": [[0.0, 10.0, 0.0, 0.0]], "step_s": 5e-4, "of": [3, 8]}
        moved = client.post(f"{at}/responses", json=force).json()
        assert np.shape(moved["values"]) == (2, 4)
        assert moved["peak"] == pytest.approx(np.abs(moved["values"]).max(axis=1))


def test_frfs_of_a_model_come_as_files_of_other_programs(lab: Lab, campaign: str, tmp_path: Path) -> None:
    at = f"{API}/campaigns/{campaign}/model/frf"
    asked = {"outputs": [3, 8], "inputs": [6], "lines": 50, "quantity": "receptance"}
    with lab.client() as client:
        plain = client.get(at, params=asked).json()
        files = {to: client.get(f"{at}/export", params=asked | {"to": to}) for to in ("uff", "mat", "hdf5")}
        assert client.get(f"{at}/export", params={"to": "xls"}).status_code == 422
    values = np.array(plain["values"]["re"]) + 1j * np.array(plain["values"]["im"])
    matlab = io.loadmat(BytesIO(files["mat"].content))
    np.testing.assert_allclose(matlab["H"], values)
    np.testing.assert_allclose(matlab["sigma"], plain["sigma"])
    for to in ("uff", "hdf5"):
        name = files[to].headers["content-disposition"].split('"')[1]
        (tmp_path / name).write_bytes(files[to].content)
        read = ml.load(tmp_path / name).campaign.frfs[0]
        np.testing.assert_allclose(read.values, values, rtol=1e-5)


def test_a_force_by_kind_moves_a_model_over_rest(lab: Lab, campaign: str) -> None:
    at = f"{API}/campaigns/{campaign}/model"
    sine = {"kind": "sine", "frequency_hz": 28.0, "amplitude_n": 2.0}
    asked = {"at": [10], "forces": [sine], "seconds": 1.0, "step_s": 1e-3, "of": [3], "samples": False}
    with lab.client() as client:
        moved = client.post(f"{at}/responses", json=asked).json()
        assert moved["values"] is None
        assert 0 < moved["peak_sigma"][0] < moved["peak"][0]
        assert moved["rms"][0] ** 2 >= sum(level**2 for level in moved["levels"][0])
        pulled = asked | {"start": [{"at": 10, "displacement_m": 0.01}]}
        assert client.post(f"{at}/responses", json=pulled).json()["peak"] > moved["peak"]
        for wrong in ({"forces_n": [[0.0, 1.0]]}, {"seconds": None}, {"at": [10, 8]}):
            assert client.post(f"{at}/responses", json=asked | wrong).status_code == 422
        found = client.get(f"{at}/state-space", params={"at": 10, "of": [3, 8]}).json()
        modes = len(found["frequency_hz"])
        assert (np.shape(found["A"]), np.shape(found["C"])) == ((2 * modes, 2 * modes), (2, 2 * modes))
        first = found["frequency_hz"][0]
        band = {"low_hz": 0.97 * first, "high_hz": 1.03 * first, "by": "mass", "at": [10, 1]}
        heavy = client.post(f"{at}/free-bands", json=band).json()["answers"][0]
        changes = [{"kind": "element", "at": 10, "mass_kg": 1.001 * heavy["size"]}]
        after = client.post(f"{at}/modifications", json={"changes": changes}).json()
        assert (heavy["at"], after["frequency_hz"][0] < 0.97 * first) == (10, True)


def test_a_model_is_compared_coupled_and_tuned_over_rest(lab: Lab, campaign: str) -> None:
    at = f"{API}/campaigns/{campaign}/model"
    with lab.client() as client:
        same = client.get(f"{at}/correlation", params={"other": campaign}).json()
        assert [(p["mode"], p["other"]) for p in same["pairs"]] == [(n, n) for n in range(1, len(same["pairs"]) + 1)]
        assert same["pairs"][0]["mac"] == pytest.approx(1)
        twice = {"kind": "coupling", "campaign": campaign, "pairs": [[10, 10]]}
        coupled = client.post(f"{at}/modifications", json={"changes": [twice, twice | {"remove": True}]})
        assert coupled.status_code == 200
        first = same["pairs"][0]["frequency_hz"][0]
        found = client.post(f"{at}/tunings", json={"mode": 1, "to_hz": 0.98 * first, "by": "mass", "at": [10]}).json()
        heavy = {"kind": "element", "at": 10, "mass_kg": found["tunings"][0]["size"]}
        after = client.post(f"{at}/modifications", json={"changes": [heavy]}).json()
        assert after["frequency_hz"][0] == pytest.approx(0.98 * first, rel=1e-3)
        absorber = client.post(f"{at}/absorbers", json={"mode": 1, "at": 10, "mass_kg": 0.02}).json()
        assert absorber["peak_after"] < absorber["peak_before"] / 2


def test_a_finite_element_model_is_corrected_over_rest(lab: Lab, campaign: str) -> None:
    at = f"{API}/campaigns/{campaign}/model/updates"
    with lab.client() as client:
        spring = {"spring@8": {"value": 0, "sigma": 1000}}
        found = client.post(at, json={"priors": spring, "held_out": [3]}).json()
        low, high = found["parameters"]["spring@8"]["interval"]
        assert low < 0 < high
        assert found["parameters"]["youngs_modulus"]["unit"] == "Pa"
        assert any("Held out, mode 3" in said for said in found["notes"])
        rows = [[n, "z"] for n in range(1, 11)]
        even = np.eye(10).tolist()
        matrices = {"stiffness": (1e5 * np.diag(np.arange(1, 11.0) ** 4)).tolist(), "mass": even, "freedoms": rows}
        tip = {"mass": np.diag(np.eye(10)[9]).tolist(), "value": 0, "sigma": 0.1}
        of = client.post(at, json={"matrices": matrices | {"parameters": {"tip": tip}}}).json()
        assert set(of["parameters"]) == {"stiffness", "mass", "tip"}
        small = matrices | {"mass": [[1.0]]}
        assert client.post(at, json={"matrices": small}).status_code == 422
        assert client.post(at, json={"priors": {"glue": {"value": 0, "sigma": 1}}}).status_code == 422


def test_what_a_model_cannot_be_asked_is_a_problem(lab: Lab, campaign: str) -> None:
    at = f"{API}/campaigns/{campaign}/model"
    with lab.client() as client:
        assert client.get(f"{at}/nodes", params={"point": 3}).status_code == 422
        assert "no model of the chirp test" in client.get(f"{at}/nodes", params={"test": "chirp"}).json()["detail"]
        foreign = client.post(f"{at}/modifications", json={"changes": [{"kind": "link", "at": 77}]})
        assert foreign.status_code < 500
        assert "77" in foreign.json()["detail"]
        one = client.get(f"{at}/participation", params={"at": 10, "of": 3, "low_hz": 3}).json()
        assert one["remedy"] == "give both, or neither"
        none = {"at": [10], "forces_n": [[0.0, 1.0], [0.0, 1.0]], "step_s": 5e-4}
        assert "2 forces at 1 points" in client.post(f"{at}/responses", json=none).json()["detail"]
