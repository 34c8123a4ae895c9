"""A tip that slides over the body of a Guqin feels at most a third of the ripple that the union of its spheres has, in force and in
direction, and sinks into the mesh no further; on random slides from a fixed seed and from a new one. And the judge of it is red where there
is one."""
import hashlib
import pathlib
import shutil
import struct
import sys
import tempfile
import unittest
from unittest import mock

import comparison
import mesh_statics
import numpy as np
import played
import ripple

SLIDES = 12
# Of the rms of the same slides over the same spheres when they do not blend.
SHARE = 1 / 3
# How far a tip may sink into the mesh, um: rounding, and what hides between the samples of a fit.
SUNK_UM = 1.0
# A scene of each tree; the others share these.
SCENES = {"guqin": ("five_fingers", "stress"), "guqin_coarse": ()}
MESH = ripple.ROOT / "deploy/models/guqin_body.ply"


def union_of(tree):
    """The bytes of a tree of the same spheres that do not blend: version 1, without the width, and its hash."""
    data = (ripple.ROOT / "deploy/models" / tree).read_bytes()
    assert struct.unpack_from("<I", data, 8) == (2,), tree
    data = data[:8] + struct.pack("<I", 1) + data[12:-40]
    return data + hashlib.blake2b(data, digest_size=32).digest()


def installed(folder, trees):
    """The daemon as it is installed, with the unions of `trees` among its models; its path."""
    share, program = pathlib.Path(folder, "share/hapticd"), pathlib.Path(folder, "bin/hapticd")
    (share / "models").mkdir(parents=True)
    program.parent.mkdir()
    shutil.copy2(played.daemon.HAPTICD, program)
    for each in ("devices", "gestures", "scenes", "schema"):
        (share / each).symlink_to(ripple.ROOT / "deploy" / each)
    for model in (ripple.ROOT / "deploy/models").iterdir():
        (share / "models" / model.name).symlink_to(model)
    for tree in trees:
        (share / "models" / f"union_{tree}").write_bytes(union_of(tree))
    return str(program)


class Ripple(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.seed = comparison.new_seed()
        cls.tip = ripple.Tip()
        cls.statics = mesh_statics.Statics(mesh_statics.Mesh(MESH), cls.tip)
        cls.slides = [slide for seed in (*comparison.FIXED_SEEDS, cls.seed) for slide in ripple.draw(cls.statics, seed, SLIDES)]

    def test_the_judge_sees_a_ripple_that_is_put_on_the_truth(self):
        plays = [(slide.truth, slide.hand[list(slide.chosen)] + slide.truth / ripple.KT_N_PER_M) for slide in self.slides]
        exact = ripple.judge(self.statics, self.slides, plays)
        self.assertLess(max(exact["rms_mn"], exact["rms_deg"], exact["sunk_um"]), 0.01)
        waves = [1 + 0.02 * np.sin(0.4 * np.arange(len(slide.truth)))[:, None] for slide in self.slides]
        rippled = ripple.judge(self.statics, self.slides, [(force * wave, p - 5e-6 * force) for (force, p), wave in zip(plays, waves)])
        self.assertGreater(rippled["rms_mn"], 10)
        self.assertGreater(rippled["sunk_um"], 3)

    def test_the_bodies_of_guqins_have_a_third_of_the_ripple_of_their_spheres(self):
        trees = {name: ripple.body_of(name)[0] for name in SCENES}
        for name, others in SCENES.items():
            self.assertEqual({trees[name]}, {trees[name], *(ripple.body_of(other)[0] for other in others)})
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(played.daemon, "HAPTICD", installed(folder, trees.values())):
            with played.Player() as player:
                for tree in trees.values():
                    self.judge_tree(player, tree)

    def judge_tree(self, player, tree):
        union, blend = (ripple.judge(self.statics, self.slides, [ripple.play(player, slide, self.tip, each) for slide in self.slides])
                        for each in (f"union_{tree}", tree))
        print(f"{tree}\nunion {union}\nblend {blend}", flush=True)
        for what in ("rms_mn", "rms_deg"):
            self.assertLess(blend[what], SHARE * union[what], (tree, what, self.seed))
        self.assertLess(blend["sunk_um"], SUNK_UM, (tree, self.seed))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
