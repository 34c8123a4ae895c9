"""Session against the model server of tests/protocol/conformance, over real sockets on loopback: requests, errors, streams, lockstep,
restart, silence, and the thread that keeps the lease."""
import math
import pathlib
import random
import socket
import tempfile
import threading
import time
import unittest
import unittest.mock

import support  # noqa: F401
import hapticd
from hapticd import connection, conversation
from hapticd.v1 import control_pb2
from model_server import ModelServer


def address(server):
    return f"{server.address[0]}:{server.address[1]}"


class WithServer(unittest.TestCase):
    virtual = True

    def setUp(self):
        self.server = ModelServer(self.virtual).start()
        self.addCleanup(self.server.stop)

    def session(self, **options):
        session = hapticd.Session(address(self.server), **options)
        self.addCleanup(session.close)
        return session


class Requests(WithServer):
    def test_a_new_session_knows_scene_lease_and_recorder(self):
        session = self.session()
        self.assertEqual(session.scene.scene.name, "single_string")
        self.assertEqual((session.lease.fence, session.lease.yours), (0, False))
        self.assertEqual(session.recorder.state, 1)
        self.assertNotEqual(session.boot_id, 0)
        self.assertEqual([event.kind for event in session.events(timeout=0)], ["scene_info", "lease_info", "record_info"])

    def test_a_refusal_is_an_exception_with_code_and_path(self):
        session = self.session()
        with self.assertRaises(hapticd.RequestError) as caught:
            session.set("strings[0].tension_n", 10)
        self.assertEqual(caught.exception.code, "NOT_OWNER")
        session.acquire()
        with self.assertRaises(hapticd.RequestError) as caught:
            session.set({"strings[0].tension_n": 10, "strings[7].tension_n": 10})
        self.assertEqual((caught.exception.code, caught.exception.path), ("NOT_FOUND", "strings[7].tension_n"))
        self.assertEqual(session.get("strings[0].tension_n"), 30)

    def test_parameters_are_set_and_read(self):
        session = self.session()
        session.acquire()
        session.set("strings[0].tension_n", 41.5)
        self.assertEqual(session.get("strings[0].tension_n"), 41.5)
        self.assertEqual(session.get(["strings[*].tension_n"]), {"strings[0].tension_n": 41.5})
        self.assertEqual(set(session.get()), {"strings[0].tension_n", "tools[0].coupling.kt_n_per_m"})

    def test_the_lease_goes_from_one_to_the_other(self):
        first, second = self.session(), self.session()
        self.assertTrue(first.acquire("first").yours)
        with self.assertRaises(hapticd.RequestError) as caught:
            second.acquire("second")
        self.assertEqual(caught.exception.code, "BUSY")
        first.release()
        self.assertGreater(second.acquire("second").fence, 1)
        first.ping()  # its answer comes behind the news of the lease
        self.assertFalse(first.lease.yours)

    def test_a_scene_is_loaded_by_name_and_by_text_of_any_length(self):
        session = self.session()
        session.acquire()
        self.assertEqual(session.load_scene("wall").scene.name, "wall")
        text = 'name: "mine"\n' + "#" * 20000 + '\ntools { name: "t" }'
        self.assertEqual(session.load_scene(text).scene.name, "mine")
        with self.assertRaises(hapticd.RequestError) as caught:
            session.load_scene("nowhere")
        self.assertEqual(caught.exception.code, "NOT_FOUND")
        self.assertEqual(session.load_scene("wall", check_only=True).scene.name, "mine")

    def test_of_a_file_its_text_is_sent_and_never_its_path(self):
        session = self.session()
        session.acquire()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "scene.textproto"
            path.write_text('name: "of_a_file"\ntools { name: "t" }')
            for source in (path, str(path)):
                self.assertEqual(session.load_scene("wall").scene.name, "wall")
                self.assertEqual(session.load_scene(source).scene.name, "of_a_file")
            path.write_text('name: "of_a_gesture"')
            session.play_gesture(path)
            session.play_gesture(str(path))
            for call in (session.load_scene, session.play_gesture):
                with self.assertRaises(FileNotFoundError):
                    call(path.with_name("nothing.textproto"))

    def test_names_that_are_none_are_refused_here(self):
        session = self.session()
        for call in (lambda: session.subscribe(1, ["FORCES"]), lambda: session.record("BEGIN"), lambda: session.load_scene("wall", preset="x")):
            with self.assertRaisesRegex(ValueError, "is none of"):
                call()

    def test_threads_share_a_session(self):
        session = self.session()
        failures = []

        def ask():
            try:
                for _ in range(10):
                    session.ping()
            except Exception as error:
                failures.append(error)
        threads = [threading.Thread(target=ask) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])

    def test_after_close_nothing_works_and_the_server_has_no_lease(self):
        session = self.session()
        session.acquire()
        session.close()
        session.close()
        with self.assertRaises(hapticd.SessionEnded):
            session.ping()
        self.assertFalse(self.session().lease.fence)


