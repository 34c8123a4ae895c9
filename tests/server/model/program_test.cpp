// hapticd-model run as a user runs it: what it writes, what it says, how it ends. Truth: shapes
// whose volume and distances are known; the files read by the library.
#include <doctest/doctest.h>

#include <filesystem>
#include <string>

#include "server/model/mesh_file.h"
#include "server/model/packing/mesh_check.h"
#include "server/model/packing/mesh_distance.h"
#include "tests/server/model/temporary_folder.h"
#include "tests/support/scale.h"
#include "tests/support/shell_run.h"

namespace hapticd::test {
namespace {

/// Runs hapticd-model with these arguments of the shell; what it prints and its complaints.
ShellOutcome run(const std::string& arguments) {
  return run_in_shell(std::string("'") + HAPTICD_MODEL_PROGRAM + "' " + arguments + " 2>&1");
}

/// A box of 100 x 60 x 40 mm, in mm.
constexpr const char* kBox =
    "v 0 0 0\nv 100 0 0\nv 100 60 0\nv 0 60 0\nv 0 0 40\nv 100 0 40\nv 100 60 40\nv 0 60 40\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

MeasuredTree read_tree(const std::string& path) {
  return decode_sphere_tree(read_bytes(path, std::uint64_t{1} << 30U));
}

}  // namespace

TEST_CASE("a tree built from a mesh in millimetres holds to its bound, and the report says so") {
  const TemporaryFolder folder;
  const std::string mesh = folder.write("box.obj", kBox);
  const std::string tree = folder.path("box.tree");
  // A sanitizer takes a minute for the picture, which has a test of its own.
  const std::string picture =
      test_scale() < 0.05 ? std::string() : "--picture " + folder.path("box.png");
  const ShellOutcome built = run("build " + mesh + " --unit mm --error 8mm --report - " + picture +
                                 " --json " + folder.path("box.json") + " -o " + tree);
  CAPTURE(built.text);
  REQUIRE(built.code == 0);
  const MeasuredTree file = read_tree(tree);
  CHECK(file.source_name == "box.obj");
  CHECK(file.outer <= 8e-3);
  const MeshDistance distance(read_mesh(mesh, 1e-3).mesh);
  for (std::size_t i = 0; i < file.tree.leaf_r.size(); ++i) {
    const Sphere leaf = file.tree.view().leaf(static_cast<std::int32_t>(i));
    // Its six outermost points along the axes stand for all: the nearest face is normal to one.
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        REQUIRE(distance.signed_distance(leaf.p + side * leaf.r * Vector3::Unit(axis)) <=
                file.outer);
      }
    }
  }
  CHECK(built.says("| uncovered surface | 0 % |"));
  CHECK(built.says("| spheres | " + std::to_string(file.tree.leaf_r.size()) + " |"));
  CHECK((picture.empty() || read_text(folder.path("box.png")).starts_with("\x89PNG\r\n")));
  CHECK(read_text(folder.path("box.json")).starts_with("{\"name\":"));

  const ShellOutcome inspected = run("inspect " + tree + " --mesh " + mesh + " --unit mm");
  CHECK(inspected.code == 0);
  CHECK(inspected.says("| uncovered surface | 0 % |"));
  CHECK_FALSE(inspected.says("warning"));
  CHECK(run("inspect " + tree + " --mesh model:pillar").says("not the mesh"));
}

TEST_CASE("the number of threads and the name of the output do not change the tree") {
  const TemporaryFolder folder;
  const std::string mesh = folder.write("box.obj", kBox);
  REQUIRE(
      run("build " + mesh + " --unit mm --error 15mm --threads 1 --quiet -o " + folder.path("a"))
          .text.empty());
  REQUIRE(
      run("build " + mesh + " --unit mm --error 15mm --threads 3 --quiet -o " + folder.path("b"))
          .text.empty());
  CHECK(read_text(folder.path("a")) == read_text(folder.path("b")));
}

