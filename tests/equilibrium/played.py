"""Plays the cases of kinds.py on a daemon with the virtual clock: the hand is put where the case has it, and what State says comes back."""
import os
import sys

import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "system"))

import daemon  # noqa: E402
import hapticd  # noqa: E402
import statics  # noqa: E402


def numbers(values):
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def spheres(each):
    return f"shape {{ spheres {{ centre_m: {numbers(np.ravel([c for c, _ in each]))} radius_m: {numbers([r for _, r in each])} }} }}"


def coupling(scene):
    if scene.axes is None:
        return f"kt_n_per_m: {scene.kt!r} length_m: {scene.length!r}"
    return f"kt_w_n_per_m: {numbers(scene.axes[:3])} kr_g_n_m_per_rad: {numbers(scene.axes[3:])}"


def text_of(scene, p_start, extras=""):
    """The scene in text form, its tool at p_start."""
    tool = spheres(list(zip(scene.centres, scene.radii)))
    lines = ['name: "equilibrium"', f'tools {{ name: "tool" parts {{ name: "part" {tool} }} pose_wg {{ p_m: {numbers(p_start)} }} '
             f"coupling {{ {coupling(scene)} }} }}"]
    for k, body in enumerate(scene.bodies):
        lines.append(f'bodies {{ name: "body_{k}" {spheres([body])} }}')
    for k, (a, b, radius) in enumerate(scene.lines):
        lines.append(f'lines {{ name: "line_{k}" radius_m: {radius!r} points_w_m: {numbers([*a, *b])} }}')
    for k, string in enumerate(scene.strings):
        modulus = string.axial / (np.pi * string.radius**2)
        lines.append(f'strings {{ name: "string_{k}" p_wa_m: {numbers(string.a)} p_wb_m: {numbers(string.b)} radius_m: {string.radius!r} '
                     f"tension_n: {string.tension!r} youngs_modulus_pa: {modulus!r} }}")
    return "\n".join([*lines, "torque {}", extras])


def computed(tool):
    """The wrench before the limits of the device: 6 numbers."""
    return list(tool.wrench_unlimited_h_w or tool.wrench_h_w)


class Player:
    """A daemon of one's own and a session that has the lease."""

    def __init__(self, *options):
        self.options = options

    def __enter__(self):
        self.played = daemon.Daemon("--clock", "virtual", "--device", "scripted", "--scene", "single_string", *self.options)
        self.played.__enter__()
        self.session = hapticd.Session(self.played.address)
        self.session.acquire("equilibrium")
        return self

    def __exit__(self, *error):
        self.session.close()
        self.played.__exit__(*error)

    def load(self, text, sections=("TOOLS",)):
        self.session.load_scene(text)
        self.session.subscribe(divisor=1, sections=list(sections))

    def run(self, rows):
        """States of the hand at `rows` of 3 or 7 numbers, one a tick."""
        return self.session.run(poses=[tuple(map(float, row)) for row in rows]).states

    def forces(self, case, extras=""):
        """(force, torque, p_G) in every tick of the case."""
        rows = case.rows()
        self.load(text_of(case.scene, rows[0][:3], extras), ["TOOLS"])
        states = self.run(rows)
        wrenches = np.array([computed(state.tools[0]) for state in states])
        return wrenches[:, :3], wrenches[:, 3:], np.array([state.tools[0].p_wg_m for state in states])


def row_of(p, R):
    return [*p, *statics.quaternion(R)]
