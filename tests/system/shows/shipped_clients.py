#!/usr/bin/python3
"""The clients that are shipped, each beside a daemon: the bytes it takes, and what is left of the ticks when it is stalled or killed.

usage: shipped_clients.py [--seconds S] [--write]
Under the virtual clock the States of a session, by their chained hash, are compared with those of a run that nobody listens to, while the
client is stopped by SIGSTOP in the middle of it, or killed. Under the real clock, S seconds each, CPU time of the ticks is told with the client,
with it stopped and after it was killed, and the bytes of the datagrams (UDP payload) it exchanged. haptic-audio needs jackd, haptic-relay
mosquitto. Asserts that hashes are equal and that no fault is latched. --write puts the report into
tests/results."""
import argparse
import contextlib
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time

import show

import hapticd
from lossy_proxy import LossyProxy

sys.path.insert(0, str(show.ROOT / "tests/clients/audio"))
import jack_rig  # noqa: E402

BIN = pathlib.Path(os.environ["HAPTICCTL"]).parent
MOSQUITTO = shutil.which("mosquitto", path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")


def tcp_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def broker():
    """Port of a broker of our own."""
    port = tcp_port()
    process = subprocess.Popen([MOSQUITTO, "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield port
    finally:
        end(process)


def clients(port):
    """(name, command that lacks the server's address) of each client."""
    return [("haptic-web", [BIN / "haptic-web", "--listen", "127.0.0.1:0", "--server"]),
            ("haptic-osc", [BIN / "haptic-osc", "--to", "127.0.0.1:9", "--server"]), ("listen (the example)", [os.environ["HAPTICD_LISTEN"]]),
            ("haptic-relay", [BIN / "haptic-relay", "--broker", f"127.0.0.1:{port}", "--server"]),
            ("haptic-audio", [BIN / "haptic-audio", "--wait", "--no-connect", "--delay-ms", "17", "--server"])]


def start(arguments, address):
    return subprocess.Popen([*arguments, address], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL, env=jack_rig.ENVIRONMENT)


def end(process):
    process.kill()
    process.wait()


def drag(ticks):
    return [(0.0, 0.0046, -0.02 + 0.0001 * max(0, tick - 220)) for tick in range(ticks)]


def hash_of(arguments, how):
    """Chained hash of 2000 ticks; the client gets the signal in the middle of them."""
    poses = drag(2000)
    with show.daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string") as played:
        with hapticd.Session(played.address) as session, LossyProxy(played.address, loss=0, twice=0, jitter_s=0) as road:
            session.acquire("show")
            process = start(arguments, road.address) if arguments else None
            while process and road.to_clients_bytes < 1000 and process.poll() is None:
                time.sleep(0.05)
            first = session.run(poses=poses[:1000])
            if process:
                if process.poll() is not None:
                    raise RuntimeError(f"{arguments[0]} ended by itself with {process.returncode}")
                process.send_signal(how)
            second = session.run(poses=poses[1000:])
            if process:
                end(process)
            return first.state_hash, second.state_hash


def lockstep(able, failures):
    alone = hash_of(None, None)
    for name, arguments in able:
        for how in (signal.SIGSTOP, signal.SIGKILL):
            if hash_of(arguments, how) != alone:
                failures.append(f"States differ with {name} and {how.name}")
    return (f"Virtual clock, 2000 ticks of a drag over a string, the client stopped or killed after the first 1000: hashes of all States "
            f"{'DIFFER' if failures else 'are those of a run without it'} for {', '.join(name for name, _ in able)}.")


class Realtime:
    """Spans of a recorded session, each with its name."""

    def __init__(self, session, seconds):
        self.session, self.seconds, self.spans, self.rates = session, seconds, {}, {}

    def span(self, name):
        list(self.session.states(timeout=0))
        begin = list(self.session.states(1))[0].t_ns
        time.sleep(self.seconds)
        self.spans[name] = (begin, list(self.session.states(timeout=0))[-1].t_ns)

    def client(self, name, arguments, address):
        with LossyProxy(address, loss=0, twice=0, jitter_s=0) as road:
            process = start(arguments, road.address)
            time.sleep(1.0)
            before, began = (road.to_clients_bytes, road.to_server_bytes), time.monotonic()
            self.span(f"{name}: runs")
            lasted = time.monotonic() - began
            self.rates[name] = [(now - then) / lasted for now, then in zip((road.to_clients_bytes, road.to_server_bytes), before)]
            process.send_signal(signal.SIGSTOP)
            self.span(f"{name}: stopped")
            end(process)
            self.span(f"{name}: killed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=0.5)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    failures, late = [], []
    with contextlib.ExitStack() as stack:
        stack.enter_context(jack_rig.Jack(256, patient=False))
        able = clients(stack.enter_context(broker()))
        lines = [lockstep(able, failures), ""]
        path = f"{stack.enter_context(show.folder())}/session.mcap"
        with show.daemon.Daemon("--record", path) as played, hapticd.Session(played.address) as session:
            session.subscribe(divisor=20, sections=["TOOLS"])
            next(session.states(1))
            time.sleep(1.0)
            real = Realtime(session, options.seconds)
            real.span("nobody else")
            for name, arguments in able:
                real.client(name, arguments, played.address)
            session.close()
            code = played.end()
        records = show.read(path)
    lines += [f"Real clock, scene `guqin` with its demonstration, {options.seconds:g} s each. Bytes of the datagrams of one client, without headers:", "",
              "| client | from hapticd, kB/s | to hapticd, kB/s |", "|---|---|---|"]
    lines += [f"| {name} | {down / 1e3:.1f} | {up / 1e3:.1f} |" for name, (down, up) in real.rates.items()]
    lines += ["", "CPU time of the haptic thread per tick:", "", *show.TABLE]
    lines += [show.row(name, [tick.cpu_ns for tick in records.ticks if begin <= tick.t_ns < finish]) for name, (begin, finish) in real.spans.items()]
    own, held_up, explained = show.over_period([tick for tick in records.ticks if tick.cpu_ns], 1_000_000)
    lines += ["", *explained]
    if own:
        late.append(f"{len(own)} ticks took longer than the period by their own work")
    if code != 0 or any(tick.state == 6 for tick in records.ticks):
        failures.append("a fault was latched, or the daemon did not end well")
    return show.finish("Shipped clients", lines, failures, options.write, late, held_up)


if __name__ == "__main__":
    raise SystemExit(main())
