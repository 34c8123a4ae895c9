"""The ear of the page against sounds that are known, its truths as they stand in string_truth.md, and the page itself from few plays: what a string
tells is right, and every table and picture is made."""
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

import cost
import hearing
import measures
import numpy as np
import page
import phrase
import pictures
import playing
import quality

AUDIO = sys.argv.pop()
RATE_HZ = 48000


def tone(hz, amplitudes, seconds=1.0):
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    return sum(a * np.sin(2 * np.pi * n * hz * t + n) for n, a in enumerate(amplitudes, 1))


class Ear(unittest.TestCase):
    def test_pitch_of_a_tone_with_partials_is_its_own_with_and_without_a_guess(self):
        for hz in (65.4, 109.0, 146.8, 261.6):
            sound = tone(hz, (1.0, 0.5, 0.7, 0.2))
            self.assertLess(abs(hearing.cents(hearing.pitch(sound, RATE_HZ, 0.5), hz)), 3, hz)
            self.assertLess(abs(hearing.cents(hearing.hz_near(sound, RATE_HZ, 0.5, 1.02 * hz, 0.12), hz)), 0.5, hz)

    def test_silence_and_noise_have_no_pitch(self):
        noise = np.random.default_rng(1).normal(size=RATE_HZ)
        self.assertTrue(np.isnan(hearing.pitch(np.zeros(RATE_HZ), RATE_HZ, 0.5)))
        self.assertTrue(np.isnan(hearing.pitch(noise, RATE_HZ, 0.5)))

    def test_levels_and_peaks_are_those_of_the_partials(self):
        sound = tone(100.0, (1.0, 0.1, 0.01))
        for n, amplitude in enumerate((1.0, 0.1, 0.01), 1):
            self.assertAlmostEqual(hearing.level(sound, RATE_HZ, 0.2, 100.0 * n, 0.5), amplitude, delta=0.002)
        hz, db = hearing.spectrum(sound, RATE_HZ, 0.0, 1.0, 400)
        self.assertAlmostEqual(hz[np.argmax(db)], 100.0, delta=0.5)
        self.assertAlmostEqual(db[np.argmin(abs(hz - 200))], -20.0, delta=0.5)


class Truths(unittest.TestCase):
    def test_figures_are_found_where_they_stand(self):
        levels = measures.true_levels()
        self.assertEqual(len(levels), 54)
        self.assertEqual(set((hz, place) for hz, place, _ in levels), set(measures.PLUCKED))
        self.assertEqual(len(measures.true_harmonics()), 8)

    def test_a_stop_that_neither_yields_nor_stretches_halves_the_string(self):
        self.assertAlmostEqual(measures.held_hz(100.0, 0.5, 0.0), 200.0)
        self.assertGreater(measures.held_hz(100.0, 0.5, 3000.0), 200.0)


