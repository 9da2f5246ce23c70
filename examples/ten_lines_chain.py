#!/usr/bin/env python3
"""Twins in this process: a frame, a signal, an hour of bus time. $ECTWIN: the command, if it is not in PATH."""
import os
import sys
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python"))
import ectwin  # noqa: E402

HOUR_NS = 3600 * 10**9
read_al_status = bytes.fromhex("ffffffffffff 02000000000188a4 0e10 0700 0000 3001 0200 0000 0000 0000").ljust(60, b"\0")
with ectwin.Chain("fzm1,vr-bu-ect-map7") as chain:
    (reply,) = chain.frame(read_al_status)
    print(f"{reply.frame[28]} slaves, AL status {reply.frame[26]}")
    chain.set({"data1": 2.5})
    (reply,) = chain.frame(read_al_status, now_ns=HOUR_NS)
    print(f"after an hour: AL status {reply.frame[26]}, data1 = {chain.get('data1')}")
