"""The service over HTTP: problems, tokens, keys, tags, cursors."""

import re

import httpx
import numpy as np
import pytest
from lab import RIG, TOKEN, Lab

from modallab.client import Client
from modallab.core.documents.runs import RunRequest
from modallab.core.plan import ImpactPlan
from modallab.service.campaigns.run_start import begin_run

API = "/api/v1"


def problem(response: httpx.Response, status: int, code: str) -> dict:
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    found = response.json()
    assert (found["status"], found["code"]) == (status, code)
    return found


def test_without_the_token_nothing_is_answered_but_health(lab: Lab) -> None:
    with lab.client(None) as anyone:
        assert problem(anyone.get(f"{API}/rigs"), 401, "token-needed")
        assert anyone.get("/health").json()["rigs"] == {RIG: "idle"}
        assert problem(anyone.get(f"{API}/rigs", headers={"Authorization": "Bearer wrong"}), 401, "token-needed")


def test_every_problem_has_its_page(lab: Lab) -> None:
    with lab.client() as client:
        found = problem(client.get(f"{API}/campaigns/none"), 404, "not-found")
        page = client.get(found["type"])
        assert page.status_code == 200
        assert found["title"] in page.text


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "[::2]:80"])
def test_another_host_is_rejected(lab: Lab, host: str) -> None:
    with lab.client() as client:
        problem(client.get(f"{API}/rigs", headers={"Host": host}), 403, "foreign-host")


def test_a_page_of_another_site_changes_nothing(lab: Lab) -> None:
    with lab.client() as client:
        stop = f"{API}/rigs/{RIG}/emergency-stop"
        problem(client.post(stop, headers={"Origin": "https://evil.example"}), 403, "foreign-origin")
        problem(client.post(stop, headers={"Origin": "null"}), 403, "foreign-origin")
        assert client.get(f"{API}/rigs/{RIG}").json()["trip"] is None


def test_a_browser_logs_in_with_a_cookie_that_is_not_the_token(lab: Lab) -> None:
    with lab.client(None) as browser:
        problem(browser.post(f"{API}/session", json={"token": "wrong"}), 401, "token-needed")
        answer = browser.post(f"{API}/session", json={"token": TOKEN})
        assert answer.status_code == 204
        said = answer.headers["set-cookie"].lower()
        assert "httponly" in said
        assert "samesite=strict" in said
        assert TOKEN not in said
        assert browser.get(f"{API}/rigs").status_code == 200
        kept = browser.cookies["modallab_session"]
        browser.delete(f"{API}/session")
        assert browser.get(f"{API}/rigs").status_code == 401
        # A copy of the cookie stands for nothing any more.
        with lab.client(None) as thief:
            assert thief.get(f"{API}/rigs", headers={"Cookie": f"modallab_session={kept}"}).status_code == 401


def test_a_large_body_is_rejected_however_it_comes(lab: Lab) -> None:
    with lab.client() as client:
        large = b'{"name": "' + b"x" * 5000 + b'", "rig": "link"}'
        headers = {"Content-Type": "application/json"}
        problem(client.post(f"{API}/campaigns", content=large, headers=headers), 413, "too-large")
        pieces = (large[n : n + 100] for n in range(0, len(large), 100))
        problem(client.post(f"{API}/campaigns", content=pieces, headers=headers), 413, "too-large")


def test_a_body_that_is_not_valid_names_every_field(lab: Lab) -> None:
    with lab.client() as client:
        found = problem(client.post(f"{API}/campaigns", json={"name": "", "colour": 1}), 422, "not-valid")
        assert {"body.name", "body.rig", "body.colour"} == {one["where"] for one in found["errors"]}
        assert "/docs" in found["remedy"]
        without_kind = client.post(f"{API}/campaigns/c1/runs", json={"plan": {"points": [10]}})
        (one,) = problem(without_kind, 422, "not-valid")["errors"]
        assert one["what"] == "needs a field 'kind' with its kind"
        problem(
            client.post(f"{API}/campaigns", content=b"{", headers={"Content-Type": "application/json"}),
            422,
            "not-valid",
        )


