"""A Stop by the Stop road reaches the loop whatever the daemon's network thread does: held by a debugger, under floods of junk, behind listings
and while time waits for clients. It counts in ticks: those that the answer and the recording name. Others' Stops, forged and repeated ones do nothing;
a dead-man's heartbeat fades the force and brings it back."""
import contextlib
import json
import os
import pathlib
import secrets
import socket
import sys
import tempfile
import threading
import time
import unittest

import daemon
import hapticd
from hapticd import stop_road
from hapticd.v1 import recording_pb2, state_pb2

import held_thread

sys.path.append(str(pathlib.Path(__file__).parent.parent / "server/recorder"))
import read_recording

CTL = os.environ["HAPTICCTL"]
HANG_S = 10.0
PATIENCE_S = 30.0
READY, ENGAGED, FAULT = state_pb2.LOOP_STATE_READY, state_pb2.LOOP_STATE_ENGAGED, state_pb2.LOOP_STATE_FAULT
STOPPED, DEAD_MAN = 1, 14


def port_of(address):
    return int(address.rpartition(":")[2])


def road_port(played):
    with hapticd.Session(played.address) as session:
        return session.scene.stop_port


def road_to(played, **options):
    return stop_road.StopRoad(port=road_port(played), session_port=port_of(played.address), **options)


def ctl(played, *words):
    return daemon.said(CTL, "--server", played.address, *map(str, words))


def ticks_of(file):
    reader = read_recording.Recording()
    for _, opcode, content in read_recording.records(file.read_bytes(), 8):
        if opcode == 0x0F:
            break
        reader.take(opcode, content)
    return [recording_pb2.TickRecord.FromString(content) for channel, _, content in reader.messages
            if reader.channels[channel][0] == "/hapticd/tick"]


def until(road, wanted, patience=PATIENCE_S):
    """The first answer that is as wanted."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        answer = road.query()
        if answer and wanted(answer):
            return answer
    raise AssertionError(f"the road says {answer}")


class Flood:
    """Junk to some ports, of all lengths, among it what has the road's form and no right tag."""

    def __init__(self, *ports):
        self.ports = ports
        self.ended = threading.Event()
        self.threads = [threading.Thread(target=self.run, args=(port,), daemon=True) for port in ports for _ in range(2)]

    def run(self, port):
        form = stop_road.encode_request(stop_road.STOP, 5, 6, secrets.token_bytes(16), key=secrets.token_bytes(32))
        junk = [form] * 20 + [secrets.token_bytes(secrets.randbelow(200)) for _ in range(20)]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not self.ended.is_set():
                for each in junk:
                    with contextlib.suppress(OSError):
                        out.sendto(each, ("127.0.0.1", port))

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        for thread in self.threads:
            thread.join()


