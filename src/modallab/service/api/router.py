"""The router all resources use: one prefix, idempotent routes, the problems any of them may answer with."""

from fastapi import APIRouter, Depends

from modallab.service.api.idempotent import IdempotentRoute, idempotency_key
from modallab.service.api.problems import documented

PREFIX = "/api/v1"
ANY = (401, 403, 405, 413, 422, 500, 503)
"""Statuses any route may answer with."""

ONCE = [Depends(idempotency_key)]
"""For routes that make something."""


def make_router(tag: str) -> APIRouter:
    """A router for one resource."""
    return APIRouter(prefix=PREFIX, tags=[tag], route_class=IdempotentRoute, responses=documented(*ANY))