def test_who_asks_for_a_report_that_is_not_there_learns_how_its_job_stands(lab: Lab) -> None:
    campaign, service = lab.campaign("no report"), lab.service
    with lab.client() as client:
        at = f"{API}/campaigns/{campaign}"
        assert "has no diagnosis" in problem(client.get(f"{at}/diagnosis"), 404, "not-found")["detail"]
        job = service.jobs.submit("diagnose", {"for": campaign}, [])
        service.repository.add_job(campaign, job, "Ada")
        waits = problem(client.get(f"{at}/diagnosis"), 404, "not-found")
        assert ("is queued" in waits["detail"], job.id in waits["remedy"]) == (True, True)
        service.jobs.cancel(job.id)
        gone = problem(client.get(f"{at}/diagnosis"), 404, "not-found")
        assert ("is cancelled" in gone["detail"], "order the job again" in gone["remedy"]) == (True, True)


def test_blind_trials_are_ordered_without_a_campaign(lab: Lab) -> None:
    with lab.client() as client:
        ordered = client.post(f"{API}/blind-trials", json={"parameters": {"trials": 1, "none": 0, "seed": 9}})
        assert (ordered.status_code, ordered.json()["kind"], ordered.json()["inputs"]) == (202, "blind", [])
        assert client.get(ordered.headers["location"]).json()["id"] == ordered.json()["id"]
        client.delete(ordered.headers["location"])
        none = client.post(f"{API}/blind-trials", json={"parameters": {"trials": 0, "none": 0}})
        assert "no trial is requested" in none.json()["detail"]
        of_runs = client.post(f"{API}/blind-trials", json={"runs": ["a"]})
        assert "have no input runs" in of_runs.json()["detail"]


def test_who_types_the_address_alone_or_opens_a_problem_s_page_can_read_on(lab: Lab) -> None:
    with lab.client(token=None) as client:
        assert client.get("/").headers["location"] == "/page/"
        page = client.get("/problems/lease-needed")
        assert page.status_code == 200
        assert "<code>Modallab-Lease</code>" in page.text
        assert "`" not in page.text


def test_the_same_key_makes_one_campaign(lab: Lab) -> None:
    with lab.client() as client:
        key, body = {"Idempotency-Key": "a-key-of-mine"}, {"name": "once", "rig": RIG}
        first = client.post(f"{API}/campaigns", json=body, headers=key)
        second = client.post(f"{API}/campaigns", json=body, headers=key)
        assert first.status_code == second.status_code == 201
        assert first.json() == second.json()
        assert first.headers["location"] == second.headers["location"]
        assert second.headers["idempotency-replayed"] == "true"
        other = client.post(f"{API}/campaigns", json={"name": "twice", "rig": RIG}, headers=key)
        problem(other, 422, "idempotency-key")
        # What was rejected may be tried again under its key.
        failing = {"json": {"name": "no rig", "rig": "none"}, "headers": {"Idempotency-Key": "key-number-2"}}
        for _ in range(2):
            problem(client.post(f"{API}/campaigns", **failing), 404, "not-found")


def test_a_change_must_be_of_what_was_read(lab: Lab) -> None:
    with lab.client() as client:
        made = client.post(f"{API}/campaigns", json={"name": "old", "rig": RIG})
        place, tag = made.headers["location"], made.headers["etag"]
        problem(client.patch(place, json={"name": "new"}), 428, "precondition-needed")
        changed = client.patch(place, json={"name": "new"}, headers={"If-Match": tag})
        assert changed.json()["name"] == "new"
        problem(client.patch(place, json={"name": "newer"}, headers={"If-Match": tag}), 412, "changed")
        now = changed.headers["etag"]
        assert client.get(place, headers={"If-None-Match": now}).status_code == 304
        assert client.get(place, headers={"If-None-Match": tag}).json()["name"] == "new"


