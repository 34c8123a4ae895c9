"""The conformance checker itself: it finds nothing wrong with the model server under either clock, and finds every fault that is put into
the model on purpose. The checks are run side by side, since they mostly wait."""
import os
import subprocess
import sys
import unittest
from unittest import mock

import check_server
import model_requests
import model_server
import model_world
from registry import CHECKS, Server
from schema import answer, control

HERE = os.path.dirname(os.path.abspath(__file__))
PARTS = 8


def outcome(check_name, virtual=True):
    """(outcome, text) of one check against a model in this process."""
    server = model_server.ModelServer(virtual).start()
    try:
        return check_server.run_check(Server(server.address), next(each for each in CHECKS if each.name == check_name))
    finally:
        server.stop()


class ModelIsSound(unittest.TestCase):
    def test_all_quick_checks_pass_under_both_clocks(self):
        running = []
        for clock in ("--virtual", "--realtime"):
            for part in range(1, PARTS + 1):
                model = subprocess.Popen([sys.executable, "-B", f"{HERE}/model_server.py", "127.0.0.1:0", clock], stdout=subprocess.PIPE, text=True)
                self.addCleanup(model.stdout.close)
                self.addCleanup(model.wait)
                self.addCleanup(model.kill)
                address = model.stdout.readline().split()[-1]
                command = [sys.executable, "-B", f"{HERE}/check_server.py", address, "--quick", "--part", f"{part}/{PARTS}"]
                running.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True))
        passed = 0
        for checker in running:
            text = checker.communicate()[0]
            self.assertEqual(checker.returncode, 0, text)
            passed += int(text.splitlines()[-1].split()[0])
        self.assertGreater(passed, 100)

    def test_every_check_has_a_rule_and_a_section(self):
        for each in CHECKS:
            self.assertTrue(each.sentence.endswith("."), each.name)
            self.assertIn(each.section, range(2, 13))
        self.assertEqual(len({each.name for each in CHECKS}), len(CHECKS))


def refuses_nothing(*_):
    return answer.RESULT_CODE_OK, {}


