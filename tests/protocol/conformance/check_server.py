#!/usr/bin/python3
"""Checks a running server against proto/PROTOCOL.md, and against nothing else: every check is a sentence of the document.

usage: check_server.py [HOST:PORT] [--keys DIR] [--hapticd PATH] [--quick] [--only WORD] [--part K/N] [--list] [--json]

HOST:PORT      a server that runs already, 127.0.0.1:47800 by default; lockstep is checked if it has the virtual clock
--keys DIR     it has the keys of this folder, view.key and control.key
--hapticd PATH start this daemon on loopback, with the real clock, the virtual clock, and keys, and check all three
--quick        leave out what takes more than 4 s
--only WORD    only checks whose name contains WORD
--part K/N     only every Nth check, beginning with the Kth: parts may run side by side, each with a server of its own
--list         print names and sentences
--json         one object instead of lines

Loads scenes, changes parameters and stops the loop: not for a server that somebody plays on. Exit code 0 if nothing failed."""
import argparse
import json
import os
import secrets
import socket
import subprocess
import sys
import tempfile
import time

import checks_control  # noqa: F401
import checks_items  # noqa: F401
import checks_keyed  # noqa: F401
import checks_lockstep  # noqa: F401
import checks_session  # noqa: F401
import checks_state  # noqa: F401
import keyed
from peer import Failed, Peer, Skipped
from registry import CHECKS, Server

START_TIMEOUT_S = 30.0
STARTS = {
    "realtime": ["--clock", "realtime", "--device", "simulated", "--realtime", "best_effort"],
    "virtual": ["--clock", "virtual", "--device", "scripted"],
    "keyed": ["--clock", "virtual", "--device", "scripted"],
}


def keys_of(folder):
    """Role to key, psk and server, of a folder of keys; under the old roles the same."""
    keys = {}
    for old, new, name in ((keyed.OLD_VIEW, keyed.VIEW, "view.key"), (keyed.OLD_CONTROL, keyed.CONTROL, "control.key")):
        with open(os.path.join(folder, name), "rb") as file:
            _, psk, server = keyed.key_in(file.read())
        keys[old] = keys[new] = (psk, server)
    return keys


def make_keys(folder):
    """New keys in `folder`: the server's own, and two for clients."""
    from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
    own = secrets.token_bytes(32)
    server = X25519PrivateKey.from_private_bytes(own).public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)
    files = {"server.key": own}
    for role, name in ((1, "view.key"), (2, "control.key")):
        files[name] = b"hapticd" + bytes([role]) + secrets.token_bytes(32) + server
    for name, content in files.items():
        with open(os.path.join(folder, name), "wb", opener=lambda path, flags: os.open(path, flags, 0o600)) as file:
            file.write(content)


def run_check(server, check):
    """(outcome, text) of one check; the server is left clean."""
    outcome, text = "passed", ""
    try:
        check.run(server)
    except Skipped as reason:
        outcome, text = "SKIPPED", str(reason)
    except Failed as failure:
        outcome, text = "FAILED", str(failure)
    except OSError as error:
        outcome, text = "FAILED", f"the socket: {error}"
    try:
        server.clean()
    except Failed as failure:
        if outcome == "passed":
            outcome, text = "FAILED", f"afterwards: {failure}"
        server.peers = []
    return outcome, text


def run_all(address, label, options, report, keys=None):
    """All checks of one server; returns the results."""
    server = Server(address, keys)
    road = "plain" if keys is None else "keyed"
    results = []
    part, parts = (int(number) for number in options.part.split("/"))
    for check in sorted(CHECKS, key=lambda check: check.section)[part - 1::parts]:
        if options.only not in check.name or (check.slow and options.quick) or check.road not in ("both", road):
            continue
        begin = time.monotonic()
        for _ in range(check.attempts):
            outcome, text = run_check(server, check)
            if outcome != "FAILED":
                break
        result = {"server": label, "name": check.name, "section": check.section, "rule": check.sentence, "outcome": outcome, "text": text,
                  "seconds": round(time.monotonic() - begin, 2)}
        results.append(result)
        report(result)
    return results


def print_result(result):
    text = f": {result['text']}" if result["text"] else ""
    print(f"{result['outcome']:7} {result['server']} section {result['section']} {result['name']} ({result['seconds']} s){text}", flush=True)
    if result["outcome"] == "FAILED":
        print(f"        the rule: {result['rule']}", flush=True)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def started(path, label, folder=None):
    """The daemon and its address, once it answers; with the keys of `folder`."""
    port = free_port()
    command = [path, "--listen", f"127.0.0.1:{port}", "--scene", "single_string", *STARTS[label], *(("--keys", folder) if folder else ())]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + START_TIMEOUT_S
    while time.monotonic() < end and process.poll() is None:
        probe = Peer(("127.0.0.1", port), *((keys_of(folder)[keyed.CONTROL],) if folder else ()))
        try:
            probe.open().bye()
            return process, ("127.0.0.1", port)
        except Failed:
            probe.close()
    process.kill()
    raise SystemExit(f"{' '.join(command)} does not answer: {process.communicate()[1].strip()}")


def main():
    parser = argparse.ArgumentParser(description="Checks a server against PROTOCOL.md.")
    parser.add_argument("address", nargs="?", default="127.0.0.1:47800")
    parser.add_argument("--keys", default="")
    parser.add_argument("--hapticd", default="")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if options.list:
        for check in sorted(CHECKS, key=lambda check: check.section):
            print(f"{check.section:2} {check.name}: {check.sentence}")
        return 0

    report = (lambda result: None) if options.json else print_result
    results = []
    if options.hapticd:
        for label in STARTS:
            folder = tempfile.TemporaryDirectory()
            make_keys(folder.name)
            keys = folder.name if label == "keyed" else None
            process, address = started(options.hapticd, label, keys)
            try:
                results += run_all(address, label, options, report, keys and keys_of(keys))
                if process.poll() is not None:
                    raise SystemExit(f"the daemon ended with {process.returncode}: {process.stderr.read().strip()}")
            finally:
                process.terminate()
                process.wait(10)
                folder.cleanup()
    else:
        host, port = options.address.rsplit(":", 1)
        results = run_all((host, int(port)), options.address, options, report, keys_of(options.keys) if options.keys else None)

    counts = {outcome: sum(result["outcome"] == outcome for result in results) for outcome in ("passed", "FAILED", "SKIPPED")}
    if options.json:
        print(json.dumps({"checks": results, "passed": counts["passed"], "failed": counts["FAILED"], "skipped": counts["SKIPPED"]}, indent=1))
    else:
        print(f"{counts['passed']} passed, {counts['FAILED']} failed" + (f", {counts['SKIPPED']} skipped" if counts["SKIPPED"] else ""))
    return 1 if counts["FAILED"] else 0


if __name__ == "__main__":
    sys.exit(main())
