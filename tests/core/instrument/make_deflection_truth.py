#!/usr/bin/python3
"""Writes deflection_truth.csv: Eq. 10-12, and their series with a spring, in 120 digits.

From the printed definitions, with L1 + L2 - L as it stands, the slope by numerical differentiation
and the series law by bisection: nothing here is rearranged as in core/instrument/deflection.cpp.
Each line is a string (length, T, E, R, lambda), its answers to a deflection (force, dF/ddelta,
energy, F_i, lateral force), and those to the same displacement through a spring kc (delta, force).
Inputs are the shortest decimals that give the double back, outputs have 25 digits; with twice the
digits and bisections the same file comes out.
Needs python3-mpmath. Run it without arguments; it overwrites the file beside it.
"""
import itertools
import os
import random

import mpmath as mp

mp.mp.dps = 120
PRINTED_DIGITS = 25
# The error of the extrapolated difference is its fourth power, rounding costs its inverse: 90 digits remain.
RELATIVE_STEP = mp.mpf(10) ** -25
BISECTIONS = 320
RANDOM_LINES = 1000
SEED = 20240607

COLUMNS = ["length", "tension", "youngs_modulus", "radius", "lambda", "displacement", "stiffness",
           "force", "slope", "energy", "axial_force", "lateral_force", "series_delta", "series_force"]
TENSIONS = [0.0, 1.0, 30.0, 1000.0]
MATERIALS = [(0.0, 0.00034), (1.9e11, 0.0), (1e9, 1e-6), (1.9e11, 0.00034), (1e12, 0.001)]
LAMBDAS = [0.0, 1e-9, 0.001, 0.1, 0.5, 0.73, 0.999, 1.0 - 2.0**-40, 1.0]
DISPLACEMENTS = [1e-9, 1e-6, 0.0001, 0.001, 0.005, 0.02, 0.05]
STIFFNESSES = [0.1, 1.0, 30.0, 1000.0, 1e4, 1e6]


class String:
    """A string between (0, 0) and (length, 0), pressed at x = lambda length."""

    def __init__(self, length, tension, youngs_modulus, radius, place):
        self.length, self.tension = mp.mpf(length), mp.mpf(tension)
        self.axial_stiffness = mp.mpf(youngs_modulus) * mp.pi * mp.mpf(radius) ** 2
        self.run_1 = mp.mpf(place) * self.length
        self.run_2 = (1 - mp.mpf(place)) * self.length

    def sides(self, delta):
        return mp.sqrt(self.run_1**2 + delta**2), mp.sqrt(self.run_2**2 + delta**2)

    def stretch(self, delta):
        return sum(self.sides(delta)) - self.length

    def axial_force(self, delta):
        return self.axial_stiffness * self.stretch(delta) / self.length

    def force(self, delta):
        side_1, side_2 = self.sides(delta)
        return (self.tension + self.axial_force(delta)) * (delta / side_1 + delta / side_2)

    def slope(self, delta):
        """Central differences of two step sizes, extrapolated: the error is of fourth order."""
        step = delta * RELATIVE_STEP
        wide, narrow = ((self.force(delta + h) - self.force(delta - h)) / (2 * h) for h in (2 * step, step))
        return (4 * narrow - wide) / 3

    def energy(self, delta):
        stretch = self.stretch(delta)
        return self.tension * stretch + self.axial_stiffness * stretch**2 / (2 * self.length)

    def lateral_force(self, delta):
        side_1, side_2 = self.sides(delta)
        return (self.tension + self.axial_force(delta)) * (self.run_2 / side_2 - self.run_1 / side_1)

    def in_series(self, displacement, stiffness):
        """delta and force where force(delta) = stiffness (displacement - delta)."""
        load = stiffness * displacement
        if 0 in (self.run_1, self.run_2) and load <= self.tension:
            return mp.mpf(0), load
        low, high = mp.mpf(0), displacement
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            if self.force(middle) + stiffness * middle < load:
                low = middle
            else:
                high = middle
        delta = (low + high) / 2
        return delta, self.force(delta)


def line(inputs):
    """One line of the file: the inputs and all answers."""
    *of_string, displacement, stiffness = inputs
    string = String(*of_string)
    delta = mp.mpf(displacement)
    answers = [string.force(delta), string.slope(delta), string.energy(delta), string.axial_force(delta),
               string.lateral_force(delta), *string.in_series(delta, mp.mpf(stiffness))]
    printed = [mp.nstr(answer, PRINTED_DIGITS, strip_zeros=True) for answer in answers]
    return ",".join([repr(float(value)) for value in inputs] + printed)


def log_uniform(generator, low, high):
    return low * (high / low) ** generator.random()


def random_inputs(generator):
    """A string, displacement and spring, with ends and zeros more often than chance would have them."""
    place = generator.choice([generator.random(), log_uniform(generator, 1e-12, 0.5),
                              1.0 - log_uniform(generator, 1e-12, 0.5)])
    return (log_uniform(generator, 0.05, 20.0), generator.choice([0.0] + 9 * [log_uniform(generator, 1e-3, 1e3)]),
            log_uniform(generator, 1e6, 1e12), log_uniform(generator, 1e-6, 1e-3), place,
            log_uniform(generator, 1e-9, 0.05), log_uniform(generator, 0.1, 1e6))


def main():
    stiffnesses = itertools.cycle(STIFFNESSES)
    grid = itertools.product(TENSIONS, MATERIALS, LAMBDAS, DISPLACEMENTS)
    inputs = [(1.1, tension, *material, place, displacement, next(stiffnesses))
              for tension, material, place, displacement in grid]
    generator = random.Random(SEED)
    inputs += [random_inputs(generator) for _ in range(RANDOM_LINES)]
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "deflection_truth.csv")
    with open(path, "w", encoding="ascii") as file:
        file.write(",".join(COLUMNS) + "\n")
        for each in inputs:
            file.write(line(each) + "\n")


if __name__ == "__main__":
    main()
