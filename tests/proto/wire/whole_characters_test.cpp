// Texts that are cut stay text, whatever they were: judged by protobuf's own rule for strings.
#include "proto/wire/whole_characters.h"

#include <doctest/doctest.h>
#include <google/protobuf/stubs/common.h>

#include <algorithm>
#include <array>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::wire {
namespace {

bool is_text(const std::string& bytes) {
  return google::protobuf::internal::IsStructurallyValidUTF8(bytes);
}

}  // namespace

TEST_CASE("text is cut between characters and otherwise left as it is") {
  const std::string text = "a\xc3\xa4\xe2\x82\xac\xf0\x9f\x8e\xb8z";
  const std::array<std::size_t, 12> lengths{0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10, 11};
  for (std::size_t bytes = 0; bytes < lengths.size(); ++bytes) {
    CHECK(whole_characters(text, bytes) == text.substr(0, lengths[bytes]));
  }
}

TEST_CASE("bytes of no character become question marks") {
  CHECK(whole_characters("a\377b", 9) == "a?b");
  CHECK(whole_characters("\xc3", 9) == "?");
  CHECK(whole_characters("\xe2\x82", 9) == "??");
  CHECK(whole_characters("\xc0\xaf", 9) == "??");            // longer than it needs to be
  CHECK(whole_characters("\xed\xa0\x80", 9) == "???");       // half of a pair of UTF-16
  CHECK(whole_characters("\xf4\x90\x80\x80", 9) == "????");  // beyond the last character
  CHECK(whole_characters(std::string(20, '\x80'), 9) == "?????????");
}

TEST_CASE("whatever the bytes are, what is cut from them is text, and as long as it can be") {
  hapticd::test::SplitMix64 random(71);
  const std::array<std::string, 14> pieces{
      "a",        "\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\x8e\xb8", "\xff", "\x80",     "\xc3",
      "\xe2\x82", "\xf0\x9f", "\xed\xa0\x80", "\xc0\xaf",         "\xf5", "\xe0\x80", "\xf4\x90"};
  const std::int64_t count = hapticd::test::scaled(100'000);
  for (std::int64_t i = 0; i < count; ++i) {
    std::string bytes;
    const std::uint64_t length = random.below(12);
    const bool any = random.chance(0.3);
    for (std::uint64_t k = 0; k < length; ++k) {
      bytes += any ? std::string(1, static_cast<char>(random.below(256)))
                   : pieces[random.below(pieces.size())];
    }
    const std::size_t most = random.below(30);
    const std::string text = whole_characters(bytes, most);
    CAPTURE(bytes);
    CHECK(is_text(text));
    CHECK(text.size() <= most);
    CHECK(text.size() + 3 >= std::min(most, bytes.size()));
    if (is_text(bytes)) CHECK(text == bytes.substr(0, text.size()));
    if (bytes.size() <= most) CHECK(text.size() == bytes.size());
  }
}

}  // namespace hapticd::wire
