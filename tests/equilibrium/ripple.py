"""How much ripple a slide on the body of a scene feels, beside the exact statics on the mesh that its tree was made from. SI.

A tip comes down on the body at a random place, presses about 1 N, and slides straight on at 20 mm/s. A round tip does not turn, so that the
truth is the statics of its centre: mesh_statics.py. What differs from it by more or less along a slide is ripple."""
import pathlib
import re

import mesh_statics
import numpy as np
import played

ROOT = pathlib.Path(__file__).resolve().parents[2]
KT_N_PER_M = 1000.0
# What is shipped with a body that a tree was made of.
SCENES = ("guqin", "five_fingers", "guqin_coarse", "bunny", "cabin", "stress")
SPEED_M_PER_S, WAY_M, DEPTH_M, ABOVE_M = 0.02, 0.03, 0.001, 0.01
# Truths of a slide: one every so many ticks.
EVERY = 10
# A slide counts that stays on one face: its exact force in N, and how far that turns, degrees.
FORCE_N, TURN_DEG = (0.4, 2.5), 25.0
DRAWS = 400
# How far from where it begins a slide goes, with the tool and what is next to it.
AROUND_M = 0.07


def body_of(scene):
    """(tree, mesh) of the first body of a shipped scene that has them."""
    text = (ROOT / f"deploy/scenes/{scene}.textproto").read_text(encoding="utf-8")
    found = re.search(r'^bodies \{[^\n]*tree: "([^"]+)" mesh: "([^"]+)"', text, re.M)
    return found and (found[1], found[2])


class Tip:
    """The tool: one sphere."""

    def __init__(self, radius=mesh_statics.TIP):
        self.spheres = np.array([[0.0, 0.0, 0.0, radius]])
        self.shape = f"shape {{ spheres {{ centre_m: [0, 0, 0] radius_m: {radius} }} }}"


class Slide:
    """A way of the hand over a body, and the exact rest of the tool in some of its ticks."""

    def __init__(self, statics, place, normal, way):
        """From `place`, where the tool just touches, along `way`; None in truth where it does not stay on one face."""
        self.down = place + ABOVE_M * normal
        first = place - DEPTH_M * normal
        count = round(WAY_M / (SPEED_M_PER_S * 1e-3))
        self.hand = first + np.outer(np.arange(1, count + 1) / count, WAY_M * way)
        self.first = first
        self.chosen = range(0, count, EVERY)
        self.truth = []
        rest = place
        for k in self.chosen:
            rest = statics.rest(self.hand[k], rest)
            self.truth.append(KT_N_PER_M * (rest - self.hand[k]))
            if not self.on_one_face():
                self.truth = None
                return
        self.truth = np.array(self.truth)

    def on_one_face(self):
        strength = np.linalg.norm(self.truth[-1])
        cosine = self.truth[-1] @ self.truth[0] / (strength * np.linalg.norm(self.truth[0]) + 1e-12)
        return FORCE_N[0] < strength < FORCE_N[1] and cosine > np.cos(np.radians(TURN_DEG))

    def rows(self):
        down = [self.down + (self.first - self.down) * k / 200 for k in range(201)]
        return [*down, *[self.first] * 100], self.hand


def draw(statics, seed, count):
    """`count` slides over a body from a seed."""
    random, mesh, found = np.random.default_rng(seed), statics.all, []
    edge = np.cross(mesh.corners[:, 1] - mesh.corners[:, 0], mesh.corners[:, 2] - mesh.corners[:, 0])
    area = np.linalg.norm(edge, axis=1)
    for _ in range(DRAWS):
        if len(found) == count:
            return found
        k = random.choice(len(area), p=area / area.sum())
        u, v = sorted(random.uniform(size=2))
        a, b, c = mesh.corners[k]
        normal = edge[k] / area[k]
        turn = np.cross(normal, random.normal(size=3))
        # From far enough that no part of the tool is inside; down to where the first of it touches.
        spot = a * u + b * (v - u) + c * (1 - v)
        statics.look_around(spot, AROUND_M)
        start = spot + 0.03 * normal - statics.tool.spheres[:, :3].mean(axis=0)
        place = statics.fall(start, -normal, 0.06)
        if place is None or statics.gap(place + ABOVE_M * normal) < 0.5 * ABOVE_M:
            continue
        slide = Slide(statics, place, normal, turn / np.linalg.norm(turn))
        if slide.truth is not None:
            found.append(slide)
    raise RuntimeError(f"{len(found)} slides of {count} found on {mesh.corners.shape[0]} triangles")


def play(player, slide, tool, tree):
    """(force, place of the tool) in the ticks of the slide's truths."""
    p = played.numbers(slide.down)
    player.load(f'name: "ripple" tools {{ name: "tool" parts {{ name: "part" {tool.shape} }} pose_wg {{ p_m: {p} }} '
                f"coupling {{ kt_n_per_m: {KT_N_PER_M} }} }} "
                f'bodies {{ name: "body" shape {{ tree: "{tree}" }} }} torque {{}}')
    down, way = slide.rows()
    player.run(down)
    tools = [state.tools[0] for state in player.run(way)]
    return (np.array([played.computed(tools[k])[:3] for k in slide.chosen]), np.array([tools[k].p_wg_m for k in slide.chosen]))


def measure(player, tree, mesh, seeds):
    """Ripple of a tree: {what: number}; seeds: [(seed, how many slides)]."""
    tip = Tip()
    statics = mesh_statics.Statics(mesh_statics.Mesh(ROOT / "deploy/models" / mesh), tip)
    slides = [slide for seed, count in seeds for slide in draw(statics, seed, count)]
    return judge(statics, slides, [play(player, slide, tip, tree) for slide in slides])


def judge(statics, slides, plays):
    """Ripple of forces and places beside the truths of slides."""
    each = [mesh_statics.ripple(force, slide.truth) for slide, (force, _) in zip(slides, plays)]
    rms = {key: float(np.sqrt(np.mean([one[key] ** 2 for one in each]))) for key in ("rms_mn", "rms_deg")}
    worst = {key: max(one[key] for one in each) for key in ("worst_mn", "worst_deg")}
    mean = {key: float(np.mean([one[key] for one in each])) for key in ("force_n", "fat_mn")}
    sunk = 0.0
    for _, places in plays:
        statics.look_around(places[0], AROUND_M)
        sunk = max(sunk, -min(statics.gap(p) for p in places))
    return {"slides": len(slides), **mean, **rms, **worst, "sunk_um": 1e6 * sunk}
