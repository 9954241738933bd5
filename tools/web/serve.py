# SPDX-License-Identifier: MIT
"""Serves a folder on the loopback address until Ctrl-C, and prints the address. With --port 0 the system chooses the port."""

import argparse
import functools
import http.server
from pathlib import Path


class Handler(http.server.SimpleHTTPRequestHandler):
    extensions_map = {**http.server.SimpleHTTPRequestHandler.extensions_map,
                      ".mjs": "text/javascript", ".wasm": "application/wasm"}

    def end_headers(self):
        self.send_header("Cache-Control", "no-cache")  # a page that was built anew is shown anew
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")  # these two: the page may share memory with its workers
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        super().end_headers()

    def log_message(self, format, *args):  # pylint: disable=redefined-builtin
        pass


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("folder", type=Path)
parser.add_argument("--port", type=int, default=8000)
args = parser.parse_args()
if not (args.folder / "index.html").is_file():
    parser.error(f"{args.folder}: holds no index.html; allowed: a folder that `tools/dev web` has made")

handler = functools.partial(Handler, directory=args.folder)
try:
    server = http.server.ThreadingHTTPServer(("127.0.0.1", args.port), handler)
except OSError as error:
    parser.error(f"--port {args.port}: cannot be opened: {error.strerror}; allowed: a free port, or 0 for any")
with server:
    print(f"http://127.0.0.1:{server.server_port}/", flush=True)
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass
