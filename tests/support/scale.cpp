// Reads HAPTICD_TEST_SCALE; the default is compiled in from the CMake variable of the same name.
// Not RT.
#include "tests/support/scale.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace hapticd::test {
namespace {

double read_scale() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): tests do not change the environment
  const char* text = std::getenv("HAPTICD_TEST_SCALE");
  if (text == nullptr || *text == '\0') return HAPTICD_DEFAULT_TEST_SCALE;
  char* end = nullptr;
  const double scale = std::strtod(text, &end);
  if (*end == '\0' && scale > 0.0 && scale <= 1.0) return scale;
  std::fprintf(stderr, "HAPTICD_TEST_SCALE=%s: expected a number above 0 and up to 1\n", text);
  std::abort();
}

}  // namespace

double test_scale() {
  static const double scale = read_scale();
  return scale;
}

std::int64_t scaled(std::int64_t full_count) {
  const double count = static_cast<double>(full_count) * test_scale();
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(count));
}

}  // namespace hapticd::test
