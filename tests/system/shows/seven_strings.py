"""The seven strings of the Guqin and a finger, without body and hand: a scene in which a script releases each string at a force it chooses."""
import math
import re

import show

FINGER_RADIUS_M = 0.005
ABOVE_M = 0.02
PLUCKED_X_M = 0.44  # a tenth of the length from the bridge
RATE_HZ = 1000
DECAY_S = 0.1  # tones follow each other soon


class String:
    def __init__(self, line):
        a, b = ([float(number) for number in re.search(name + r": \[([^]]*)\]", line)[1].split(",")] for name in ("p_wa_m", "p_wb_m"))
        self.name = re.search(r'name: "(\w+)"', line)[1]
        tension_n, density_kg_per_m, self.radius_m = (float(re.search(name + r": ([\d.]+)", line)[1])
                                                      for name in ("tension_n", "linear_density_kg_per_m", "radius_m"))
        self.frequency_hz = math.sqrt(tension_n / density_kg_per_m) / (2.0 * math.dist(a, b))
        share = (PLUCKED_X_M - a[0]) / (b[0] - a[0])
        self.y_m, self.z_m = (a[i] + share * (b[i] - a[i]) for i in (1, 2))
        self.line = re.sub(r"decay_s: [\d.]+", f"decay_s: {DECAY_S}", line)


def strings():
    text = (show.ROOT / "deploy/scenes/guqin.textproto").read_text(encoding="utf-8")
    return [String(line) for line in text.splitlines() if line.startswith("strings {")]


def scene(reference_force_n, preset="PRESET_PAPER"):
    """Text of the scene; level 1 at that force."""
    return "\n".join([f'name: "seven_strings" preset: {preset}',
                      f'tools {{ name: "finger" parts {{ name: "tip" shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: {FINGER_RADIUS_M} }} }} }} '
                      f"pose_wg {{ p_m: [{PLUCKED_X_M}, {ABOVE_M}, 0] }} }}",
                      f"vibration {{}} tones {{ reference_force_n: {reference_force_n} }}", *(string.line for string in strings())])


def over(string):
    return (PLUCKED_X_M, ABOVE_M, string.z_m)


def towards(begin, end, speed_m_per_s=0.1):
    """Places from one to the other, one per tick."""
    distance = max(abs(b - a) for a, b in zip(begin, end))
    ticks = max(round(distance / speed_m_per_s * RATE_HZ), 1)
    return [tuple(a + (b - a) * (tick + 1) / ticks for a, b in zip(begin, end)) for tick in range(ticks)]


def pressed(string, depth_m):
    """Where the finger's centre is when the string yields by `depth_m`."""
    return (PLUCKED_X_M, string.y_m + string.radius_m + FINGER_RADIUS_M - depth_m, string.z_m)


def deepest(steps):
    """`steps` depths up to 5 mm, evenly."""
    return [0.005 * (n + 1) / steps for n in range(steps)]
