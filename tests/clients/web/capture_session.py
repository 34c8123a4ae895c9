#!/usr/bin/python3
"""Writes what a page would receive from a running daemon into a file, for mock_gateway.js: SceneInfo, States of every fourth tick and all
events of some seconds, each as a 4-byte little-endian length and a PageEvent. Needs the Python package of this repository on PYTHONPATH.

usage: capture_session.py HOST:PORT SECONDS FILE [GESTURE]"""
import struct
import sys
import threading
import time

import hapticd
from hapticd.v1 import gateway_pb2

SECTIONS = ["TOOLS", "DEVICES", "STRINGS", "CONTACTS", "TIMING", "STAGES", "ENERGY", "QUALITY", "STIFFNESS", "GESTURES", "REPLAY"]


def main():
    address, seconds, path = sys.argv[1], float(sys.argv[2]), sys.argv[3]
    lock = threading.Lock()
    with hapticd.Session(address) as session, open(path, "wb") as file:
        def write(**body):
            data = gateway_pb2.PageEvent(**body).SerializeToString()
            with lock:
                file.write(struct.pack("<I", len(data)) + data)

        write(item={"scene_info": session.scene})
        write(item={"lease_info": session.lease})
        write(item={"record_info": session.recorder})
        session.subscribe(divisor=4, sections=SECTIONS, max_contacts=16)
        if len(sys.argv) > 4:
            session.acquire("capture")
            session.play_gesture(sys.argv[4], repeat=0)
        end = time.monotonic() + seconds

        def events():
            while time.monotonic() < end:
                for event in session.events(timeout=0.1):
                    write(item={event.kind: event.body})

        thread = threading.Thread(target=events)
        thread.start()
        while time.monotonic() < end:
            for state in session.states(timeout=0.1):
                write(state=state)
                if time.monotonic() >= end:
                    break
        thread.join()


if __name__ == "__main__":
    main()
