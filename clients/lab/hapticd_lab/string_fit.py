"""Eq. 8-13 fitted to a measured session by least squares: T, E A and the contact distance from presses; k_v r_max, T_d and omega from touches
of the vibrating string. What enters the equations only as a product is fitted as the product."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence

import numpy
from scipy import optimize, signal, stats

from hapticd_lab import string_law
from hapticd_lab.measured import FREE, PRESS, RING, Measured

TOUCH_SHARE, SILENT_SHARE = 0.12, 0.04
"""Of the largest force: beyond the first the string is touched for sure, and from there on as long as it stays beyond the second, where the
file does not say the phase."""
LEAST_TOUCH_S = 0.02
"""Shorter touches, and shorter gaps in them, are noise or a swing of the string."""
MEDIAN_SAMPLES = 5
LEAST_SAMPLES = 30
LEAST_PRESS_M = 0.002
"""A press that stays below bends the law less than forces are measured: T and E A would stand for each other."""
LEAST_PERIODS = 5.0
CONFIDENCE = 0.95
LOWEST_HZ = 15.0
"""Below it a touch by hand moves by itself."""


class TooLittle(ValueError):
    """The session does not have what the fit needs; the text says what is missing."""


@dataclass(frozen=True)
class Geometry:
    """The string at rest from A to B. `radius_m`, `tip_radius_m`: None where not known."""

    a_m: numpy.ndarray
    b_m: numpy.ndarray
    radius_m: Optional[float] = None
    tip_radius_m: Optional[float] = None

    @property
    def length_m(self) -> float:
        return float(numpy.linalg.norm(self.b_m - self.a_m))


@dataclass(frozen=True)
class Estimate:
    """A parameter with its interval of 95 %; NaN and a reason in `how` where it cannot be told."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    how: str

    @property
    def known(self) -> bool:
        return math.isfinite(self.value)


@dataclass
class Touch:
    """Samples first..last-1 of one contact, all of one phase; `normal` is the direction of its force."""

    phase: str
    rows: slice
    normal: numpy.ndarray = field(default_factory=lambda: numpy.zeros(3))


@dataclass
class Fit:
    """What was found. Per sample of the touches, in order of time: `rows`, `height_m` (axis to fingertip along the normal), `place` (lambda),
    `measured_n`, `model_n` (both along the normal), `deflection_m`, `touch_of`."""

    estimates: List[Estimate]
    touches: List[Touch]
    rows: numpy.ndarray
    place: numpy.ndarray
    deflection_m: numpy.ndarray
    measured_n: numpy.ndarray
    model_n: numpy.ndarray
    across_n: numpy.ndarray
    sigma_n: float
    inflation: float
    correlations: Dict[str, float]

    def estimate(self, name: str) -> Estimate:
        return next(each for each in self.estimates if each.name == name)


def _runs(mask: numpy.ndarray) -> numpy.ndarray:
    """m x 2, ranges [first, last) of consecutive True."""
    return numpy.flatnonzero(numpy.diff(numpy.concatenate(([0], mask.astype(int), [0])))).reshape(-1, 2)


def _touched(measured: Measured) -> numpy.ndarray:
    """n, True where the force says that the string is touched."""
    smooth = signal.medfilt(numpy.linalg.norm(measured.force_n, axis=1), MEDIAN_SAMPLES)
    most = smooth.max(initial=0.0)
    touched = smooth > SILENT_SHARE * most
    for first, last in _runs(~touched):
        if 0 < first and last < len(touched) and measured.t_s[last] - measured.t_s[first] < LEAST_TOUCH_S:
            touched[first:last] = True
    for first, last in _runs(touched):
        if smooth[first:last].max() <= TOUCH_SHARE * most:
            touched[first:last] = False
    return touched


