#!/usr/bin/python3
"""Prints what is touched and what sounds. usage: listen.py [HOST:PORT [TONES]]; TONES: end after so many"""
import sys

import hapticd

left = int(sys.argv[2]) if len(sys.argv) > 2 else -1
with hapticd.Session(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:47800") as session:
    for kind, event in session.events():
        if kind == "contact" and event.phase == 1:
            print(f"tool {event.tool_id} touches")
        if kind == "tone":
            print(f"string {event.string_index} sounds at {event.frequency_hz:.2f} Hz, level {event.level:.2f}", flush=True)
            left -= 1
        if left == 0:
            break
