"""What the product says of random cases of a kind beside the exact statics, and what is allowed. SI."""
import secrets

import numpy as np

import kinds
import statics

# Allowed at rest: of each force, N, and of all of a kind together, rms. While moving: the same of every tick that is judged.
REST_N, MOVING_N, SHARE, NOTHING_N = 5e-3, 60e-3, 5e-3, 1e-3
# Where the product says its tool is, m.
PLACE_M = 5e-6
# Torque goes with force through the longest lever of the scenes, m.
LEVER_M = 0.1
FIXED_SEEDS = (30,)
# What the product is asked for besides its defaults: at quality 2 and above the same holds.
SETTINGS = {"default": "", "quality 2": "quality { level: 2 }", "quality 4": "quality { level: 4 }", "skin 0": "solver { skin_m: 0 }"}


def new_seed():
    """One that no run had before."""
    seed = secrets.randbelow(2**31)
    print(f"the new seed of this run is {seed}", flush=True)
    return seed


class Errors:
    """Of one kind: force, torque and place in every tick that was judged."""

    def __init__(self, moving=False, nothing=False):
        self.moving, self.nothing = moving, nothing
        self.force, self.torque, self.place, self.truth = [], [], [], []

    def add(self, played, ticks, rests):
        force, torque, p_G = played
        for tick, rest in zip(ticks, rests):
            self.force.append(np.linalg.norm(force[tick] - rest.force))
            self.torque.append(np.linalg.norm(torque[tick] - rest.torque))
            self.place.append(np.linalg.norm(p_G[tick] - rest.p_G))
            self.truth.append(np.linalg.norm(rest.force))

    @property
    def worst(self):
        return max(self.force)

    @property
    def share(self):
        return float(np.sqrt(np.sum(np.square(self.force)) / max(np.sum(np.square(self.truth)), 1e-30)))

    def failures(self):
        """What is not as allowed, in words."""
        if self.nothing:
            return [f"{1e3 * self.worst:.3f} mN of nothing"] if self.worst > NOTHING_N else []
        most, found = MOVING_N if self.moving else REST_N, []
        if self.worst > most:
            found.append(f"force off by {1e3 * self.worst:.3f} mN, allowed {1e3 * most:g}")
        if self.share > SHARE:
            found.append(f"force off by {100 * self.share:.3f} % rms, allowed {100 * SHARE:g}")
        if max(self.torque) > most * LEVER_M:
            found.append(f"torque off by {1e3 * max(self.torque):.3f} mN m")
        if max(self.place) > PLACE_M and not self.moving:
            found.append(f"the tool shown {1e6 * max(self.place):.2f} um off")
        return found


def compare(player, make, seeds, settings=("default",)):
    """{setting: Errors} of cases of a kind; seeds: [(seed, how many)]."""
    found = {}
    for seed, count in seeds:
        for case, ticks, rests in kinds.draw(make, seed, count):
            for setting in settings:
                errors = found.setdefault(setting, Errors(case.moving, case.nothing))
                errors.add(player.forces(case, SETTINGS[setting]), ticks, rests)
    return found


def fattened(make, seed, count, fat):
    """Errors of a truth whose surfaces are `fat` too fat: the control."""
    errors = None
    for case, _, rests in kinds.draw(make, seed, count):
        try:
            _, fat_rests = case.truths(fat)
        except statics.NoRest:
            continue
        errors = errors or Errors(case.moving, case.nothing)
        for rest, other in zip(rests, fat_rests):
            errors.add(([other.force], [other.torque], [other.p_G]), [0], [rest])
    return errors
