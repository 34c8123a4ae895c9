#!/usr/bin/python3
"""The include check finds what it is there for, on the real table and on invented files."""
import unittest

import check_includes
import source_tree

FLOORS = check_includes.Floors(source_tree.read("tests/architecture/floors.txt"))


def found(path, *includes):
    text = "// what it is\n" + "".join(f"#include {include}\n" for include in includes)
    return check_includes.violations(FLOORS, path, text)


class CheckIncludesTest(unittest.TestCase):
    def assert_refused(self, path, include, reason):
        lines = found(path, include)
        self.assertEqual(len(lines), 1, lines)
        self.assertIn(reason, lines[0])

    def test_lower_floors_and_the_own_folder_pass(self):
        self.assertEqual([], found("core/contact/a.h", '"core/math/pose.h"', '"core/solver/qp.h"', '"core/contact/b.h"',
                                   "<array>", "<Eigen/Core>"))
        self.assertEqual([], found("server/encoding/a.cpp", '"core/scene/a.h"', '"hapticd/v1/pose.pb.h"', "<string>"))
        self.assertEqual([], found("clients/web/a.cpp", '"clients/library/subscriber.h"', '"hapticd/v1/pose.pb.h"'))
        self.assertEqual([], found("device/hid/a.cpp", '"device/api/haptic_device.h"', "<vector>"))

    def test_upward_includes_are_refused(self):
        self.assert_refused("core/math/a.h", '"core/geometry/sphere.h"', "floor 0 may not include floor 1")
        self.assert_refused("core/tree/a.h", '"core/scene/scene.h"', "floor 2 may not include floor 5")

    def test_sideways_includes_are_refused(self):
        self.assert_refused("core/math/a.h", '"core/rt/spsc_ring.h"', "floor 0 may not include floor 0")
        self.assert_refused("device/hid/a.h", '"device/simulated/plant.h"', "floor 4 may not include floor 4")

    def test_angled_includes_of_ours_are_seen_too(self):
        self.assert_refused("core/math/a.h", "<core/geometry/sphere.h>", "floor 0 may not include floor 1")

    def test_core_knows_itself_alone_and_devices_core(self):
        self.assert_refused("core/scene/a.cpp", '"hapticd/v1/scene.pb.h"', "core sees only core")
        self.assert_refused("core/tree/a.cpp", '"proto/hapticd/v1/scene.pb.h"', "core sees only core")
        self.assert_refused("core/scene/a.cpp", '"device/api/pace_source.h"', "core sees only core")
        self.assert_refused("device/attach/a.cpp", '"hapticd/v1/device_profile.pb.h"', "device sees only core device")
        self.assertEqual([], found("device/attach/a.cpp", '"device/hid/hid_device.h"', '"core/math/pose.h"'))

    def test_clients_see_only_proto_and_their_library(self):
        self.assert_refused("clients/web/a.cpp", '"core/math/pose.h"', "clients sees only")
        self.assert_refused("clients/web/a.cpp", '"server/network/hub.h"', "do not know each other")
        self.assert_refused("clients/web/a.cpp", '"clients/audio/tone.h"', "floor 8 may not include floor 8")
        self.assert_refused("server/daemon/a.cpp", '"clients/library/subscriber.h"', "do not know each other")
        self.assertEqual([], found("clients/web/a.cpp", '"clients/web/b.h"'))

    def test_only_binds_what_is_below_tests_too_but_not_the_tests_themselves(self):
        self.assert_refused("tests/truth/a.cpp", '"server/scene_io/a.h"', "tests/truth sees only core")
        self.assert_refused("tests/truth/a.h", '"hapticd/v1/scene.pb.h"', "tests/truth sees only core")
        self.assert_refused("tests/truth/a.h", '"tests/support/random.h"', "tests/truth sees only core")
        self.assertEqual([], found("tests/truth/a.h", '"core/scene/scene.h"', '"tests/truth/b.h"', "<vector>"))
        self.assertEqual([], found("tests/truth/a_test.cpp", '"tests/support/random.h"'))
        self.assertEqual([], found("tests/oracle/a.h", '"server/scene_io/a.h"', '"tests/truth/b.h"', '"core/math/pose.h"'))

    def test_the_haptic_loop_sees_no_wire_types(self):
        self.assert_refused("server/haptic_loop/a.cpp", '"hapticd/v1/pose.pb.h"', "sees only")

    def test_unknown_folders_are_refused(self):
        self.assert_refused("core/math/a.h", '"core/helpers/a.h"', "unknown folder")
        self.assertIn("no floor", found("core/helpers/a.h")[0])
        self.assertIn("no floor", found("core/a.h")[0])

    def test_includes_relative_to_the_file_are_refused(self):
        self.assert_refused("core/math/a.h", '"pose.h"', "from the root")

    def test_product_code_may_not_include_tests(self):
        self.assert_refused("core/scene/a.h", '"tests/support/random.h"', "only tests")

    def test_realtime_folders_refuse_headers_that_may_allocate_or_lock(self):
        for header in ("mutex", "iostream", "vector", "string", "memory", "functional", "thread", "chrono", "stdio.h"):
            self.assert_refused("core/solver/a.h", f"<{header}>", "realtime")
            self.assertEqual([], found("core/scene/a.h", f"<{header}>"))

    def test_realtime_folders_refuse_other_folders(self):
        self.assert_refused("core/contact/a.h", '"core/tree/builder.h"', "only realtime folders")

    def test_a_realtime_folder_must_say_so_to_the_build(self):
        forgot = check_includes.unmarked_libraries(FLOORS, "core/math/CMakeLists.txt", "hapticd_library(core/math)")
        self.assertEqual(len(forgot), 1)
        self.assertEqual([], check_includes.unmarked_libraries(FLOORS, "core/scene/CMakeLists.txt", "hapticd_library(core/scene)"))


if __name__ == "__main__":
    unittest.main()
