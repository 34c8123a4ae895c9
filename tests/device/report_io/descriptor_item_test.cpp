// Items of report descriptors, byte by byte as HID 1.11 section 6.2.2 draws them.
#include "device/report_io/descriptor_item.h"

#include <doctest/doctest.h>

#include <vector>

namespace hapticd::test {
namespace {

/// The items of `bytes`; none when they end within one.
std::vector<DescriptorItem> items_of(const std::vector<std::uint8_t>& bytes) {
  std::vector<DescriptorItem> items;
  items.reserve(bytes.size());
  std::span<const std::uint8_t> rest = bytes;
  while (!rest.empty()) {
    DescriptorItem item;
    if (!next_item(rest, item)) return {};
    items.push_back(item);
  }
  return items;
}

}  // namespace

TEST_CASE("an item has 0, 1, 2 or 4 bytes of data, least byte first, signed by its highest bit") {
  const auto items = items_of({0xC0,                            // end of a collection
                               0x15, 0x80,                      // least value -128
                               0x26, 0xFF, 0x7F,                // greatest 32767
                               0x27, 0xFF, 0xFF, 0xFF, 0xFF,    // greatest: 2^32 - 1, or -1
                               0x0B, 0x01, 0x00, 0x48, 0xFF});  // usage with its page
  REQUIRE(items.size() == 5);
  CHECK(items[0].kind == ItemKind::kEndCollection);
  CHECK(items[0].data_bytes == 0);
  CHECK(items[0].signed_value == 0);
  CHECK(items[1].kind == ItemKind::kMinimum);
  CHECK(items[1].value == 128);
  CHECK(items[1].signed_value == -128);
  CHECK(items[2].kind == ItemKind::kMaximum);
  CHECK(items[2].signed_value == 32767);
  CHECK(items[3].value == 0xFFFFFFFF);
  CHECK(items[3].signed_value == -1);
  CHECK(items[4].kind == ItemKind::kUsage);
  CHECK(items[4].value == 0xFF480001);
  CHECK(items[4].data_bytes == 4);
}

TEST_CASE("a long item is passed over with its data, and means nothing") {
  const auto items = items_of({0xFE, 2, 0x90, 0x81, 0x81, 0x05, 0x01});
  REQUIRE(items.size() == 2);
  CHECK(items[0].kind == ItemKind::kReserved);
  CHECK(items[0].data_bytes == 0);
  CHECK(items[1].kind == ItemKind::kUsagePage);
}

TEST_CASE("bytes that end within an item are told, wherever they end") {
  const std::vector<std::vector<std::uint8_t>> whole{
      {0x75, 8}, {0x26, 1, 2}, {0x27, 1, 2, 3, 4}, {0xFE, 3, 0x10, 1, 2, 3}};
  for (const std::vector<std::uint8_t>& item : whole) {
    REQUIRE(items_of(item).size() == 1);
    for (std::size_t length = 1; length < item.size(); ++length) {
      CAPTURE(length);
      CHECK(items_of({item.begin(), item.begin() + static_cast<std::ptrdiff_t>(length)}).empty());
    }
  }
}

TEST_CASE("inputs, outputs, features and collections are main items, the others are not") {
  for (const ItemKind kind : {ItemKind::kInput, ItemKind::kOutput, ItemKind::kFeature,
                              ItemKind::kCollection, ItemKind::kEndCollection}) {
    CHECK(is_main(kind));
  }
  for (const ItemKind kind : {ItemKind::kUsagePage, ItemKind::kUsage, ItemKind::kReserved,
                              ItemKind::kReportSize, ItemKind::kPush, ItemKind::kLastUsage}) {
    CHECK_FALSE(is_main(kind));
  }
}

}  // namespace hapticd::test
