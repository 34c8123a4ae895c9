// What the guided check makes of movements and answers. Truth: a device whose handle is known to
// the micrometre, mapped by the formula of axis_map as its comments have it.
#include "clients/ctl/check_verdict.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

namespace hapticd::test {
namespace {

using ctl::Movement;
using Axes = std::array<v1::Axis, 3>;
using Vector = std::array<double, 3>;

constexpr v1::Axis kX = v1::AXIS_POSITIVE_X, kY = v1::AXIS_POSITIVE_Y, kZ = v1::AXIS_POSITIVE_Z;

Vector unit(v1::Axis axis) {
  switch (axis) {
    case v1::AXIS_POSITIVE_X:
      return {1, 0, 0};
    case v1::AXIS_NEGATIVE_X:
      return {-1, 0, 0};
    case v1::AXIS_POSITIVE_Y:
      return {0, 1, 0};
    case v1::AXIS_NEGATIVE_Y:
      return {0, -1, 0};
    case v1::AXIS_POSITIVE_Z:
      return {0, 0, 1};
    default:
      return {0, 0, -1};
  }
}

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// D as the profile makes it of a raw reading: component i is that along axes[i].
Vector in_base(const Axes& axes, const Vector& raw) {
  return {dot(unit(axes[0]), raw), dot(unit(axes[1]), raw), dot(unit(axes[2]), raw)};
}

v1::DeviceProfile profile_with(const Axes& axes) {
  v1::DeviceProfile profile;
  for (const v1::Axis axis : axes) profile.mutable_axis_map()->add_axes(axis);
  return profile;
}

/// All 48 ways in which axes can lie.
std::vector<Axes> all_axes() {
  std::vector<Axes> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (unsigned signs = 0; signs < 8; ++signs) {
      Axes axes{};
      for (unsigned i = 0; i < 3; ++i) {
        axes[i] = static_cast<v1::Axis>(1 + 2 * order[i] + static_cast<int>(signs >> i & 1U));
      }
      all.push_back(axes);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

/// What is told, under the profile `told`, of a movement along +i of a device that lies as `truth`.
v1::Axis came_as(const Axes& truth, const Axes& told, int i) {
  // The raw reading of a unit movement along +i is the raw direction that is i in truth.
  const Vector d = in_base(told, unit(truth[static_cast<std::size_t>(i)]));
  const ctl::MovementVerdict verdict = ctl::judge_movement({0.03 * d[0], 0.03 * d[1], 0.03 * d[2]});
  REQUIRE(verdict.movement == Movement::kClear);
  return verdict.came;
}

}  // namespace

TEST_CASE("whatever a profile says of the axes, three movements tell how they lie in truth") {
  for (const Axes& truth : all_axes()) {
    for (const Axes& told : all_axes()) {
      const Axes came{came_as(truth, told, 0), came_as(truth, told, 1), came_as(truth, told, 2)};
      const auto mended = ctl::mended_axes(profile_with(told), came);
      REQUIRE(mended.has_value());
      CHECK(*mended == truth);
    }
  }
}

TEST_CASE("of a device of two axes the third is what is left over") {
  // Raw x and y are told to be left and up; in truth they are right and toward the user.
  const v1::DeviceProfile told = profile_with({v1::AXIS_NEGATIVE_X, kY, kZ});
  const auto mended =
      ctl::mended_axes(told, {v1::AXIS_NEGATIVE_X, v1::AXIS_UNSPECIFIED, v1::AXIS_POSITIVE_Y});
  REQUIRE(mended.has_value());
  CHECK((*mended)[0] == kX);
  CHECK((*mended)[2] == kY);
  CHECK((*mended)[1] == kZ);
  CHECK(ctl::axes_line(*mended) ==
        "axis_map { axes: [AXIS_POSITIVE_X, AXIS_POSITIVE_Z, AXIS_POSITIVE_Y] }");
}

TEST_CASE("movements that contradict each other mend nothing") {
  const v1::DeviceProfile plain;
  CHECK_FALSE(ctl::mended_axes(plain, {kX, kX, kZ}).has_value());
  CHECK_FALSE(
      ctl::mended_axes(plain, {kX, v1::AXIS_UNSPECIFIED, v1::AXIS_UNSPECIFIED}).has_value());
}

TEST_CASE("a movement is clear when it is long enough and along one axis") {
  CHECK(ctl::judge_movement({0.03, 0.0, 0.0}).came == kX);
  CHECK(ctl::judge_movement({0.01, 0.012, -0.03}).came == v1::AXIS_NEGATIVE_Z);
  CHECK(ctl::judge_movement({0.0, -0.04, 0.0}).length == doctest::Approx(0.04));
  CHECK(ctl::judge_movement({0.0, 0.009, 0.0}).movement == Movement::kTooShort);
  CHECK(ctl::judge_movement({0.0, 0.0, 0.0}).movement == Movement::kTooShort);
  CHECK(ctl::judge_movement({0.03, 0.025, 0.0}).movement == Movement::kOblique);
}

TEST_CASE("answers are directions by their first letter, or nothing") {
  CHECK(ctl::direction_of("r") == kX);
  CHECK(ctl::direction_of("Left") == v1::AXIS_NEGATIVE_X);
  CHECK(ctl::direction_of(" u") == kY);
  CHECK(ctl::direction_of("down") == v1::AXIS_NEGATIVE_Y);
  CHECK(ctl::direction_of("t") == kZ);
  CHECK(ctl::direction_of("away") == v1::AXIS_NEGATIVE_Z);
  for (const char* other : {"", " ", "n", "x", "1"}) CHECK_FALSE(ctl::direction_of(other));
  CHECK(ctl::felt_nothing("Nothing"));
  CHECK_FALSE(ctl::felt_nothing(""));
}

TEST_CASE("each direction of each axis is pushed once, in an order that depends on the seed") {
  std::set<std::vector<v1::Axis>> orders;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const std::vector<v1::Axis> order = ctl::push_order({true, true, true}, seed);
    CHECK(order.size() == 6);
    CHECK(std::set<v1::Axis>(order.begin(), order.end()).size() == 6);
    CHECK(order == ctl::push_order({true, true, true}, seed));
    orders.insert(order);
  }
  CHECK(orders.size() > 30);
  const std::vector<v1::Axis> two = ctl::push_order({true, false, true}, 7);
  CHECK(std::set<v1::Axis>(two.begin(), two.end()) ==
        std::set<v1::Axis>{kX, v1::AXIS_NEGATIVE_X, kZ, v1::AXIS_NEGATIVE_Z});
}

TEST_CASE("a device of two axes pushes along those that its raw x and y become") {
  v1::DeviceProfile stick = profile_with({kX, v1::AXIS_NEGATIVE_Z, kY});
  stick.mutable_actuated_axes()->add_value(2.0);
  CHECK(ctl::pushed_axes(stick) == std::array<bool, 3>{true, false, true});
  CHECK(ctl::sensed_axes(stick) == std::array<bool, 3>{true, true, true});
  stick.mutable_actuated_axes()->set_value(0, 0.0);
  CHECK(ctl::pushed_axes(stick) == std::array<bool, 3>{false, false, false});
}

TEST_CASE("a push felt the other way round is mended by its sign, on top of the present signs") {
  v1::DeviceProfile profile;
  CHECK(ctl::push_advice(profile, kY, v1::AXIS_NEGATIVE_Y).find("value: [1, -1, 1]") !=
        std::string::npos);
  for (const double sign : {1.0, -1.0, -1.0}) {
    profile.mutable_axis_map()->mutable_force_sign()->add_value(sign);
  }
  CHECK(ctl::push_advice(profile, v1::AXIS_NEGATIVE_Y, kY).find("value: [1, 1, -1]") !=
        std::string::npos);
  CHECK(ctl::push_advice(profile, kX, kZ).find("firmware") != std::string::npos);
}

}  // namespace hapticd::test
