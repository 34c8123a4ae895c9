// The realtime promise of the whole tick with strings that yield, ring and rub: nothing allocated
// over a long session, and the same bits whatever instruction set the loops choose.
#include <doctest/doctest.h>

#include "core/math/cpu.h"
#include "tests/realtime/string_session.h"
#include "tests/support/no_heap.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr StringSession::Play kPlays[] = {
    StringSession::Play::kPaper, StringSession::Play::kDeflecting, StringSession::Play::kModes};

}  // namespace

TEST_CASE("a hundred thousand ticks of playing touch no heap") {
  for (const auto play : kPlays) {
    StringSession session(play);
    session.run(10);
    const std::int64_t ticks = scaled(100'000) / 3 + 6000;
    const NoHeapScope scope;
    session.run(ticks);
    const std::int64_t touched = scope.count();
    CHECK(touched == 0);
    MESSAGE(ticks << " ticks: " << session.contact_ticks() << " in contact, "
                  << session.struck_ticks() << " struck, " << session.tones() << " tones, "
                  << session.faults() << " faults");
    CHECK(session.contact_ticks() > ticks / 20);
    CHECK(session.struck_ticks() > 10);
    CHECK(session.tones() > 5);
    CHECK(session.faults() > 0);
  }
}

TEST_CASE("playing gives the same bits with and without AVX2") {
  for (const auto play : kPlays) {
    StringSession with(play);
    with.run(3000);
    allow_avx2(false);
    StringSession without(play);
    without.run(3000);
    allow_avx2(true);
    CHECK(with.hash() == without.hash());
  }
}

TEST_CASE("the same playing twice gives the same bits, another one does not") {
  for (const auto play : kPlays) {
    StringSession a(play);
    StringSession b(play);
    a.run(3000);
    b.run(3000);
    CHECK(a.hash() == b.hash());
    b.run(1);
    CHECK(a.hash() != b.hash());
  }
}

}  // namespace hapticd::test
