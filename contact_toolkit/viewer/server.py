"""The meshcat server, on the loopback interface only; run as a process of its own by `Viewer`.

meshcat's own command listens on every interface of the machine.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from meshcat.servers.zmqserver import ZMQWebSocketBridge


class LoopbackBridge(ZMQWebSocketBridge):  # type: ignore[misc]  # meshcat has no types
    """Serves browsers and Python processes of this machine alone."""

    def make_app(self) -> Any:
        """Make the web application, bound to 127.0.0.1 when it listens."""
        app = super().make_app()
        app.listen = partial(app.listen, address="127.0.0.1")
        return app


if __name__ == "__main__":
    bridge = LoopbackBridge()
    for line in (f"zmq_url={bridge.zmq_url}", f"web_url={bridge.web_url}"):
        print(line, flush=True)  # noqa: T201  the parent process reads it
    bridge.run()
