// Reports against bytes written by hand from the documented layouts.
#include "device/spacemouse/spacemouse_report.h"

#include <doctest/doctest.h>

#include <vector>

namespace hapticd::spacemouse::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("a short report 1 is a translation, low byte first, with sign") {
  // 1, -2 and 350.
  const Report report = decode(Bytes{1, 0x01, 0x00, 0xFE, 0xFF, 0x5E, 0x01});
  CHECK(report.content == Content::kTranslation);
  CHECK(report.translation == Array3{1.0, -2.0, 350.0});
  CHECK(report.rotation == Array3{});
}

TEST_CASE("report 2 is a rotation") {
  // -350, 256 and -1.
  const Report report = decode(Bytes{2, 0xA2, 0xFE, 0x00, 0x01, 0xFF, 0xFF});
  CHECK(report.content == Content::kRotation);
  CHECK(report.rotation == Array3{-350.0, 256.0, -1.0});
  CHECK(report.translation == Array3{});
}

TEST_CASE("a long report 1 has all six axes") {
  const Report report = decode(Bytes{1, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 0xFA, 0xFF});
  CHECK(report.content == Content::kMotion);
  CHECK(report.translation == Array3{1.0, 2.0, 3.0});
  CHECK(report.rotation == Array3{4.0, 5.0, -6.0});
}

TEST_CASE("a report 1 that ends within the second half is a translation alone") {
  const Report report = decode(Bytes{1, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6});
  CHECK(report.content == Content::kTranslation);
  CHECK(report.rotation == Array3{});
}

TEST_CASE("buttons come in as many bytes as the device has") {
  CHECK(decode(Bytes{3, 0x02}).content == Content::kButtons);
  CHECK(decode(Bytes{3, 0x02}).buttons == 2);
  CHECK(decode(Bytes{3, 0x01, 0x80}).buttons == 0x8001);
  CHECK(decode(Bytes{3, 0, 0, 0, 0x80}).buttons == 0x8000'0000);
  CHECK(decode(Bytes{3, 0, 0, 0, 0, 0xFF, 0xFF}).buttons == 0);
}

TEST_CASE("battery and unknown reports are of no consequence, short ones malformed") {
  CHECK(decode(Bytes{0x17, 0x64}).content == Content::kNothing);
  CHECK(decode(Bytes{0x17}).content == Content::kNothing);
  CHECK(decode(Bytes{4, 1}).content == Content::kNothing);
  CHECK(decode(Bytes{}).content == Content::kMalformed);
  CHECK(decode(Bytes{3}).content == Content::kMalformed);
  for (const std::uint8_t id : Bytes{1, 2}) {
    for (std::size_t length = 1; length < 7; ++length) {
      Bytes bytes(length, 0x11);
      bytes[0] = id;
      CHECK(decode(bytes).content == Content::kMalformed);
      CHECK(decode(bytes).translation == Array3{});
      CHECK(decode(bytes).rotation == Array3{});
    }
  }
}

TEST_CASE("a reading beyond any deflection is cut") {
  const Report report = decode(Bytes{1, 0xFF, 0x7F, 0x00, 0x80, 0x00, 0x02});
  CHECK(report.translation == Array3{512.0, -512.0, 512.0});
}

TEST_CASE(
    "a multi-axis controller is one wherever it stands, at the top, with its page before it") {
  const Bytes cap{0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xA1, 0x00, 0xC0, 0xC0};
  const Bytes mouse{0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x01, 0xA1, 0x00, 0xC0, 0xC0};
  const auto joined = [](Bytes first, const Bytes& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  };
  CHECK(has_six_axes(cap));
  CHECK(has_six_axes(joined(mouse, cap)));
  CHECK(has_six_axes(joined(cap, mouse)));
  // The usage with its own page.
  CHECK(has_six_axes(Bytes{0x0B, 0x08, 0x00, 0x01, 0x00, 0xA1, 0x01, 0xC0}));
  CHECK_FALSE(has_six_axes(mouse));
  CHECK_FALSE(has_six_axes(Bytes{}));
  // Another page, a physical collection, a descriptor that is cut off.
  CHECK_FALSE(has_six_axes(Bytes{0x05, 0x0C, 0x09, 0x08, 0xA1, 0x01, 0xC0}));
  CHECK_FALSE(has_six_axes(Bytes{0x05, 0x01, 0x09, 0x08, 0xA1, 0x00, 0xC0}));
  CHECK_FALSE(has_six_axes(Bytes{0x05, 0x01, 0x09, 0x08, 0xA1, 0x01}));
  CHECK_FALSE(has_six_axes(Bytes{0xC0, 0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xC0}));
}

TEST_CASE("receivers are of the family, and known as what mice may be behind") {
  for (const int product : {0xC641, 0xC652, 0xC658}) {
    CAPTURE(product);
    CHECK(is_spacemouse(0x256F, static_cast<std::uint16_t>(product)));
    CHECK(is_receiver(0x256F, static_cast<std::uint16_t>(product)));
    CHECK_FALSE(is_receiver(0x046D, static_cast<std::uint16_t>(product)));
  }
  CHECK_FALSE(is_receiver(0x256F, 0xC635));
}

TEST_CASE("the family is known by its numbers, and mice and keyboards are left alone") {
  CHECK(is_spacemouse(0x046D, 0xC626));        // SpaceNavigator
  CHECK(is_spacemouse(0x046D, 0xC62B));        // SpaceMouse Pro
  CHECK(is_spacemouse(0x256F, 0xC635));        // SpaceMouse Compact
  CHECK(is_spacemouse(0x256F, 0xC62E));        // SpaceMouse Wireless
  CHECK_FALSE(is_spacemouse(0x046D, 0xC077));  // a mouse
  CHECK_FALSE(is_spacemouse(0x256F, 0xC626));
  CHECK_FALSE(is_spacemouse(0x046D, 0xC635));
  for (const int other :
       {0xC62C, 0xC650, 0xC651, 0xC653, 0xC654, 0xC655, 0xC656, 0xC657, 0xC664, 0xC665, 0xC668}) {
    CAPTURE(other);
    CHECK_FALSE(is_spacemouse(0x256F, static_cast<std::uint16_t>(other)));
  }
  int count = 0;
  for (std::uint32_t product = 0; product < 0x10000; ++product) {
    count += is_spacemouse(0x046D, static_cast<std::uint16_t>(product)) ? 1 : 0;
    count += is_spacemouse(0x256F, static_cast<std::uint16_t>(product)) ? 1 : 0;
  }
  CHECK(count == 24);
}

}  // namespace hapticd::spacemouse::test
