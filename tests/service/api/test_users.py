"""Users: what each role may do, tokens that end, links that work once, and leases that are a person's own."""

from collections.abc import Iterator
from contextlib import ExitStack

import httpx
import pytest
from lab import RIG, Lab

from modallab.client import Client, ServiceProblemError
from modallab.core.documents.runs import RunRequest
from modallab.core.documents.users import Role, TokenRequest, UserRequest
from modallab.core.plan import ImpactPlan
from modallab.service.campaigns.run_start import begin_run
from modallab.service.records.users import UserTable
from modallab.storage.engine import write_transaction
from modallab.storage.service_tables import TOKENS

API = "/api/v1"
LONG = ImpactPlan(points=(10,), hits=60)


def token(lab: Lab, name: str, role: Role = "operator", **more: object) -> str:
    users = UserTable(lab.service.engine)
    if all(user.name != name for user in users.all_users()):
        users.add(UserRequest(name=name, role=role), "tests")
    made = users.make_token(name, TokenRequest.model_validate(more), "tests").token
    lab.app.state.callers.refresh()
    return made


@pytest.fixture(scope="module")
def people(lab: Lab) -> Iterator[dict[str, httpx.Client]]:
    roles: dict[str, Role] = {"Olga": "observer", "Otto": "operator", "Anna": "admin"}
    with ExitStack() as stack:
        yield {name: stack.enter_context(lab.client(token(lab, name, role))) for name, role in roles.items()}


def code(answer: httpx.Response) -> str:
    return answer.json().get("code", "") if answer.status_code >= 400 else str(answer.status_code)


def test_an_observer_looks_an_operator_works_and_an_admin_says_who_else_may(lab: Lab, people) -> None:
    body = {"name": "session", "rig": RIG}
    assert {name: code(who.get(f"{API}/rigs")) for name, who in people.items()} == dict.fromkeys(people, "200")
    made = {name: code(who.post(f"{API}/campaigns", json=body)) for name, who in people.items()}
    assert made == {"Olga": "role-needed", "Otto": "201", "Anna": "201"}
    seen = {name: code(who.get(f"{API}/users")) for name, who in people.items()}
    assert seen == {"Olga": "role-needed", "Otto": "role-needed", "Anna": "200"}
    rejected = people["Olga"].post(f"{API}/rigs/{RIG}/lease", json={}).json()
    assert "needs the role operator; Olga is observer" in rejected["detail"]


def test_everybody_may_stop(lab: Lab, people) -> None:
    # Also with a token that is for another rig.
    with lab.client(token(lab, "Elsewhere", rigs=("another",))) as elsewhere:
        for who in (people["Olga"], elsewhere):
            assert who.post(f"{API}/rigs/{RIG}/emergency-stop").json()["trip"] is not None
    lease = lab.lease()
    lab.controllers.reset(RIG, "a test", lease.id)
    lab.service.leases.release(RIG, lease.id)


def test_the_name_in_the_record_is_that_of_the_token(lab: Lab, people) -> None:
    claims = {"Modallab-Operator": "Anna"}
    made = people["Otto"].post(f"{API}/campaigns", json={"name": "mine", "rig": RIG}, headers=claims).json()
    assert made["operator"] == "Otto"
    lease = people["Otto"].post(f"{API}/rigs/{RIG}/lease", json={"operator": "Anna"}).json()
    assert lease["operator"] == "Otto"
    people["Otto"].delete(f"{API}/rigs/{RIG}/lease", headers={"Modallab-Lease": lease["id"]})


def test_nobody_commands_with_the_lease_of_another(lab: Lab, people) -> None:
    lease = people["Otto"].post(f"{API}/rigs/{RIG}/lease", json={}).json()["id"]
    campaign = lab.campaign()
    asked = {"json": {"plan": LONG.model_dump(mode="json")}, "headers": {"Modallab-Lease": lease}}
    rejected = people["Anna"].post(f"{API}/campaigns/{campaign}/runs", **asked).json()
    assert (rejected["code"], "Otto's" in rejected["detail"]) == ("lease-needed", True)
    people["Otto"].delete(f"{API}/rigs/{RIG}/lease", headers={"Modallab-Lease": lease})


def test_a_page_that_was_loaded_again_has_its_lease_back_and_another_person_has_not(lab: Lab, people) -> None:
    take = f"{API}/rigs/{RIG}/lease"
    first = people["Otto"].post(take, json={"ttl_s": 600}).json()
    assert code(people["Otto"].post(take, json={})) == "lease-held"
    assert code(people["Anna"].post(take, json={"recover": True})) == "lease-held"
    again = people["Otto"].post(take, json={"recover": True}).json()
    assert (again["id"], again["fence"]) == (first["id"], first["fence"])
    people["Otto"].delete(take, headers={"Modallab-Lease": first["id"]})
    assert code(people["Otto"].post(take, json={"recover": True})) == "not-found"