def find_touches(measured: Measured) -> List[Touch]:
    """Touches by the file's phases; without them by the force: the first is a press, later ones are of the vibrating string."""
    label = numpy.array(measured.phase) if measured.phase else numpy.where(_touched(measured), PRESS, FREE)
    touches = []
    edges = [0, *(numpy.flatnonzero(label[1:] != label[:-1]) + 1), len(label)]
    for first, last in zip(edges[:-1], edges[1:]):
        if first < last and label[first] != FREE and measured.t_s[last - 1] - measured.t_s[first] >= LEAST_TOUCH_S:
            phase = str(label[first]) if measured.phase or not touches else RING
            mean = measured.force_n[first:last].sum(axis=0)
            if numpy.linalg.norm(mean) > 0.0:
                touches.append(Touch(phase, slice(int(first), int(last)), mean / numpy.linalg.norm(mean)))
    return touches


class _Session:
    """The samples of all touches as the model sees them."""

    def __init__(self, measured: Measured, place_m: numpy.ndarray, geometry: Geometry, touches: Sequence[Touch]) -> None:
        axis = (geometry.b_m - geometry.a_m) / geometry.length_m
        parts: Dict[str, list] = {name: [] for name in ("rows", "place", "height", "force", "across", "touch", "t")}
        self.touches = list(touches)
        for index, touch in enumerate(self.touches):
            touch.normal = touch.normal - axis * (axis @ touch.normal)
            touch.normal /= max(numpy.linalg.norm(touch.normal), 1e-300)
            rows = numpy.arange(touch.rows.start, touch.rows.stop)
            offset = place_m[rows] - geometry.a_m
            along = offset @ axis / geometry.length_m
            force = measured.force_n[rows]
            normal_force = force @ touch.normal
            for name, values in (("rows", rows), ("place", along), ("height", offset @ touch.normal), ("force", normal_force),
                                 ("across", numpy.linalg.norm(force - normal_force[:, None] * touch.normal, axis=1)),
                                 ("touch", numpy.full(len(rows), index)), ("t", measured.t_s[rows])):
                parts[name].append(values)
        joined = {name: numpy.concatenate(values) for name, values in parts.items()}
        self.rows, self.place, self.height = joined["rows"], joined["place"], joined["height"]
        self.force, self.across, self.touch_of, self.t_s = joined["force"], joined["across"], joined["touch"], joined["t"]
        self.length_m = geometry.length_m
        self.is_ring = numpy.array([self.touches[i].phase == RING for i in self.touch_of])

    def check(self, geometry: Geometry) -> None:
        press = ~self.is_ring
        if press.sum() < LEAST_SAMPLES:
            raise TooLittle(f"{int(press.sum())} samples press the string at rest, {LEAST_SAMPLES} are needed: press it slowly, some millimetres, "
                            "for a second or more")
        if numpy.any((self.place <= 0.0) | (self.place >= 1.0)):
            row = int(self.rows[numpy.flatnonzero((self.place <= 0.0) | (self.place >= 1.0))[0]])
            raise TooLittle(f"sample {row + 1} lies beyond the string's ends: give the ends A and B in the frame of the file")
        depth = float(numpy.ptp(self.height[press]))
        if depth < LEAST_PRESS_M:
            raise TooLittle(f"the press spans {depth * 1e3:.2f} mm, {LEAST_PRESS_M * 1e3:g} mm are needed: press deeper, or the tension and the "
                            "stretching cannot be told apart")
        if numpy.polyfit(self.height[press], self.force[press], 1)[0] > 0.0:
            raise TooLittle("the force grows as the finger leaves the string: give the force on the finger (negate it where the sensor sits "
                            "in the string or the finger's own force was measured)")


def _static(session: _Session, values: numpy.ndarray) -> numpy.ndarray:
    tension, axial, contact = values[:3]
    delta = numpy.maximum(contact - session.height, 0.0)
    sines, strain = string_law.shape(delta, session.place, session.length_m)
    return (tension + axial * strain) * sines