TEST_CASE("models are listed and made, with parameters") {
  const TemporaryFolder folder;
  const ShellOutcome list = run("list --parameters");
  CHECK(list.code == 0);
  CHECK(list.says("guqin_body"));
  REQUIRE(run("make plate -o " + folder.path("plate.ply")).code == 0);
  CHECK(check_mesh(read_mesh(folder.path("plate.ply"), 1.0).mesh).findings.empty());
  const ShellOutcome unknown = run("make teapot -o " + folder.path("x.ply"));
  CHECK(unknown.code == 2);
  CHECK(unknown.says("guqin_body"));
  CHECK(run("make plate --set nothing=1 -o " + folder.path("x.ply")).code == 2);
  CHECK(run("make plate --set nothing -o " + folder.path("x.ply")).code == 2);
}

TEST_CASE("bad input ends with 1, the file's name and what to do about it") {
  const TemporaryFolder folder;
  const std::string open = folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const ShellOutcome outcome = run("build " + open + " -o " + folder.path("x.tree"));
  CHECK(outcome.code == 1);
  CHECK(outcome.says(open + ": 3 edges belong"));
  CHECK(outcome.says("Close the holes"));
  CHECK_FALSE(std::filesystem::exists(folder.path("x.tree")));
  CHECK(run("build " + folder.path("none.obj") + " -o " + folder.path("x.tree")).code == 1);
  const std::string damaged = folder.write("damaged.tree", "this is no tree");
  const ShellOutcome inspected = run("inspect " + damaged);
  CHECK(inspected.code == 1);
  CHECK(inspected.says(damaged + ": not a sound sphere-tree file"));
}

TEST_CASE("a turned triangle is an error, and with --repair it is not") {
  const TemporaryFolder folder;
  std::string turned = kBox;
  turned.replace(turned.find("f 1 4 3 2"), 9, "f 1 2 3 4");
  const std::string mesh = folder.write("turned.obj", turned);
  const std::string command =
      "build " + mesh + " --unit mm --error 20mm -o " + folder.path("x.tree");
  const ShellOutcome refused = run(command);
  CHECK(refused.code == 1);
  CHECK(refused.says("--repair"));
  const ShellOutcome repaired = run(command + " --repair");
  CHECK(repaired.code == 0);
  CHECK(repaired.says("2 turned round"));
}

TEST_CASE("a doubtful unit is a warning that names the remedy") {
  const TemporaryFolder folder;
  const std::string mesh = folder.write("box.obj", kBox);
  const ShellOutcome outcome = run("build " + mesh + " --error 20 -o " + folder.path("x.tree"));
  CHECK(outcome.code == 0);
  CHECK(outcome.says("--unit mm"));
}

TEST_CASE("a command line that makes no sense ends with 2, help with 0") {
  CHECK(run("--help").code == 0);
  CHECK(run("build --help").code == 0);
  CHECK(run("--version").code == 0);
  for (const char* bad : {"", "sing", "build", "build x.obj", "build x.obj -o y --leaves 0",
                          "build x.obj -o y --leaves 5 --error 1mm", "build x.obj -o y --error 1ft",
                          "build x.obj -o y --error -1mm", "build x.obj -o y --unit mile",
                          "build x.obj -o y --scale 0", "build x.obj -o y --threads 0",
                          "build x.obj -o y --set a=1", "inspect", "make plate"}) {
    CAPTURE(bad);
    CHECK(run(bad).code == 2);
  }
}

TEST_CASE("explain tells what a level is bound to err and predicted to cost, of levels there are") {
  const TemporaryFolder folder;
  const std::string scene = folder.write(
      "ball.textproto",
      "name: \"ball\" tools { name: \"finger\" parts { name: \"tip\" shape { spheres { "
      "centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, 0.07, 0] } } bodies { name: "
      "\"ball\" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.05 } } }");
  const ShellOutcome fast = run("explain --quality 0 '" + scene + "'");
  CHECK(fast.code == 0);
  CHECK(fast.says("quality 0: force error at most "));
  CHECK(fast.says("predicted work of a tick in touch: "));
  const ShellOutcome usual = run("explain '" + scene + "'");
  CHECK(usual.says("in touch: 1 times that of quality 3, the default\n"));
  CHECK(usual.says("finger: 1 sphere\n"));
  CHECK(usual.says("work of a tick: bounded to 500 us of processor time, half of a tick at 1 kHz"));
  CHECK(usual.says("hapticd --budget-us N"));
  CHECK(run("explain --quality 5 '" + scene + "'").code == 2);
}