def test_the_same_person_takes_over_while_a_run_is_on_and_nobody_else(lab: Lab, people) -> None:
    take, over = f"{API}/rigs/{RIG}/lease", {"take_over": True}
    first = people["Otto"].post(take, json={"ttl_s": 600}).json()
    campaign = lab.campaign()
    mine = {"Modallab-Lease": first["id"]}
    plan = {"plan": LONG.model_dump(mode="json")}
    run = people["Otto"].post(f"{API}/campaigns/{campaign}/runs", json=plan, headers=mine).json()
    assert run["operator"] == "Otto"
    assert code(people["Anna"].post(take, json=over)) == "lease-held"
    second = people["Otto"].post(take, json=over).json()
    assert second["fence"] == first["fence"] + 1
    stop = f"{API}/runs/{run['id']}/commands"
    assert code(people["Otto"].post(stop, json={"kind": "stop"}, headers=mine)) == "lease-needed"
    now = {"Modallab-Lease": second["id"]}
    assert code(people["Otto"].post(stop, json={"kind": "stop"}, headers=now)) == "202"
    lab.wait_for_ended(run["id"])
    lab.wait_until_idle()
    people["Otto"].delete(take, headers=now)


def test_a_token_is_for_its_rigs(lab: Lab) -> None:
    with lab.client(token(lab, "Rita", rigs=("another",))) as rita:
        assert code(rita.get(f"{API}/rigs/{RIG}")) == "200"
        campaign = lab.campaign()
        asked = (
            rita.post(f"{API}/rigs/{RIG}/lease", json={}),
            rita.post(f"{API}/campaigns", json={"name": "n", "rig": RIG}),
            rita.post(f"{API}/campaigns/{campaign}/models"),
        )
        assert [code(answer) for answer in asked] == ["role-needed"] * 3


def test_a_token_ends_when_it_expires_or_is_revoked_and_its_cookies_with_it(lab: Lab, people) -> None:
    made = people["Anna"].post(f"{API}/users/Otto/tokens", json={"label": "a tablet", "ttl_days": 1}).json()
    ident = made["about"]["id"]
    with lab.client(made["token"]) as tablet, lab.client(None) as browser:
        assert browser.post(f"{API}/session", json={"token": made["token"]}).status_code == 204
        assert (tablet.get(f"{API}/me").json()["name"], browser.get(f"{API}/me").json()["token"]) == ("Otto", ident)
        with write_transaction(lab.service.engine) as connection:
            connection.execute(TOKENS.update().where(TOKENS.c.id == ident).values(expires_utc="2020-01-01"))
        lab.app.state.callers.refresh()
        assert {tablet.get(f"{API}/rigs").status_code, browser.get(f"{API}/rigs").status_code} == {401}
    made = people["Anna"].post(f"{API}/users/Otto/tokens", json={}).json()
    with lab.client(made["token"]) as script:
        assert script.get(f"{API}/rigs").status_code == 200
        people["Anna"].delete(f"{API}/users/Otto/tokens/{made['about']['id']}")
        assert script.get(f"{API}/rigs").status_code == 401
    assert people["Otto"].get(f"{API}/rigs").status_code == 200


def test_a_revoked_user_is_out_and_his_name_is_not_used_again(lab: Lab, people) -> None:
    with lab.client(token(lab, "Gone")) as gone:
        assert gone.get(f"{API}/rigs").status_code == 200
        assert people["Anna"].delete(f"{API}/users/Gone").json()["revoked_utc"]
        assert gone.get(f"{API}/rigs").status_code == 401
    assert code(people["Anna"].post(f"{API}/users", json={"name": "Gone"})) == "conflict"
    assert code(people["Anna"].post(f"{API}/users/Gone/tokens", json={})) == "conflict"


def test_another_process_may_revoke(lab: Lab) -> None:
    with lab.client(token(lab, "Away")) as away:
        UserTable(lab.service.engine).revoke("Away", "at the terminal")
        answers = (away.get(f"{API}/rigs").status_code for _ in iter(int, 1))
        assert next(status for status in answers if status != 200) == 401


def test_a_token_does_no_more_than_its_user(lab: Lab, people) -> None:
    assert code(people["Anna"].post(f"{API}/users/Olga/tokens", json={"role": "admin"})) == "conflict"
    weak = people["Anna"].post(f"{API}/users/Anna/tokens", json={"role": "observer"}).json()["token"]
    with lab.client(weak) as looks:
        assert code(looks.post(f"{API}/campaigns", json={"name": "n", "rig": RIG})) == "role-needed"
    with lab.client(token(lab, "Falls", "admin")) as falls:
        assert falls.get(f"{API}/me").json()["role"] == "admin"
        people["Anna"].patch(f"{API}/users/Falls", json={"role": "observer"})
        assert falls.get(f"{API}/me").json()["role"] == "observer"


