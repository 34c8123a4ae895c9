"""What the proofs need of algebra. Each lemma is shown once, for all real numbers, by z3's solver for polynomials; the code then only has to
meet its premises."""
import z3

MOST_STEPS = 20_000_000


def between(part, whole):
    """part lies between 0 and whole."""
    return z3.Or(z3.And(part >= 0, part <= whole), z3.And(part <= 0, part >= whole))


def square_of_part(part, whole):
    return [between(part, whole)], part * part <= whole * whole


def shortened(q, v, length, most):
    """Three components, cut to the share most / length of themselves or less, are together no longer than most."""
    premises = [length > 0, most >= 0, v[0] * v[0] + v[1] * v[1] + v[2] * v[2] <= length * length]
    premises += [(q[i] * length) * (q[i] * length) <= (v[i] * most) * (v[i] * most) for i in range(3)]
    return premises, q[0] * q[0] + q[1] * q[1] + q[2] * q[2] <= most * most


def share(part, whole, length, most):
    """The share most / length of something, rounded toward zero, is a part of it."""
    return [length > 0, most >= 0, most * most <= length * length, between(part * length, whole * most)], between(part, whole)


def part_of_part(part, half, whole):
    return [between(part, half), between(half, whole)], between(part, whole)


def component(a, b, c, most):
    """Each component is no longer than the whole."""
    return [most >= 0, a * a + b * b + c * c <= most * most], z3.And(a <= most, a >= -most)


def long_component(a, b, c, most):
    """One component beyond most is enough."""
    return [most >= 0, z3.Or(a > most, a < -most)], a * a + b * b + c * c > most * most


def plane(p, q, r, u, v):
    """Two variables: no negative minor, no negative value."""
    return [p >= 0, r >= 0, p * r >= q * q], p * u * u + 2 * q * u * v + r * v * v >= 0


def divided(a, b):
    return [a > 0, a * b >= 0], b >= 0


def minors_of(k):
    """Of the symmetric matrix xx, yy, zz, xy, xz, yz: all principal minors, the determinant by the rule of Sarrus."""
    xx, yy, zz, xy, xz, yz = k
    return [xx, yy, zz, xx * yy - xy * xy, xx * zz - xz * xz, yy * zz - yz * yz,
            xx * yy * zz + xy * yz * xz + xz * xy * yz - xz * yy * xz - xx * yz * yz - xy * xy * zz]


def form_of(k, u, v, w):
    """What K gives along (u, v, w): twice the energy."""
    xx, yy, zz, xy, xz, yz = k
    return xx * u * u + yy * v * v + zz * w * w + 2 * (xy * u * v + xz * u * w + yz * v * w)


def valid(premises, conclusion):
    solver = z3.Tactic("qfnra-nlsat").solver()
    solver.set("rlimit", MOST_STEPS)
    solver.add(*premises, z3.Not(conclusion))
    return solver.check() == z3.unsat


def identical(left, right):
    """Equal as polynomials."""
    return z3.is_true(z3.simplify(left - right == 0, som=True, flat=True))


def all_valid():
    """{name: whether it was shown}."""
    a, b, c, m, u, v, w = z3.Reals("a b c m u v w")
    q, x = z3.Reals("q0 q1 q2"), z3.Reals("x0 x1 x2")
    found = {"square_of_part": valid(*square_of_part(a, b)), "shortened": valid(*shortened(q, x, b, m)),
             "share": valid(*share(a, b, c, m)), "part_of_part": valid(*part_of_part(a, b, c)), "component": valid(*component(a, b, c, m)),
             "long_component": valid(*long_component(a, b, c, m)), "plane": valid(*plane(a, b, c, u, v)), "divided": valid(*divided(a, b))}
    found["minors"] = minors_suffice()
    return found


def minors_suffice():
    """No principal minor of K below zero: K gives nothing along any (u, v, w). Where xx is 0, xy and xz are too, and a plane is left. Else xx
    times the form is a square and a form of two variables, whose minors are xx times those of K."""
    k = xx, yy, zz, xy, xz, yz = z3.Reals("xx yy zz xy xz yz")
    u, v, w = z3.Reals("u v w")
    minors, form = minors_of(k), form_of(k, u, v, w)
    premises = [minor >= 0 for minor in minors]
    p, q, r = xx * yy - xy * xy, xx * yz - xy * xz, xx * zz - xz * xz
    row = xx * u + xy * v + xz * w
    steps = [identical(xx * form, row * row + p * v * v + 2 * q * v * w + r * w * w), identical(p * r - q * q, xx * minors[6])]
    rest = z3.Real("rest")  # the form of two variables, not negative by `plane`
    steps.append(valid([xx > 0, rest >= 0, xx * form == row * row + rest], form >= 0))
    det = z3.Real("det")
    steps.append(valid([xx > 0, det >= 0], xx * det >= 0))
    steps.append(valid([*premises, xx == 0], form >= 0))
    return all(steps)
