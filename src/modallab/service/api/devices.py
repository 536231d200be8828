"""What is there: devices, with the address to open each by, and the service's own processes."""

from typing import Annotated

from fastapi import Query

from modallab.bench.loader import DEVICES, find_devices
from modallab.core.discovery import installed_entry_points
from modallab.core.documents.pages import Page
from modallab.core.documents.rigs import DeviceView
from modallab.core.errors import DataError
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import make_router

router = make_router("devices")


@router.get("/processes")
def list_processes(service: ServiceOf) -> dict[str, int]:
    """The running processes of the service, by name, each with its process id."""
    return service.control.processes()


@router.get("/devices")
def list_devices(
    scheme: Annotated[str, Query(max_length=32, pattern=r"^[a-z0-9+]*$", description="Only this driver.")] = "",
) -> Page[DeviceView]:
    """Devices that the installed drivers find on the service's machine."""
    known = sorted(entry.name for entry in installed_entry_points(DEVICES))
    if scheme and scheme not in known:
        raise DataError(f"no driver {scheme!r} looks for devices", where="scheme", remedy=f"known: {', '.join(known)}")
    found = find_devices(f"{scheme}://" if scheme else "")
    return Page(items=tuple(DeviceView(address=device.address, what=device.what) for device in found))