class Lockstep(WithServer):
    def test_steps_give_every_state_and_the_same_hash_again(self):
        session = self.session()
        session.acquire()
        hashes = []
        for _ in range(2):
            session.load_scene("single_string")
            session.subscribe(1)
            result = session.run(poses=[(0, 0.01 - 1e-5 * tick, 0) for tick in range(2500)])
            self.assertEqual((result.steps, result.next_tick, result.held_inputs), (2500, 2500, 0))
            states = result.states
            self.assertEqual([state.tick for state in states], list(range(2500)))
            self.assertEqual(list(session.states(2500, timeout=2)), states)
            hashes.append(result.state_hash)
        self.assertEqual(len(hashes[0]), 32)
        self.assertEqual(hashes[0], hashes[1])
        table = hapticd.table(states)
        for row in (0, 1000, 1500, 2499):  # the model's wall is at y = 0, 1000 N/m
            depth = max(0.0, 1e-5 * row - 0.01)
            self.assertTrue(math.isclose(table["wrench_h_w"][row][1], 1000 * depth, abs_tol=1e-6))

    def test_each_run_has_the_states_of_its_own_ticks_however_many_are_kept(self):
        draw = random.Random(20261126)
        for _ in range(support.scaled(60)):
            session = self.session(keep_states=draw.choice((1, 7, 64, 16384)))
            session.acquire()
            session.load_scene("single_string")
            tick = 0
            for _ in range(draw.randrange(2, 6)):
                divisor, steps = draw.choice((0, 1, 2, 7, 50, 1000)), draw.choice((1, 2, 63, 64, 65, 200, 777))
                if divisor or draw.random() < 0.5:
                    session.subscribe(divisor)
                else:
                    divisor = session._connection.divisor
                for state in session.states(draw.randrange(3), timeout=0):
                    self.assertLess(state.tick, tick)
                result = session.run(steps)
                expected = [each for each in range(tick, tick + steps) if divisor and each % divisor == 0]
                self.assertEqual([state.tick for state in result.states], expected)
                tick += steps
                self.assertEqual(result.next_tick, tick)
                if divisor:
                    self.assertEqual(list(session.states(len(expected), timeout=0)), result.states)
            self.assertEqual(session.states_dropped, 0)
            session.close()

    def test_a_run_whose_states_do_not_all_arrive_says_which_and_gives_the_rest(self):
        session = self.session()
        session.acquire()
        session.subscribe(2)
        keep = session._connection._keep
        draw = random.Random(5)
        for lost in ({0}, {98}, {4, 6, 50}, set(draw.sample(range(0, 100, 2), 20)), set(range(0, 100, 2))):
            session.load_scene("single_string")
            with unittest.mock.patch.object(session._connection, "_keep", lambda state: state.tick in lost or keep(state)):
                with self.assertRaisesRegex(hapticd.StatesLost, f"^{len(lost)} of 50 States") as caught:
                    session.run(100)
            self.assertEqual(caught.exception.missing, sorted(lost))
            self.assertEqual([state.tick for state in caught.exception.result.states], [each for each in range(0, 100, 2) if each not in lost])
            self.assertEqual((caught.exception.result.steps, caught.exception.result.next_tick), (100, 100))
            self.assertEqual([state.tick for state in session.run(10).states], [100, 102, 104, 106, 108])

    def test_a_run_that_would_collect_too_much_is_refused_before_it_begins(self):
        session = self.session()
        session.acquire()
        session.subscribe(1)
        with self.assertRaisesRegex(ValueError, "run in pieces"):
            session.run(10**9)
        self.assertEqual(session.run(3).next_tick, 3)
        result = session.run(50, collect=False)
        self.assertEqual(result.states, [])
        self.assertEqual([state.tick for state in session.states(53, timeout=1)], list(range(53)))

    def test_states_can_be_read_by_another_thread_while_a_run_is_under_way(self):
        session = self.session()
        session.acquire()
        session.subscribe(1)
        seen = []

        def read():
            for state in session.states(timeout=2):
                seen.append(state.tick)
                if len(seen) == 100:
                    session.halt()
                    return
        reader = threading.Thread(target=read)
        reader.start()
        result = session.run(10**6)
        reader.join()
        self.assertEqual(seen, list(range(100)))
        self.assertEqual([state.tick for state in result.states], list(range(result.steps)))
        self.assertLess(result.steps, 10**6)

    def test_ticks_without_poses_hold_the_last(self):
        session = self.session()
        session.acquire()
        self.assertEqual(session.run(100, poses=[(0, 0.5, 0)] * 10).held_inputs, 90)

    def test_a_refused_pose_is_raised_by_the_next_request(self):
        session = self.session()
        session.poses([(0, 0, 0)])
        with self.assertRaises(hapticd.RequestError) as caught:
            session.ping()
        self.assertEqual(caught.exception.code, "NOT_OWNER")
        session.ping()

    def test_a_run_whose_poses_are_refused_does_not_run(self):
        session = self.session()
        session.acquire()
        session.poses([(0, 0.5, 0)] * 4090)
        for collect in (True, False):  # the queue holds 4096
            with self.assertRaises(hapticd.RequestError):
                session.run(poses=[(0, 0.5, 0)] * 28, collect=collect)
        self.assertEqual(session.run(1).next_tick, 1)

    def test_a_run_is_halted_from_another_thread(self):
        session = self.session()
        session.acquire()
        threading.Timer(0.2, session.halt).start()
        result = session.run(10**9)
        self.assertLess(result.steps, 10**9)
        self.assertGreater(result.steps, 0)


