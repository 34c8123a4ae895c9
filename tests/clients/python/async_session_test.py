"""AsyncSession against the model server of tests/protocol/conformance, over real sockets on loopback: the same answers as Session, several
tasks and sessions in one loop, cancelled tasks, a server that is restarted in the middle, and loops that end."""
import asyncio
import contextlib
import inspect
import threading
import time
import unittest
import unittest.mock
import warnings

import support  # noqa: F401
import hapticd
from hapticd import conversation
from hapticd.v1 import control_pb2
from model_server import ModelServer

LIMIT_S = 30


def address(server):
    return f"{server.address[0]}:{server.address[1]}"


class WithServer(unittest.IsolatedAsyncioTestCase):
    virtual = True

    def setUp(self):
        self.server = ModelServer(self.virtual).start()
        self.addCleanup(self.server.stop)

    async def session(self, **options):
        session = await hapticd.AsyncSession(address(self.server), **options).open()
        self.addAsyncCleanup(session.close)
        return session


class Methods(unittest.TestCase):
    def test_both_kinds_of_session_have_the_same_methods_with_the_same_arguments(self):
        def public(kind):
            return {name: each for name, each in inspect.getmembers(kind) if not name.startswith("_") and name not in ("open", "close")}

        blocking, awaited = public(hapticd.Session), public(hapticd.AsyncSession)
        self.assertEqual(set(blocking), set(awaited))
        self.assertGreater(len(blocking), 25)
        for name, method in blocking.items():
            if callable(method):
                self.assertEqual(inspect.signature(method).parameters, inspect.signature(awaited[name]).parameters, name)
                self.assertEqual(inspect.iscoroutinefunction(awaited[name]), name not in ("states", "events", "clock"), name)
        self.assertEqual(inspect.signature(hapticd.Session).parameters, inspect.signature(hapticd.AsyncSession).parameters)


class Requests(WithServer):
    async def test_a_session_asks_and_is_refused_as_the_blocking_one(self):
        async with hapticd.AsyncSession(address(self.server)) as session:
            self.assertEqual(session.scene.scene.name, "single_string")
            self.assertFalse(session.lease.yours)
            with self.assertRaises(hapticd.RequestError) as caught:
                await session.set("strings[0].tension_n", 10)
            self.assertEqual(caught.exception.code, "NOT_OWNER")
            self.assertTrue((await session.acquire("async")).yours)
            await session.set({"strings[0].tension_n": 41.5})
            self.assertEqual(await session.get("strings[0].tension_n"), 41.5)
            self.assertEqual((await session.load_scene("wall")).scene.name, "wall")
            self.assertEqual([event.kind async for event in session.events(timeout=0)][:3], ["scene_info", "lease_info", "record_info"])
            self.assertNotEqual(session.boot_id, 0)
            self.assertIsNotNone(session.clock())
        with hapticd.Session(address(self.server)) as after:
            self.assertFalse(after.lease.fence)
        with self.assertRaises(hapticd.SessionEnded):
            await session.ping()

    async def test_tasks_share_a_session_and_a_loop_has_several(self):
        first, second = await self.session(), await self.session()
        await first.acquire("first")
        answers = await asyncio.gather(*(each.get("strings[0].tension_n") for each in [first, second] * 40))
        self.assertEqual(answers, [30] * 80)
        with self.assertRaises(hapticd.RequestError) as caught:
            await second.acquire("second")
        self.assertEqual(caught.exception.code, "BUSY")
        await first.release()
        self.assertTrue((await second.acquire("second")).yours)

    async def test_what_makes_no_sense_is_refused_here_and_the_session_goes_on(self):
        session = await self.session()
        await session.acquire()
        for call in (lambda: session.poses([(1, 2)]), lambda: session.run(poses=[(None, 0, 0)]), lambda: session.set("x", None),
                     lambda: session.run(-1), lambda: session.record("BEGIN"), lambda: session.subscribe(1, ["FORCES"]),
                     lambda: session.load_scene("{" + "#" * 5_000_000)):
            with self.assertRaises((ValueError, TypeError)):
                await asyncio.wait_for(call(), LIMIT_S)
        await session.ping()

    async def test_a_session_is_opened_first_and_once(self):
        session = hapticd.AsyncSession(address(self.server))
        with self.assertRaisesRegex(RuntimeError, "not open"):
            await session.ping()
        await session.close()
        async with session:
            with self.assertRaisesRegex(RuntimeError, "opened before"):
                await session.open()

    async def test_nobody_there_is_an_error_after_a_while(self):
        with unittest.mock.patch.object(conversation, "SILENCE_NS", 200_000_000):
            with self.assertRaises(hapticd.ServerSilent):
                await hapticd.AsyncSession("127.0.0.1:9").open()

    async def test_the_servers_bye_ends_streams_and_requests(self):
        session = await self.session()
        for remote in list(self.server.remotes.values()):
            self.server.end(remote, control_pb2.BYE_REASON_SHUTDOWN, "the daemon ends")
        self.assertEqual([state async for state in session.states(timeout=2)], [])
        with self.assertRaisesRegex(hapticd.SessionEnded, "SHUTDOWN: the daemon ends"):
            await session.ping()


