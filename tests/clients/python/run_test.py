"""A run without a server: its steps are answered by hand, so that what came at which moment is exact."""
import unittest

import support  # noqa: F401
import hapticd
from hapticd import requests
from hapticd.conversation import Conversation, Peer
from hapticd.run import run
from hapticd.v1 import answer_pb2, control_pb2, event_pb2, state_pb2

TICK_NS = 333_333  # of 3000 Hz: periods are whole ns


def conversation(rate_hz=3000.0):
    made = Conversation(Peer(""))
    made.info["scene_info"] = answer_pb2.SceneInfo(scene_id=7, rate_hz=rate_hz)
    return made


class ByHand(unittest.TestCase):
    def carry_out(self, work, talk, answers, sent=None, ping=lambda: None):
        """The Items that were sent, and the result; `answers` gives a Result, or raises, for each that is asked, and `ping` raises what was
        refused before."""
        sent, answer, error = [] if sent is None else sent, None, None
        while True:
            try:
                step = work.send(answer) if error is None else work.throw(error)
            except StopIteration as done:
                return sent, done.value
            answer, error = None, None
            if isinstance(step, requests.Look):
                answer = step.action(talk)
            elif isinstance(step, requests.Until):
                answer = step.holds(talk)
            else:
                sent.append(step.item)
                if isinstance(step, requests.Ask):
                    try:
                        answer = ping() if step.item.HasField("ping") else answers(step.item)
                    except BaseException as raised:
                        error = raised

    def test_events_of_ticks_before_the_run_are_not_its_own(self):
        talk = conversation()
        instants = [999_999 * TICK_NS, 999_999 * TICK_NS + 1, 10**6 * TICK_NS, (10**6 + 9) * TICK_NS]

        def answers(item):
            talk.collected.events.extend(hapticd.Event("tone", event_pb2.Tone(t_ns=t_ns)) for t_ns in instants)
            talk.collected.events.append(hapticd.Event("lease_info", answer_pb2.LeaseInfo()))
            return answer_pb2.Result(run=dict(steps=item.run.steps, next_tick=10**6 + item.run.steps))
        _, result = self.carry_out(run(10, None, 0, True), talk, answers)
        self.assertEqual([event.body.t_ns for event in result.events], instants[1:])

    def test_a_long_path_goes_in_pieces_and_ends_where_a_fault_ends_it(self):
        talk = conversation()
        done = []

        def answers(item):
            done.append(min(item.run.steps, 1000) if done else item.run.steps)
            return answer_pb2.Result(run=dict(steps=done[-1], next_tick=sum(done), held_inputs=1))
        sent, result = self.carry_out(run(None, [(0, 0, row) for row in range(9000)], 3, True), talk, answers)
        rows = [sample for item in sent for sample in item.pose_batch.poses]
        self.assertEqual([sample.pose_dh.p_m[2] for sample in rows], list(range(len(rows))))
        self.assertEqual({sample.tool_id for sample in rows}, {3})
        self.assertEqual((result.steps, result.next_tick, result.held_inputs), (3048, 3048, 2))
        self.assertLessEqual(len(rows), 4096)

    def test_nothing_is_sent_of_a_path_with_a_row_that_is_no_pose(self):
        for bad, error in (((0, 0), ValueError), ((0, 0, "up"), ValueError), ((0, 0, None), TypeError), (5, TypeError)):
            sent = []
            with self.assertRaises(error):
                self.carry_out(run(None, [(0, 0, 0)] * 5000 + [bad], 0, True), conversation(), sent.append)
            self.assertEqual(sent, [])
        for steps in ("many", 1.5, float("nan")):
            with self.assertRaises(TypeError):
                self.carry_out(run(steps, None, 0, True), conversation(), self.fail)

    def test_nothing_is_sent_of_a_run_of_too_few_or_too_many_steps(self):
        for steps in (0, -3, 10**9 + 1, 2 * 10**9, 10**12):
            for collect in (True, False):
                sent = []
                with self.assertRaisesRegex(ValueError, f"1 to 1000000000 steps, not {steps}"):
                    self.carry_out(run(steps, [(0, 0, 0)] * 100, 0, collect), conversation(), self.fail, sent)
                self.assertEqual(sent, [])
        with self.assertRaises(ValueError):
            self.carry_out(run(None, [], 0, True), conversation(), self.fail)

    def test_no_tick_runs_without_a_pose_that_was_refused(self):
        for piece in range(3):
            pings, sent = [], []

            def ping():
                pings.append(len(sent))
                if len(pings) > piece:
                    raise hapticd.RequestError(answer_pb2.Result(code=answer_pb2.RESULT_CODE_NOT_FOUND))

            def answers(item):
                return answer_pb2.Result(run=dict(steps=item.run.steps, next_tick=10**6))
            with self.assertRaises(hapticd.RequestError):
                self.carry_out(run(None, [(0, 0, 0)] * 5000, 9, True), conversation(), answers, sent, ping)
            self.assertEqual([item.run.steps for item in sent if item.HasField("run")], [2048] * piece)

    def test_an_answer_that_cannot_be_is_none(self):
        for steps, next_tick in ((11, 100), (10**12, 10**12), (2**64 - 1, 2**64 - 1), (10, 9), (1, 0)):
            talk = conversation()
            talk.subscription = requests.stream_pb2.Item(subscribe=dict(divisor=1))
            with self.assertRaisesRegex(hapticd.ProtocolError, f"of 10 steps {steps} were run, up to tick {next_tick}"):
                self.carry_out(run(10, None, 0, True), talk, lambda _: answer_pb2.Result(run=dict(steps=steps, next_tick=next_tick)))

    def test_states_of_another_scene_or_tick_are_not_its_own(self):
        talk = conversation()
        talk.subscription = requests.stream_pb2.Item(subscribe=dict(divisor=2))
        talk.states.append(state_pb2.State(scene_id=7, tick=98))

        def answers(item):
            self.assertEqual(len(talk.states), 0)
            talk.collected.states.extend(state_pb2.State(scene_id=scene, tick=tick) for scene, tick in ((7, 98), (7, 100), (6, 100), (7, 102), (7, 104)))
            return answer_pb2.Result(run=dict(steps=item.run.steps, next_tick=104))
        _, result = self.carry_out(run(4, None, 0, True), talk, answers)
        self.assertEqual([(state.scene_id, state.tick) for state in result.states], [(7, 100), (7, 102)])

    def test_an_interruption_and_silence_stop_time_even_if_that_fails(self):
        for error in (KeyboardInterrupt(), hapticd.ServerSilent()):
            work = run(10, None, 0, True)
            step = next(work)
            while not (isinstance(step, requests.Ask) and step.item.HasField("run")):
                step = work.send(step.action(conversation()) if isinstance(step, requests.Look) else None)
            stop = work.throw(error)
            self.assertEqual((stop.item.run.mode, stop.at_once), (control_pb2.RUN_MODE_STOP, True))
            with self.assertRaises(type(error)):
                work.throw(hapticd.SessionEnded())


if __name__ == "__main__":
    unittest.main()