def test_pages_hold_every_campaign_once(lab: Lab) -> None:
    with lab.client() as client:
        made = {client.post(f"{API}/campaigns", json={"name": f"n{n}", "rig": RIG}).json()["id"] for n in range(5)}
        seen: list[str] = []
        cursor: str | None = None
        while True:
            page = client.get(f"{API}/campaigns", params={"limit": 2} | ({"cursor": cursor} if cursor else {})).json()
            assert len(page["items"]) <= 2
            seen += [campaign["id"] for campaign in page["items"]]
            cursor = page["next"]
            if cursor is None:
                break
        assert len(seen) == len(set(seen))
        assert made <= set(seen)
        problem(client.get(f"{API}/campaigns", params={"cursor": "not ours"}), 422, "data")


def test_one_holds_the_rig_and_the_next_has_a_higher_fence(lab: Lab) -> None:
    with lab.client() as client:
        lease = client.post(f"{API}/rigs/{RIG}/lease", json={"operator": "Ada"}).json()
        taken = problem(client.post(f"{API}/rigs/{RIG}/lease", json={"operator": "Bob"}), 409, "lease-held")
        assert "Ada" in taken["detail"]
        assert client.get(f"{API}/rigs/{RIG}/lease").json()["operator"] == "Ada"
        mine = {"Modallab-Lease": lease["id"]}
        assert client.put(f"{API}/rigs/{RIG}/lease", headers=mine).json()["fence"] == lease["fence"]
        assert client.delete(f"{API}/rigs/{RIG}/lease", headers=mine).status_code == 204
        problem(client.put(f"{API}/rigs/{RIG}/lease", headers=mine), 403, "lease-needed")
        later = client.post(f"{API}/rigs/{RIG}/lease", json={"operator": "Bob", "ttl_s": 1}).json()
        assert later["fence"] == lease["fence"] + 1
        # An old lease commands nothing, however late its request arrives.
        campaign = client.post(f"{API}/campaigns", json={"name": "x", "rig": RIG}).json()["id"]
        plan = {"plan": {"kind": "impact", "points": [10]}}
        problem(client.post(f"{API}/campaigns/{campaign}/runs", json=plan, headers=mine), 403, "lease-needed")
        client.delete(f"{API}/rigs/{RIG}/lease", headers={"Modallab-Lease": later["id"]})


def test_a_lease_whose_holder_is_gone_is_taken_over_when_no_run_is_on(lab: Lab) -> None:
    with lab.client() as client:
        lost = client.post(f"{API}/rigs/{RIG}/lease", json={"operator": "Ada", "ttl_s": 3600}).json()
        rejected = problem(client.post(f"{API}/rigs/{RIG}/lease", json={"operator": "Bob"}), 409, "lease-held")
        assert "take_over" in rejected["remedy"]
        campaign = client.post(f"{API}/campaigns", json={"name": "x", "rig": RIG}).json()["id"]
        plan = {"plan": {"kind": "impact", "points": [10], "hits": 60}}
        old = {"Modallab-Lease": lost["id"]}
        run = client.post(f"{API}/campaigns/{campaign}/runs", json=plan, headers=old).json()["id"]
        over = {"operator": "Bob", "take_over": True}
        busy = problem(client.post(f"{API}/rigs/{RIG}/lease", json=over), 409, "lease-held")
        assert run in busy["detail"]
        client.post(f"{API}/runs/{run}/commands", json={"kind": "stop"}, headers=old)
        lab.wait_for_state(run, "done")
        lab.wait_until_idle()
        mine = client.post(f"{API}/rigs/{RIG}/lease", json=over).json()
        assert (mine["operator"], mine["fence"]) == ("Bob", lost["fence"] + 1)
        problem(client.post(f"{API}/campaigns/{campaign}/runs", json=plan, headers=old), 403, "lease-needed")
        noted = client.get(f"{API}/audit").json()["items"][0]
        assert (noted["action"], noted["detail"]["taken_from"]) == ("take-lease", "Ada")
        client.delete(f"{API}/rigs/{RIG}/lease", headers={"Modallab-Lease": mine["id"]})


