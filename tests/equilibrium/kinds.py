"""The kinds of contact that are compared with the exact statics: press, wedge, lever, capsule end, strings, string and body at once, contact
switch, slides; each as random cases around a nominal one. SI, frame W: y up, lines and strings along x."""
import math

import numpy as np

import statics

TIP = 0.005
STRING_RADIUS = 0.34e-3
STEEL_PA = 1.9e11
# The hand comes at this speed, then rests for so many ticks.
APPROACH_M_PER_S, SLIDE_M_PER_S, REST_TICKS = 0.05, 0.02, 120
# Of a way to a place of rest: rests between two corners; more where axes that differ let the tool snap aside on its way, so that the oracle
# does not step over what the tool cannot. Of a slide: every so many ticks.
STEPS, FINE_STEPS, EVERY = 5, 40, 50


class Case:
    """A scene and the hand's way, corner by corner (p, rotation vector). `moving`: the last leg is judged tick by tick at 20 mm/s; otherwise
    the rest at the last corner is."""

    def __init__(self, kind, scene, corners, moving=False, nothing=False):
        self.kind, self.scene, self.moving, self.nothing = kind, scene, moving, nothing
        self.corners = [(np.array(p, float), np.array(w, float)) for p, w in corners]

    def leg(self, k, count):
        """`count` poses (p, R) on the way from corner k, without it, to the next."""
        (p, w), (p1, w1) = self.corners[k], self.corners[k + 1]
        return [(p + (p1 - p) * i / count, statics.rotation(w + (w1 - w) * i / count)) for i in range(1, count + 1)]

    def ticks(self, k):
        (p, w), (p1, w1) = self.corners[k], self.corners[k + 1]
        speed = SLIDE_M_PER_S if self.moving and k == len(self.corners) - 2 else APPROACH_M_PER_S
        return max(1, math.ceil((np.linalg.norm(p1 - p) + 0.05 * np.linalg.norm(w1 - w)) / (1e-3 * speed)))

    def poses(self):
        """Of the hand, one a tick."""
        p, w = self.corners[0]
        out = [(p, statics.rotation(w))] * 3
        for k in range(len(self.corners) - 1):
            if self.moving and k == len(self.corners) - 2:
                out += [out[-1]] * REST_TICKS
            out += self.leg(k, self.ticks(k))
        return out if self.moving else out + [out[-1]] * REST_TICKS

    def rows(self):
        return [[*p, *statics.quaternion(R)] for p, R in self.poses()]

    def truths(self, fat=0.0, steps=None):
        """([index of a tick], [Rest]) that are judged."""
        steps = steps or (STEPS if self.scene.axes is None else FINE_STEPS)
        p, w = self.corners[0]
        way = [(p, statics.rotation(w))]
        last = len(self.corners) - 2
        for k in range(last + (0 if self.moving else 1)):
            way += self.leg(k, steps)
        if not self.moving:
            return [len(self.poses()) - 1], [statics.follow(self.scene, way, fat)[-1]]
        count = self.ticks(last)
        slide = self.leg(last, count)
        chosen = list(range(0, count, EVERY))
        rests = statics.follow(self.scene, way + [slide[i] for i in chosen], fat)[len(way):]
        first = len(self.poses()) - count
        return [first + i for i in chosen], rests


def steel(random, a, b):
    tension = random.uniform(20, 80)
    return statics.String(a, b, STRING_RADIUS, tension, STEEL_PA * math.pi * STRING_RADIUS**2)


NONE = (0.0, 0.0, 0.0)


def press_line(random):
    x, z, turn = random.uniform(-0.3, 0.3), random.uniform(-2.5e-3, 2.5e-3), random.uniform(-0.4, 0.4)
    radius = random.uniform(0.2e-3, 8e-3)
    axis = np.array([math.cos(turn), 0, math.sin(turn)])
    height = math.sqrt((TIP + radius) ** 2 - z * z)
    across = np.array([-math.sin(turn), 0, math.cos(turn)])
    above = x * axis + z * across
    depth = random.uniform(0.2e-3, 3e-3)
    scene = statics.Scene([((0, 0, 0), TIP)], lines=[(-0.5 * axis, 0.5 * axis, radius)], kt=random.choice([200.0, 1000.0, 3000.0]))
    return Case("press", scene, [(above + [0, height + 2e-3, 0], NONE), (above + [0, height - depth, 0], NONE)])


