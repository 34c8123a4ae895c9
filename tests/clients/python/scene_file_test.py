"""The files beside a scene's file: those that it names and that stay in its folder, and a remedy for each that cannot be sent. A server that
forgets what it was sent is not sent it for ever."""
import hashlib
import os
import pathlib
import tempfile
import unittest

import support  # noqa: F401  (finds the package)
from hapticd import errors, requests, scene_file
from hapticd.v1 import answer_pb2


def body(shape):
    return f'bodies {{ name: "b" shape {{ {shape} }} }}\n'


class SceneFile(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "own"
        (self.folder / "parts").mkdir(parents=True)
        self.scene = self.folder / "x.textproto"

    def names(self, text):
        return [file.name for file in scene_file.beside(self.scene, text)]

    def test_files_that_are_named_are_read_once(self):
        (self.folder / "a.tree").write_bytes(b"tree")
        (self.folder / "parts/a.ply").write_bytes(b"mesh")
        text = 'tools { parts { shape { mesh: "parts/a.ply" } } }\n' + 2 * body('tree: "a.tree" mesh: "installed.ply"') + "field_of_later: 3\n"
        self.assertEqual(scene_file.beside(os.fspath(self.scene), text),
                         [scene_file.AssetFile("parts/a.ply", hashlib.blake2b(b"mesh", digest_size=32).digest(), b"mesh"),
                          scene_file.AssetFile("a.tree", hashlib.blake2b(b"tree", digest_size=32).digest(), b"tree")])
        self.assertEqual(self.names("tools { " + body('tree: "a.tree"')), [])

    def test_a_name_that_leads_out_has_no_file(self):
        secret = self.folder.parent / "secret.tree"
        secret.write_bytes(b"secret")
        for name in ("../secret.tree", "parts/../../secret.tree", str(secret), "\\033[31m", ""):
            self.assertEqual(self.names(body(f'tree: "{name}"')), [])

    def test_what_cannot_be_sent_is_named_with_its_remedy(self):
        tree = self.folder / "a.tree"
        tree.write_bytes(b"")
        with self.assertRaisesRegex(ValueError, "x.textproto: 'a.tree' is empty"):
            self.names(body('tree: "a.tree"'))
        os.truncate(tree, scene_file.MOST_BYTES + 1)
        with self.assertRaisesRegex(ValueError, "'a.tree' and those before it .* Make coarser"):
            self.names(body('tree: "a.tree"'))
        tree.unlink()
        tree.mkdir()
        with self.assertRaisesRegex(ValueError, "'a.tree' is not a file"):
            self.names(body('tree: "a.tree"'))

    def test_a_refusal_names_the_file_that_was_read(self):
        self.scene.write_text('name: "x"\n', encoding="utf-8")
        said = "inline:3:25: error: there is no inline: here.\ninline:7: error: nor there."
        of_file = f"{self.scene}:3:25: error: there is no inline: here.\n{self.scene}:7: error: nor there."
        for scene, right in ((self.scene, of_file), (os.fspath(self.scene), of_file), ('name: "x/y"\n', said)):
            work = requests.load_scene(scene, None, True)
            next(work)
            work.send(answer_pb2.SceneInfo())
            with self.assertRaises(errors.RequestError) as refused:
                work.throw(errors.RequestError(answer_pb2.Result(code=answer_pb2.RESULT_CODE_INVALID, path="load_scene", message=said)))
            found = refused.exception
            self.assertEqual((found.code, found.path, found.message), ("INVALID", "load_scene", right))

    def test_a_server_that_forgets_is_given_up(self):
        work = requests.bring(scene_file.AssetFile("a.tree", bytes(32), bytes(100_000)))
        next(work)
        asked = work.send(answer_pb2.Result())
        self.assertEqual(len(asked.item.put_asset.bytes), scene_file.PIECE)
        with self.assertRaisesRegex(ConnectionError, "forgotten"):
            work.send(answer_pb2.Result())


if __name__ == "__main__":
    unittest.main(verbosity=2)
