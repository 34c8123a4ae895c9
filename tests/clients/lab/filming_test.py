"""Filming: which recording becomes which video, from where it is seen, and what has none."""
import pathlib
import tempfile
import types
import unittest

from hapticd_lab import filming
from hapticd_lab.figure import Figure, Spec


class Filming(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.scratch.name)
        self.lab = types.SimpleNamespace(folder=self.folder / "F13", recording=lambda name: self.folder / f"{name}.mcap")
        self.written = []

    def tearDown(self):
        self.scratch.cleanup()

    def make(self, figure_id, records=True):
        def make(lab, figure):
            figure.notes.append("made")
            if records:
                lab.recording("paper").write_bytes(b"session")

        spec = filming.filmed(Spec(figure_id, "Switch of contact", "", make, 5.0), lambda *order, **more: self.written.append((order, more)))
        figure = Figure(figure_id, "", "")
        spec.make(self.lab, figure)
        return spec, figure

    def test_the_figure_is_made_and_its_first_run_filmed_into_its_folder(self):
        spec, figure = self.make("F13")
        self.assertEqual(figure.notes, ["made"])
        ((order, more),) = self.written
        self.assertEqual(order, (self.folder / "paper.mcap", self.folder / "F13" / "paper.webm"))
        self.assertEqual((more["caption"], more["camera"]), ("F13: Switch of contact", "player"))
        self.assertGreater(spec.cost_s, 5.0)

    def test_the_instrument_is_seen_from_close_to_the_hand(self):
        self.assertEqual([filming.camera(each) for each in ("F12a", "S1.2", "F1", "F15d", "F17")], ["player", "player", "close", "close", "close"])

    def test_without_a_session_it_says_so(self):
        with self.assertRaisesRegex(ValueError, "F3 has no session to film"):
            self.make("F3", records=False)
        self.assertEqual(self.written, [])


if __name__ == "__main__":
    unittest.main()