def press_wall(random):
    spot = np.array([random.uniform(-0.05, 0.05), 0, random.uniform(-0.05, 0.05)])
    scene = statics.Scene([((0, 0, 0), TIP)], bodies=[((0, -1000, 0), 1000.0)])
    return Case("wall", scene, [(spot + [0, TIP + 2e-3, 0], NONE), (spot + [0, TIP - random.uniform(0.2e-3, 3e-3), 0], NONE)])


def press_ball(random):
    n = random.normal(size=3)
    n /= np.linalg.norm(n)
    radius = random.uniform(0.01, 0.05)
    aside = np.cross(n, random.normal(size=3)) * 0.01
    scene = statics.Scene([((0, 0, 0), TIP)], bodies=[((0, 0, 0), radius)])
    return Case("ball", scene, [((radius + TIP + 2e-3) * n, NONE), ((radius + TIP - random.uniform(0.2e-3, 3e-3)) * n + aside * 0.1, NONE)])


def wedge(random):
    half, skew = random.uniform(1e-3, 5e-3), random.uniform(-2e-3, 2e-3)
    lines = [((-0.5, 0, half), (0.5, 0, half + skew), STRING_RADIUS), ((-0.5, 0, -half), (0.5, 0, -half - skew), STRING_RADIUS)]
    height = math.sqrt((TIP + STRING_RADIUS) ** 2 - half**2)
    aside = random.uniform(-0.2, 0.2) * 1e-3
    scene = statics.Scene([((0, 0, 0), TIP)], lines=lines)
    return Case("wedge", scene, [((0.02, height + 3e-3, aside), NONE), ((0.02, height - random.uniform(1e-3, 3e-3), aside), NONE)])


def lever(random):
    arm = random.uniform(0.02, 0.08)
    scene = statics.Scene([((arm, 0, 0), TIP)], lines=[((0, 0, -0.5), (0, 0, 0.5), STRING_RADIUS)], length=random.uniform(0.02, 0.06))
    x, top = -arm + random.uniform(-1e-3, 1e-3), TIP + STRING_RADIUS
    return Case("lever", scene, [((x, top + 3e-3, 0), NONE), ((x, top - random.uniform(0.5e-3, 4e-3), random.uniform(-1e-3, 1e-3)), NONE)])


def twisted(random):
    """A bar of three spheres, turned and pressed between two lines that are askew."""
    spheres = [((-0.03, 0, 0), TIP), ((0, 0, 0), TIP), ((0.03, 0, 0), TIP)]
    lines = [((-0.028, 0, -0.3), (-0.026, 0, 0.3), 1e-3), ((0.033, -1e-3, -0.3), (0.031, 1e-3, 0.3), 2e-3)]
    turn = random.uniform(-0.08, 0.08, 3)
    scene = statics.Scene(spheres, lines=lines)
    return Case("bar", scene, [((0, 0.012, 0), NONE), ((0, 0.012, 0), turn), ((random.uniform(-2e-3, 2e-3), 0.006 - random.uniform(0.5e-3, 3e-3), 0), turn)])


def capsule_end(random):
    """Onto the round end of a line, from beyond it."""
    radius = random.uniform(0.3e-3, 4e-3)
    s = TIP + radius
    lean, round_ = random.uniform(0.1, 1.3), random.uniform(-0.5, 0.5)
    n = np.array([math.sin(lean), math.cos(lean) * math.cos(round_), math.cos(lean) * math.sin(round_)])
    depth = random.uniform(0.2e-3, 0.4 * s)
    scene = statics.Scene([((0, 0, 0), TIP)], lines=[((-0.5, 0, 0), (0, 0, 0), radius)])
    return Case("capsule end", scene, [((s + 2e-3) * n, NONE), ((s - depth) * n + [random.uniform(-1e-3, 1e-3), 0, 0], NONE)])