class _Model:
    """Values: T, E A, contact distance; with vibration also k_v r_max, T_d, omega, and a phase for each touch of it."""

    def __init__(self, session: _Session, released_s: Optional[float], pluck_place: float) -> None:
        self.session, self.released_s, self.pluck_place = session, released_s, pluck_place
        self.rings = [i for i, touch in enumerate(session.touches) if touch.phase == RING] if released_s is not None else []
        self.used = ~session.is_ring | numpy.isin(session.touch_of, self.rings)

    def vibration(self, values: numpy.ndarray) -> numpy.ndarray:
        out = numpy.zeros(len(self.session.t_s))
        amplitude, decay, omega = values[3:6]
        for number, index in enumerate(self.rings):
            at = self.session.touch_of == index
            since = self.session.t_s[at] - self.released_s
            share = numpy.minimum(numpy.sin(numpy.pi * self.session.place[at]) / math.sin(math.pi * self.pluck_place), 1.0)
            out[at] = amplitude * share * numpy.exp(-since / decay) * numpy.sin(omega * since + values[6 + number])
        return out

    def __call__(self, values: numpy.ndarray) -> numpy.ndarray:
        force = _static(self.session, values)
        return numpy.maximum(force + self.vibration(values), 0.0) if self.rings else force

    def residuals(self, values: numpy.ndarray) -> numpy.ndarray:
        return (self(values) - self.session.force)[self.used]


def _static_start(session: _Session) -> numpy.ndarray:
    """Starting values, by a grid over the contact distance: for each, T and E A follow linearly."""
    press = ~session.is_ring
    best, cost = None, math.inf
    top = float(session.height[press].max())
    for contact in numpy.linspace(float(numpy.median(session.height[press])), top + 0.002, 60):
        delta = numpy.maximum(contact - session.height[press], 0.0)
        sines, strain = string_law.shape(delta, session.place[press], session.length_m)
        columns = numpy.column_stack((sines, sines * strain))
        scale = numpy.maximum(numpy.linalg.norm(columns, axis=0), 1e-300)
        found, misfit = optimize.nnls(columns / scale, session.force[press])
        if misfit < cost:
            best, cost = numpy.array([*(found / scale), contact]), misfit
    best[0], best[1] = max(best[0], 1e-3), max(best[1], 1.0)
    return best


def _ring_start(session: _Session, rings: Sequence[int], static: numpy.ndarray, released_s: float) -> numpy.ndarray:
    """Starting values of the vibration: the strongest line of the longest touch's periodogram, then amplitude and decay from its envelope."""
    longest = max(rings, key=lambda index: int(numpy.sum(session.touch_of == index)))
    at = session.touch_of == longest
    t_s = session.t_s[at]
    wave = (session.force - _static(session, static))[at]
    wave = wave - wave.mean()
    span, step = float(t_s[-1] - t_s[0]), float(numpy.median(numpy.diff(t_s)))
    rates = numpy.arange(LOWEST_HZ, 0.49 / step, 1.0 / (8.0 * span)) * 2.0 * numpy.pi
    omega = float(rates[numpy.argmax(signal.lombscargle(t_s, wave, rates))])
    if span * omega / (2.0 * numpy.pi) < LEAST_PERIODS:
        raise TooLittle(f"the touch of the vibrating string lasts {span * omega / (2.0 * numpy.pi):.1f} periods, {LEAST_PERIODS:g} are needed: "
                        "touch it longer")
    best, cost = None, math.inf
    for decay in numpy.geomspace(0.2 * span, 20.0 * span, 25):
        envelope = numpy.exp(-(t_s - released_s) / decay)
        columns = numpy.column_stack((envelope * numpy.sin(omega * (t_s - released_s)), envelope * numpy.cos(omega * (t_s - released_s))))
        found, misfit, _, _ = numpy.linalg.lstsq(columns, wave, rcond=None)
        if len(misfit) and misfit[0] < cost:
            best, cost = (decay, *found), float(misfit[0])
    amplitude, phase = math.hypot(best[1], best[2]), math.atan2(best[2], best[1])
    return numpy.array([amplitude, best[0], omega, *([phase] * len(rings))])


