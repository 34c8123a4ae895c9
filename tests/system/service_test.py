"""hapticd as a service: what it tells systemd, the socket it is given, what it refuses to announce. systemd is this test: a datagram socket."""
import contextlib
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

import daemon
import hapticd
from held_thread import HeldThread

PATIENCE_S = 60.0
HAPTIC_WEB = os.environ.get("HAPTIC_WEB")


class Manager:
    """The receiving end of sd_notify(3)."""

    def __init__(self, folder, watchdog_s=None):
        self.path = str(pathlib.Path(folder) / "notify")
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(self.path)
        self.environment = {"NOTIFY_SOCKET": self.path}
        if watchdog_s is not None:
            self.environment["WATCHDOG_USEC"] = str(int(watchdog_s * 1e6))
        self.heard = []

    def hear(self, timeout_s):
        """The next message; None where none comes."""
        self.socket.settimeout(timeout_s)
        try:
            self.heard.append(self.socket.recv(4096).decode())
        except TimeoutError:
            return None
        return self.heard[-1]

    def hear_until(self, wanted):
        """All messages up to one that begins so."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            message = self.hear(PATIENCE_S)
            if message is not None and message.startswith(wanted):
                return message
        raise AssertionError(f"no {wanted} among {self.heard}")

    def drain(self):
        while self.hear(0.001) is not None:
            pass

    def close(self):
        self.socket.close()


class ServiceCase(unittest.TestCase):
    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        self.folder = self.stack.enter_context(tempfile.TemporaryDirectory())

    def manager(self, watchdog_s=None):
        return self.stack.enter_context(contextlib.closing(Manager(self.folder, watchdog_s)))


class Notifications(ServiceCase):
    def test_ready_is_said_once_ticks_pass_and_stopping_at_the_end(self):
        manager = self.manager()
        with daemon.Daemon("--scene", "sphere", environment=manager.environment) as played:
            manager.hear_until("READY=1")
            # What is asked for after READY is answered from a tick.
            with hapticd.Session(played.address, reconnect=False) as session:
                session.subscribe(divisor=10, sections=["TOOLS"])
                list(session.states(2))
            self.assertNotIn("STOPPING=1", manager.heard)
            self.assertEqual(played.end(signal.SIGTERM), 0, played.log)
            manager.hear_until("STOPPING=1")
        manager.drain()
        self.assertEqual(manager.heard.count("READY=1"), 1)

    def test_what_does_not_start_is_never_ready(self):
        manager = self.manager()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bad.textproto"
            path.write_text("scne: 1\n")
            done = subprocess.run([daemon.HAPTICD, "--config", str(path)], env=dict(os.environ, **manager.environment), capture_output=True,
                                  timeout=PATIENCE_S, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIsNone(manager.hear(0.001))

    def test_the_status_names_scene_rate_device_and_state(self):
        manager = self.manager()
        with daemon.Daemon("--scene", "sphere", "--rate", "500", environment=manager.environment):
            engaged = ""
            while "ENGAGED" not in engaged:
                engaged = manager.hear_until("STATUS=")
            self.assertEqual(engaged, "STATUS=plays sphere at 500 Hz, device simulated, ENGAGED")

    def test_a_reload_is_over_when_the_scene_of_the_configuration_plays(self):
        manager = self.manager()
        path = pathlib.Path(self.folder) / "my.textproto"
        path.write_text('scene: "single_string"\n')
        with daemon.Daemon("--config", str(path), environment=manager.environment) as played:
            manager.hear_until("READY=1")
            for text, scene in (('scene: "sphere"\n', "sphere"), ("scne: 1\n", "sphere")):
                path.write_text(text)
                played.process.send_signal(signal.SIGHUP)
                manager.hear_until("RELOADING=1")
                manager.hear_until("READY=1")
                with hapticd.Session(played.address, reconnect=False) as session:
                    self.assertEqual(session.scene.scene.name, scene)

    def test_the_watchdog_is_fed_while_ticks_pass_and_not_while_the_loop_stands_still(self):
        manager = self.manager(watchdog_s=0.2)
        with daemon.Daemon("--scene", "sphere", environment=manager.environment) as played:
            for _ in range(4):
                manager.hear_until("WATCHDOG=1")
            # The haptic thread alone stands still: the main thread, which feeds, goes on.
            with HeldThread(played.process.pid, "haptic"):
                # What was fed before it was held.
                manager.drain()
                manager.heard.clear()
                end = time.monotonic() + 1.0
                while time.monotonic() < end:
                    manager.hear(0.05)
                # Ticks that had passed before may still have been told: once, and not 20 times.
                self.assertLessEqual(manager.heard.count("WATCHDOG=1"), 1)
            manager.hear_until("WATCHDOG=1")

    def test_virtual_time_that_waits_for_its_client_is_alive(self):
        manager = self.manager(watchdog_s=0.2)
        with daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "sphere", environment=manager.environment):
            manager.hear_until("READY=1")
            for _ in range(4):
                manager.hear_until("WATCHDOG=1")
            self.assertIn("STATUS=plays sphere in virtual time, device scripted, ", "".join(manager.heard))


@unittest.skipUnless(HAPTIC_WEB, "there is no viewer here")
class Viewer(ServiceCase):
    def start(self, manager, *options):
        started = subprocess.Popen([HAPTIC_WEB, "--page", self.folder, *options], env=dict(os.environ, **manager.environment), text=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(started.stderr.close)
        self.addCleanup(started.kill)
        return started

    def test_the_viewer_is_ready_once_it_serves_its_page_and_says_when_it_stops(self):
        pathlib.Path(self.folder, "index.html").write_text("here", encoding="utf-8")
        port = daemon.free_port()
        manager = self.manager()
        started = self.start(manager, "--listen", f"127.0.0.1:{port}")
        manager.hear_until("READY=1")
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=PATIENCE_S) as answer:
            self.assertEqual(b"here", answer.read())
        started.terminate()
        manager.hear_until("STOPPING=1")
        self.assertEqual(0, started.wait(PATIENCE_S))
        self.assertEqual(["READY=1", "STOPPING=1"], manager.heard)

    def test_a_viewer_whose_address_is_taken_is_never_ready(self):
        pathlib.Path(self.folder, "index.html").write_text("here", encoding="utf-8")
        manager = self.manager()
        with socket.create_server(("127.0.0.1", 0)) as taken:
            started = self.start(manager, "--listen", f"127.0.0.1:{taken.getsockname()[1]}")
            self.assertEqual(1, started.wait(PATIENCE_S))
        self.assertIsNone(manager.hear(0.001))


class PassedSocket(ServiceCase):
    """As systemd does it: the socket is descriptor 3, LISTEN_PID is the daemon itself."""

    def start(self, passed, *options):
        """hapticd with these sockets as 3 and so on; its first lines."""
        sockets = [each.detach() for each in passed]

        def become():
            for place, descriptor in enumerate(sockets):
                os.dup2(descriptor, 100 + place)
            for place in range(len(sockets)):
                os.dup2(100 + place, 3 + place, inheritable=True)

        shell = f'LISTEN_PID=$$ LISTEN_FDS={len(sockets)} exec "$0" "$@"'
        process = subprocess.Popen(["sh", "-c", shell, daemon.HAPTICD, "--scene", "sphere", *options], preexec_fn=become, close_fds=False,
                                   stderr=subprocess.STDOUT, stdout=subprocess.PIPE, text=True)
        for each in sockets:
            os.close(each)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def refused(self, code, words, passed, *options):
        process = self.start(passed, *options)
        text, _ = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, code, text)
        for word in words:
            self.assertIn(word, text)

    def bound(self, family=socket.AF_INET, kind=socket.SOCK_DGRAM, address="127.0.0.1"):
        made = socket.socket(family, kind)
        made.bind((address, 0))
        return made

    def test_a_socket_bound_by_systemd_is_served(self):
        for family, host in ((socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1")):
            made = self.bound(family, address=host)
            port = made.getsockname()[1]
            # It counts, and not what --listen says.
            process = self.start([made], "--listen", "127.0.0.1:1")
            address = f"{host}:{port}" if family == socket.AF_INET else f"[{host}]:{port}"
            with hapticd.Session(address, reconnect=False) as session:
                self.assertEqual(session.scene.scene.name, "sphere")
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(PATIENCE_S), 0)

    def test_a_socket_that_cannot_serve_is_refused_with_the_remedy(self):
        remedy = "ListenDatagram=ADDR:PORT"
        self.refused(3, [remedy, "datagrams"], [self.bound(kind=socket.SOCK_STREAM)])
        self.refused(3, [remedy, "2 were passed"], [self.bound(), self.bound()])
        local, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        with other:
            self.refused(3, [remedy, "IPv4 or IPv6"], [local])
        self.refused(3, ["keygen", "--keys"], [self.bound(address="0.0.0.0")])


class Announcing(ServiceCase):
    def test_nobody_is_told_of_a_daemon_without_keys_or_on_one_address(self):
        code, text = daemon.run("--scene", "sphere", "--announce")
        self.assertEqual(code, 2, text)
        for word in ("--announce", "keygen", "--keys"):
            self.assertIn(word, text)
        keys = str(pathlib.Path(self.folder) / "keys")
        subprocess.run([os.environ["HAPTICCTL"], "keygen", keys], check=True, stdout=subprocess.DEVNULL)
        for address in ("127.0.0.1", "[::1]", "127.1.2.3"):
            code, text = daemon.run("--scene", "sphere", "--announce", "--keys", keys, "--listen", f"{address}:0")
            self.assertEqual(code, 2, text)
            for word in ("--announce", address, "--listen 0.0.0.0"):
                self.assertIn(word, text)

    def test_without_avahi_daemon_it_warns_and_serves(self):
        keys = str(pathlib.Path(self.folder) / "keys")
        subprocess.run([os.environ["HAPTICCTL"], "keygen", keys], check=True, stdout=subprocess.DEVNULL)
        nobody = {"DBUS_SYSTEM_BUS_ADDRESS": f"unix:path={self.folder}/no_bus"}
        with daemon.Daemon("--scene", "sphere", "--announce", "--keys", keys, host="0.0.0.0", environment=nobody) as played:
            while "not announced" not in played.log:
                line = played.process.stdout.readline()
                self.assertNotEqual("", line, played.log)
                played.log += line
            self.assertEqual(played.end(), 0, played.log)
        self.assertIn("avahi-daemon", played.log)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