def string_press(random):
    string = steel(random, (-0.55, 0, 0), (0.55, 0, 0))
    x, z = random.uniform(-0.5, 0.5), random.uniform(-0.3e-3, 0.3e-3)
    top = TIP + STRING_RADIUS
    scene = statics.Scene([((0, 0, 0), TIP)], strings=[string])
    return Case("string", scene, [((x, top + 2e-3, z), NONE), ((x, top - random.uniform(0.3e-3, 2.5e-3), z), NONE)])


def string_lever(random):
    """A tool that turns as it presses a string off its centre."""
    string = steel(random, (-0.55, 0, 0), (0.55, 0, 0))
    arm = random.uniform(0.01, 0.05)
    x, top = random.uniform(-0.3, 0.3), TIP + STRING_RADIUS
    scene = statics.Scene([((arm, 0, 0), TIP)], strings=[string])
    return Case("string lever", scene, [((x, top + 2e-3, 1e-4), NONE), ((x, top - random.uniform(0.3e-3, 2e-3), 1e-4), NONE)])


def two_strings(random):
    """A tool of two tips on two strings, each under its own, one pressed deeper."""
    strings = [steel(random, (-0.55, 0, z), (0.55, 0, z)) for z in (-0.01, 0.01)]
    scene = statics.Scene([((0, 0, -0.01), TIP), ((0, 0, 0.01), TIP)], strings=strings)
    x, top = random.uniform(-0.3, 0.3), TIP + STRING_RADIUS
    turn = (random.uniform(-0.02, 0.02), 0, 0)
    return Case("two strings", scene, [((x, top + 2e-3, 0), turn), ((x, top - random.uniform(0.5e-3, 2e-3), 0), turn)])


def coupled(random):
    """The tip lies on a wall and bends a string at once."""
    string = steel(random, (-0.55, 0, 0), (0.55, 0, 0))
    floor = -random.uniform(5e-3, 6.5e-3)
    scene = statics.Scene([((0, 0, 0), TIP)], bodies=[((0, floor - 1000 + 3e-3, 0), 1000.0)], strings=[string])
    x = random.uniform(-0.4, 0.4)
    # The wall stops the tip's centre at floor + 3 mm + 5 mm; the string is met at 5.34 mm.
    y = floor + 3e-3 + TIP - random.uniform(0.5e-3, 2e-3)
    return Case("coupled", scene, [((x, TIP + STRING_RADIUS + 2e-3, 1e-4), NONE), ((x, y, 1e-4), NONE)])


def coupled_lever(random):
    """A bar of two tips: one on a line, one on a string."""
    string = steel(random, (-0.55, 0, 0.02), (0.55, 0, 0.02))
    scene = statics.Scene([((0, 0, -0.02), TIP), ((0, 0, 0.02), TIP)], lines=[((-0.5, 0, -0.02), (0.5, 0, -0.02), STRING_RADIUS)], strings=[string])
    x, top = random.uniform(-0.3, 0.3), TIP + STRING_RADIUS
    return Case("coupled lever", scene, [((x, top + 2e-3, 1e-4), NONE), ((x, top - random.uniform(0.5e-3, 2e-3), 1e-4), NONE)])


def zero_overlap(random):
    """Just in touch with a line, a ball or a string: nothing is to be felt."""
    top = TIP + STRING_RADIUS
    x = random.uniform(-0.3, 0.3)
    choice = int(random.integers(3))
    if choice == 0:
        scene = statics.Scene([((0, 0, 0), TIP)], lines=[((-0.5, 0, 0), (0.5, 0, 0), STRING_RADIUS)])
    elif choice == 1:
        x = 0.0
        scene = statics.Scene([((0, 0, 0), TIP)], bodies=[((0, STRING_RADIUS - 0.02, 0), 0.02)])
    else:
        scene = statics.Scene([((0, 0, 0), TIP)], strings=[steel(random, (-0.55, 0, 0), (0.55, 0, 0))])
    return Case("no overlap", scene, [((x, top + 2e-3, 0), NONE), ((x, top, 0), NONE)], nothing=True)


