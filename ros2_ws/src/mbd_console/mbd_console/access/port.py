"""The port looked at before it is announced: a web server that cannot listen says so only to its own log."""

from __future__ import annotations

import errno
import socket

from mbd_model.errors import MbdError

_WHY = {
    errno.EADDRINUSE: "another program listens there",
    errno.EACCES: "this user may not listen there",
    errno.EADDRNOTAVAIL: "this machine has no such address",
}


def refuse_taken_port(host: str, port: int, another: str = "--ros-args -p port:=8081 (-p host:=127.0.0.1)") -> None:
    """Raises MbdError when nobody can listen on that TCP port of ``host`` now; ``another``: how to give another."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        with socket.socket(family, kind, protocol) as tried:
            # As the web server does, so that a console that has just ended does not hold the port.
            tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            tried.bind(address)
    except OSError as error:
        why = _WHY.get(error.errno or 0, error.strerror or str(error))
        raise MbdError(
            f"the console cannot be served at {host}:{port}: {why}; end that, or give another: {another}"
        ) from error