class RealTime(WithServer):
    virtual = False

    def test_states_stream_and_the_lease_holds_while_the_user_computes(self):
        session = self.session()
        session.acquire()
        session.subscribe(10, ["TOOLS"])
        end = time.monotonic() + 2.3
        while time.monotonic() < end:
            sum(range(10000))
        self.assertTrue(session.lease.yours)
        ticks = [state.tick for state in session.states(20, timeout=1)]
        self.assertEqual([tick % 10 for tick in ticks], [0] * 20)
        self.assertEqual(ticks, sorted(set(ticks)))
        estimate = session.clock()
        self.assertLessEqual(abs(estimate.offset_ns), estimate.error_ns + 1)  # one machine, one clock

    def test_a_refused_run_leaves_the_unread_states(self):
        session = self.session()
        session.acquire()
        session.subscribe(10)
        first = next(session.states(timeout=2)).tick
        with session._connection.changed:
            self.assertTrue(session._connection.wait(lambda: session._connection.states, 2))
        with self.assertRaises(hapticd.RequestError):
            session.run(10)
        self.assertEqual(next(session.states(timeout=2)).tick, first + 10)

    def test_a_restarted_server_is_joined_anew(self):
        session = self.session()
        session.subscribe(10)
        next(session.states(timeout=2))
        boot_id, port = session.boot_id, self.server.address[1]
        self.server.stop()
        self.server = ModelServer(False, port).start()
        self.addCleanup(self.server.stop)
        with session._connection.changed:
            self.assertTrue(session._connection.wait(lambda: session.boot_id not in (0, boot_id), 2, survives=True))
        session.ping()
        self.assertEqual(session.epoch, 2)
        self.assertTrue(list(session.states(5, timeout=2)))

    def test_without_reconnect_a_restart_is_an_error(self):
        session = self.session(reconnect=False)
        port = self.server.address[1]
        self.server.stop()
        self.server = ModelServer(False, port).start()
        self.addCleanup(self.server.stop)
        with self.assertRaises(hapticd.SessionLost):
            for _ in range(100):
                session.ping()
                time.sleep(0.02)


class Refusals(WithServer):
    def test_the_33rd_session_is_refused(self):
        for _ in range(32):
            self.session().stop()  # who only looks may have to give way
        with self.assertRaises(hapticd.ServerFull):
            self.session()

    def test_a_session_keeps_one_state_at_least(self):
        for keep in (0, -1):
            for kind in (hapticd.Session, hapticd.AsyncSession):
                with self.assertRaisesRegex(ValueError, f"keep_states is {keep}"):
                    kind(address(self.server), keep_states=keep)

    def test_an_address_that_is_none_is_refused_at_once(self):
        for kind in (hapticd.Session, hapticd.AsyncSession):
            for bad in ("127.0.0.1:99999", "127.0.0.1:0", "x:y", "x:", "[::1]:-1", "x:\u0661"):
                with self.assertRaisesRegex(ValueError, "is not HOST:PORT"):
                    kind(bad)

    def test_nobody_there_is_an_error_after_a_while(self):
        with unittest.mock.patch.object(conversation, "SILENCE_NS", 200_000_000), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as mute:
            mute.bind(("127.0.0.1", 0))
            with self.assertRaises(hapticd.ServerSilent):
                hapticd.Session(f"127.0.0.1:{mute.getsockname()[1]}")

    def test_after_a_long_silence_the_session_begins_anew(self):
        session = self.session()
        with unittest.mock.patch.object(conversation, "ANEW_NS", 300_000_000):
            self.server.remotes.clear()  # and no Reset either: the client must not wait for one
            with unittest.mock.patch.object(self.server, "reset", lambda *_: None):
                end = time.monotonic() + 5
                while session.epoch < 2 and time.monotonic() < end:
                    time.sleep(0.01)
        self.assertEqual(session.epoch, 2)
        session.ping()

    def test_the_servers_bye_ends_streams_and_requests(self):
        session = self.session()
        for remote in list(self.server.remotes.values()):
            self.server.end(remote, control_pb2.BYE_REASON_SHUTDOWN, "the daemon ends")
        self.assertEqual(list(session.states(timeout=2)), [])
        with self.assertRaisesRegex(hapticd.SessionEnded, "SHUTDOWN: the daemon ends"):
            session.ping()

    def test_addresses_are_read_as_people_write_them(self):
        for text, port in (("127.0.0.1:5", 5), ("127.0.0.1", 47800), ("localhost:7", 7), (":9", 9)):
            with connection.open_socket(text) as found:
                self.assertEqual(found.getpeername()[1], port, text)


if __name__ == "__main__":
    unittest.main()
