"""Plots: the panels of the paper's figures, what each of them holds, and the files."""
import pathlib
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree

import numpy
from hapticd import Event
from hapticd.v1 import event_pb2
from hapticd_lab import plots
from lab_support import make_trace

COUNT = 400


def run(began_s=7.0, strength=1.0):
    """Force, torque and cost known tick by tick; body touched in ticks 100..199, string in 150..299; a tone at 0.3 s."""
    ramp = numpy.arange(COUNT) / COUNT
    body, string = numpy.zeros((COUNT, 3)), numpy.zeros((COUNT, 3))
    body[100:200, 1], string[150:300, 2] = 1.0, 1.0
    tone = event_pb2.Tone(t_ns=round((began_s + 0.3) * 1e9), string_index=4)
    return make_trace(
        COUNT,
        force_n=strength * numpy.outer(ramp, [1.0, 2.0, -3.0]),
        torque_n_m=numpy.outer(ramp, [-0.1, 0.2, 0.3]),
        cpu_us=numpy.full(COUNT, 20.0),
        object_force_n={"C2": string, "body": body},
        began_s=began_s,
        events=[Event("tone", tone)],
    )


class Layout(unittest.TestCase):
    def setUp(self):
        self.picture = plots.draw_runs({"paper": run(), "deflecting": run(strength=2.5)}, "F15a: title")
        self.axes = self.picture.figure.axes

    def tearDown(self):
        plots.pyplot.close(self.picture.figure)

    def curve(self, axis, label):
        return next(line for line in axis.lines if line.get_label() == label)

    def test_force_torque_cost_and_contacts_are_above_each_other_runs_beside_each_other(self):
        self.assertEqual(len(self.axes), 8)
        self.assertEqual([axis.get_ylabel() for axis in self.axes[::2]], ["force, N", "torque, N m", "time per tick, \N{MICRO SIGN}s", ""])
        self.assertEqual([axis.get_title("left") for axis in self.axes[:2]], ["paper", "deflecting"])
        self.assertEqual({axis.get_xlabel() for axis in self.axes[6:]}, {"time, s"})

    def test_curves_are_the_components(self):
        for axis, table in ((self.axes[0], run().force_n), (self.axes[2], run().torque_n_m)):
            for i, name in enumerate("xyz"):
                numpy.testing.assert_array_equal(self.curve(axis, name).get_ydata(), table[:, i])

    def test_x_is_red_y_green_and_z_blue_and_each_has_a_style_of_its_own(self):
        lines = [self.curve(self.axes[0], name) for name in "xyz"]
        colors = [plots.matplotlib.colors.to_rgb(line.get_color()) for line in lines]
        self.assertEqual([numpy.argmax(color) for color in colors], [0, 1, 2])
        self.assertEqual(len({str(line.get_linestyle()) + str(line._dash_pattern) for line in lines}), 3)

    def test_runs_share_their_axes(self):
        for row in range(0, 6, 2):
            self.assertEqual(self.axes[row].get_ylim(), self.axes[row + 1].get_ylim())

    def test_every_curve_of_every_run_is_within_its_panel(self):
        for row in (0, 2):
            low, high = self.axes[row].get_ylim()
            for axis in self.axes[row : row + 2]:
                for name in "xyz":
                    data = self.curve(axis, name).get_ydata()
                    self.assertTrue(low < data.min() and data.max() < high)

    def test_no_line_is_drawn_over_ticks_that_are_missing(self):
        tick = numpy.arange(COUNT)
        tick[100:] += 50
        picture = plots.draw_runs({"paper": make_trace(COUNT, tick=tick, t_s=tick * 1e-3)}, "title")
        data = self.curve(picture.figure.axes[0], "x").get_ydata()
        self.assertEqual(numpy.flatnonzero(numpy.isnan(data)).tolist(), [100])
        plots.pyplot.close(picture.figure)

    def test_the_millisecond_is_in_the_picture_however_fast_ticks_are(self):
        low, high = self.axes[4].get_ylim()
        self.assertTrue(low < 20.0 and high > plots.PERIOD_US)
        self.assertIn(plots.PERIOD_US, [line.get_ydata()[0] for line in self.axes[4].lines])
        self.assertIn("100 % under 1 ms", self.axes[4].get_title("right"))

    def test_strips_show_who_is_touched_when(self):
        strips = self.axes[6]
        self.assertEqual([label.get_text() for label in strips.get_yticklabels()], ["body", "C2"])
        ranges = [
            [round(float(x), 6) for x in (box.vertices[:, 0].min(), box.vertices[:, 0].max())]
            for group in strips.collections
            for box in group.get_paths()
        ]
        self.assertEqual(ranges, [[0.1, 0.2], [0.15, 0.3]])

    def test_a_tone_is_marked_when_it_sounds_with_the_number_of_its_string(self):
        self.assertEqual([round(float(x), 6) for line in self.axes[0].lines if line.get_marker() == "v" for x in line.get_xdata()], [0.3])
        self.assertEqual([text.get_text() for text in self.axes[0].texts], ["5"])


class Files(unittest.TestCase):
    def save(self, runs):
        with tempfile.TemporaryDirectory() as folder:
            plots.draw_runs(runs, "title").save(pathlib.Path(folder) / "plot")
            svg = (pathlib.Path(folder) / "plot.svg").read_text(encoding="utf-8")
            return svg, (pathlib.Path(folder) / "plot.png").read_bytes()

    def test_are_svg_and_png_with_room_for_the_curves(self):
        svg, png = self.save({"paper": run()})
        self.assertTrue(xml.etree.ElementTree.fromstring(svg).tag.endswith("svg"))
        self.assertFalse([line for line in svg.splitlines() if line != line.rstrip()])
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")

    def test_a_run_without_contact_cost_or_tone_is_drawn_too(self):
        with self.assertNoLogs(), unittest.mock.patch("warnings.warn", side_effect=AssertionError):
            self.save({"paper": make_trace(10), "deflecting": make_trace(20)})


class Spans(unittest.TestCase):
    def test_are_ranges_of_consecutive_ticks(self):
        for mask, ranges in (("", []), ("0", []), ("1", [(0, 1)]), ("0110100", [(1, 3), (4, 5)]), ("1011", [(0, 1), (2, 4)])):
            self.assertEqual(plots.spans(numpy.array([each == "1" for each in mask], bool)), ranges)


class Lines(unittest.TestCase):
    def test_panels_have_their_curves_bounds_and_scales(self):
        panel = plots.Panel(
            "speed, m/s", "force, N", [plots.Line("ours", [1, 10], [2, 3])], "title", log_x=True, bounds={"limit": 22.0}, marks={"tap": 1.204}
        )
        picture = plots.lines("all", [panel, panel, panel])
        axes = picture.figure.axes
        self.assertEqual([axis.get_visible() for axis in axes], [True, True, True, False])
        self.assertEqual((axes[0].get_xscale(), axes[0].get_yscale()), ("log", "linear"))
        self.assertEqual([line.get_label() for line in axes[0].lines], ["ours", "limit", "tap"])
        plots.pyplot.close(picture.figure)


if __name__ == "__main__":
    unittest.main()