class Knobs(unittest.TestCase):
    def test_a_stop_is_due_where_a_finger_as_hard_as_a_nail_has_it_and_a_soft_one_lower(self):
        for share in quality.STOPS:
            with mock.patch.object(quality, "FLESH_N_PER_M", 1e12):
                self.assertAlmostEqual(quality.due_hz(share, 0.0), measures.held_hz(quality.HZ, share, 0.0), places=4)
                self.assertAlmostEqual(quality.due_hz(share, 2000.0), measures.held_hz(quality.HZ, share, 2000.0), places=4)
            # By T / (k L) of the part, to first order.
            flat = 1200 / np.log(2) * playing.TENSION_N / (quality.FLESH_N_PER_M * (1 - share) * playing.LENGTH_M)
            self.assertAlmostEqual(hearing.cents(measures.held_hz(quality.HZ, share, 0.0), quality.due_hz(share, 0.0)), flat, delta=0.1 * flat)

    def test_half_the_cost_is_told_of_the_most_exact_that_costs_it(self):
        rows = [{"modes": n, "substeps": s, "off_db": [db, None], "stopped_cents": [cents], "instructions": count}
                for n, s, db, cents, count in ((8, 8, 0.3, 9.0, 20), (16, 16, -0.1, -5.0, 50), (32, 32, 0.05, 2.0, 100), (64, 64, 0.04, 1.0, 400))]
        said = page.half_the_cost(rows, rows[2])
        self.assertIn("For 0.50 of its cost `wave { modes: 16 substeps: 16 }` is off by up to 0.10 dB instead of 0.05", said)
        self.assertIn("stopped by up to 5.0 cents instead of 2.0", said)
        self.assertIn("None", page.half_the_cost(rows[2:], rows[2]))

    def test_fewer_modes_and_sub_steps_are_loud_and_in_tune_to_less(self):
        with playing.Stage(AUDIO) as stage, mock.patch.multiple(quality, PLUCKED=((65.4, 0.25), (146.8, 0.5)), SPEEDS=(0.6,)):
            rows = {knobs: quality.of_knobs(stage, None, *knobs) for knobs in (quality.KNOBS[0], quality.USUAL)}
        worst = {knobs: max(map(abs, page.known_db(row))) for knobs, row in rows.items()}
        flat = {knobs: max(map(abs, row["stopped_cents"])) for knobs, row in rows.items()}
        self.assertLess(worst[quality.USUAL], 0.05)
        self.assertLess(flat[quality.USUAL], 2)
        self.assertLess(worst[quality.USUAL], 0.5 * worst[quality.KNOBS[0]])
        self.assertLess(flat[quality.USUAL], 0.5 * flat[quality.KNOBS[0]])


class Page(unittest.TestCase):
    def test_few_plays_are_right_and_make_every_table_and_picture(self):
        few = mock.patch.multiple(measures, SPEEDS=(0.5, 1.0), PLUCKED=((65.4, 0.1), (146.8, 0.25)), LAPS=measures.LAPS[1:3], STRETCHES_N=(0.0,))
        with tempfile.TemporaryDirectory() as folder, playing.Stage(AUDIO) as stage, few, \
                mock.patch.multiple(page, PAGE=pathlib.Path(folder) / "one_string.md", FOLDER=pathlib.Path(folder) / "one_string"):
            page.FOLDER.mkdir()
            figures = {name: getattr(measures, name)(stage) for name in ("loudness", "pitch", "attacks", "harmonics", "touched", "felt", "laps",
                                                                           "ringing", "shape")}
            figures["phrase"] = phrase.measure(stage, page.FOLDER / "phrase.wav")
            figures["cost"] = {what: 1.0 for what in cost.cases()}
            figures["quality"] = {"knobs": [{"modes": 32, "substeps": 32, "off_db": [0.1], "stopped_cents": [1.0], "instructions": 1.0}],
                                  "tension": [{"what": "E A 0", "stopped_cents": [1.0], "rise_cents": [0.0], "instructions": 1.0}]}
            figures["machine"] = "This machine."
            pictures.draw(figures, page.FOLDER)
            page.write(figures, cost.REFERENCE, quality.USUAL)
            text = page.PAGE.read_text(encoding="utf-8")
            for name in pictures.ALL:
                self.assertIn(f"one_string/{name}.png", text)
                self.assertLess((page.FOLDER / f"{name}.png").stat().st_size, 60000, name)
            self.assertLess((page.FOLDER / "phrase.wav").stat().st_size, 400000)
        last = figures["phrase"]["words"][-1][0]
        for name in ("told", "heard"):
            of = [hz for t, hz in zip(figures["phrase"]["times"], figures["phrase"][name]) if t > last + 0.3 and np.isfinite(hz)]
            self.assertGreater(len(of), 20, name)
            # The part from the fret, which the string is stretched over: 3 cents.
            self.assertLess(abs(np.median(hearing.cents(np.array(of), phrase.STRING["hz"] / (1 - phrase.FRET_AT))) - 3), 5, name)
        for row in figures["loudness"]["rows"]:
            self.assertLess(abs(page.decibels(row["mode_mm"], row["truth_mm"])), 0.2)
        for way in figures["pitch"].values():
            self.assertLess(way["0"]["worst"], 8)
            self.assertLess(way["0"]["heard_worst"], 12)


if __name__ == "__main__":
    unittest.main(verbosity=2)
