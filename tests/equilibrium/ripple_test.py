"""A tip that slides over spheres that blend feels at most a third of the ripple that their union has, in force and in direction, and sinks
into the mesh no further; on random slides from a fixed seed and from a new one."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import comparison
import mesh_statics
import numpy as np
import played
import ripple

SLIDES = 5
# Of the rms of the same slides over the tree of the same balls that do not blend.
SHARE = 1 / 3
# How far a tip may sink into the mesh, um: rounding, and what hides between the samples of a fit.
SUNK_UM = 1.0
MESH, UNION, BLEND = "plate.ply", "plate_1000um.tree", "plate_blend.tree"
MODELS = ripple.ROOT / "deploy/models"


class Ripple(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.seed = comparison.new_seed()
        cls.tip = ripple.Tip()
        cls.statics = mesh_statics.Statics(mesh_statics.Mesh(MODELS / MESH), cls.tip)
        cls.slides = [slide for seed in (*comparison.FIXED_SEEDS, cls.seed) for slide in ripple.draw(cls.statics, seed, SLIDES)]

    def test_the_judge_sees_a_ripple_that_is_put_on_the_truth(self):
        plays = [(slide.truth, slide.hand[list(slide.chosen)] + slide.truth / ripple.KT_N_PER_M) for slide in self.slides]
        exact = ripple.judge(self.statics, self.slides, plays)
        self.assertLess(max(exact["rms_mn"], exact["rms_deg"], exact["sunk_um"]), 0.01)
        waves = [1 + 0.02 * np.sin(0.4 * np.arange(len(slide.truth)))[:, None] for slide in self.slides]
        rippled = ripple.judge(self.statics, self.slides, [(force * wave, p - 5e-6 * force) for (force, p), wave in zip(plays, waves)])
        self.assertGreater(rippled["rms_mn"], 10)
        self.assertGreater(rippled["sunk_um"], 3)

    def test_spheres_that_blend_have_a_third_of_the_ripple_of_their_union(self):
        data = tempfile.TemporaryDirectory()
        self.addCleanup(data.cleanup)
        models = pathlib.Path(data.name, "models")
        models.mkdir()
        pathlib.Path(data.name, "scenes").symlink_to(ripple.ROOT / "deploy/scenes")
        for model in MODELS.iterdir():
            pathlib.Path(models, model.name).symlink_to(model)
        subprocess.run([pathlib.Path(os.environ["HAPTICD"]).parent / "hapticd-model", "build", MODELS / MESH, "--error", "1mm", "--blend", "4mm",
                        "--quiet", "-o", models / BLEND], check=True)
        os.environ["HAPTICD_DATA"] = data.name
        self.addCleanup(os.environ.pop, "HAPTICD_DATA")
        with played.Player() as player:
            union, blend = (ripple.judge(self.statics, self.slides, [ripple.play(player, slide, self.tip, tree) for slide in self.slides])
                            for tree in (UNION, BLEND))
        print(f"union {union}\nblend {blend}", flush=True)
        for what in ("rms_mn", "rms_deg"):
            self.assertLess(blend[what], SHARE * union[what], (what, self.seed))
        self.assertLess(blend["sunk_um"], SUNK_UM, self.seed)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