def test_a_run_over_http_with_its_illegal_step_and_the_list_of_legal_ones(lab: Lab) -> None:
    with lab.client() as client:
        lease = client.post(f"{API}/rigs/{RIG}/lease", json={"operator": "Ada"}).json()
        mine = {"Modallab-Lease": lease["id"]}
        campaign = client.post(f"{API}/campaigns", json={"name": "x", "rig": RIG}).json()["id"]
        runs = f"{API}/campaigns/{campaign}/runs"
        wrong = {"plan": {"kind": "impact", "points": [99], "hits": 2}}
        assert "99" in problem(client.post(runs, json=wrong, headers=mine), 422, "plan")["detail"]
        begun = client.post(runs, json={"plan": {"kind": "impact", "points": [10], "hits": 60}}, headers=mine)
        assert begun.status_code == 202
        place = begun.headers["location"]
        run = begun.json()["id"]
        rejected = problem(
            client.post(runs, json={"plan": {"kind": "impact", "points": [10]}}, headers=mine), 409, "conflict"
        )
        assert run in rejected["detail"]
        lab.wait_for_state(run, "acquiring")
        found = problem(
            client.post(f"{place}/commands", json={"kind": "resume"}, headers=mine), 409, "illegal-transition"
        )
        assert set(found["legal"]) == {"paused", "processing", "stopping"}
        # One hit may be left out below only if others are there.
        lab.wait_for(lambda e: e.kind == "block" and e.content["n"] >= 6)
        assert client.post(f"{place}/commands", json={"kind": "stop"}, headers=mine).status_code == 202
        lab.wait_for_state(run, "done")
        lab.wait_until_idle()
        assert client.get(place).json()["state"] == "done"
        blocks = client.get(f"{place}/blocks", params={"limit": 500}).json()["items"]
        frf = client.get(f"{place}/frf").json()
        assert frf["averages"] == [sum(block["accepted"] for block in blocks)]
        h1, h2 = (client.get(f"{place}/frf?estimator={kind}").json()["values"] for kind in ("H1", "H2"))
        # Over the coherence, which is at most 1.
        assert np.all(np.hypot(h2["re"], h2["im"]) >= 0.999999 * np.hypot(h1["re"], h1["im"]))
        assert client.get(f"{place}/frf?estimator=H3").status_code == 422
        first = client.put(f"{place}/blocks/0/verdict", json={"accepted": False}, headers=mine).json()
        assert not first["accepted"]
        assert client.get(f"{place}/frf").json()["averages"] == [frf["averages"][0] - 1]
        client.delete(f"{API}/rigs/{RIG}/lease", headers=mine)


def test_docs_load_nothing_from_elsewhere(lab: Lab) -> None:
    with lab.client(None) as client:
        page = client.get("/docs").text
        assert "swagger-ui-bundle.js" in page
        assert "https://" not in page
        assert client.get("/docs/static/swagger-ui-bundle.js").status_code == 200
        assert client.get("/docs/static/%2e%2e/%2e%2e/core.py").status_code == 404


def test_metrics_are_in_the_text_format(lab: Lab) -> None:
    with lab.client() as client:
        answer = client.get("/metrics")
    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    lines = answer.text.splitlines()
    assert f'modallab_rig_usable{{rig="{RIG}"}} 1.0' in lines
    named = [line.split()[2] for line in lines if line.startswith("# TYPE ")]
    # One type a family, before its samples, which stand together.
    assert len(named) == len(set(named))
    family = ""
    for line in lines:
        found = re.fullmatch(r'# TYPE (\w+) gauge|(\w+)(?:\{\w+="(?:[^"\\]|\\.)*"\})? [-+.\de]+', line)
        assert found is not None, line
        family = found[1] or family
        assert found[2] in (None, family), line