class Lockstep(WithServer):
    async def test_steps_give_what_the_blocking_session_gets(self):
        path = [(0, 0.01 - 1e-5 * tick, 0) for tick in range(2500)]
        session = await self.session()
        await session.acquire()
        await session.load_scene("single_string")
        await session.subscribe(1)
        result = await session.run(poses=path)
        self.assertEqual([state.tick for state in result.states], list(range(2500)))
        self.assertEqual([state async for state in session.states(2500, timeout=2)], result.states)
        await session.close()
        with hapticd.Session(address(self.server)) as blocking:
            blocking.acquire()
            blocking.load_scene("single_string")
            blocking.subscribe(1)
            self.assertEqual(blocking.run(poses=path).state_hash, result.state_hash)

    async def test_states_are_read_by_another_task_while_a_run_is_under_way(self):
        session = await self.session()
        await session.acquire()
        await session.subscribe(1)

        async def read():
            seen = []
            async for state in session.states(timeout=5):
                seen.append(state.tick)
                if len(seen) == 100:
                    await session.halt()
                    return seen
        seen, result = await asyncio.gather(read(), session.run(10**6))
        self.assertEqual(seen, list(range(100)))
        self.assertEqual([state.tick for state in result.states], list(range(result.steps)))
        self.assertLess(result.steps, 10**6)

    async def test_runs_of_several_tasks_go_one_after_the_other(self):
        session = await self.session()
        await session.acquire()
        await session.subscribe(1)
        results = await asyncio.gather(*(session.run(poses=[(0, 0.5, 0)] * 70) for _ in range(5)))
        self.assertEqual([[state.tick for state in result.states] for result in results], [list(range(70 * k, 70 * k + 70)) for k in range(5)])

    async def test_a_cancelled_run_stops_time_and_the_next_one_runs(self):
        session = await self.session()
        await session.acquire()
        await session.subscribe(1)
        for _ in range(3):
            running = asyncio.create_task(session.run(10**6))
            async for _ in session.states(20, timeout=5):
                pass
            running.cancel()
            with self.assertRaises(asyncio.CancelledError):
                await running
            result = await asyncio.wait_for(session.run(10), LIMIT_S)  # which would wait for a million steps
            self.assertEqual(len(result.states), 10)
            self.assertEqual([state.tick for state in result.states], list(range(result.next_tick - 10, result.next_tick)))

    async def test_cancelling_at_any_moment_leaves_a_session_that_works(self):
        session = await self.session()
        await session.acquire()
        await session.subscribe(1)
        for count in range(support.scaled(200)):
            running = asyncio.create_task(session.run(poses=[(0, 0.5, 0)] * 3000))
            for _ in range(count):
                await asyncio.sleep(0)
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
        with contextlib.suppress(hapticd.RequestError):  # of poses that found the queue full
            await session.ping()
        await session.load_scene("single_string")  # drops what poses are still queued
        self.assertEqual((await asyncio.wait_for(session.run(5), LIMIT_S)).next_tick, 5)


class Restart(WithServer):
    virtual = False

    def restart(self):
        port = self.server.address[1]
        self.server.stop()
        self.server = ModelServer(self.virtual, port).start()
        self.addCleanup(self.server.stop)

    async def test_streams_go_on_with_the_server_that_was_restarted(self):
        session = await self.session()
        await session.subscribe(10)
        boots = set()
        async for _ in session.states(timeout=5):
            boots.add(session.boot_id)
            if len(boots) == 1 and session.epoch == 1:
                await asyncio.to_thread(self.restart)
            if session.epoch == 2 and session.boot_id:
                break
        boots.add(session.boot_id)
        self.assertEqual((session.epoch, len(boots)), (2, 2))
        await session.ping()

    async def test_a_request_under_way_is_lost_with_its_server(self):
        session = await self.session()
        with unittest.mock.patch.object(self.server, "run_time", lambda: None), unittest.mock.patch.object(self.server, "receive", lambda *_: None):
            asking = asyncio.create_task(session.ping())
            await asyncio.sleep(0)
            await asyncio.to_thread(self.restart)
        with self.assertRaises(hapticd.SessionLost):
            await asking

    async def test_without_reconnect_a_restart_ends_the_session(self):
        session = await self.session(reconnect=False)
        await asyncio.to_thread(self.restart)
        with self.assertRaises(hapticd.SessionLost):
            await asyncio.wait_for(session.ping(), LIMIT_S)


class Loops(unittest.TestCase):
    def setUp(self):
        self.server = ModelServer(True).start()
        self.addCleanup(self.server.stop)

    def test_a_session_of_a_loop_that_has_ended_says_so(self):
        async def opened():
            return await hapticd.AsyncSession(address(self.server)).open()

        async def asked(session, call):
            with self.assertRaisesRegex(RuntimeError, "another event loop"):
                await call(session)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # it was not closed
            self.ask_elsewhere(asyncio.run(opened()), asked)

    def ask_elsewhere(self, session, asked):
        for call in (hapticd.AsyncSession.ping, hapticd.AsyncSession.close, lambda each: each.run(1)):
            asyncio.run(asked(session, call))

    def test_interrupting_a_blocking_run_stops_time(self):
        with hapticd.Session(address(self.server)) as session:
            session.acquire()
            result, asked = session._connection.result, []

            def interrupted(item_id):
                asked.append(item_id)
                if len(asked) == 1:  # the ping before the run
                    return result(item_id)
                end = time.monotonic() + LIMIT_S
                while not self.server.running and time.monotonic() < end:
                    time.sleep(0.001)
                with unittest.mock.patch.object(session._connection.changed, "wait", side_effect=KeyboardInterrupt):
                    result(item_id)
            with unittest.mock.patch.object(session._connection, "result", interrupted), self.assertRaises(KeyboardInterrupt):
                session.run(10**9)
            pinged = threading.Thread(target=session.ping, daemon=True)
            pinged.start()
            pinged.join(LIMIT_S)
            self.assertFalse(pinged.is_alive(), "the run goes on")
            self.assertEqual(session.run(1).steps, 1)


if __name__ == "__main__":
    unittest.main()
