"""What stands between a client and the resources: compression, and pages of other sites."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from lab import RIG, TOKEN, Lab
from pydantic import ValidationError

from modallab.core.documents.runs import CampaignRequest
from modallab.core.settings import Settings
from modallab.service.api.app import accepts_gzip, create_app

PAGE = "https://page.lab:8443"


Ask = Callable[..., httpx.Response]


@pytest.fixture(scope="module")
def page(lab: Lab, tmp_path_factory: pytest.TempPathFactory) -> Ask:
    """The same service, for a page of another site."""
    app = create_app(lab.service, Settings(data=tmp_path_factory.mktemp("page"), cors=(PAGE,)), TOKEN)

    async def asked(method: str, path: str, headers: dict[str, str], body: object) -> httpx.Response:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
            return await client.request(method, path, headers={"Origin": PAGE} | headers, json=body)

    def ask(method: str, path: str, headers: dict[str, str] | None = None, body: object = None) -> httpx.Response:
        return asyncio.run(asked(method, path, headers or {}, body))

    return ask


@pytest.mark.parametrize(
    ("accepted", "takes"),
    [("gzip", True), ("br, gzip;q=0.5", True), ("*", True), ("gzip;q=0, *", False), ("", False), ("gzip;q=x", False)],
)
def test_gzip_is_sent_to_whom_takes_it(accepted: str, takes: bool) -> None:
    assert accepts_gzip(accepted) == takes


def test_text_is_compressed_with_a_weak_tag_and_is_the_same(lab: Lab) -> None:
    with lab.client() as client:
        plain = client.get("/openapi.json", headers={"Accept-Encoding": "identity"})
        small = client.get("/openapi.json", headers={"Accept-Encoding": "gzip"})
        assert "content-encoding" not in plain.headers
        assert small.headers["content-encoding"] == "gzip"
        assert "accept-encoding" in small.headers["vary"].lower()
        assert int(small.headers["content-length"]) < len(plain.content) / 4
        assert small.content == plain.content
        head = client.head("/openapi.json", headers={"Accept-Encoding": "gzip"})
        assert head.headers["content-length"] == small.headers["content-length"]


def test_a_weak_tag_is_as_good_for_a_change(lab: Lab) -> None:
    campaign = lab.service.repository.create(CampaignRequest(name="long", rig=RIG, note="x" * 2000), "Ada").id
    with lab.client() as client:
        tag = client.get(f"/api/v1/campaigns/{campaign}").headers["etag"]
        assert tag.startswith("W/")
        assert client.get(f"/api/v1/campaigns/{campaign}", headers={"If-None-Match": tag}).status_code == 304
        changed = client.patch(f"/api/v1/campaigns/{campaign}", json={"name": "new"}, headers={"If-Match": tag})
        assert changed.status_code == 200


def test_small_answers_and_streams_are_left_as_they_are(lab: Lab) -> None:
    with lab.client() as client:
        assert "content-encoding" not in client.get("/health").headers
        with client.stream("GET", "/api/v1/events/stream?after=0") as stream:
            assert "content-encoding" not in stream.headers
            assert next(stream.iter_raw())


def test_a_page_of_a_named_site_may_ask_with_a_token_and_read_what_it_needs(page: Ask) -> None:
    before = {"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "authorization,modallab-lease"}
    may = page("OPTIONS", "/api/v1/campaigns", before)
    assert may.status_code == 200
    assert may.headers["access-control-allow-origin"] == PAGE
    body = {"name": "from a page", "rig": RIG}
    made = page("POST", "/api/v1/campaigns", {"Authorization": f"Bearer {TOKEN}"}, body)
    assert made.status_code == 201
    assert "ETag" in made.headers["access-control-expose-headers"]
    assert "access-control-allow-credentials" not in made.headers
    assert page("GET", "/api/v1/rigs").headers["access-control-allow-origin"] == PAGE, "it may read why it was rejected"


def test_other_pages_stay_out(page: Ask, lab: Lab) -> None:
    foreign = {"Origin": "https://elsewhere.example", "Authorization": f"Bearer {TOKEN}"}
    rejected = page("POST", "/api/v1/campaigns", foreign, {"name": "x", "rig": RIG})
    assert (rejected.status_code, rejected.json()["code"]) == (403, "foreign-origin")
    assert "access-control-allow-origin" not in rejected.headers
    with lab.client() as client:
        assert client.options("/api/v1/campaigns", headers={"Origin": PAGE}).status_code == 405


def test_whoever_leaves_in_the_middle_of_a_body_is_no_fault_of_the_service(
    lab: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    messages = [{"type": "http.request", "body": b"{", "more_body": True}, {"type": "http.disconnect"}]
    sent: list[dict[str, object]] = []

    async def receive() -> dict[str, object]:
        return messages.pop(0)

    async def send(message: dict[str, object]) -> None:
        sent.append(message)

    headers = [(b"host", b"127.0.0.1"), (b"content-type", b"application/json"), (b"content-length", b"900")]
    scope = {"type": "http", "method": "POST", "path": "/api/v1/session", "headers": headers, "query_string": b""}
    asyncio.run(lab.app(scope, receive, send))  # type: ignore[arg-type]
    assert not messages
    assert not [record for record in caplog.records if record.levelname == "ERROR"]
    assert all(message.get("status") != 500 for message in sent)


def test_the_manual_is_served_where_it_was_built(lab: Lab, tmp_path: Path) -> None:
    with lab.client() as client:
        assert client.get("/manual/").status_code == 404
    (tmp_path / "index.html").write_text("<h1>Manual</h1>", encoding="utf-8")
    app = create_app(lab.service, Settings(data=tmp_path / "data", site=tmp_path), TOKEN)

    async def asked() -> httpx.Response:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
            return await client.get("/manual/")

    assert "Manual" in asyncio.run(asked()).text
    with pytest.raises(ValidationError, match="make docs"):
        Settings(site=tmp_path / "data")
