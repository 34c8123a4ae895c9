"""What Table 1 is judged by: the string's law, analyses of variance, the simulated observer, the printed tables."""
import decimal
import math
import unittest

import numpy
from hapticd.v1 import scene_pb2
from hapticd_lab import anova, selection
from hapticd_lab.observer import ANSWERS, EQUAL, FIRST, SECOND, WeberObserver
from hapticd_lab.published import ANOVAS, TABLE_1, TABLE_2
from hapticd_lab.stimulus import TIP_RADIUS_M, press_path
from hapticd_lab.string_law import StringValues, change, force_n, forget_own_law, values_of
from scipy import stats

REFERENCE = StringValues()


def exact_force(tension, youngs, radius, length, delta, place):
    """Eq. 10-12 with 40 digits."""
    with decimal.localcontext() as context:
        context.prec = 40
        number = decimal.Decimal
        tension, youngs, radius, length, delta, place = (number(repr(value)) for value in (tension, youngs, radius, length, delta, place))
        first, second = ((place * length) ** 2 + delta ** 2).sqrt(), (((1 - place) * length) ** 2 + delta ** 2).sqrt()
        inner = youngs * number("3.141592653589793238462643383279502884197") * radius ** 2 * (first + second - length) / length
        return float((tension + inner) * (delta / first + delta / second))


class Law(unittest.TestCase):
    def test_the_force_is_that_of_40_digits(self):
        for delta in (1e-9, 1e-4, 5e-3, 2e-2):
            for place in (0.01, 0.25, 0.5, 0.9):
                for raised in (REFERENCE, REFERENCE.raised("T", 0.5), REFERENCE.raised("E", 0.5), REFERENCE.raised("R", 0.5)):
                    exact = exact_force(raised.tension_n, raised.youngs_modulus_pa, raised.radius_m, raised.length_m, delta, place)
                    self.assertLess(abs(force_n(raised, delta, place) / exact - 1.0), 1e-13, (delta, place))

    def test_a_string_with_an_axial_stiffness_of_its_own_is_pressed_by_that(self):
        for own in (0.0, 3000.0):
            string = StringValues(own_axial_stiffness_n=own)
            area = math.pi * string.radius_m ** 2
            exact = exact_force(string.tension_n, own / area, string.radius_m, string.length_m, 5e-3, 0.25)
            self.assertLess(abs(force_n(string, 5e-3, 0.25) / exact - 1.0), 1e-13)
            self.assertEqual(force_n(string.raised("E", 0.5), 5e-3, 0.25), force_n(string, 5e-3, 0.25))

    def test_a_string_of_a_scene_has_its_own_law_until_that_is_forgotten(self):
        string = scene_pb2.String(p_wa_m=[0.0, 0.0, 0.0], p_wb_m=[0.3, 0.0, 0.4], tension_n=20.0, radius_m=1e-3, youngs_modulus_pa=1e9,
                                  axial_stiffness_n=700.0, linear_density_kg_per_m=2e-3, frequency_hz=100.0, tuning=scene_pb2.TUNING_TENSION)
        self.assertEqual(values_of(string), StringValues(20.0, 1e9, 1e-3, 0.5, 700.0))
        forget_own_law(string)
        self.assertEqual(values_of(string), StringValues(20.0, 1e9, 1e-3, 0.5))
        self.assertAlmostEqual(values_of(string).axial_stiffness_n, 1e3 * math.pi)
        self.assertEqual((string.frequency_hz, string.tuning, string.HasField("linear_density_kg_per_m")), (100.0, scene_pb2.TUNING_UNSPECIFIED, False))

    def test_raised_r_changes_the_force_more_than_raised_e_at_every_deflection(self):
        for delta in numpy.geomspace(1e-4, 5e-2, 12):
            for increment in (0.3, 0.4, 0.5):
                self.assertGreater(change(REFERENCE, "R", increment, delta, 0.25), change(REFERENCE, "E", increment, delta, 0.25))


