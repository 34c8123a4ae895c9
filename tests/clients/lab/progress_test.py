"""Progress: the words for durations, the time left, and what is written to a log and to a terminal."""
import io
import unittest

from hapticd_lab.progress import Progress, duration, time_left


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Durations(unittest.TestCase):
    def test_are_said_as_people_say_them(self):
        for seconds, text in (
            (0, "0 s"),
            (-3, "0 s"),
            (8.4, "8 s"),
            (59.6, "1 min"),
            (80, "1 min 20 s"),
            (3600, "1 h 0 min"),
            (7500, "2 h 5 min"),
        ):
            self.assertEqual(duration(seconds), text)


class TimeLeft(unittest.TestCase):
    def test_is_the_work_over_the_processes(self):
        self.assertAlmostEqual(time_left([10.0, 20.0, 30.0], [], [], 2), 30.0)
        self.assertAlmostEqual(time_left([10.0] * 4, [], [], 2), 20.0)

    def test_is_at_least_the_longest_figure(self):
        self.assertAlmostEqual(time_left([60.0, 1.0], [], [], 8), 60.0)

    def test_what_runs_counts_with_its_rest(self):
        self.assertAlmostEqual(time_left([], [(30.0, 10.0)], [], 4), 20.0)

    def test_what_takes_longer_than_said_is_nearly_done(self):
        self.assertAlmostEqual(time_left([], [(10.0, 50.0)], [], 1), 0.5)

    def test_follows_what_was_measured(self):
        slow = time_left([100.0], [], [(100.0, 300.0)], 1)
        self.assertAlmostEqual(slow, 100.0 * 310.0 / 110.0)
        self.assertLess(time_left([100.0], [], [(100.0, 20.0)], 1), 30.0)

    def test_is_nothing_when_all_is_done(self):
        self.assertEqual(time_left([], [], [(10.0, 10.0)], 2), 0.0)


class Writing(unittest.TestCase):
    def play(self, out):
        progress = Progress({"F1": 10.0, "F12a": 30.0}, 1, out)
        progress.began()
        progress.running({"F12a": 3.0})
        progress.finished("F12a", "deviates", 31.0, {})
        progress.running({"F1": 3.0})
        progress.finished("F1", "reproduced", 10.0, {})
        progress.close()
        return out.getvalue()

    def test_a_log_gets_whole_lines_of_plain_text(self):
        text = self.play(io.StringIO())
        self.assertTrue(all(each == "\n" or each.isprintable() for each in text), repr(text))
        self.assertEqual(
            text.splitlines(), ["2 figures in 1 process, about 40 s", "[1/2] F12a deviates, 31 s; about 10 s left", "[2/2] F1 reproduced, 10 s"]
        )

    def test_the_time_of_what_failed_says_nothing_about_the_rest(self):
        out = io.StringIO()
        progress = Progress({"F1": 100.0, "F2": 100.0}, 1, out)
        progress.finished("F1", "failed", 1.0, {}, counts=False)
        self.assertIn("about 1 min 40 s left", out.getvalue())

    def test_a_terminal_also_sees_what_runs(self):
        text = self.play(Terminal())
        self.assertIn("[0/2] F12a 3 s; about 37 s left", text)
        self.assertIn("\r\x1b[K[2/2] F1 reproduced, 10 s\n", text)


if __name__ == "__main__":
    unittest.main()
