"""The Debian package of the shared library, made by CPack from this build: what is built against it asks for this version or a later one, as
every version may have more functions.

usage: package_test.py CPACK BUILD VERSION"""
import pathlib
import subprocess
import sys
import tempfile
import unittest


class Package(unittest.TestCase):
    def test_what_is_built_against_it_needs_its_version(self):
        with tempfile.TemporaryDirectory() as scratch:
            subprocess.run([CPACK, "--config", pathlib.Path(BUILD, "CPackConfig.cmake"), "-G", "DEB", "-B", scratch, "-D",
                            "CPACK_COMPONENTS_ALL=libhapticd-client0"], check=True, stdout=subprocess.DEVNULL, cwd=BUILD)
            package = next(pathlib.Path(scratch).glob("libhapticd-client0_*.deb"))
            shlibs = subprocess.run(["dpkg-deb", "--info", package, "shlibs"], check=True, stdout=subprocess.PIPE, text=True).stdout
        self.assertEqual(shlibs, f"libhapticd-client 0 libhapticd-client0 (>= {VERSION})\n")


if __name__ == "__main__":
    CPACK, BUILD, VERSION = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