def switch(random):
    """Moving at 20 mm/s from a ball onto a line."""
    depth = random.uniform(0.5e-3, 1.5e-3)
    scene = statics.Scene([((0, 0, 0), TIP)], bodies=[((0, -0.03, -0.012), 0.03)], lines=[((-0.5, -1e-3, 4e-3), (0.5, -1e-3, 4e-3), 2e-3)])
    y = TIP - depth
    return Case("contact switch", scene, [((0, TIP + 3e-3, -0.012), NONE), ((0, y, -0.012), NONE), ((2e-3, y, 2e-3), NONE)], moving=True)


def slide_ball(random):
    radius, depth = random.uniform(0.02, 0.05), random.uniform(0.5e-3, 2e-3)
    scene = statics.Scene([((0, 0, 0), TIP)], bodies=[((0, -radius, 0), radius)])
    y = TIP - depth
    return Case("slide on a ball", scene, [((0, TIP + 3e-3, 0), NONE), ((0, y, 0), NONE), ((0.006, y, 0.003), NONE)], moving=True)


def slide_string(random):
    string = steel(random, (-0.55, 0, 0), (0.55, 0, 0))
    x, y = random.uniform(-0.4, 0.4), TIP + STRING_RADIUS - random.uniform(0.5e-3, 2e-3)
    scene = statics.Scene([((0, 0, 0), TIP)], strings=[string])
    return Case("slide along a string", scene, [((x, y + 4e-3, 1e-4), NONE), ((x, y, 1e-4), NONE), ((x + 0.02, y, 1e-4), NONE)], moving=True)


def slide_lever(random):
    arm = random.uniform(0.02, 0.06)
    scene = statics.Scene([((arm, 0, 0), TIP)], lines=[((0, 0, -0.5), (0, 0, 0.5), 3e-3)])
    y = TIP + 3e-3 - random.uniform(0.5e-3, 2e-3)
    return Case("slide, turning", scene, [((-arm, y + 4e-3, 0), NONE), ((-arm, y, 0), NONE), ((-arm + 1.5e-3, y, 0.01), NONE)], moving=True)


def uneven(random):
    """Six stiffnesses, the stiffest of each three up to 1000 times the softest."""
    out = []
    for stiffest in (1000.0, random.uniform(0.5, 4.0)):
        ratio = 10 ** random.uniform(0, 3)
        out += list(random.permutation([stiffest, stiffest / ratio, stiffest * ratio ** -random.uniform()]))
    return out


def uneven_wall(random):
    """Onto a wall that leans any way: the tool slides along it to where the soft axis takes it."""
    n = random.normal(size=3)
    n /= np.linalg.norm(n)
    scene = statics.Scene([((0, 0, 0), TIP)], bodies=[(-1000 * n, 1000.0)], axes=uneven(random))
    turn = random.uniform(-1, 1, 3)
    return Case("uneven wall", scene, [((TIP + 2e-3) * n, turn), ((TIP - random.uniform(0.2e-3, 3e-3)) * n, turn)])


def uneven_bar(random):
    """A bar of three spheres, turned and pressed between two lines that are askew, held by axes that differ."""
    case = twisted(random)
    scene = statics.Scene(list(zip(case.scene.centres, case.scene.radii)), lines=case.scene.lines, axes=uneven(random))
    return Case("uneven bar", scene, case.corners)


def uneven_string(random):
    """A tool that turns as it presses a string off its centre, held by axes that differ. Of half the draws the oracle finds no rest: not RESTING."""
    case = string_lever(random)
    scene = statics.Scene(list(zip(case.scene.centres, case.scene.radii)), strings=case.scene.strings, axes=uneven(random))
    return Case("uneven string", scene, case.corners)


RESTING = [press_line, press_wall, press_ball, wedge, lever, twisted, capsule_end, string_press, string_lever, two_strings, coupled,
           coupled_lever, uneven_wall, uneven_bar]
MOVING = [switch, slide_ball, slide_string, slide_lever]


def draw(make, seed, count):
    """`count` cases of a kind with their truths [(Case, ticks, rests)]; a draw whose rest is not stable is drawn again."""
    random, out, refused = np.random.default_rng(seed), [], 0
    while len(out) < count:
        case = make(random)
        try:
            ticks, rests = case.truths()
        except statics.NoRest:
            refused += 1
            if refused > 5 * count + 5:
                raise
            continue
        out.append((case, ticks, rests))
    return out
