#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A control socket with canned replies, for commands that print them.

usage: canned.py SOCKET REPLY... -- COMMAND ARG...

The n-th request, on whatever connection, gets the n-th REPLY, in which \\n is the end of a line and \\xNN a byte. After the last reply the connection closes. The exit status is that of COMMAND.
"""
import os
import socket
import subprocess
import sys
import threading


def serve(listener, replies):
    while True:
        connection, _ = listener.accept()
        with connection, connection.makefile("rb") as requests:
            for _request in requests:
                if replies:
                    connection.sendall(replies.pop(0))
                if not replies:
                    break


def main():
    end = sys.argv.index("--")
    replies = [text.encode().decode("unicode_escape").encode("latin-1") for text in sys.argv[2:end]]
    os.makedirs(os.path.dirname(sys.argv[1]) or ".", 0o700, exist_ok=True)
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(sys.argv[1])
    listener.listen()
    threading.Thread(target=serve, args=(listener, replies), daemon=True).start()
    status = subprocess.run(sys.argv[end + 1:], check=False).returncode
    os.unlink(sys.argv[1])
    return status


if __name__ == "__main__":
    sys.exit(main())