class Variance(unittest.TestCase):
    def test_groups_give_what_scipy_gives(self):
        groups = numpy.random.default_rng(1).normal(size=(3, 7)) + numpy.array([[0.0], [0.5], [1.0]])
        f, p = stats.f_oneway(*groups)
        found = anova.of_groups(groups)
        self.assertAlmostEqual(found.f, f, 12)
        self.assertAlmostEqual(found.p, p, 12)
        self.assertEqual((found.between, found.within), (2, 18))

    def test_two_groups_are_a_t_test(self):
        groups = numpy.random.default_rng(2).normal(size=(2, 7))
        self.assertAlmostEqual(anova.of_groups(groups).f, stats.ttest_ind(*groups).statistic ** 2, 12)

    def test_the_printed_analysis_of_t_does_not_follow_from_its_table_and_the_others_do(self):
        found = {name: anova.from_summary([TABLE_1[name].means[i] for i in printed.levels], [TABLE_1[name].deviations[i] for i in printed.levels], 7)
                 for name, printed in ANOVAS.items()}
        self.assertAlmostEqual(found["T"].f, 1.74, 2)  # by hand: 7 (19.0^2 / 2) / ((26.5^2 + 27.4^2) / 2)
        for name in ("E", "R"):
            self.assertLess(abs(found[name].f / ANOVAS[name].f - 1.0), 0.03)
        for name, printed in ANOVAS.items():
            self.assertEqual((found[name].between, found[name].within), printed.degrees)
            # what is printed for F and p agrees with itself
            self.assertAlmostEqual(float(stats.f.sf(printed.f, *printed.degrees)), printed.p, 2)

    def test_groups_without_any_scatter_are_no_division_by_zero(self):
        self.assertTrue(numpy.isnan(anova.of_groups([[1.0, 1.0], [1.0, 1.0]]).f))
        self.assertEqual(anova.of_groups([[1.0, 1.0], [2.0, 2.0]]).p, 0.0)


class Tables(unittest.TestCase):
    def test_the_printed_scores_follow_from_the_players(self):
        for name, scores in TABLE_2.items():
            self.assertLess(abs(numpy.mean(scores.players) - scores.mean), 0.051, name)
            self.assertLess(abs(numpy.std(scores.players, ddof=1) - scores.deviation), 0.051, name)


class Observer(unittest.TestCase):
    def test_the_closed_form_rate_is_that_of_its_answers(self):
        observer, noise = WeberObserver(), numpy.random.default_rng(3).normal(size=40000)
        for ratio in (1.0, 1.2, 1.6):
            rate = numpy.mean([observer.answer(1.0, ratio, each) == SECOND for each in noise])
            self.assertLess(abs(rate - observer.rate_correct(numpy.log(ratio))), 4.0 * 0.5 / numpy.sqrt(len(noise)))

    def test_order_does_not_matter(self):
        observer = WeberObserver()
        turned = {FIRST: SECOND, SECOND: FIRST, EQUAL: EQUAL}
        for noise in numpy.linspace(-3.0, 3.0, 61):
            self.assertEqual(observer.answer(1.0, 1.3, noise), turned[observer.answer(1.3, 1.0, -noise)])

    def test_without_noise_the_criterion_parts_equal_from_stiffer(self):
        observer = WeberObserver(criterion=0.2)
        found = [observer.answer(1.0, numpy.exp(difference), 0.0) for difference in (-0.21, -0.19, 0.0, 0.19, 0.21)]
        self.assertEqual(found, [FIRST, EQUAL, EQUAL, EQUAL, SECOND])
        self.assertEqual(set(found), set(ANSWERS))


class Press(unittest.TestCase):
    def test_the_finger_goes_as_deep_as_asked_from_where_it_touches_and_back(self):
        path = press_path(REFERENCE, 0.005, 0.25)
        self.assertAlmostEqual(path[:, 1].min(), TIP_RADIUS_M + 3.4e-4 - 0.005, 12)
        self.assertGreater(path[0, 1], TIP_RADIUS_M + 3.4e-4 + 1e-3)
        self.assertTrue(numpy.array_equal(path[0], path[-1]))
        self.assertTrue(numpy.allclose(path[:, 0], -0.25 * 1.1))
        self.assertLess(numpy.abs(numpy.diff(path[:, 1])).max(), 0.051e-3)

    def test_strings_of_other_t_and_e_are_pressed_the_same_way(self):
        for parameter in ("T", "E"):
            self.assertTrue(numpy.array_equal(press_path(REFERENCE.raised(parameter, 0.5), 0.005, 0.5), press_path(REFERENCE, 0.005, 0.5)))

    def test_table_1_is_among_the_figures(self):
        self.assertEqual([spec.id for spec in selection.chosen(selection.offered(), ["T1"])], ["T1"])


if __name__ == "__main__":
    unittest.main()
