// Descriptors item by item against what HID 1.11 says of them.
#include "device/pid/field_descriptor.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using pid::Descriptor;
using pid::read_fields;

DescriptorFlaw flaw_of(const Bytes& bytes) {
  const Descriptor descriptor = read_fields(bytes);
  CHECK(descriptor.flaw != DescriptorFlaw::kNone);
  CHECK(descriptor.fields.empty());
  CHECK(descriptor.collections.empty());
  return descriptor.flaw;
}

}  // namespace

TEST_CASE("a logical maximum is unsigned where the minimum has no sign") {
  // One field of -1..-1 would be empty; 0..255 it is.
  const Descriptor none = read_fields(
      Bytes{0x05, 0x01, 0x09, 0x30, 0x15, 0x00, 0x25, 0xFF, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02});
  REQUIRE(none.fields.size() == 1);
  CHECK(none.fields[0].maximum == 255);
  CHECK(none.fields[0].bit == 0);
  const Descriptor with_sign = read_fields(Bytes{0x85, 0x07, 0x05, 0x01, 0x09, 0x30, 0x15, 0x81,
                                                 0x25, 0x7F, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02});
  REQUIRE(with_sign.fields.size() == 1);
  CHECK(with_sign.fields[0].minimum == -127);
  CHECK(with_sign.fields[0].maximum == 127);
  CHECK(with_sign.fields[0].bit == 8);
  CHECK(with_sign.fields[0].report_id == 7);
}

TEST_CASE("globals are pushed and popped, and the page in force at the main item counts") {
  const Descriptor descriptor =
      read_fields(Bytes{0x05, 0x09, 0x75, 0x08, 0x95, 0x01, 0x25, 0x01, 0xA4, 0x09,
                        0x30, 0x05, 0x01, 0x81, 0x02, 0xB4, 0x09, 0x02, 0x81, 0x02});
  REQUIRE(descriptor.fields.size() == 2);
  CHECK(descriptor.fields[0].usages[0] == usage_of(0x01, 0x30));
  CHECK(descriptor.fields[1].usages[0] == usage_of(0x09, 0x02));
  CHECK(descriptor.fields[1].bit == 8);
}

TEST_CASE("globals are pushed and popped as often as one likes, four deep") {
  Bytes bytes;
  for (int k = 0; k < 9; ++k) bytes.insert(bytes.end(), {0xA4, 0xA4, 0xB4, 0xB4});
  CHECK(read_fields(bytes).flaw == DescriptorFlaw::kNone);
}

TEST_CASE("constants are no fields, whatever their usage, but take their bits") {
  const Descriptor descriptor = read_fields(Bytes{0x05, 0x01, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x01,
                                                  0x09, 0x30, 0x81, 0x03, 0x09, 0x31, 0x81, 0x02});
  REQUIRE(descriptor.fields.size() == 1);
  CHECK(descriptor.fields[0].usages[0] == usage_of(0x01, 0x31));
  CHECK(descriptor.fields[0].bit == 8);
}

TEST_CASE("a long item is passed over") {
  const Descriptor descriptor =
      read_fields(Bytes{0xFE, 0x02, 0x10, 0xC0, 0xC0, 0x05, 0x01, 0x09, 0x30, 0x25, 0x7F, 0x75,
                        0x08, 0x95, 0x01, 0x81, 0x02});
  CHECK(descriptor.fields.size() == 1);
}

TEST_CASE("a flaw is named, and nothing else told") {
  CHECK(flaw_of({0xA1, 0x01}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0xC0}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0xB4}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0xA4, 0xA4, 0xA4, 0xA4, 0xA4}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0x26, 0xFF}) == DescriptorFlaw::kCutOff);
  CHECK(flaw_of({0xFE, 0x02, 0x10, 0x00}) == DescriptorFlaw::kCutOff);
  CHECK(flaw_of({0x85, 0x00}) == DescriptorFlaw::kBadReportId);
  CHECK(flaw_of({0x86, 0x00, 0x01}) == DescriptorFlaw::kBadReportId);
  CHECK(flaw_of(Bytes(4097, 0x81)) == DescriptorFlaw::kTooLong);
  // 2^32 - 1 fields of 2^32 - 1 bits.
  CHECK(flaw_of({0x77, 0xFF, 0xFF, 0xFF, 0xFF, 0x97, 0xFF, 0xFF, 0xFF, 0xFF, 0x81, 0x02}) ==
        DescriptorFlaw::kTooLarge);
}

TEST_CASE("as many usages as one item may have are kept, however many are announced") {
  // Usages 0 to 2^32 - 1 for 200 bits.
  const Descriptor descriptor =
      read_fields(Bytes{0x05, 0x09, 0x1B, 0,    0,    0,    0,    0x2B, 0xFF, 0xFF,
                        0xFF, 0xFF, 0x25, 0x01, 0x75, 0x01, 0x95, 0xC8, 0x81, 0x02});
  CHECK(descriptor.fields.size() == pid::kMaxUsages);
}

}  // namespace hapticd::test