class StopRoad(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def check_recording(self, file, read_at):
        """No force from the second tick after the one that was over when the Stop was read, or the next but one, to the end; and the same bits again."""
        ticks = ticks_of(file)
        stops = [tick.tick for tick in ticks if recording_pb2.ORDER_STOP in tick.orders]
        self.assertEqual(len(stops), 1, stops)
        self.assertGreater(stops[0], read_at)
        # One may have been under way when it was read.
        self.assertLessEqual(stops[0], read_at + 2)
        forces = {tick.tick: max((abs(f) for tool in tick.outputs for f in (*tool.wrench_h_w.f_n, *tool.wrench_h_w.t_n_m)), default=0.0) for tick in ticks}
        self.assertTrue(any(force > 0 for tick, force in forces.items() if tick < stops[0]), "nothing was felt before")
        self.assertEqual([tick for tick, force in forces.items() if tick >= stops[0] and force != 0.0], [])
        code, said = daemon.run("--device", f"replay:{file}", "--clock", "virtual", "--listen", "127.0.0.1:0", "--verify", timeout=200)
        self.assertEqual(code, 0, said)
        self.assertIn("identical: every wrench to the bit", said)

    def stopped_while(self, *options, disturb):
        """A daemon of the real clock whose simulated hand plays, stopped while `disturb(played)` lasts; the file it recorded, and the tick that was
        over when the Stop was read."""
        file = self.path / "stopped.mcap"
        with daemon.Daemon("--scene", "guqin_coarse", "--record", str(file), *options, state=str(self.path)) as played:
            with road_to(played) as road:
                until(road, lambda answer: answer.loop_state == ENGAGED and answer.tick > 2500)
                with disturb(played):
                    first = road.ask(stop_road.STOP, timeout=PATIENCE_S)
                    self.assertEqual(first.code, stop_road.DONE)
                    latched = until(road, lambda answer: answer.latch != stop_road.ASKED)
                    self.assertEqual((latched.latch, latched.loop_state, latched.cause), (stop_road.LATCHED, FAULT, STOPPED))
                self.assertEqual(until(road, lambda answer: True).loop_state, FAULT)
            self.assertEqual(played.end(), 0)
        return file, first.tick

    def test_while_the_network_thread_hangs_for_ten_seconds(self):
        @contextlib.contextmanager
        def held(played):
            with road_to(played) as road, held_thread.HeldThread(played.process.pid):
                end = time.monotonic() + HANG_S
                yield
                while time.monotonic() < end:
                    answer = road.query()
                    self.assertEqual((answer.latch, answer.loop_state), (stop_road.LATCHED, FAULT))

        self.check_recording(*self.stopped_while(disturb=held))

    def test_under_a_flood_of_junk_to_both_ports(self):
        self.check_recording(*self.stopped_while(disturb=lambda played: Flood(road_port(played), port_of(played.address))))

    def test_behind_listings_of_others(self):
        @contextlib.contextmanager
        def listings(played):
            ended = threading.Event()

            def ask():
                with hapticd.Session(played.address) as session:
                    while not ended.is_set():
                        session.gestures()

            others = [threading.Thread(target=ask) for _ in range(4)]
            for other in others:
                other.start()
            yield
            ended.set()
            for other in others:
                other.join()

        self.check_recording(*self.stopped_while(disturb=listings))

    def test_hapticctl_stops_a_daemon_whose_network_thread_hangs_and_says_how(self):
        with daemon.Daemon("--scene", "single_string") as played, road_to(played) as road:
            port = road_port(played)
            with held_thread.HeldThread(played.process.pid):
                code, out, err = ctl(played, "stop", "--stop-port", port)
                self.assertEqual(code, 0, err)
                self.assertIn("stopped by the Stop road", out)
                self.assertEqual(road.query().loop_state, FAULT)
            self.assertEqual(ctl(played, "clear")[0], 0)
            self.assertIn("stopped by a session", ctl(played, "stop", "--stop-port", daemon.free_port())[1])
            self.assertEqual(until(road, lambda answer: True).loop_state, FAULT)

    def test_virtual_time_that_runs_or_waits_for_its_clients_stops(self):
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string") as played, \
                hapticd.Session(played.address) as session, road_to(played) as road:
            session.acquire("test")
            result = []
            running = threading.Thread(target=lambda: result.append(session.run(50_000_000, collect=False)))
            running.start()
            until(road, lambda answer: answer.tick > 1000)
            answer = road.stop(PATIENCE_S)
            self.assertEqual((answer.latch, answer.cause), (stop_road.LATCHED, STOPPED))
            running.join(PATIENCE_S)
            self.assertLess(result[0].steps, 50_000_000)
            # Time stands still: the next tick latches, and a Clear before the Stop does not end it.
            session.clear()
            session.run(300)
            self.assertEqual(road.stop().latch, stop_road.ASKED)
            session.run(1)
            self.assertEqual(road.query().latch, stop_road.LATCHED)

    def test_another_daemon_is_left_alone(self):
        with daemon.Daemon("--scene", "single_string") as first, daemon.Daemon("--scene", "single_string") as second, \
                road_to(first) as road, road_to(second) as other:
            until(road, lambda answer: answer.loop_state == ENGAGED)
            port = road_port(first)
            self.assertNotEqual(port, road_port(second))
            self.assertIsNone(stop_road.stop(second.address, port))
            # Not by the first one's road, but all the same.
            self.assertIn("stopped by a session", ctl(second, "stop", "--stop-port", port)[1])
            self.assertEqual(other.query().loop_state, FAULT)
            self.assertEqual(road.query().loop_state, ENGAGED)
            self.assertEqual(stop_road.stop(first.address, port).code, stop_road.DONE)
            self.assertEqual(until(road, lambda answer: answer.latch != stop_road.ASKED).loop_state, FAULT)

    def keyed(self, *options, **more):
        keys = self.path / "keys"
        if not keys.exists():
            self.assertEqual(daemon.said(CTL, "keygen", str(keys))[0], 0)
        self.key = (keys / "stop.key").read_bytes()
        self.assertEqual((keys / "stop.key").stat().st_mode & 0o777, 0o600)
        return daemon.Daemon("--scene", "single_string", "--keys", str(keys), *options, **more)

    def test_a_recorded_stop_or_heartbeat_does_nothing_when_it_is_played_again(self):
        with self.keyed("--stop-listen", "127.0.0.1:0") as played:
            control = (self.path / "keys" / "control.key").read_bytes()
            with hapticd.Session(played.address, key=control) as session:
                port = session.scene.stop_port
                session.acquire("test")
                with stop_road.StopRoad(port=port, key=self.key) as road, stop_road.StopRoad(port=port, key=self.key) as looker:
                    sent = []
                    plain = road.send
                    road.send = lambda *words: sent.append(plain(*words)) or sent[-1]
                    until(looker, lambda answer: answer.loop_state == ENGAGED)
                    self.assertEqual(road.ask(stop_road.HEARTBEAT, timeout_ms=1000).code, stop_road.DONE)
                    self.assertEqual(road.ask(stop_road.LEAVE).code, stop_road.DONE)
                    self.assertEqual(road.stop().latch, stop_road.LATCHED)
                    session.clear()
                    for _ in range(3):
                        for data in sent:
                            road._socket.send(data)
                        self.assertEqual(looker.query().latch, 0)
                        self.assertEqual(looker.query().heartbeats, 0)
                    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as elsewhere:
                        for data in sent:
                            elsewhere.sendto(data, ("127.0.0.1", port))
                    until(looker, lambda answer: answer.loop_state == ENGAGED)
                    self.assertEqual(looker.query().latch, 0)

    def test_what_the_road_brings_is_counted_by_cause_and_told_in_status_and_log(self):
        key = str(self.path / "keys/control.key")
        with self.keyed("--stop-listen", "127.0.0.1:0") as played:
            control = (self.path / "keys" / "control.key").read_bytes()
            with hapticd.Session(played.address, key=control) as session:
                port = session.scene.stop_port
            short, strange = 1 + secrets.randbelow(40), 1 + secrets.randbelow(40)
            forged = stop_road.encode_request(stop_road.STOP, 5, 6, secrets.token_bytes(16), key=secrets.token_bytes(32))
            with stop_road.StopRoad(port=port, key=self.key) as road, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
                for data in [forged[:-1]] * short + [forged] * strange:
                    out.sendto(data, ("127.0.0.1", port))
                self.assertEqual(road.stop().code, stop_road.DONE)
            counted = json.loads(daemon.said(CTL, "--server", played.address, "--key", key, "status", "--json")[1])["network"]
            self.assertEqual((counted["stop_malformed"], counted["stop_forged"], counted["stop_obeyed"]), (short, strange, 1))
            self.assertGreaterEqual(counted["stop_received"], short + strange + 1)
            self.assertEqual((counted["stop_other_daemon"], counted["stop_full"], counted["stop_heartbeat"]), (0, 0, 0))
            self.assertEqual(played.end(), 0)
        self.assertIn(f"({short} so far)", played.log)
        self.assertIn(f"stop_forged {strange} ", played.log)

    def test_a_heartbeat_that_stays_away_fades_the_force_and_brings_it_back(self):
        with self.keyed("--stop-listen", "127.0.0.1:0") as played:
            control = (self.path / "keys" / "control.key").read_bytes()
            with hapticd.Session(played.address, key=control) as session:
                port = session.scene.stop_port
                session.acquire("test")
            with stop_road.StopRoad(port=port, key=self.key) as road:
                until(road, lambda answer: answer.loop_state == ENGAGED)
                with hapticd.Heartbeat(self.key, port=port, timeout_ms=300) as hand, hapticd.Heartbeat(self.key, port=port, timeout_ms=1000):
                    self.assertEqual(road.query().heartbeats, 2)
                    until(road, lambda answer: answer.loop_state == ENGAGED)
                    hand.held.clear()
                    self.assertEqual(until(road, lambda answer: answer.loop_state == READY).cause, DEAD_MAN)
                    hand.held.set()
                    until(road, lambda answer: answer.loop_state == ENGAGED)
                self.assertEqual(until(road, lambda answer: answer.heartbeats == 0).latch, 0)
                # One that dies is missed until a Clear.
                road.ask(stop_road.HEARTBEAT, timeout_ms=50)
                until(road, lambda answer: answer.loop_state == READY)
                self.assertEqual(daemon.said(CTL, "--server", played.address, "--key", str(self.path / "keys/control.key"), "clear")[0], 0)
                until(road, lambda answer: answer.loop_state == ENGAGED)
                self.assertEqual(road.query().heartbeats, 0)

    def test_a_heartbeat_needs_the_key_even_here(self):
        with daemon.Daemon("--scene", "single_string") as played, road_to(played) as road:
            self.assertEqual(road.ask(stop_road.HEARTBEAT, timeout_ms=100).code, stop_road.KEY_NEEDED)
            self.assertEqual(road.query().heartbeats, 0)

    def test_a_port_that_is_taken_is_refused_if_it_was_named_and_another_one_told_if_not(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
            taken.bind(("127.0.0.1", 0))
            port = taken.getsockname()[1]
            code, said = daemon.run("--scene", "sphere", "--listen", "127.0.0.1:0", "--stop-listen", f"127.0.0.1:{port}")
            self.assertEqual(code, 3, said)
            self.assertIn("--stop-listen", said)
        for bad in ("nonsense", "127.0.0.1", "127.0.0.1:99999", ":47801", "::1:5", "host:5", "0.0.0.0:0", "[::]:0"):
            code, said = daemon.run("--scene", "sphere", "--listen", "127.0.0.1:0", "--stop-listen", bad)
            self.assertEqual(code, 3, said)
            self.assertIn("--stop-listen", said)
        with daemon.Daemon("--scene", "sphere") as first, daemon.Daemon("--scene", "sphere") as second:
            ports = {road_port(first), road_port(second)}
            self.assertEqual(len(ports), 2)
            # Whoever else has the default port, one of the two has not.
            self.assertIn("the Stop road has another one", first.log + second.log)
            for played in (first, second):
                self.assertIn(f"Stop road on 127.0.0.1:{road_port(played)}", played.log)
        with daemon.Daemon("--scene", "sphere", "--stop-listen", "off") as played, hapticd.Session(played.address) as session:
            self.assertFalse(session.scene.HasField("stop_port"))
            self.assertIn("--stop-listen off", played.log)
            self.assertIn("stopped by a session", ctl(played, "stop", "--stop-port", daemon.free_port())[1])

    def test_ipv6_and_every_address(self):
        with self.keyed("--stop-listen", "[::1]:0", host="[::1]") as played:
            control = (self.path / "keys" / "control.key").read_bytes()
            with hapticd.Session(played.address, key=control) as session, stop_road.StopRoad("::1", session.scene.stop_port) as road:
                self.assertEqual(until(road, lambda answer: True).latch, 0)
        with self.keyed("--stop-listen", "[::]:0", host="[::]") as played:
            control = (self.path / "keys" / "control.key").read_bytes()
            with hapticd.Session(played.address.replace("[::]", "[::1]"), key=control) as session:
                for host in ("127.0.0.1", "127.0.0.2", "::1"):
                    with stop_road.StopRoad(host, session.scene.stop_port, key=self.key) as road:
                        self.assertIsNotNone(road.query(), host)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
