// A device that renders the stiffness of contacts by itself, under the whole loop. Truth: a handle
// let go inside a wall flies out as one on a spring does, by the equation of motion in long double;
// a spring rendered from outside, a delay late, gives it energy that no spring has.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/math/rotation.h"
#include "device/simulated/simulated_device.h"
#include "server/haptic_loop/tool_loop.h"
#include "tests/server/haptic_loop/loop_run.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr double kDeep = 0.004;  ///< of the handle in the wall, m
constexpr double kHome = 0.025;  ///< likewise, before it
constexpr double kTip = 0.005;
constexpr double kSkin = 20e-6;

/// An ideal handle but for a delay.
DeviceProfile late_handle(bool affine) {
  DeviceProfile profile;
  profile.peak_force = 20.0;
  profile.peak_torque = 1.0;
  profile.mass = {0.15, 0.15, 0.15};
  profile.damping = 1.0;
  profile.delay = 2e-3;
  profile.affine = affine;
  return profile;
}

/// A loop with that handle before the wall.
struct Flight {
  explicit Flight(bool affine) {
    std::unique_ptr<PlayedScene> played =
        played_scene(kWallScene, 1, {"simulated", "premium_3_0_6dof", false, true});
    const SimulatedOptions options{.X_DH = at(kHome), .arm = ArmKind::kFirm};
    auto made = std::make_unique<SimulatedDevice>(late_handle(affine), options);
    handle = made.get();
    PlayedDevice& place = played->tools[0].device;
    place.device = handle;
    place.facets = {.hand = handle};
    place.owned = std::move(made);
    loop.emplace(LoopOptions{}, std::move(played), *channels);
  }
  static Pose at(double z) { return {Quaternion::Identity(), Vector3(0.0, 0.0, z)}; }
  void tick() {
    now_ns += 1'000'000;
    loop->tick_once(now_ns);
    while (channels->ticks.pop(*told)) tool = told->tools[0];
    const bool spring = (tool.flags & kDeviceSpring) != 0;
    springs += spring ? 1 : 0;
    free_springs += spring && handle->plant().X_DH.p.z() > kTip + 2e-3 ? 1 : 0;
  }
  /// Presses the handle into the wall, lets go, and watches it fly: the fastest it gets, m/s.
  double fly() {
    for (int k = 0; k < 700; ++k) tick();
    for (double z = kHome; z > kTip - kDeep; z -= 2e-4) {
      handle->place(at(z));
      tick();
    }
    for (int k = 0; k < 500; ++k) tick();
    handle->set_arm(ArmKind::kOff);
    depth = kTip + kSkin - handle->plant().X_DH.p.z();
    double fastest = 0.0;
    for (int k = 0; k < 200; ++k) {
      tick();
      fastest = std::max(fastest, handle->plant().V_DH.v.z());
    }
    return fastest;
  }

  std::unique_ptr<LoopChannels> channels = std::make_unique<LoopChannels>();
  std::optional<HapticLoop> loop;
  SimulatedDevice* handle = nullptr;
  std::int64_t now_ns = 1'000'000'000;
  std::unique_ptr<Tick> told = std::make_unique<Tick>();
  ToolTick tool;
  double depth = 0.0;    ///< where the hand let go, m
  int springs = 0;       ///< ticks in which the device had a spring
  int free_springs = 0;  ///< of these well outside the wall
};

/// m z'' = k (0 - z) - b z' from -depth at rest until the spring is let go of: the fastest, m/s.
double fastest_by_the_law(double k, double depth) {
  const DeviceProfile handle = late_handle(true);
  long double z = -depth;
  long double v = 0.0L;
  long double fastest = 0.0L;
  constexpr long double kStep_s = 1e-6L;
  while (z < 0.0L) {
    v += kStep_s * (-k * z - handle.damping * v) / handle.mass[2];
    z += kStep_s * v;
    fastest = std::max(fastest, v);
  }
  return static_cast<double>(fastest);
}

}  // namespace

TEST_CASE("let go in a wall, the handle flies out as from a spring if the device renders it") {
  Flight affine(true);
  const double fastest = affine.fly();
  const double k = 1000.0 * affine.tool.stiffness.scale;
  const double truth = fastest_by_the_law(k, affine.depth);
  CAPTURE(affine.depth);
  CAPTURE(k);
  CHECK(affine.springs > 50);
  CHECK(affine.free_springs == 0);
  Flight plain(false);
  const double late = plain.fly();
  CHECK(plain.springs == 0);
  const double late_truth = fastest_by_the_law(1000.0 * plain.tool.stiffness.scale, plain.depth);
  MESSAGE("speed over the law's: ", fastest / truth, " by the device, ", late / late_truth,
          " by the loop");
  CHECK(std::abs(fastest / truth - 1.0) < 0.01);
  CHECK(late / late_truth - 1.0 > 0.03);
}

TEST_CASE(
    "the spring at a device turned, mirrored and scaled is what moving it does to its force") {
  SplitMix64 random(7);
  for (int k = 0; k < 200; ++k) {
    WorkspaceMap map;
    map.scale = random.uniform(0.2, 5.0);
    map.X_WD.q = exp_rotation(to_vector(random.direction()) * random.uniform(0.0, 3.0));
    map.mirror = static_cast<Mirror>(random.below(3));
    const Vector3 n = to_vector(random.direction());
    const Vector3 m = to_vector(random.direction());
    ContactStiffness K;
    K.K_W = 800.0 * n * n.transpose() + 100.0 * m * m.transpose();
    K.Kr_W = 0.5 * n * n.transpose();
    const double gain = random.uniform(0.1, 2.0);
    const DeviceSpring spring = spring_at_device(map, K, gain);
    const auto& [xx, yy, zz, xy, xz, yz] = spring.K_D;
    Matrix3 K_D;
    K_D << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    const Vector3 way = to_vector(random.direction()) * 1e-3;
    const Vector3 way_W = to_world(map, Twist{way, Vector3::Zero()}).v;
    const Wrench pull = to_device(map, Wrench{gain * K.K_W * way_W, Vector3::Zero()});
    CHECK((K_D * way - pull.f).norm() < 1e-12 * pull.f.norm() + 1e-15);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 turn = Vector3::Unit(static_cast<Eigen::Index>(i));
      const Vector3 turn_W = to_world(map, Twist{Vector3::Zero(), turn}).w;
      const Wrench back = to_device(map, Wrench{Vector3::Zero(), gain * K.Kr_W * turn_W});
      CHECK(std::abs(spring.Kr_D[i] - back.t.dot(turn)) < 1e-12 * back.t.norm());
    }
  }
}

}  // namespace hapticd::test