def _release(session: _Session) -> Optional[tuple]:
    """(instant, place) at which the string was left, and began to vibrate: the end of the last press before the first touch of it."""
    rings = numpy.flatnonzero(session.is_ring)
    before = numpy.flatnonzero(~session.is_ring & (session.rows < session.rows[rings[0]])) if len(rings) else []
    return (float(session.t_s[before[-1]]), float(session.place[before[-1]])) if len(before) else None


@dataclass
class Solved:
    """Least squares with its covariance."""

    values: numpy.ndarray
    covariance: numpy.ndarray
    sigma_n: float
    inflation: float
    quantile: float

    def half_width(self, gradient: numpy.ndarray) -> float:
        """Half of the interval of a quantity with that gradient in the values."""
        variance = float(gradient @ self.covariance @ gradient)
        return self.quantile * math.sqrt(variance) if variance >= 0.0 else math.nan


def solve(model: _Model, start: numpy.ndarray) -> Solved:
    """From the starting values. Residuals that follow each other count as fewer: the covariance is inflated by (1 + r) / (1 - r), r being
    their correlation from sample to sample, where r is above what chance gives."""
    scale = numpy.maximum(numpy.abs(start), 1e-6)
    scale[6:] = 1.0  # phases
    lower = numpy.full(len(start), -numpy.inf)
    lower[:2] = 0.0
    lower[3:6] = 0.0
    found = optimize.least_squares(lambda scaled: model.residuals(scaled * scale), start / scale, bounds=(lower / scale, numpy.inf),
                                   x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=400)
    free = len(found.fun) - len(start)
    variance = float(found.fun @ found.fun) / free
    follow = float(found.fun[1:] @ found.fun[:-1] / (found.fun @ found.fun)) if variance > 0.0 else 0.0
    inflation = (1.0 + follow) / (1.0 - follow) if follow > 2.0 / math.sqrt(len(found.fun)) else 1.0
    inverse = numpy.linalg.pinv(found.jac.T @ found.jac)
    return Solved(found.x * scale, inflation * variance * inverse * numpy.outer(scale, scale), math.sqrt(variance), inflation,
                  float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, free)))


def _estimate(solved: Solved, name: str, unit: str, value: float, gradient: Dict[int, float], how: str) -> Estimate:
    row = numpy.zeros(len(solved.values))
    for index, slope in gradient.items():
        row[index] = slope
    half = solved.half_width(row)
    return Estimate(name, unit, value, value - half, value + half, how)


def _unknown(name: str, unit: str, why: str) -> Estimate:
    return Estimate(name, unit, math.nan, math.nan, math.nan, why)


def _static_estimates(solved: Solved, geometry: Geometry) -> List[Estimate]:
    tension, axial, contact = solved.values[:3]
    out = [_estimate(solved, "T", "N", tension, {0: 1.0}, "fitted"),
           _estimate(solved, "EA", "N", axial, {1: 1.0}, "fitted; E and R enter the force only as E A = E pi R^2"),
           _estimate(solved, "contact_distance", "m", contact, {2: 1.0}, "fitted; fingertip radius + R, and what A and B are off")]
    if geometry.radius_m is not None:
        area = math.pi * geometry.radius_m ** 2
        out.append(_estimate(solved, "E", "Pa", axial / area, {1: 1.0 / area}, "E A over pi R^2, R as given"))
        out.append(Estimate("R", "m", geometry.radius_m, geometry.radius_m, geometry.radius_m, "given, not fitted"))
    elif geometry.tip_radius_m is not None:
        radius = contact - geometry.tip_radius_m
        if radius > 0.0:
            area = math.pi * radius ** 2
            out.append(_estimate(solved, "E", "Pa", axial / area, {1: 1.0 / area, 2: -2.0 * axial / (area * radius)}, "E A over pi R^2, R as fitted"))
            out.append(_estimate(solved, "R", "m", radius, {2: 1.0}, "contact distance less the fingertip's radius: as exact as that, A and B"))
        else:
            why = "the contact distance is smaller than the fingertip's radius: check --tip-radius, A and B, or give --radius"
            out += [_unknown("E", "Pa", why), _unknown("R", "m", why)]
    else:
        why = "cannot be told apart from the force: only E A can. Give --radius, or --tip-radius for R from where contact begins"
        out += [_unknown("E", "Pa", why), _unknown("R", "m", why)]
    return out


