// The reader of HID report descriptors: that of the profile, one of a keyboard as the HID
// specification prints it (appendix E.6 of the Device Class Definition 1.11), ones put together by
// hand, and broken ones.
#include "device/hid/report_descriptor.h"

#include <doctest/doctest.h>

#include <vector>

#include "device/hid/reference_firmware/hapticd_device.h"

namespace hapticd::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const Bytes& plain() {
  static const Bytes all(hid::kPlainDescriptor.begin(), hid::kPlainDescriptor.end());
  return all;
}

DescriptorFlaw flaw_of(const Bytes& descriptor) { return hid::read_descriptor(descriptor).flaw; }
bool is_haptic(const Bytes& descriptor) { return hid::read_descriptor(descriptor).is_haptic; }

const Bytes kKeyboard{0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0x05, 0x07, 0x19, 0xE0, 0x29, 0xE7, 0x15,
                      0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0x95, 0x01, 0x75, 0x08,
                      0x81, 0x01, 0x95, 0x05, 0x75, 0x01, 0x05, 0x08, 0x19, 0x01, 0x29, 0x05, 0x91,
                      0x02, 0x95, 0x01, 0x75, 0x03, 0x91, 0x01, 0x95, 0x06, 0x75, 0x08, 0x15, 0x00,
                      0x25, 0x65, 0x05, 0x07, 0x19, 0x00, 0x29, 0x65, 0x81, 0x00, 0xC0};

TEST_CASE("the descriptor of the profile is recognised, with its six reports and their lengths") {
  bool affine = false;
  const hid::DescriptorFacts facts = hid::read_descriptor(hid::kAffineDescriptor);
  CHECK(facts.flaw == DescriptorFlaw::kNone);
  CHECK(facts.is_haptic);
  CHECK(hid::is_profile_v1(facts, &affine));
  CHECK(affine);
  struct Report {
    ReportKind kind;
    int id;
    std::uint64_t bytes;
  };
  const std::array<Report, 6> expected{{{ReportKind::kInput, 0x01, 64},
                                        {ReportKind::kOutput, 0x02, 32},
                                        {ReportKind::kOutput, 0x03, 64},
                                        {ReportKind::kFeature, 0x10, 64},
                                        {ReportKind::kFeature, 0x11, 16},
                                        {ReportKind::kFeature, 0x12, 8}}};
  REQUIRE(facts.reports.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(facts.reports[i].kind == expected[i].kind);
    CHECK(facts.reports[i].id == expected[i].id);
    CHECK(hid::bytes_of(facts.reports[i]) == expected[i].bytes);
  }
}

TEST_CASE("a device without the affine command is one of the profile too") {
  bool affine = true;
  CHECK(hid::is_profile_v1(hid::read_descriptor(plain()), &affine));
  CHECK_FALSE(affine);
}

TEST_CASE("the firmware offers the descriptors that the host knows") {
  std::uint16_t length = 0;
  const std::uint8_t* bytes = hap_report_descriptor(false, &length);
  CHECK(Bytes(bytes, bytes + length) == plain());
  bytes = hap_report_descriptor(true, &length);
  CHECK(Bytes(bytes, bytes + length) ==
        Bytes(hid::kAffineDescriptor.begin(), hid::kAffineDescriptor.end()));
}

TEST_CASE("a keyboard is read and is no haptic device") {
  const hid::DescriptorFacts facts = hid::read_descriptor(kKeyboard);
  CHECK(facts.flaw == DescriptorFlaw::kNone);
  CHECK_FALSE(facts.is_haptic);
  CHECK_FALSE(hid::is_profile_v1(facts));
  REQUIRE(facts.reports.size() == 2);
  // 8 modifier bits, a reserved byte, 6 keys; 5 lamps and 3 bits of padding.
  CHECK(hid::bytes_of(facts.reports[0]) == 8);
  CHECK(hid::bytes_of(facts.reports[1]) == 1);
}

TEST_CASE("a haptic collection is found behind another one, by a usage of four bytes too") {
  CHECK(is_haptic(joined({kKeyboard, plain()})));
  CHECK(is_haptic({0x0B, 0x01, 0x00, 0x48, 0xFF, 0xA1, 0x01, 0xC0}));
  // Whatever page is in force.
  CHECK(is_haptic({0x05, 0x01, 0x0B, 0x01, 0x00, 0x48, 0xFF, 0xA1, 0x01, 0xC0}));
  CHECK_FALSE(is_haptic({0x06, 0x48, 0xFF, 0x0B, 0x01, 0x00, 0x01, 0x00, 0xA1, 0x01, 0xC0}));
  // The page after the usage is the one that counts.
  CHECK(is_haptic({0x09, 0x01, 0x06, 0x48, 0xFF, 0xA1, 0x01, 0xC0}));
  CHECK(is_haptic({0x06, 0x48, 0xFF, 0x0A, 0x01, 0x00, 0xA1, 0x01, 0xC0}));
}

