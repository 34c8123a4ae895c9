"""A recording becomes a video whose frames are its instants: by ffprobe, and by where the ball is in them. Named programs are looked for
first; the rest runs where chromium, ffmpeg and the page are."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy
import sample_recording
from hapticd_lab import chromium, video

HAPTIC_WEB = os.path.abspath(sys.argv.pop(1))
SIZE = (640, 360)
FRAMES_PER_S = 10
LENGTH_S = 2.0


def only(folder, *names):
    """An environment in which nothing but these programs is found."""
    for name in names:
        path = pathlib.Path(folder) / name
        path.write_text("#!/bin/sh\nexit 1\n")
        path.chmod(0o755)
    return mock.patch.dict(os.environ, {"PATH": str(folder)})


def decoded(path):
    """Frames of a video, n x height x width, 0 to 255."""
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "gray", "-"], capture_output=True, check=True).stdout
    return numpy.frombuffer(raw, numpy.uint8).reshape(-1, SIZE[1], SIZE[0]).astype(float)


class FrameTimesTest(unittest.TestCase):
    def test_frames_are_evenly_spaced_and_none_is_after_the_end(self):
        self.assertEqual(video.frame_times(0.1, 25.0), [0.0, 0.04, 0.08])
        self.assertEqual(len(video.frame_times(2.0, 25.0)), 51)
        self.assertEqual(len(video.frame_times(2.0, 25.0, speed=0.25)), 201)
        self.assertEqual(video.frame_times(0.0, 25.0), [0.0])
        for length_ms in (1160, 2320, 2360, 4000):  # whole numbers of frames, of which the quotient of the first three falls short
            times = video.frame_times(length_ms * 1e-3, 25.0)
            self.assertEqual(len(times), length_ms // 40 + 1)
            self.assertAlmostEqual(times[-1], length_ms * 1e-3, places=12)


class MissingTest(unittest.TestCase):
    def test_what_is_missing_is_named_with_its_package(self):
        for there, package in (((), "ffmpeg"), (("ffmpeg",), "hapticd"), (("ffmpeg", "haptic-web"), "chromium")):
            with self.subTest(package), tempfile.TemporaryDirectory() as folder, only(folder, *there):
                output = pathlib.Path(folder) / "x.webm"
                with self.assertRaisesRegex((video.VideoError, chromium.ChromiumError), f"apt-get install {package}"):
                    video.write_video(pathlib.Path("/nowhere.mcap"), output)
                self.assertFalse(output.exists())

    def test_a_size_that_no_video_has_is_refused(self):
        with self.assertRaisesRegex(video.VideoError, "641x360"):
            video.write_video(pathlib.Path("/nowhere.mcap"), pathlib.Path("/nowhere.webm"), size=(641, 360))


class VideoTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls._folder.name)
        cls.recording, cls.output = cls.folder / "ball.mcap", cls.folder / "ball.webm"
        sample_recording.write(cls.recording, LENGTH_S, -0.3, 0.3)
        cls.told = []
        # What is left behind would lie here.
        with mock.patch.object(tempfile, "tempdir", str(cls.folder)):
            cls.count = video.write_video(cls.recording, cls.output, frames_per_s=FRAMES_PER_S, size=SIZE, camera="top", caption="a ball",
                                          haptic_web=HAPTIC_WEB, progress=lambda *frames: cls.told.append(frames))

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    def test_the_video_has_a_frame_for_each_instant_and_the_size_that_was_asked_for(self):
        said = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=width,height,nb_read_frames,r_frame_rate:format=format_name",
                               "-of", "default=noprint_wrappers=1", str(self.output)], capture_output=True, text=True, check=True).stdout
        found = dict(line.split("=", 1) for line in said.split())
        self.assertEqual(self.count, LENGTH_S * FRAMES_PER_S + 1)
        self.assertEqual(found, {"width": "640", "height": "360", "r_frame_rate": "10/1", "nb_read_frames": "21", "format_name": "matroska,webm"})
        self.assertEqual(self.told, [(done, 21) for done in range(1, 22)])

    def test_each_frame_shows_where_the_ball_was_at_its_instant(self):
        frames = decoded(self.output)[:, 70:-60, :]  # without the cards
        moving = numpy.abs(frames - numpy.median(frames, axis=0)) > 30.0
        columns = numpy.arange(SIZE[0])
        x_px = numpy.array([(mask.sum(axis=0) * columns).sum() / mask.sum() for mask in moving])
        # The ball goes at constant speed at one height, and the eye stands above: so it does in the picture.
        k = numpy.arange(len(x_px))
        slope, begin = numpy.polyfit(k, x_px, 1)
        self.assertGreater(slope * len(k), 200.0)
        self.assertLess(numpy.abs(x_px - (begin + slope * k)).max(), 3.0)
        self.assertAlmostEqual(x_px.mean(), SIZE[0] / 2, delta=5.0)

    def test_nothing_is_left_behind(self):
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["ball.mcap", "ball.webm"])

    def test_what_is_no_recording_is_refused_in_the_words_of_haptic_web_and_leaves_no_video(self):
        bad = self.folder / "text.mcap"
        bad.write_text("no recording at all")
        self.addCleanup(bad.unlink)
        with self.assertRaisesRegex(video.VideoError, r"text\.mcap: not a recording of hapticd"):
            video.write_video(bad, self.folder / "none.webm", haptic_web=HAPTIC_WEB)
        self.assertFalse((self.folder / "none.webm").exists())

    def test_who_stops_in_the_middle_leaves_no_video(self):
        def stop(done, _):
            if done == 20:
                raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            video.write_video(self.recording, self.folder / "half.webm", size=SIZE, haptic_web=HAPTIC_WEB, progress=stop)
        self.assertEqual(list(self.folder.glob("*half*")), [])


class ChromiumTest(unittest.TestCase):
    def test_what_the_page_throws_comes_back_in_its_words_and_the_browser_goes_on(self):
        with chromium.Chromium(SIZE) as browser:
            with self.assertRaisesRegex(chromium.ChromiumError, "out of tune"):
                browser.evaluate("Promise.reject(new Error('out of tune'))")
            with self.assertRaisesRegex(chromium.ChromiumError, "No.such"):
                browser.call("No.such")
            self.assertEqual(browser.evaluate("Promise.resolve(6 * 7)"), 42)

    def test_a_browser_that_dies_is_said_so(self):
        with chromium.Chromium(SIZE) as browser:
            browser.call("Runtime.enable")
            with self.assertRaisesRegex(chromium.ChromiumError, "chromium ended"):
                browser.call("Browser.crash")
                browser.evaluate("1")


if __name__ == "__main__":
    unittest.main()
