// What goes through the ring comes out once, in order, whole, and is freed once.
#include "core/rt/owner_ring.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <thread>

#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace {

using hapticd::OwnerRing;
using hapticd::test::scaled;

/// Counts those that live.
class Counted {
 public:
  Counted(std::uint64_t number, int& living) : number_(number), living_(living) { ++living_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted() { --living_; }
  [[nodiscard]] std::uint64_t number() const { return number_; }

 private:
  std::uint64_t number_;
  int& living_;
};

using Ring = OwnerRing<std::unique_ptr<Counted>, 4>;

}  // namespace

TEST_CASE("a ring of owners gives back what it took, in order, and nothing else") {
  hapticd::test::SplitMix64 random(28);
  int living = 0;
  {
    Ring ring;
    std::deque<std::uint64_t> model;
    std::uint64_t last = 0;
    for (std::int64_t k = 0; k < scaled(20'000); ++k) {
      if (random.chance(0.5)) {
        auto owner = std::make_unique<Counted>(++last, living);
        const bool fits = model.size() < Ring::capacity();
        REQUIRE(ring.push(owner) == fits);
        REQUIRE((owner == nullptr) == fits);
        if (fits) model.push_back(last);
      } else {
        const std::unique_ptr<Counted> owner = ring.pop();
        REQUIRE((owner == nullptr) == model.empty());
        if (model.empty()) continue;
        REQUIRE(owner->number() == model.front());
        model.pop_front();
      }
      REQUIRE(living == static_cast<int>(model.size()));
    }
    auto owner = std::make_unique<Counted>(++last, living);
    static_cast<void>(ring.pop());
    CHECK(ring.push(owner));
  }
  CHECK(living == 0);
}

TEST_CASE("a ring of owners leaves the heap alone") {
  int living = 0;
  Ring ring;
  auto owner = std::make_unique<Counted>(1, living);
  bool whole = true;
  const hapticd::test::NoHeapScope scope;
  for (int k = 0; k < 10; ++k) {
    whole = ring.push(owner) && owner == nullptr && whole;
    owner = ring.pop();
  }
  const std::int64_t heap_calls = scope.count();
  CHECK(heap_calls == 0);
  CHECK(whole);
  CHECK(owner->number() == 1);
}

TEST_CASE("owners pass between two threads, each one once") {
  const auto count = static_cast<std::uint64_t>(scaled(200'000));
  OwnerRing<std::unique_ptr<std::uint64_t>, 8> ring;
  std::uint64_t wrong = 0;
  std::thread reader([&] {
    for (std::uint64_t number = 1; number <= count;) {
      const std::unique_ptr<std::uint64_t> owner = ring.pop();
      if (owner == nullptr) continue;
      if (*owner != number) ++wrong;
      ++number;
    }
  });
  for (std::uint64_t number = 1; number <= count; ++number) {
    auto owner = std::make_unique<std::uint64_t>(number);
    while (!ring.push(owner)) std::this_thread::yield();
  }
  reader.join();
  CHECK(wrong == 0);
}
