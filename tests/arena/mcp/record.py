#!/usr/bin/env python3
"""Records a conversation between a client of the Model Context Protocol and `enfilade mcp`.

    record.py stdio FILE CLIENT -- enfilade mcp --data grid -o NEW     in place of the server's command
    record.py http FILE CLIENT URL PORT                                between the client and `enfilade mcp --port`

FILE gets a line of JSON for the client (its name and version), then one per message or HTTP exchange.
"""

import http.client
import http.server
import json
import subprocess
import sys
import threading
from urllib.parse import urlsplit

lock = threading.Lock()
KEPT = ("accept", "content-type", "origin", "vary", "allow")  # and those of the protocol and of CORS


def note(file, **entry):
    with lock:
        print(json.dumps(entry), file=file, flush=True)


def over_stdio(file, command):
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:

        def back():
            for line in server.stdout:
                note(file, server=json.loads(line))
                print(line, end="", flush=True)

        thread = threading.Thread(target=back)
        thread.start()
        for line in sys.stdin:
            note(file, client=json.loads(line))
            print(line, end="", file=server.stdin, flush=True)
        server.stdin.close()
        thread.join()


def kept(headers):
    return {
        name.lower(): value
        for name, value in headers
        if name.lower() in KEPT or name.lower().startswith(("mcp-", "access-control-"))
    }


def messages(kind, body):
    """The messages of a body: JSON, or a stream of events."""
    if not body:
        return []
    if kind.startswith("text/event-stream"):
        return [
            json.loads(line[6:]) for line in body.decode().splitlines() if line.startswith("data: ")
        ]
    return [json.loads(body)]


def over_http(file, address, port):
    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def forward(self):
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            server = http.client.HTTPConnection(urlsplit(address).netloc)
            left_out = ("host", "accept-encoding")  # a body as text
            sent = {name: value for name, value in self.headers.items() if name.lower() not in left_out}
            server.request(self.command, self.path, body or None, sent)
            answer = server.getresponse()
            answered = answer.read()
            note(
                file,
                request={
                    "method": self.command, "path": self.path, "headers": kept(self.headers.items()),
                    "body": json.loads(body) if body else None,
                },
                response={
                    "status": answer.status, "headers": kept(answer.getheaders()),
                    "messages": messages(answer.getheader("Content-Type", ""), answered),
                },
            )  # fmt: skip
            self.send_response(answer.status)
            for name, value in answer.getheaders():
                if name.lower() not in ("connection", "keep-alive", "content-length"):
                    self.send_header(name, value)
            self.send_header("Content-Length", str(len(answered)))
            self.end_headers()
            self.wfile.write(answered)

        do_POST = do_GET = do_DELETE = do_OPTIONS = forward

        def log_message(self, *_):
            pass

    http.server.ThreadingHTTPServer(("127.0.0.1", int(port)), Handler).serve_forever()


def main():
    way, name, client, *rest = sys.argv[1:]
    with open(name, "w") as file:
        note(file, name=client)
        if way == "stdio":
            over_stdio(file, [word for word in rest if word != "--"])
        else:
            over_http(file, *rest)


if __name__ == "__main__":
    main()
