// What of a HELLO is outside of Noise, against Python's hashlib.blake2b.
#include "proto/noise/hello_tag.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace hapticd::noise {
namespace {

std::string hex(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

Key counting_key() {
  Key key;
  for (std::size_t i = 0; i < key.size(); ++i) key[i] = static_cast<std::uint8_t>(i);
  return key;
}

TEST_CASE("key id, key of the MACs and MAC are what another BLAKE2b makes of the same psk") {
  const Key psk = counting_key();
  CHECK(hex(key_id(psk)) == "6146af7fb926cc86");
  CHECK(hex(hello_key(psk)) == "067ae30cce72fdf77f64262d6bcbceb595bd8dd349f5b7b6ad52a810ac1b0707");
  const std::vector<std::uint8_t> before{'a', 'b', 'c'};
  CHECK(hex(hello_tag(hello_key(psk), before)) == "1a0369f5b1e6a73583357ae33c3c17b6");
}

TEST_CASE("a tag is good for all bytes before it, under its key, and whole") {
  const Key key = hello_key(counting_key());
  const std::vector<std::uint8_t> before(74, 7);
  const HelloTag tag = hello_tag(key, before);
  CHECK(is_hello_tag(key, before, tag));
  CHECK(!is_hello_tag(hello_key(Key{}), before, tag));
  for (std::size_t i = 0; i < before.size(); ++i) {
    std::vector<std::uint8_t> other = before;
    other[i] ^= 1U;
    CHECK(!is_hello_tag(key, other, tag));
  }
  for (std::size_t i = 0; i < tag.size(); ++i) {
    HelloTag other = tag;
    other[i] ^= 1U;
    CHECK(!is_hello_tag(key, before, other));
    CHECK(!is_hello_tag(key, before, std::span(tag).first(i)));
  }
}

}  // namespace
}  // namespace hapticd::noise