def _ring_estimates(solved: Solved, model: _Model, why_not: str, deflection_m: numpy.ndarray) -> List[Estimate]:
    kinds = (("k_v_r_max", "N"), ("r_max", "m"), ("k_v", "N/m"), ("T_d", "s"), ("omega", "rad/s"), ("f", "Hz"))
    if not model.rings:
        return [_unknown(name, unit, why_not) for name, unit in kinds]
    amplitude, decay, omega = solved.values[3:6]
    before = (model.session.t_s <= model.released_s) & ~model.session.is_ring
    largest = float(signal.medfilt(deflection_m[before], MEDIAN_SAMPLES).max())  # a single noisy sample is no deflection
    cycle = 2.0 * math.pi
    return [_estimate(solved, "k_v_r_max", "N", amplitude, {3: 1.0}, "fitted; k_v and r_max enter only as their product"),
            _estimate(solved, "r_max", "m", largest, {2: 1.0}, "the largest deflection before the release, as in the paper"),
            _estimate(solved, "k_v", "N/m", amplitude / largest, {3: 1.0 / largest, 2: -amplitude / largest ** 2}, "k_v r_max over that r_max"),
            _estimate(solved, "T_d", "s", decay, {4: 1.0}, "fitted"),
            _estimate(solved, "omega", "rad/s", omega, {5: 1.0}, "fitted"),
            _estimate(solved, "f", "Hz", omega / cycle, {5: 1.0 / cycle}, "omega / 2 pi")]


def fit(measured: Measured, place_m: numpy.ndarray, geometry: Geometry) -> Fit:
    """Fits the session; `place_m`: n x 3, centre of the fingertip. TooLittle says what is missing for T and E A; what is missing for the
    vibration stands in its estimates."""
    if len(measured) < LEAST_SAMPLES:
        raise TooLittle(f"the file has {len(measured)} samples, {LEAST_SAMPLES} are needed")
    touches = find_touches(measured)
    if not touches:
        raise TooLittle("nothing is touched: no force lasts 20 ms")
    session = _Session(measured, place_m, geometry, touches)
    session.check(geometry)
    start, release, why_not = _static_start(session), _release(session), "no touch of the vibrating string after a press: press, leave, touch again"
    model = _Model(session, None, 0.5)
    if release is not None:
        model = _Model(session, *release)
        try:
            start = numpy.concatenate((start, _ring_start(session, model.rings, start, release[0])))
        except TooLittle as missing:
            model, why_not = _Model(session, None, 0.5), str(missing)
    solved = solve(model, start)
    deflection_m = numpy.maximum(solved.values[2] - session.height, 0.0)
    spread = numpy.sqrt(numpy.diag(solved.covariance)[:3])
    correlations = {f"{a} and {b}": float(solved.covariance[i, j] / (spread[i] * spread[j]))
                    for i, a, j, b in ((0, "T", 1, "EA"), (0, "T", 2, "contact_distance"), (1, "EA", 2, "contact_distance"))}
    estimates = _static_estimates(solved, geometry) + _ring_estimates(solved, model, why_not, deflection_m)
    at = model.used
    return Fit(estimates, touches, session.rows[at], session.place[at], deflection_m[at], session.force[at], model(solved.values)[at],
               session.across[at], solved.sigma_n, solved.inflation, correlations)