def test_a_link_logs_a_browser_in_once(lab: Lab, people) -> None:
    path = people["Otto"].post(f"{API}/login-links").json()["path"]
    with lab.client(None) as browser, lab.client(None) as thief:
        assert browser.get(path, headers={"Sec-Purpose": "prefetch"}).status_code == 204
        assert browser.get(path).headers["location"] == "/"
        assert browser.get(f"{API}/me").json()["name"] == "Otto"
        assert code(thief.get(path)) == "token-needed"
        assert thief.get(f"{API}/me").status_code == 401


def test_no_secret_is_in_the_database(lab: Lab, people) -> None:
    key = {"Idempotency-Key": "secret-token-1"}
    made = people["Anna"].post(f"{API}/users/Otto/tokens", json={}, headers=key).json()["token"]
    path = people["Otto"].post(f"{API}/login-links", headers=key).json()["path"]
    kept = b"".join(file.read_bytes() for file in lab.service.folder.glob("modallab.db*"))
    assert made.encode() not in kept
    assert path.partition("=")[2].encode() not in kept


def test_one_person_does_not_get_the_answer_to_another(lab: Lab, people) -> None:
    key, body = {"Idempotency-Key": "the-same-key"}, {"name": "once", "rig": RIG}
    assert code(people["Otto"].post(f"{API}/campaigns", json=body, headers=key)) == "201"
    assert code(people["Anna"].post(f"{API}/campaigns", json=body, headers=key)) == "idempotency-key"


def test_an_old_run_is_judged_without_a_lease_and_not_by_an_observer(lab: Lab, people) -> None:
    lease = lab.lease("Bob")
    run = begin_run(lab.service, lab.campaign(), RunRequest(plan=ImpactPlan(points=(10,), hits=2)), lease.id)
    lab.wait_for_ended(run)
    lab.wait_until_idle()
    # Somebody else holds the rig meanwhile.
    path, body = f"{API}/runs/{run}/blocks/0/verdict", {"accepted": False, "reason": "a slip"}
    assert code(people["Olga"].put(path, json=body)) == "role-needed"
    assert "by Otto" in people["Otto"].put(path, json=body).json()["reason"]
    lab.service.leases.release(RIG, lease.id)


def test_every_route_says_which_role_it_needs(lab: Lab) -> None:
    document = lab.app.openapi()
    said: dict[str, set[str]] = {}
    for path, routes in document["paths"].items():
        for method, route in routes.items():
            security = route.get("security", document["security"])
            roles = {role for scheme in security for names in scheme.values() for role in names}
            assert len(roles) == 1 or security == [], (method, path)
            said.setdefault(next(iter(roles), "open"), set()).add(f"{method} {path}")
    assert said["open"] == {"get /health", f"post {API}/session", f"delete {API}/session"}
    assert f"post {API}/rigs/{{rig}}/emergency-stop" in said["observer"]
    assert all(route.split()[1].startswith(f"{API}/users") for route in said["admin"])
    # Besides the stop, what an observer may send changes nothing for anybody else: a model answers, and is as before.
    rig, model = f"post {API}/rigs/{{rig}}", f"post {API}/campaigns/{{campaign}}/model"
    harmless = {
        f"{rig}/emergency-stop",
        f"{rig}/plan-checks",
        f"post {API}/login-links",
        f"{model}/modifications",
        f"{model}/responses",
        f"{model}/tunings",
        f"{model}/absorbers",
        f"{model}/free-bands",
        f"{model}/updates",
    }
    assert {route for route in said["observer"] if not route.startswith("get ")} == harmless


def test_a_client_keeps_users_and_recovers_its_lease(lab: Lab) -> None:
    with Client(lab.url, token(lab, "Cleo", "admin")) as cleo:
        assert cleo.current_user().role == "admin"
        assert cleo.add_user("Dora", "operator").name in {user.name for user in cleo.users()}
        made = cleo.make_token("Dora", label="laptop", ttl_days=30)
        with Client(lab.url, made.token) as dora:
            assert dora.login_link().path.startswith("/login")
            with dora.take_lease(RIG, ttl_s=600) as lease, dora.take_lease(RIG, recover=True) as again:
                assert lease.id == again.id
                again.lost = RuntimeError("given back by the other")
            cleo.revoke_token("Dora", made.about.id)
            with pytest.raises(ServiceProblemError, match="token"):
                dora.rigs()
        assert [bool(known.revoked_utc) for known in cleo.tokens("Dora")] == [True]
        assert cleo.change_user("Dora", "observer").role == "observer"
        assert cleo.revoke_user("Dora").revoked_utc
