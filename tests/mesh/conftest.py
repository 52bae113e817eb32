"""A web server on this machine, and a cache folder of its own for each test."""

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest


@dataclass
class Server:
    """What the server answers, by path: body, headers, and how many bytes it sends before it hangs up."""

    address: str
    bodies: dict[str, bytes] = field(default_factory=dict)
    headers: dict[str, dict[str, str]] = field(default_factory=dict)
    cut: dict[str, int] = field(default_factory=dict)
    requests: list[str] = field(default_factory=list)

    def serve(self, path: str, body: bytes, **headers: str) -> str:
        self.bodies[path], self.headers[path] = body, headers
        return f"{self.address}{path}"


@pytest.fixture
def server(monkeypatch) -> Iterator[Server]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            site.requests.append(self.path)
            if self.path not in site.bodies:
                self.send_error(404)
                return
            body = site.bodies[self.path]
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            for name, value in site.headers[self.path].items():
                self.send_header(name.replace("_", "-"), value)
            self.end_headers()
            self.wfile.write(body[: site.cut.get(self.path)])

        def log_message(self, *_args: object) -> None:
            pass

    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as http:
        site = Server(f"http://127.0.0.1:{http.server_port}")
        thread = threading.Thread(target=http.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield site
        http.shutdown()
        thread.join()


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    """Folder of WM3D_CACHE, not made yet; WM3D_DATA is unset."""
    monkeypatch.setenv("WM3D_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("WM3D_DATA", raising=False)
    return tmp_path / "cache"
