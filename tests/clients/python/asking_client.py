#!/usr/bin/python3
"""The client that check_client.py checks: opens a session of the Python package, asks for States, and pings until it is ended.
usage: asking_client.py HOST:PORT"""
import sys
import time

import hapticd


def main():
    end = time.monotonic() + 20
    with hapticd.Session(sys.argv[1]) as session:
        subscribed = False
        while time.monotonic() < end:
            try:
                if not subscribed:
                    session.subscribe(10)
                    subscribed = True
                session.ping()
            except hapticd.SessionLost:
                pass  # joined anew
            time.sleep(0.05)


if __name__ == "__main__":
    main()
