// The watch over frames, in a time of the test's own, against frames that are written here from
// RFC 6455, section 5.2.
#include "clients/web/gateway/frame_watch.h"

#include <doctest/doctest.h>

#include <optional>
#include <string>
#include <vector>

#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

using web::FrameWatch;

constexpr unsigned kContinuation = 0x0;
constexpr unsigned kBinary = 0x2;
constexpr unsigned kPong = 0xa;

std::string frame(bool last, unsigned opcode, std::size_t size, bool masked = true) {
  std::string bytes(1, static_cast<char>((last ? 0x80U : 0U) | opcode));
  const unsigned mask = masked ? 0x80U : 0U;
  const std::size_t wide = size > 0xffff ? 8 : (size > 125 ? 2 : 0);
  bytes += static_cast<char>(mask | (wide == 8 ? 127U : (wide == 2 ? 126U : unsigned(size))));
  for (std::size_t i = wide; i-- > 0;) bytes += static_cast<char>(size >> (8 * i) & 0xffU);
  if (masked) bytes += "mask";
  return bytes + std::string(size, '\x85');
}

TEST_CASE("a peer that sends whole messages owes nothing, however long they are") {
  FrameWatch watch;
  CHECK_FALSE(watch.unfinished_since_ns().has_value());
  std::int64_t now_ns = 0;
  for (const std::size_t size : {0U, 1U, 125U, 126U, 65'535U, 65'536U, 100'000U}) {
    for (const bool masked : {false, true}) {
      watch.take(frame(true, kBinary, size, masked), ++now_ns);
      CHECK_FALSE(watch.unfinished_since_ns().has_value());
      watch.take(frame(true, kPong, 0, masked), ++now_ns);
      CHECK_FALSE(watch.unfinished_since_ns().has_value());
    }
  }
}

TEST_CASE("half a frame is owed since its first byte, whatever comes of it later") {
  const std::string whole = frame(true, kBinary, 70'000);
  FrameWatch watch;
  for (std::size_t i = 0; i + 1 < whole.size(); ++i) {
    watch.take(whole.substr(i, 1), 1000 + static_cast<std::int64_t>(i));
    REQUIRE(watch.unfinished_since_ns() == 1000);
  }
  watch.take(whole.substr(whole.size() - 1), 99'999);
  CHECK_FALSE(watch.unfinished_since_ns().has_value());
}

TEST_CASE(
    "a message of many frames is owed until its last, empty ones and pongs between them too") {
  FrameWatch watch;
  watch.take(frame(false, kBinary, 3), 5);
  for (std::int64_t now_ns = 6; now_ns < 1000; ++now_ns) {
    watch.take(frame(false, kContinuation, now_ns % 2 == 0 ? 0U : 7U), now_ns);
    CHECK(watch.unfinished_since_ns() == 5);
    watch.take(frame(true, kPong, 4), now_ns);
    CHECK(watch.unfinished_since_ns() == 5);
  }
  watch.take(frame(true, kContinuation, 0), 1000);
  CHECK_FALSE(watch.unfinished_since_ns().has_value());
}

TEST_CASE("what begins behind the end of another is owed since then, and not since before") {
  FrameWatch watch;
  watch.take(frame(false, kBinary, 3), 1);
  watch.take(frame(true, kContinuation, 3) + frame(true, kPong, 9).substr(0, 4), 2);
  CHECK(watch.unfinished_since_ns() == 2);
}

TEST_CASE("however frames are cut into pieces, what is owed is told after each") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (std::int64_t run = 0; run < scaled(300); ++run) {
    // Messages, and for each byte of all whether one is open behind it, and where that began.
    std::string all;
    std::vector<std::optional<std::size_t>> open;
    for (int message = 0; message < 8; ++message) {
      const bool control = random.chance(0.3);
      const std::size_t begin = all.size();
      const std::size_t frames = control ? 1 : 1 + random.below(4);
      for (std::size_t i = 0; i < frames; ++i) {
        if (!control && i > 0 && random.chance(0.3)) all += frame(true, kPong, random.below(126));
        const bool last = i + 1 == frames;
        const unsigned opcode = control ? kPong : (i == 0 ? kBinary : kContinuation);
        all += frame(last, opcode, random.below(control ? 126U : 400U), random.chance(0.8));
      }
      open.resize(all.size() - 1, begin);
      open.emplace_back();
    }
    FrameWatch watch;
    // The clock is the number of bytes before the piece.
    std::vector<std::size_t> piece_of(all.size());
    for (std::size_t at = 0; at < all.size();) {
      const std::size_t size = std::min<std::size_t>(1 + random.below(200), all.size() - at);
      for (std::size_t i = at; i < at + size; ++i) piece_of[i] = at;
      watch.take(all.substr(at, size), static_cast<std::int64_t>(at));
      at += size;
      const auto owed = open[at - 1];
      REQUIRE(watch.unfinished_since_ns().has_value() == owed.has_value());
      if (owed.has_value()) {
        REQUIRE(*watch.unfinished_since_ns() == static_cast<std::int64_t>(piece_of[*owed]));
      }
    }
  }
}

}  // namespace
}  // namespace hapticd::test
