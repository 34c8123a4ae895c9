"""The reader of tree files, on one that is written down here byte by byte, and of meshes."""
import hashlib
import pathlib
import struct
import tempfile
import unittest

import numpy
from hapticd_lab import shaded, sphere_tree

LEAVES = [(0.0, 0.0, 0.0, 1.0), (2.0, 0.0, 0.0, 1.0), (10.0, 0.0, 0.0, 0.5)]
BOUND = (1.0, 0.0, 0.0, 2.0)
"""Of the first two leaves, exactly."""


def tree_bytes(bound=BOUND, name=b"shape.ply"):
    """A root with the bound of two leaves in slot 0 and the third leaf in slot 2."""
    body = b"HDTREE\r\n" + struct.pack("<5I", 1, 3, 2, 2, len(name)) + bytes(32) + struct.pack("<6d", 0.25, 0.0, 5.0, 0.0, 0.0, 6.0)
    body += struct.pack("<Idd", 2, 0.75, 0.5) + struct.pack("<Idd", 3, 0.25, 0.125) + name
    body += b"".join(struct.pack("<4d", *leaf) for leaf in LEAVES)
    body += struct.pack("<BB4dI", 0b101, 0b001, *bound, 2) + struct.pack("<BBII", 0b11, 0, 0, 1)
    return body + hashlib.blake2b(body, digest_size=32).digest()


def with_file(data, read):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "file"
        path.write_bytes(data)
        return read(path)


class Trees(unittest.TestCase):
    def test_levels_are_bounds_and_the_leaves_above_them(self):
        tree = with_file(tree_bytes(), sphere_tree.read_tree)
        self.assertEqual((tree.source_name, tree.outer_m), ("shape.ply", 0.25))
        self.assertEqual(tree.levels, [(2, 0.75, 0.5), (3, 0.25, 0.125)])
        numpy.testing.assert_array_equal(tree.level(1), [BOUND, LEAVES[2]])
        numpy.testing.assert_array_equal(sorted(tree.level(2).tolist()), sorted(map(list, LEAVES)))
        self.assertEqual(sorted(tree.leaves_below()[0]), [0, 1, 2])

    def test_a_leaf_that_sticks_out_of_its_bound_is_seen(self):
        self.assertEqual(with_file(tree_bytes(), sphere_tree.read_tree).worst_excess_m(), 0.0)
        self.assertAlmostEqual(with_file(tree_bytes((1.0, 0.0, 0.0, 1.75)), sphere_tree.read_tree).worst_excess_m(), 0.25)

    def test_damaged_files_are_refused(self):
        good = tree_bytes()
        for data in (b"", good[:-1], good[:100] + b"\x01" + good[101:], b"HDTREE\n\n" + good[8:]):
            with self.assertRaises(ValueError):
                with_file(data, sphere_tree.read_tree)


class Meshes(unittest.TestCase):
    TETRAHEDRON = numpy.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])

    def test_corners_and_triangles_are_read(self):
        head = b"ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        head += b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        corners, triangles = with_file(head + struct.pack("<9f", *range(9)) + struct.pack("<B3i", 3, 0, 2, 1), sphere_tree.read_mesh)
        self.assertEqual(corners.tolist(), [[0, 1, 2], [3, 4, 5], [6, 7, 8]])
        self.assertEqual(triangles.tolist(), [[0, 2, 1]])

    def test_a_closed_mesh_has_no_open_edge(self):
        self.assertEqual(sphere_tree.open_edges(self.TETRAHEDRON), 0)
        self.assertGreater(sphere_tree.open_edges(self.TETRAHEDRON[:3]), 0)
        self.assertGreater(sphere_tree.open_edges(numpy.vstack([self.TETRAHEDRON, self.TETRAHEDRON[:1]])), 0)
        turned = self.TETRAHEDRON.copy()
        turned[0] = turned[0][::-1]
        self.assertGreater(sphere_tree.open_edges(turned), 0)


class Pictures(unittest.TestCase):
    def test_a_sphere_is_a_disc_of_its_radius_where_it_is_and_the_nearer_hides_the_other(self):
        spheres = numpy.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 5.0, 0.5]])
        picture = shaded.draw_spheres(
            spheres, numpy.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), numpy.eye(3), numpy.array([-2.0, 2.0, -1.0, 1.0]), 400
        )
        self.assertEqual(picture.shape, (200, 400, 3))
        drawn = (picture < 1.0).any(axis=2)
        self.assertAlmostEqual(drawn.sum() / 100.0**2, numpy.pi, delta=0.02)
        blue = (picture[..., 2] > 0.0) & (picture[..., 0] == 0.0)
        self.assertAlmostEqual(blue.sum() / 100.0**2, numpy.pi / 4.0, delta=0.02)
        self.assertTrue(blue[100, 200])

    def test_up_is_up_and_right_is_right(self):
        picture = shaded.draw_spheres(
            numpy.array([[1.0, 0.5, 0.0, 0.2]]), numpy.zeros((1, 3)), numpy.eye(3), numpy.array([-2.0, 2.0, -1.0, 1.0]), 400
        )
        self.assertEqual(picture[50, 300].tolist(), [0.0, 0.0, 0.0])

    def test_the_window_holds_all_spheres(self):
        window = shaded.window(numpy.array([[1.0, 2.0, 3.0, 0.5], [-1.0, 0.0, 0.0, 0.25]]), numpy.eye(3))
        numpy.testing.assert_allclose(window, [-1.25, 1.5, -0.25, 2.5])

    def test_the_eye_turns_about_the_vertical_and_looks_down(self):
        numpy.testing.assert_allclose(shaded.view(0.0, 0.0), numpy.eye(3))
        numpy.testing.assert_allclose(shaded.view(0.3, 0.0) @ [0.0, 1.0, 0.0], [0.0, 1.0, 0.0])
        self.assertGreater((shaded.view(0.0, 0.4) @ [0.0, 1.0, 0.0])[2], 0.0)
        numpy.testing.assert_allclose(shaded.view(0.3, 0.4) @ shaded.view(0.3, 0.4).T, numpy.eye(3), atol=1e-15)


if __name__ == "__main__":
    unittest.main()
