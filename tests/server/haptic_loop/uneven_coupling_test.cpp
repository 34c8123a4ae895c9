// Couplings whose axes differ, on a device and in a snapshot. Truth: the clamp's closed form, and
// what was written.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "core/contact/coupling_axes.h"
#include "core/simulation/simulation_fields.h"
#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr double kPiSquaredOver4 = 2.4674011002723395;

std::string scene_of(const Vector3& along_W, const Vector3& about_G) {
  const auto list = [](const Vector3& v) {
    return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " +
           std::to_string(v.z()) + "]";
  };
  return R"(name: "uneven"
tools {
  name: "pen"
  parts { name: "tip" shape { spheres { centre_m: [0, 0, 0] radius_m: 0.005 } } }
  pose_wg { p_m: [0, 0, 0.025] }
  coupling { kt_w_n_per_m: )" +
         list(along_W) + " kr_g_n_m_per_rad: " + list(about_G) + R"( }
}
bodies { name: "wall" shape { spheres { centre_m: [0, 0, -1000] radius_m: 1000 } } }
torque {}
)";
}

Vector3 uneven(SplitMix64& random, double low, double high) {
  Vector3 k;
  for (Eigen::Index i = 0; i < 3; ++i) k[i] = low * std::pow(high / low, random.uniform());
  return k;
}

TEST_CASE("no axis of a coupling is rendered above what the device bears") {
  const std::uint64_t seed = std::random_device{}();
  MESSAGE("seed " << seed);
  SplitMix64 random(seed);
  int clamped = 0;
  for (int k = 0; k < 20; ++k) {
    const auto played =
        played_scene(scene_of(uneven(random, 100.0, 1e5), uneven(random, 0.5, 100.0)), 1,
                     {"simulated", "premium_3_0_6dof", false, true});
    const PlayedTool& tool = played->tools[0];
    const CouplingStiffness& felt = played->play.simulation->scene(0).stiffness;
    const CouplingStiffness& wanted = played->settings.tools[0].coupling;
    REQUIRE(felt.per_axis);
    CHECK(felt.along_W().maxCoeff() <= tool.grant.bound * (1.0 + 1e-12));
    const double least = felt.about_G().minCoeff();
    const double most = felt.about_G().maxCoeff();
    CHECK(least + kPiSquaredOver4 * (most - least) <= tool.grant.rotational_bound * (1.0 + 1e-12));
    // A clamped world is softer, not different.
    CHECK((felt.along_W() - tool.grant.scale * wanted.along_W()).norm() <= 1e-9 * wanted.kt);
    CHECK((felt.about_G() - tool.grant.scale * wanted.about_G()).norm() <= 1e-9 * wanted.kr());
    clamped += tool.grant.scale < 1.0 ? 1 : 0;
  }
  CHECK(clamped > 0);
}

TEST_CASE("settings with six stiffnesses come back from a snapshot, and no others take more room") {
  LiveSettings six;
  six.coupling = coupling_of_axes({10, 20, 5000}, {0.1, 2.0, 0.3});
  for (const LiveSettings& settings : {LiveSettings{}, six}) {
    std::array<double, 64> reals{};
    std::array<std::int64_t, 64> integers{};
    StateWriter write({reals, integers});
    write(settings);
    REQUIRE(write.good());
    StateReader read({reals.data(), write.reals()}, {integers.data(), write.integers()});
    LiveSettings back;
    back.coupling.per_axis = !settings.coupling.per_axis;
    read(back);
    REQUIRE(read.complete());
    CHECK(back.coupling.per_axis == settings.coupling.per_axis);
    CHECK(back.coupling.kt == settings.coupling.kt);
    CHECK(back.coupling.length == settings.coupling.length);
    if (!settings.coupling.per_axis) continue;
    CHECK(back.coupling.shares.along_W == settings.coupling.shares.along_W);
    CHECK(back.coupling.shares.about_G == settings.coupling.shares.about_G);
  }
}

}  // namespace
}  // namespace hapticd::test
