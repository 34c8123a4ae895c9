#!/usr/bin/env python3
"""Derives every constant of elementary.cpp: minimax polynomials and the parts of pi and log 2.

Remez exchange in 60 digits, then each coefficient is rounded to double and the error that remains
in the function itself (sine, cosine, arctangent, exponential, logarithm) is measured on a dense
grid.
Needs python3-mpmath. Run it and compare with elementary.cpp; nothing else reads it.
"""
import mpmath as mp

mp.mp.dps = 60


def remez(target, high, count):
    """c of the sum c[i] z^i, i < count, with the least maximum error to target on [0, high]."""
    points = [high * (1 - mp.cos(mp.pi * i / count)) / 2 for i in range(count + 1)]
    grid = [high * (1 - mp.cos(mp.pi * i / 2000)) / 2 for i in range(2001)]
    targets = [target(z) for z in grid]
    while True:
        # p(z_i) - target(z_i) = +-level: linear in the coefficients and the level.
        rows = mp.matrix(count + 1)
        right = mp.matrix(count + 1, 1)
        for i, z in enumerate(points):
            for j in range(count):
                rows[i, j] = z**j
            rows[i, count] = (-1) ** i
            right[i] = target(z)
        solution = mp.lu_solve(rows, right)
        coefficients, level = list(solution[:count]), abs(solution[count])

        # The next points: the extremum of each run of errors of one sign.
        extrema = []
        for z, value in zip(grid, targets):
            error = mp.polyval(coefficients[::-1], z) - value
            if extrema and (error > 0) == (extrema[-1][1] > 0):
                if abs(error) > abs(extrema[-1][1]):
                    extrema[-1] = (z, error)
            else:
                extrema.append((z, error))
        assert len(extrema) == count + 1
        if max(abs(error) for _, error in extrema) < level * mp.mpf("1.001"):
            return coefficients
        points = [z for z, _ in extrema]


def report(name, target, residual, high, count):
    """Prints the rounded coefficients; residual(p, z) is the error of the whole function."""
    rounded = [float(c) for c in remez(target, high, count)]
    descending = [mp.mpf(c) for c in reversed(rounded)]
    grid = [high * mp.mpf(i) / 5000 for i in range(1, 5001)]
    worst = max(abs(residual(mp.polyval(descending, z), z)) for z in grid)
    print(f"{name}: relative error {mp.nstr(worst, 3)}")
    print("  " + ",\n  ".join(c.hex() for c in rounded))


def ratio(numerator, limit):
    """numerator(sqrt z, z), or its limit at z = 0 where it is 0/0."""
    return lambda z: numerator(mp.sqrt(z), z) if z > 0 else mp.mpf(limit)


def truncated(value, bits):
    """value cut to so many significant bits."""
    unit = mp.mpf(2) ** (mp.floor(mp.log(value, 2)) + 1 - bits)
    return mp.floor(value / unit) * unit


def print_parts():
    """pi/2 in three parts for the reduction, and k pi/4 as a sum of two doubles."""
    # 36 bits: n times a part is exact for n < 2^17.
    first = truncated(mp.pi / 2, 36)
    second = truncated(mp.pi / 2 - first, 36)
    third = mp.pi / 2 - first - second
    for part in (first, second, third):
        print(f"part of pi/2: {float(part).hex()}")
    print(f"2/pi: {float(2 / mp.pi).hex()}")
    for k in range(5):
        high = float(k * mp.pi / 4)
        print(f"{k} pi/4: {high.hex()} + {float(k * mp.pi / 4 - mp.mpf(high)).hex()}")
    print(f"tan(pi/8): {float(mp.tan(mp.pi / 8)).hex()}")
    # 42 bits: the exponent, at most 2^11, times the first part is exact.
    first = truncated(mp.log(2), 42)
    print(f"log 2: {float(first).hex()} + {float(mp.log(2) - first).hex()}")
    print(f"1 / log 2: {float(1 / mp.log(2)).hex()}")
    print(f"sqrt 2: {float(mp.sqrt(2)).hex()}")
    # The largest argument with a finite exponential, and the smallest above which it is not 0.
    print(f"log of the largest double: {float(1024 * mp.log(2)).hex()}")
    print(f"log of half the least double: {float(-1075 * mp.log(2)).hex()}")


def exponential(z, p):
    """exp(r) at r = sqrt z from r coth(r / 2) = 2 + z p."""
    r = mp.sqrt(z)
    return 1 + 2 * r / (2 + z * p - r)


if __name__ == "__main__":
    third = mp.mpf(1) / 3
    quarter_turn = (mp.pi / 4) ** 2
    # sin(r) = r + r z S(z), cos(r) = 1 - z/2 + z^2 C(z), atan(t) = t + t z A(z); z the square.
    report("S", ratio(lambda r, z: (mp.sin(r) / r - 1) / z, -third / 2),
           lambda p, z: (1 + z * p) * mp.sqrt(z) / mp.sin(mp.sqrt(z)) - 1, quarter_turn, 6)
    report("C", ratio(lambda r, z: (mp.cos(r) - 1 + z / 2) / z**2, third / 8),
           lambda p, z: (1 - z / 2 + z**2 * p) / mp.cos(mp.sqrt(z)) - 1, quarter_turn, 6)
    report("A", ratio(lambda t, z: (mp.atan(t) / t - 1) / z, -third),
           lambda p, z: (1 + z * p) * mp.sqrt(z) / mp.atan(mp.sqrt(z)) - 1,
           mp.tan(mp.pi / 8) ** 2, 11)
    # r coth(r/2) = 2 + z X(z), from which exp(r) = 1 + 2 r / (r coth(r/2) - r).
    report("X", ratio(lambda r, z: (r * mp.coth(r / 2) - 2) / z, third / 2),
           lambda p, z: exponential(z, p) / mp.exp(mp.sqrt(z)) - 1, (mp.log(2) / 2) ** 2, 5)
    # log((1 + s) / (1 - s)) = 2 s + s z L(z), |s| <= (sqrt 2 - 1) / (sqrt 2 + 1).
    report("L", ratio(lambda s, z: (2 * mp.atanh(s) / s - 2) / z, 2 * third),
           lambda p, z: (2 + z * p) * mp.sqrt(z) / (2 * mp.atanh(mp.sqrt(z))) - 1,
           (3 - 2 * mp.sqrt(2)) ** 2, 7)
    print_parts()