@pytest.mark.parametrize(
    "path", ["/campaigns/a%00b", "/runs/%00", "/jobs/%00", "/events?rig=%00", "/campaigns?cursor=AAAA"]
)
def test_nul_is_in_no_text(lab: Lab, path: str) -> None:
    with lab.client() as client:
        assert client.get(f"{API}{path}").status_code == 422
        for note in ("a\0b", "a\\\0"):
            body = {"name": "n", "rig": RIG, "note": note}
            assert "NUL" in problem(client.post(f"{API}/campaigns", json=body), 422, "data")["detail"]
        harmless = {"name": r"a\u0000", "rig": RIG}
        assert client.post(f"{API}/campaigns", json=harmless).status_code == 201


def test_a_body_says_that_it_is_json(lab: Lab) -> None:
    with lab.client() as client:
        body = b'{"name": "n", "rig": "link"}'
        problem(client.post(f"{API}/campaigns", content=body), 415, "media-type")
        form = {"Content-Type": "application/x-www-form-urlencoded"}
        problem(client.post(f"{API}/campaigns", content=body, headers=form), 415, "media-type")


@pytest.mark.parametrize(
    ("header", "value"),
    [("Content-Encoding", "gzip"), ("Content-Encoding", "br"), ("Content-Type", "multipart/form-data; boundary=x")],
)
@pytest.mark.parametrize("path", ["/campaigns", f"/imports?name=n&rig={RIG}&format=csv"])
def test_a_packed_body_is_named_as_such(lab: Lab, path: str, header: str, value: str) -> None:
    with lab.client() as client:
        headers = {"Content-Type": "application/json", header: value}
        said = problem(client.post(f"{API}{path}", content=b"\x1f\x8b\0", headers=headers), 415, "media-type")
        assert value in said["detail"]
        assert said["where"] == header


def test_head_is_answered_and_405_names_the_methods(lab: Lab) -> None:
    with lab.client() as client:
        assert client.head(f"{API}/rigs").status_code == 200
        assert client.head(f"{API}/rigs").content == b""
        assert client.head(f"{API}/events/stream").status_code == 200
        rejected = client.put(f"{API}/campaigns")
        problem(rejected, 405, "not-allowed")
        assert rejected.headers["allow"] == "GET, HEAD, POST"


def test_a_name_that_is_not_ascii_is_kept_as_it_was_sent(lab: Lab) -> None:
    with Client(lab.url, TOKEN, "Jörg") as client:
        assert client.create_campaign("named", RIG).operator == "Jörg"
    with lab.client() as browser:
        answer = browser.post(
            f"{API}/campaigns", json={"name": "n", "rig": RIG}, headers=[(b"Modallab-Operator", b"J\xf6rg")]
        )
        assert answer.json()["operator"] == "Jörg"


def test_health_names_what_is_wrong_and_where_to_stop(lab: Lab) -> None:
    with lab.client(None) as anyone:
        health = anyone.get("/health").json()
    assert (health["status"], health["troubles"]) == ("good", [])
    assert health["emergency_stop"] == "http://127.0.0.1:8001/emergency-stop"


def test_a_stream_of_a_run_that_has_ended_ends_too_wherever_it_begins(lab: Lab) -> None:
    lease = lab.lease()
    run = begin_run(lab.service, lab.campaign(), RunRequest(plan=ImpactPlan(points=(10,), hits=1)), lease.id)
    lab.wait_for_state(run, "done")
    lab.wait_until_idle()
    lab.service.leases.release(RIG, lease.id)
    with lab.client() as client:
        stream = f"{API}/events/stream?run={run}&to_end=true"
        assert client.get(stream, timeout=10.0).text == ": listening\n\n"
        assert client.get(stream, headers={"Last-Event-ID": "9" * 20}, timeout=10.0).status_code == 200
        assert '"done"' in client.get(f"{stream}&after=0", timeout=10.0).text
