// The realtime promise of the whole contact tick: nothing allocated over a long session of every
// kind of contact, and the same bits whatever instruction set the loops choose.
#include <doctest/doctest.h>

#include "core/math/cpu.h"
#include "tests/realtime/contact_session.h"
#include "tests/support/no_heap.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("a hundred thousand contact ticks of hand, strings and body touch no heap") {
  ContactSession session(ContactSession::Tool::kHand);
  session.run(10);
  const std::int64_t ticks = scaled(100'000) + 10'000;
  const NoHeapScope scope;
  session.run(ticks);
  const std::int64_t touched = scope.count();
  CHECK(touched == 0);
  CHECK(session.contact_ticks() > ticks / 6);
  CHECK(session.faults() > 0);
  CHECK(session.recoveries() > 0);
}

TEST_CASE("the wrench of every tick has the same bits with and without AVX2") {
  for (const auto tool : {ContactSession::Tool::kHand, ContactSession::Tool::kBlob}) {
    ContactSession with(tool);
    with.run(3000);
    allow_avx2(false);
    ContactSession without(tool);
    without.run(3000);
    allow_avx2(true);
    CHECK(with.hash() == without.hash());
  }
}

TEST_CASE("the same session twice gives the same bits, another one does not") {
  ContactSession a(ContactSession::Tool::kHand);
  ContactSession b(ContactSession::Tool::kHand);
  a.run(2000);
  b.run(2000);
  CHECK(a.hash() == b.hash());
  b.run(1);
  CHECK(a.hash() != b.hash());
}

}  // namespace hapticd::test
