"""Answers that are files."""

from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from modallab.service.api.request_context import NOTES
from modallab.service.campaigns.export import ExportedFile

FILE = "application/octet-stream"
BINARY = {"type": "string", "format": "binary"}


def file_response(exported: ExportedFile) -> FileResponse:
    """The file, removed once it is sent; a header says what had no place in it."""
    headers = {NOTES: "; ".join(exported.notes)} if exported.notes else None
    removed = BackgroundTask(exported.remove)
    return FileResponse(
        exported.path, media_type=FILE, filename=exported.path.name, headers=headers, background=removed
    )
