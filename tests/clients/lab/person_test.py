"""A person's side of the experiment without a daemon: screens and answers as lines, as haptic-web hands them on, and what does not count."""
import contextlib
import io
import json
import os
import sys
import types
import unittest

from hapticd.v1 import state_pb2
from hapticd_lab.page_screen import PageScreen
from hapticd_lab.participant import LostControl, Person
from hapticd_lab.terminal_screen import Interrupted


class Page:
    """The other end of the lines."""

    def __init__(self, test):
        test.addCleanup(self.close)
        self._from, out = os.pipe()
        into, self._to = os.pipe()
        before = sys.stdout
        self.screen = PageScreen("P1", into, out)
        sys.stdout = before
        self._lines = os.fdopen(self._from, encoding="utf-8")

    def shown(self):
        return json.loads(self._lines.readline())

    def say(self, **answer):
        self.say_line(json.dumps(answer))

    def say_line(self, line):
        os.write(self._to, (line + "\n").encode())

    def close(self):
        """Hears no more."""
        self._lines.close()

    def go(self):
        os.close(self._to)


class Screens(unittest.TestCase):
    def test_the_alphabet_of_a_comparison_is_first_second_equal_and_again(self):
        page = Page(self)
        for number, (reply, meant) in enumerate((("FIRST", "first"), ("SECOND", "second"), ("EQUAL", "equal"), ("AGAIN", "")), 1):
            page.say(number=number, reply=f"EXPERIMENT_REPLY_{reply}")
            self.assertEqual(page.screen.choose(1), meant)
            self.assertEqual(page.shown()["stage"], "EXPERIMENT_STAGE_COMPARE")

    def test_an_answer_counts_for_the_screen_that_it_names(self):
        page = Page(self)
        page.say(number=2, reply="EXPERIMENT_REPLY_FIRST")  # too early
        page.say(number=1, reply="EXPERIMENT_REPLY_SECOND")
        page.say(number=1, reply="EXPERIMENT_REPLY_EQUAL")  # pressed twice
        page.say(number=2, reply="EXPERIMENT_REPLY_EQUAL")
        self.assertEqual([page.screen.choose(1), page.screen.choose(2)], ["second", "equal"])

    def test_what_is_no_answer_to_the_question_is_passed_over(self):
        page = Page(self)
        for line in ("", "{", "[]", '{"number": 1, "reply": "NONE"}', '{"number": 1, "reply": "EXPERIMENT_REPLY_FIRST"}',
                     '{"number": 1, "reply": "EXPERIMENT_REPLY_SCORE", "score": 101}', '{"number": 1, "reply": "EXPERIMENT_REPLY_SCORE", "score": 85}'):
            page.say_line(line)
        with contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(page.screen.rate("String smoothness", "not rough"), 85)

    def test_a_page_that_goes_interrupts(self):
        page = Page(self)
        page.go()
        with self.assertRaises(Interrupted):
            page.screen.familiarise("wall")
        self.assertEqual(page.shown()["stage"], "EXPERIMENT_STAGE_FAMILIARISE")
        with contextlib.redirect_stderr(io.StringIO()):
            page.screen.stopped("interrupted")
            self.assertEqual(page.shown()["stage"], "EXPERIMENT_STAGE_STOPPED")
            page.close()
            page.screen.stopped("interrupted")  # nobody need hear of it
        with self.assertRaises(Interrupted):
            page.screen.familiarise("wall")

    def test_control_that_is_lost_while_a_person_feels_is_told_at_once(self):
        page = Page(self)

        def check():
            raise LostControl("control was lost")

        page.screen.watch(check)
        with self.assertRaisesRegex(LostControl, "control was lost"):
            page.screen.touch(1, "A")  # and no answer ever comes

    def test_a_device_without_force_is_said_with_the_next_screen_and_once(self):
        page = Page(self)
        page.screen.no_force("WRONG_STATE")
        page.say(number=1, reply="EXPERIMENT_REPLY_ENGAGE")
        page.say(number=2, reply="EXPERIMENT_REPLY_NEXT")
        self.assertEqual([page.screen.touch(1, "A"), page.screen.touch(1, "A")], [False, True])
        self.assertIn("does not engage (WRONG_STATE)", page.shown()["notice"])
        self.assertNotIn("notice", page.shown())

    def test_no_screen_of_a_trial_tells_what_is_raised(self):
        page = Page(self)
        for number in (1, 2):
            page.say(number=number, reply="EXPERIMENT_REPLY_NEXT")
        page.screen.touch(1, "A")
        page.screen.touch(1, "B")
        first, second = page.shown(), page.shown()
        self.assertEqual({name for name in first if first[name] != second[name]}, {"number", "object"})


class Session:
    """Of a daemon, as far as control goes."""

    def __init__(self, **lease):
        self.lease, self.epoch, self.latest, self.done = types.SimpleNamespace(**{"yours": True, "fence": 1, "holder": "", **lease}), 1, None, []
        self.over = None

    def ping(self):
        if self.over is not None:
            raise self.over

    def clear(self):
        self.latest = state_pb2.State(loop_state=state_pb2.LOOP_STATE_READY)
        self.done.append("clear")

    def engage(self):
        self.done.append("engage")


def person(session):
    one = Person("", "", types.SimpleNamespace(no_force=lambda why: None))
    one._session, one._epoch = session, 1  # as its __enter__ leaves it
    return one


class Control(unittest.TestCase):
    def test_control_is_kept_while_the_lease_is_ours_and_the_session_is_the_same(self):
        person(Session())._check_control()
        with self.assertRaisesRegex(LostControl, "web page took control"):
            person(Session(yours=False, holder="web page"))._check_control()
        with self.assertRaisesRegex(LostControl, "control was lost"):
            person(Session(yours=False, fence=0))._check_control()
        session = Session()
        session.epoch = 2
        with self.assertRaisesRegex(LostControl, "connection"):
            person(session)._check_control()
        session.over = ConnectionError("SHUTDOWN")
        with self.assertRaises(ConnectionError):
            person(session)._check_control()

    def test_a_string_that_a_fault_cut_off_does_not_count_until_the_person_has_the_fault_cleared(self):
        session = Session()
        session.latest = state_pb2.State(loop_state=state_pb2.LOOP_STATE_FAULT)
        session.subscribe = lambda *_: session.done.append("subscribe")
        session.events = session.states = lambda timeout: []
        session.scene = None
        answers = iter((True, True, False, True))
        one = person(session)
        one._screen.no_force = session.done.append
        with self.assertRaises(AttributeError):  # there is no scene to build a trace of, which comes last
            one._touch(lambda: next(answers))
        self.assertEqual(session.done, ["engage", "subscribe", *["a fault is latched"] * 2, "clear", "engage", "subscribe"])


if __name__ == "__main__":
    unittest.main()
