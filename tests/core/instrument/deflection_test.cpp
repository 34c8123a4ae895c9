// Closed forms of a deflected string.
#include "core/instrument/deflection.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

TEST_CASE("a string barely deflected is a spring of stiffness k0") {
  StringConstants string;
  string.length = 1.1;
  string.tension = 30.0;
  const double k0 = 30.0 / (1.1 * 0.25);
  CHECK(small_deflection_stiffness(string, 0.5) == doctest::Approx(k0).epsilon(1e-14));
  CHECK(deflection_force(string, 0.5, 1e-9) == doctest::Approx(k0 * 1e-9).epsilon(1e-14));
}

}  // namespace
}  // namespace hapticd::test
