// The hand's motion between judged poses. Truth: the differences by hand.
#include "core/simulation/tool_renderer.h"

#include <doctest/doctest.h>

#include <cmath>

#include "core/math/rotation.h"
#include "tests/support/within.h"

namespace hapticd::test {

TEST_CASE("velocity follows true elapsed time and is left alone by repeated or backward stamps") {
  HandMotion motion;
  CHECK(follow({0, {0, 0, 0}, {1, 0, 0, 0}}, motion) == 0.0);
  const double dt_s =
      follow({2'000'000, {0.004, 0, 0}, to_array(exp_rotation({0, 0, 0.01}))}, motion);
  CHECK(dt_s == within(2e-3, 1e-15));
  CHECK(motion.V_WH.v.x() == within(2.0, 1e-12));
  CHECK(motion.V_WH.w.z() == within(5.0, 1e-12));

  for (const std::int64_t stamp :
       {std::int64_t{2'000'000}, std::int64_t{1'000'000}, std::int64_t{-5}}) {
    CHECK(follow({stamp, {0.005, 0, 0}, {1, 0, 0, 0}}, motion) == 0.0);
    CHECK(motion.V_WH.v.x() == within(2.0, 1e-12));
    CHECK(motion.X_WH.p.x() == 0.005);
  }
}

TEST_CASE("a five millisecond gap is integrated whole and a longer pause counts as five") {
  HandMotion motion;
  CHECK(follow({0, {}, {1, 0, 0, 0}}, motion) == 0.0);
  CHECK(follow({5'000'000, {}, {1, 0, 0, 0}}, motion) == within(5e-3, 1e-15));
  CHECK(follow({9'000'000'000, {}, {1, 0, 0, 0}}, motion) == kMaxElapsed);
}

TEST_CASE("a quaternion with norm between a half and two is normalised") {
  for (const double norm : {0.5, 0.9, 1.1, 2.0}) {
    HandMotion motion;
    CHECK(follow({0, {}, {norm * 0.6, 0, norm * 0.8, 0}}, motion) == 0.0);
    CHECK(std::abs(motion.X_WH.q.norm() - 1.0) < 1e-15);
    CHECK(motion.X_WH.q.y() == within(0.8, 1e-15));
  }
}

}  // namespace hapticd::test
