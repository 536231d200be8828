"""Devices that are there, with the address to open each by."""

from typing import Annotated

from fastapi import Query

from modallab.api.router import make_router
from modallab.backend.loader import find_devices
from modallab.schema.service.pages import Page
from modallab.schema.service.rigs import DeviceView

router = make_router("devices")


@router.get("/devices")
def list_devices(
    scheme: Annotated[str, Query(max_length=32, pattern=r"^[a-z0-9+]*$", description="Only this driver.")] = "",
) -> Page[DeviceView]:
    """What the installed drivers find on the service's machine."""
    found = find_devices(f"{scheme}://" if scheme else "")
    return Page(items=tuple(DeviceView(address=device.address, what=device.what) for device in found))