class FaultsAreFound(unittest.TestCase):
    def expect_found(self, check_name, patches, virtual=True):
        for owner, name, made in patches:
            patch = mock.patch.object(owner, name, made)
            patch.start()
            self.addCleanup(patch.stop)
        found, text = outcome(check_name, virtual)
        self.assertEqual(found, "FAILED", f"{check_name} did not find the fault")
        self.assertTrue(text)

    def test_counters_that_are_taken_twice(self):
        self.expect_found("a_counter_is_taken_once", [(model_server, "Remote", forgetful_remote())])

    def test_a_reset_for_every_datagram(self):
        class Never(dict):
            def __setitem__(self, key, value):
                pass
        init = model_server.ModelServer.__init__

        def without_limit(self, *arguments):
            init(self, *arguments)
            self.resets = Never()
        self.expect_found("resets_are_limited_to_one_per_100_ms", [(model_server.ModelServer, "__init__", without_limit)])

    def test_a_33rd_session(self):
        self.expect_found("the_33rd_session_is_refused", [(model_server, "SESSIONS", 40)])

    def test_lookers_that_give_no_way(self):
        self.expect_found("who_never_asked_for_control_gives_way", [(model_server, "LOOKERS", 40)])

    def test_repeats_on_another_schedule(self):
        self.expect_found("repeats_follow_the_schedule", [(model_server, "REPEATS_S", (0.04,) * 5)])

    def test_packets_ahead_for_who_takes_none(self):
        self.expect_found("packets_ahead_go_to_nobody_else", [(model_server.ModelServer, "taken_ahead", lambda *_: 32)])

    def test_more_packets_ahead_than_are_taken(self):
        def always_32(_, packet):
            return 32 if packet.ahead else 0
        self.expect_found("packets_ahead_go_to_who_takes_them", [(model_server.ModelServer, "taken_ahead", always_32)])

    def test_early_items_that_end_the_session(self):
        def skips(*_):
            raise model_server.Broken("Items were dropped")
        self.expect_found("items_that_come_early_are_skipped", [(model_server.ModelServer, "skips", skips)])

    def test_an_announcement_without_end(self):
        class Deaf(model_server.Remote):
            """One whose acknowledgements say nothing."""
            heard_it = property(lambda self: False, lambda self, value: None)
        self.expect_found("ahead_is_announced_in_return", [(model_server, "Remote", Deaf)])

    def test_a_backlog_without_end(self):
        def tell(self, remote, **body):
            remote.items.append(model_server.stream.Item(**body))
        self.expect_found("a_full_backlog_ends_with_bye", [(model_server.ModelServer, "tell", tell)])

    def test_requests_without_a_lease(self):
        self.expect_found("what_needs_the_lease_is_refused_without", [(model_server, "NEEDS_LEASE", set())])

    def test_a_lease_that_is_stolen(self):
        def do_acquire(server, remote, *_):
            server.owner, server.fence = remote, server.fence + 1
            return answer.RESULT_CODE_OK, {"lease": server.lease_info(remote)}
        self.expect_found("one_session_holds_the_lease", [(model_requests, "do_acquire", do_acquire)])

    def test_parameters_set_in_spite_of_a_bad_one(self):
        sound = model_requests.do_set_parameter

        def one_by_one(server, remote, number, change):
            for each in change.assignments:
                code, fields = sound(server, remote, number, control.SetParameter(assignments=[each]))
                if code != answer.RESULT_CODE_OK:
                    return code, fields
            return answer.RESULT_CODE_OK, {}
        self.expect_found("set_parameter_is_all_or_none", [(model_requests, "do_set_parameter", one_by_one)])

    def test_a_stop_that_does_nothing(self):
        self.expect_found("stop_needs_no_lease_and_is_latched", [(model_requests, "do_stop", refuses_nothing)])

    def test_pieces_of_a_file_in_any_order(self):
        sound = model_requests.do_put_asset

        def in_any_order(server, remote, number, put):
            put.offset = len(server.files.get(put.hash, b""))
            return sound(server, remote, number, put)
        self.expect_found("a_file_is_brought_piece_by_piece", [(model_requests, "do_put_asset", in_any_order)])

    def test_bytes_of_any_hash(self):
        self.expect_found("a_file_of_another_hash_is_refused", [(model_requests, "do_put_asset", refuses_nothing)])

    def test_all_sections_always(self):
        self.expect_found("sections_not_asked_for_are_not_filled_in", [(model_world, "section", lambda full, _: full)])

    def test_good_poses_that_are_answered(self):
        sound = model_requests.do_pose_batch

        def loud(*arguments):
            code, fields = sound(*arguments)
            return code or answer.RESULT_CODE_OK, fields
        self.expect_found("poses_are_silent_when_good_and_counted_when_missing", [(model_requests, "do_pose_batch", loud)])

    def test_a_hash_of_something_else(self):
        self.expect_found("the_hash_is_that_of_the_states", [(model_world, "canonical", lambda full: full.SerializeToString())])

    def test_a_run_that_does_not_wait(self):
        sound = model_server.ModelServer.run_time

        def run_time(self):
            if self.running is not None:
                self.running[0].newest = 2**60
            sound(self)
        self.expect_found("a_run_stays_64_states_ahead_at_most", [(model_server.ModelServer, "run_time", run_time)])

    def test_steps_under_the_real_clock(self):
        self.expect_found("steps_need_the_virtual_clock", [(model_requests, "do_run", refuses_nothing)], virtual=False)


def forgetful_remote():
    """A session that remembers no counter."""
    class Forgetful(model_server.Remote):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            self.counters = type("Nothing", (list,), {"add": lambda self, counter: None, "__iter__": lambda self: iter([0])})()
    return Forgetful


if __name__ == "__main__":
    unittest.main()
