// The fixed vector against std::vector, and what it does when full.
#include "core/math/fixed_vector.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using hapticd::FixedVector;

}  // namespace

TEST_CASE("a fixed vector refuses what does not fit, counts it and keeps its elements") {
  FixedVector<int, 2> vector;
  CHECK(vector.empty());
  CHECK(vector.push_back(1));
  CHECK(vector.push_back(2));
  CHECK(vector.full());
  CHECK_FALSE(vector.push_back(3));
  CHECK_FALSE(vector.push_back(4));
  CHECK(vector.overflow() == 2);
  CHECK(vector.size() == 2);
  CHECK(vector[0] == 1);
  CHECK(vector[1] == 2);

  vector.truncate(1);
  CHECK(vector.size() == 1);
  CHECK(vector.overflow() == 2);
  vector.clear();
  CHECK(vector.empty());
  CHECK(vector.overflow() == 0);
}

TEST_CASE("a fixed vector behaves as std::vector with a limit under random operations") {
  constexpr std::size_t kCapacity = 7;
  hapticd::test::SplitMix64 random(501);
  FixedVector<std::uint64_t, kCapacity> vector;
  std::vector<std::uint64_t> model;
  std::uint64_t refused = 0;
  bool same = true;
  const std::int64_t count = hapticd::test::scaled(200'000);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::uint64_t choice = random.below(20);
    if (choice == 0) {
      vector.clear();
      model.clear();
      refused = 0;
    } else if (choice == 1) {
      const auto size = static_cast<std::size_t>(random.below(model.size() + 1));
      vector.truncate(size);
      model.resize(size);
    } else {
      const std::uint64_t value = random.next();
      const bool fits = model.size() < kCapacity;
      same = same && vector.push_back(value) == fits;
      if (fits) {
        model.push_back(value);
      } else {
        ++refused;
      }
    }
    same = same && vector.overflow() == refused &&
           std::equal(vector.begin(), vector.end(), model.begin(), model.end());
  }
  CHECK(same);
}

TEST_CASE("a fixed vector never touches the heap") {
  const hapticd::test::NoHeapScope scope;
  FixedVector<double, 64> vector;
  for (int i = 0; i < 100; ++i) vector.push_back(i);
  vector.truncate(3);
  vector.clear();
  const std::int64_t heap_calls = scope.count();
  CHECK(heap_calls == 0);
}