TEST_CASE("explain tells what follows the tension, once where all strings are alike") {
  const TemporaryFolder folder;
  const auto explained = [&](const std::string& first, const std::string& second) {
    const auto string = [](const char* name, const std::string& words) {
      return std::string("strings { name: \"") + name +
             "\" p_wa_m: [-0.5, 0, 0] p_wb_m: [0.5, 0, 0] " + words + " } ";
    };
    return run(
        "explain '" +
        folder.write("two.textproto",
                     "name: \"two\" tools { name: \"finger\" parts { name: \"tip\" shape { "
                     "spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, "
                     "0.07, 0] } } vibration {} " +
                         string("A", first) + string("B", second)) +
        "'");
  };
  const std::string peg = "linear_density_kg_per_m: 0.002";
  const ShellOutcome alike = explained(peg, "frequency_hz: 90 tuning: TUNING_TENSION");
  CHECK(alike.says("  tuning: the pitch follows tension_n, the linear density holds\n"));
  const ShellOutcome mixed = explained(peg, "frequency_hz: 90");
  CHECK(mixed.says("  tuning of A: the pitch follows tension_n, the linear density holds\n"));
  CHECK(mixed.says("  tuning of B: the pitch holds, the linear density follows tension_n\n"));
  CHECK(explained("", "").says("  tuning: no pitch\n"));
}

TEST_CASE(
    "explain tells what a string costs on each rung, and what its own modes and sub-steps are") {
  const TemporaryFolder folder;
  const auto explained = [&](const std::string& features) {
    return run(
        "explain '" +
        folder.write("two.textproto",
                     "name: \"two\" tools { name: \"finger\" parts { name: \"tip\" shape { "
                     "spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } } pose_wg { p_m: [0, "
                     "0.07, 0] } } strings { name: \"low\" p_wa_m: [-0.5, 0, 0] p_wb_m: "
                     "[0.5, 0, 0] frequency_hz: 65 axial_stiffness_n: 0 } strings { name: "
                     "\"high\" p_wa_m: [-0.5, 0, 0.02] p_wb_m: [0.5, 0, 0.02] "
                     "frequency_hz: 130 axial_stiffness_n: 0 } " +
                         features) +
        "'");
  };
  const ShellOutcome coarse = explained("vibration {} wave { modes: 16 substeps: 8 }");
  for (const char* const rung :
       {"\n  rigid ", "\n  static ", "\n  fundamental ", "\n  wave of 32 modes, 32 sub-steps ",
        "\n  wave of 32 modes, 32 sub-steps, that stretches "}) {
    CAPTURE(rung);
    CHECK(coarse.says(rung));
  }
  CHECK(coarse.says("  waves of 16 modes in two planes, stepped 8 times a millisecond\n"));
  CHECK(coarse.says("\n  here: 2 strings, wave of 16 modes, 8 sub-steps "));
  CHECK(explained("vibration {} wave { modes: 64 substeps: 8 }")
            .says("\n  here: 2 strings, wave of 28 modes, 8 sub-steps "));
  CHECK(explained("").says("\n  here: 2 strings, static "));
}

TEST_CASE("explain tells what bounds a tick, and whether this scene comes to be cut short") {
  const TemporaryFolder folder;
  const auto scene = [&](const std::string& budget_us) {
    return folder.write(
        "ball_" + budget_us + ".textproto",
        "name: \"ball\" quality { automatic { budget_us: " + budget_us +
            " } } tools { name: \"finger\" parts { name: \"tip\" shape { spheres { centre_m: [0, "
            "0, 0] "
            "radius_m: 0.005 } } } pose_wg { p_m: [0, 0.07, 0] } } bodies { name: \"ball\" shape { "
            "spheres { centre_m: [0, 0, 0] radius_m: 0.05 } } }");
  };
  // No machine does a tick in a nanosecond, and each does one of a ball in a second.
  const ShellOutcome tight = run("explain '" + scene("0.001") + "'");
  CHECK(tight.code == 0);
  CHECK(tight.says("bounded to 0.001 us of processor time, the budget of automatic quality\n"));
  CHECK(tight.says("ticks would be cut short"));
  CHECK_FALSE(tight.says("no tick of"));
  const ShellOutcome ample = run("explain '" + scene("1000000") + "'");
  CHECK(ample.says("no tick of "));
}

}  // namespace hapticd::test