TEST_CASE("another page, another usage, another kind of collection is not haptic") {
  CHECK_FALSE(is_haptic({0x06, 0x49, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0xC0}));
  CHECK_FALSE(is_haptic({0x06, 0x48, 0xFF, 0x09, 0x02, 0xA1, 0x01, 0xC0}));
  CHECK_FALSE(is_haptic({0x06, 0x48, 0xFF, 0x09, 0x01, 0xA1, 0x00, 0xC0}));
  // Not at the top: inside another application.
  CHECK_FALSE(is_haptic(joined({{0x05, 0x01, 0x09, 0x02, 0xA1, 0x01}, plain(), {0xC0}})));
  // A usage belongs to one main item alone.
  CHECK_FALSE(is_haptic({0x06, 0x48, 0xFF, 0x09, 0x01, 0x81, 0x02, 0xA1, 0x01, 0xC0}));
  CHECK_FALSE(is_haptic({}));
}

TEST_CASE("reports of wrong size or missing make no device of the profile") {
  for (std::size_t at = 0; at < plain().size(); ++at) {
    // Every report count of the descriptor, one more.
    if (plain()[at] != 0x95) continue;
    Bytes changed = plain();
    ++changed[at + 1];
    const hid::DescriptorFacts facts = hid::read_descriptor(changed);
    CHECK(facts.is_haptic);
    CHECK_FALSE(hid::is_profile_v1(facts));
  }
  CHECK_FALSE(hid::is_profile_v1(
      hid::read_descriptor(Bytes{0x06, 0x48, 0xFF, 0x09, 0x01, 0xA1, 0x01, 0xC0})));
}

TEST_CASE("pushed globals come back with pop") {
  const Bytes descriptor{0x75, 0x08, 0x95, 0x02, 0x85, 0x05, 0xA4, 0x75, 0x01,
                         0x95, 0x01, 0x85, 0x06, 0x81, 0x02, 0xB4, 0x81, 0x02};
  const hid::DescriptorFacts facts = hid::read_descriptor(descriptor);
  CHECK(facts.flaw == DescriptorFlaw::kNone);
  REQUIRE(facts.reports.size() == 2);
  CHECK(facts.reports[0].id == 6);
  CHECK(facts.reports[0].bits == 1);
  CHECK(facts.reports[1].id == 5);
  CHECK(facts.reports[1].bits == 16);
}

TEST_CASE("long items are stepped over") {
  const Bytes head{0xFE, 0x03, 0x10, 0xC0, 0xC0, 0xC0};
  CHECK(hid::is_profile_v1(hid::read_descriptor(joined({head, plain()}))));
  CHECK(flaw_of({0xFE}) == DescriptorFlaw::kCutOff);
  CHECK(flaw_of({0xFE, 0x00}) == DescriptorFlaw::kCutOff);
  CHECK(flaw_of({0xFE, 0x02, 0x00, 0x00}) == DescriptorFlaw::kCutOff);
}

TEST_CASE("a descriptor cut off anywhere is not taken for a whole one") {
  for (std::size_t length = 0; length < plain().size(); ++length) {
    CAPTURE(length);
    const Bytes cut(plain().begin(), plain().begin() + static_cast<std::ptrdiff_t>(length));
    CHECK_FALSE(hid::is_profile_v1(hid::read_descriptor(cut)));
  }
}

TEST_CASE("every flaw of a descriptor has its name, and tells nothing else") {
  CHECK(flaw_of(Bytes(kMaxDescriptor + 1, 0x00)) == DescriptorFlaw::kTooLong);
  CHECK(flaw_of(Bytes(kMaxDescriptor, 0x00)) == DescriptorFlaw::kNone);
  CHECK(flaw_of({0x06, 0x48}) == DescriptorFlaw::kCutOff);
  CHECK(flaw_of({0xC0}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0xA1, 0x01}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0xB4}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0xA4, 0xA4, 0xA4, 0xA4}) == DescriptorFlaw::kNone);
  CHECK(flaw_of({0xA4, 0xA4, 0xA4, 0xA4, 0xA4}) == DescriptorFlaw::kUnbalanced);
  CHECK(flaw_of({0x85, 0x00}) == DescriptorFlaw::kBadReportId);
  CHECK(flaw_of({0x86, 0x00, 0x01}) == DescriptorFlaw::kBadReportId);
  CHECK(flaw_of({0x77, 0xFF, 0xFF, 0xFF, 0xFF, 0x97, 0xFF, 0xFF, 0xFF, 0xFF, 0x81, 0x02}) ==
        DescriptorFlaw::kTooLarge);
  CHECK_FALSE(is_haptic(joined({plain(), {0xC0}})));
}

TEST_CASE("more reports than anybody needs are refused") {
  Bytes descriptor{0x75, 0x08, 0x95, 0x01};
  for (std::uint8_t id = 1; id <= kMaxReports; ++id) {
    descriptor.insert(descriptor.end(), {0x85, id, 0x81, 0x02});
  }
  CHECK(flaw_of(descriptor) == DescriptorFlaw::kNone);
  descriptor.insert(descriptor.end(), {0x85, 0xFF, 0x81, 0x02});
  CHECK(flaw_of(descriptor) == DescriptorFlaw::kTooLarge);
}

}  // namespace
}  // namespace hapticd::test
