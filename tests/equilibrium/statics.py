"""Where a tool rests that a hand holds against a scene, and what the hand feels: the exact statics of the contact problem.

    minimise  kt/2 |p_G - p_H|^2 + kr/2 |log(q_G q_H^-1)|^2 + sum of the strings' energies    over the pose of G and the strings' vertices
    subject to  gap >= 0  of every sphere of the tool to every obstacle

kt may be one number per axis of W, kr one per axis of the tool, on the rotation vector in the hand's frame.

A string that yields goes straight from its ends to one vertex P, with the energy T ext + E A ext^2 / (2 L), ext = |AP| + |PB| - L; its
derivative across the axis is Eq. 10 to 12 with the exact sine. Nothing here is the product's: another method (a quasi-Newton program along
the hand's way, then Newton's method on the optimality conditions), no skin, no margin, no linearised rows kept. SI, frame W.
"""
import numpy as np
from scipy.optimize import minimize

MM = 1e-3
# Pairs further apart than this at the start of a solve are left out of it; the result is checked against all of them, m.
NEAR_M = 0.03
# What a solution must reach: the residuals of balance, N, and of touching, m.
BALANCE_N, TOUCHING_M = 1e-7, 1e-11


class NoRest(Exception):
    """No stable rest was found."""


def cross_matrix(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def rotation(w):
    """exp of the rotation vector w."""
    angle = np.linalg.norm(w)
    k = cross_matrix(w)
    if angle < 1e-6:
        return np.eye(3) + k + k @ k / 2
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * k @ k


def turn_of(w):
    """J with d exp(w) = [J dw]x exp(w)."""
    angle = np.linalg.norm(w)
    k = cross_matrix(w)
    if angle < 1e-4:
        return np.eye(3) + k / 2 + k @ k / 6
    return np.eye(3) + (1 - np.cos(angle)) / angle**2 * k + (angle - np.sin(angle)) / angle**3 * k @ k


class String:
    """A string from a to b: radius, tension T in N, axial stiffness E A in N."""

    def __init__(self, a, b, radius, tension, axial):
        self.a, self.b = np.array(a, float), np.array(b, float)
        self.radius, self.tension, self.axial = radius, tension, axial
        self.length = np.linalg.norm(self.b - self.a)
        self.axis = (self.b - self.a) / self.length

    def energy(self, p):
        """(J, gradient in N) with the vertex at p."""
        total, gradient = 0.0, np.zeros(3)
        along = (p - self.a) @ self.axis
        across = p - self.a - along * self.axis
        for end, run in ((self.a, along), (self.b, self.length - along)):
            leg = np.linalg.norm(p - end)
            # leg - run, without the difference of nearly equal numbers.
            total += across @ across / (leg + run) if run > 0 else leg - run
            gradient += (p - end) / leg
        pull = self.tension + self.axial * total / self.length
        return self.tension * total + self.axial * total**2 / (2 * self.length), pull * gradient

    def nearest(self, c):
        """The point of the axis nearest to c."""
        return self.a + np.clip((c - self.a) @ self.axis, 1e-9, self.length - 1e-9) * self.axis


class Scene:
    """spheres: (centre in G, radius) of the tool; bodies: (centre, radius); lines: (a, b, radius); strings: String; axes: six stiffnesses,
    N/m along those of W and N m/rad about those of the tool, in place of kt and length."""

    def __init__(self, spheres, bodies=(), lines=(), strings=(), kt=1000.0, length=0.032, axes=None):
        self.axes = axes
        if axes is not None:
            kt, length = max(axes[:3]), np.sqrt(max(axes[3:]) / max(axes[:3]))
        self.centres = np.array([c for c, _ in spheres], float)
        self.radii = np.array([r for _, r in spheres], float)
        self.bodies, self.lines, self.strings = list(bodies), list(lines), list(strings)
        self.kt, self.kr = kt, kt * length**2
        self.length = length
        # Of each axis, as a share of the stiffest.
        self.along = np.ones(3) if axes is None else np.array(axes[:3]) / kt
        self.about = np.ones(3) if axes is None else np.array(axes[3:]) / max(axes[3:])


def segment(c, a, b):
    """(share, vector to c) of the point of a-b nearest to c."""
    way = b - a
    size = way @ way
    share = np.clip((c - a) @ way / size, 0.0, 1.0) if size > 0 else 0.0
    return share, c - a - share * way


class Problem:
    """The program for one pose of the hand. x: p_G - p_H in mm; rotation vector times length in mm; a vertex per string in mm from its
    start `base`. The energy is in kt mm^2."""

    def __init__(self, scene, hand, base, fat=0.0):
        self.scene, self.fat = scene, fat
        self.p, self.rotation = np.array(hand[0], float), np.array(hand[1], float)
        self.base = [np.array(p, float) for p in base]
        self.size = 6 + 3 * len(scene.strings)
        self.about = self.rotation @ np.diag(scene.about) @ self.rotation.T

    def parts(self, x):
        return x[:3] * MM, x[3:6] * MM / self.scene.length, [p + x[6 + 3 * k:9 + 3 * k] * MM for k, p in enumerate(self.base)]

    def energy(self, x):
        scale = self.scene.kt * MM**2
        pull = np.concatenate((self.scene.along * x[:3], self.about @ x[3:6]))
        value, gradient = 0.5 * x[:6] @ pull, np.concatenate((pull, np.zeros(self.size - 6)))
        for k, p in enumerate(self.parts(x)[2]):
            energy, slope = self.scene.strings[k].energy(p)
            value += energy / scale
            gradient[6 + 3 * k:9 + 3 * k] = slope * MM / scale
        return value, gradient

    def gaps(self, x, pairs=None):
        """(gaps in mm, gradients, the pairs): all pairs, or those given."""
        shift, w, vertices = self.parts(x)
        turn, lever = turn_of(w), (rotation(w) @ self.rotation @ self.scene.centres.T).T
        centres = self.p + shift + lever
        out, slopes, keys = [], [], []

        def add(key, sphere, offset, radius, string=None, share=0.0):
            distance = np.linalg.norm(offset)
            n = offset / distance
            slope = np.zeros(self.size)
            slope[:3] = n
            slope[3:6] = turn.T @ np.cross(lever[sphere], n) / self.scene.length
            if string is not None:
                slope[6 + 3 * string:9 + 3 * string] = -share * n
            out.append((distance - radius - self.scene.radii[sphere] - self.fat) / MM)
            slopes.append(slope)
            keys.append(key)

        for key in pairs if pairs is not None else self.all_pairs():
            kind, number, sphere = key
            c = centres[sphere]
            if kind == "body":
                centre, radius = self.scene.bodies[number]
                add(key, sphere, c - np.asarray(centre), radius)
            elif kind == "line":
                a, b, radius = self.scene.lines[number]
                add(key, sphere, segment(c, np.asarray(a), np.asarray(b))[1], radius)
            else:
                string, p = self.scene.strings[number], vertices[number]
                if kind == "leg a":
                    share, offset = segment(c, string.a, p)
                else:
                    share, offset = segment(c, p, string.b)
                    share = 1 - share
                add(key, sphere, offset, string.radius, number, share)
        return np.array(out), np.array(slopes).reshape(-1, self.size), keys

    def all_pairs(self):
        for sphere in range(len(self.scene.radii)):
            for kind, count in (("body", len(self.scene.bodies)), ("line", len(self.scene.lines)), ("leg a", len(self.scene.strings)),
                                ("leg b", len(self.scene.strings))):
                for number in range(count):
                    yield kind, number, sphere

    def near(self, x):
        gaps, _, keys = self.gaps(x)
        return [key for gap, key in zip(gaps, keys) if gap * MM < NEAR_M]


class Rest:
    """A solution: p_G, force and torque (about G) on the hand, vertices, multipliers by pair, and how good it is."""

    def __init__(self, problem, x, active, multipliers):
        scene = problem.scene
        shift, w, self.vertices = problem.parts(x)
        self.p_G = problem.p + shift
        self.R_G = rotation(w) @ problem.rotation
        self.force = scene.kt * scene.along * shift
        self.torque = scene.kr * np.linalg.solve(turn_of(w).T, problem.about @ w)
        self.x = x
        unit = scene.kt * MM
        self.touching = dict(zip(active, multipliers * unit))
        gaps, slopes, _ = problem.gaps(x, active)
        rest = problem.energy(x)[1] - (slopes.T @ multipliers if len(active) else 0.0)
        self.balance = unit * np.abs(rest).max()
        self.worst_touch = MM * np.abs(gaps).max(initial=0.0)
        every = problem.gaps(x)[0]
        self.smallest_gap = MM * every.min(initial=1.0)


def hessian(problem, x, active, multipliers):
    """Of the Lagrangian, by central differences of its exact gradient."""
    def gradient(at):
        slope = problem.energy(at)[1]
        return slope - (problem.gaps(at, active)[1].T @ multipliers if len(active) else 0.0)

    h = 1e-4
    columns = [(gradient(x + h * e) - gradient(x - h * e)) / (2 * h) for e in np.eye(problem.size)]
    matrix = np.array(columns).T
    return 0.5 * (matrix + matrix.T)


def polish(problem, x, near):
    """Newton's method on the optimality conditions from x on; the set of pairs that touch changes as signs demand."""
    gaps, slopes, keys = problem.gaps(x, near)
    chosen = gaps < 2e-3
    if chosen.any():
        gradient = problem.energy(x)[1]
        guess = np.linalg.lstsq(slopes[chosen].T, gradient, rcond=None)[0]
    else:
        guess = np.zeros(0)
    active = [key for key, take in zip(keys, chosen) if take]
    multipliers = guess
    for _ in range(60):
        gaps, slopes, _ = problem.gaps(x, active)
        gradient = problem.energy(x)[1]
        residual = np.concatenate((gradient - (slopes.T @ multipliers if len(active) else 0.0), gaps))
        count = len(active)
        matrix = np.zeros((problem.size + count,) * 2)
        matrix[:problem.size, :problem.size] = hessian(problem, x, active, multipliers)
        if count:
            matrix[:problem.size, problem.size:] = -slopes.T
            matrix[problem.size:, :problem.size] = slopes
        step = np.linalg.lstsq(matrix, -residual, rcond=1e-13)[0]
        step *= min(1.0, 0.5 / np.abs(step[:problem.size]).max(initial=1e-30))
        x = x + step[:problem.size]
        multipliers = multipliers + step[problem.size:]
        # A pair that would have to pull is let go; one that is entered is taken in.
        if count and multipliers.min() < -1e-9:
            drop = int(np.argmin(multipliers))
            active.pop(drop)
            multipliers = np.delete(multipliers, drop)
            continue
        every, _, keys = problem.gaps(x, near)
        worst = int(np.argmin(every)) if len(keys) else -1
        if worst >= 0 and every[worst] < -1e-9 and keys[worst] not in active:
            active.append(keys[worst])
            multipliers = np.append(multipliers, 0.0)
            continue
        if np.abs(step).max() < 1e-13:
            break
    return x, active, multipliers


def stable(problem, x, active, multipliers):
    """True where the energy grows along every way that keeps what bears force in touch."""
    bearing = [key for key, mu in zip(active, multipliers) if mu > 1e-9]
    if not bearing:
        return True
    matrix = hessian(problem, x, active, multipliers)
    _, slopes, _ = problem.gaps(x, bearing)
    _, values, rows = np.linalg.svd(slopes)
    free = rows[np.count_nonzero(values > 1e-9 * values[0]):]
    # A vertex that bears nothing may stand anywhere on its axis: that way costs nothing.
    return len(free) == 0 or np.linalg.eigvalsh(free @ matrix @ free.T).min() > -1e-7


def solve(scene, hand, x=None, base=None, fat=0.0):
    """The rest next to x for the hand (p, R). `fat` makes every surface so much fatter, m: a control."""
    if base is None:
        base = [string.nearest(np.asarray(hand[0])) for string in scene.strings]
    problem = Problem(scene, hand, base, fat)
    x = np.zeros(problem.size) if x is None else np.array(x, float)
    near = problem.near(x)
    if near:
        found = minimize(problem.energy, x, jac=True, method="SLSQP", options={"ftol": 1e-13, "maxiter": 300},
                         constraints={"type": "ineq", "fun": lambda at: problem.gaps(at, near)[0],
                                      "jac": lambda at: problem.gaps(at, near)[1]})
        x = found.x
    x, active, multipliers = polish(problem, x, near)
    rest = Rest(problem, x, active, multipliers)
    if rest.balance > BALANCE_N or rest.worst_touch > TOUCHING_M or rest.smallest_gap < -TOUCHING_M:
        raise NoRest(f"balance {rest.balance:.1e} N, touching {rest.worst_touch:.1e} m, entered {-rest.smallest_gap:.1e} m")
    if not stable(problem, x, active, multipliers):
        raise NoRest("the balance is not stable")
    return rest


def follow(scene, hands, fat=0.0):
    """The rests along a way of the hand, each begun where the one before was: [Rest]. The first pose is free. A rest that ends between two
    poses, as the tool snaps aside, may be stepped over where they are far apart."""
    rests, x, before = [], None, None
    base = [string.nearest(np.asarray(hands[0][0])) for string in scene.strings]
    for p, R in hands:
        if before is not None:
            # The tool stays where it was while the hand moves on.
            x = carried(scene, x, before, (p, R))
        rests.append(solve(scene, (p, R), x, base, fat))
        x, before = rests[-1].x, (p, R)
    return rests


def carried(scene, x, before, now):
    """x of the same place of tool and strings for the hand at `now`."""
    x = x.copy()
    w = x[3:6] * MM / scene.length
    R_G = rotation(w) @ np.asarray(before[1])
    x[:3] += (np.asarray(before[0]) - np.asarray(now[0])) / MM
    x[3:6] = rotation_vector(R_G @ np.asarray(now[1]).T) * scene.length / MM
    return x


def rotation_vector(R):
    """log of R, for less than half a turn."""
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine, cosine = np.linalg.norm(v), (np.trace(R) - 1) / 2
    angle = np.arctan2(sine, cosine)
    return v if sine < 1e-12 else v * angle / sine


def quaternion(R):
    """w x y z of R."""
    w = rotation_vector(R)
    angle = np.linalg.norm(w)
    return np.concatenate(([np.cos(angle / 2)], w * (np.sin(angle / 2) / angle if angle > 1e-12 else 0.5)))
