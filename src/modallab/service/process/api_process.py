"""What runs in the REST process."""

import os
from multiprocessing.connection import Connection
from socket import socket

from modallab.core.settings import Settings
from modallab.service.process.log import set_up
from modallab.service.process.wire import RemoteControl


def run_api(connection: Connection, listener: socket, settings: Settings, token: str, boot: str) -> None:
    """Serve on a socket that is bound already, until the supervisor is gone or says so."""
    set_up(settings.log_level)
    # Imported here: the supervisor, which is the same program, needs none of it.
    import uvicorn

    from modallab.service.api.app import create_app
    from modallab.service.context import open_service

    server: uvicorn.Server | None = None

    def gone() -> None:
        # Connections that never end, such as those that follow events, must not keep it.
        if server is not None:
            server.should_exit = True
            server.force_exit = True

    control = RemoteControl(connection, gone)
    service = open_service(settings.data, control, boot)
    app = create_app(service, settings, token)
    control.on_frame = app.state.live.show
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            log_config=None,
            access_log=False,
            server_header=False,
            ws="websockets-sansio",
            timeout_graceful_shutdown=1,
        )
    )
    try:
        server.run(sockets=[listener])
    finally:
        service.close()
    # A thread of a library that waits for a client would keep the process.
    os._exit(0)
