// The sending half of exactly once, in order. PROTOCOL.md, sections 4 and 5.
#include "proto/wire/item_outbox.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace hapticd::wire {
namespace {

constexpr std::size_t kMuch = 10'000;

v1::Item tone(std::uint32_t string_index) {
  v1::Item item;
  item.mutable_tone()->set_string_index(string_index);
  return item;
}

/// An Item whose encoding has `bytes` bytes, 130 at least.
v1::Item item_of(std::size_t bytes) {
  v1::Item item;
  std::string& text = *item.mutable_load_scene()->mutable_text();
  text.assign(bytes, 'x');
  while (item.ByteSizeLong() > bytes) text.pop_back();
  return item;
}

/// What the first `count` Items look like to a receiver.
v1::Packet packet_of(const ItemOutbox& outbox, std::size_t count) {
  std::string bytes;
  outbox.append(count, bytes);
  v1::Packet packet;
  REQUIRE(packet.ParseFromString(bytes));
  return packet;
}

TEST_CASE("Items get the ids 1, 2, 3 and leave as fields of a Packet, oldest first") {
  ItemOutbox outbox;
  CHECK(outbox.first_id() == 1);
  for (std::uint32_t i = 0; i < 5; ++i) CHECK(outbox.add(tone(i)) == i + 1);
  CHECK(outbox.fitting(kMuch) == 5);
  const v1::Packet packet = packet_of(outbox, 5);
  REQUIRE(packet.items_size() == 5);
  for (int i = 0; i < 5; ++i)
    CHECK(packet.items(i).tone().string_index() == static_cast<unsigned>(i));
}

TEST_CASE("at most 16 Items, and only as many as fit, each with tag and length") {
  ItemOutbox outbox;
  for (std::uint32_t i = 0; i < 20; ++i) outbox.add(tone(i));
  CHECK(outbox.fitting(kMuch) == 16);
  std::string three;
  outbox.append(3, three);
  CHECK(outbox.fitting(three.size()) == 3);
  CHECK(outbox.fitting(three.size() - 1) == 2);
  ItemOutbox large;
  large.add(item_of(1000));
  CHECK(large.fitting(1003) == 1);
  CHECK(large.fitting(1002) == 0);
}

TEST_CASE("what is acknowledged is forgotten; an acknowledgement of what was not sent is refused") {
  ItemOutbox outbox;
  for (std::uint32_t i = 0; i < 5; ++i) outbox.add(tone(i));
  CHECK(!outbox.acknowledge(1, 0));
  outbox.sent(3, 0);
  CHECK(outbox.acknowledge(2, 0));
  CHECK(outbox.first_id() == 3);
  CHECK(outbox.acknowledge(1, 0));  // An older one, reordered.
  CHECK(outbox.first_id() == 3);
  CHECK(!outbox.acknowledge(4, 0));
  CHECK(packet_of(outbox, 1).items(0).tone().string_index() == 2);
  outbox.sent(3, 0);
  CHECK(outbox.acknowledge(5, 0));
  CHECK(outbox.empty());
  CHECK(outbox.first_id() == 6);
}

TEST_CASE(
    "a Packet leaves at once for a new Item, then after 1, 3, 7, 15, 31 ms, then every 50 ms") {
  ItemOutbox outbox;
  CHECK(outbox.due_ns(kMuch) == kNever_ns);
  outbox.add(tone(0));
  CHECK(outbox.due_ns(kMuch) == 0);
  const std::int64_t start = 7 * kMillisecond_ns;
  std::vector<std::int64_t> left_ms;
  std::int64_t now = start;
  for (int i = 0; i < 9; ++i) {
    outbox.sent(1, now);
    left_ms.push_back((now - start) / kMillisecond_ns);
    now = outbox.due_ns(kMuch);
  }
  CHECK(left_ms == std::vector<std::int64_t>{0, 1, 3, 7, 15, 31, 81, 131, 181});
}

TEST_CASE("a Packet that leaves for another reason counts as the next of the schedule") {
  ItemOutbox outbox;
  outbox.add(tone(0));
  outbox.sent(1, 0);
  outbox.sent(1, kMillisecond_ns / 2);
  CHECK(outbox.due_ns(kMuch) == 3 * kMillisecond_ns);
  // One that was late by 10 ms does not make a burst of those that were missed.
  outbox.sent(1, 10 * kMillisecond_ns);
  CHECK(outbox.due_ns(kMuch) == 15 * kMillisecond_ns);
}

TEST_CASE("a Packet without the Items counts for nothing") {
  ItemOutbox outbox;
  outbox.add(tone(0));
  outbox.sent(1, 0);
  outbox.sent(0, kMillisecond_ns / 2);
  CHECK(outbox.due_ns(kMuch) == kMillisecond_ns);
}

TEST_CASE("a newer Item begins the schedule anew") {
  ItemOutbox outbox;
  outbox.add(tone(0));
  outbox.sent(1, 0);
  outbox.sent(1, 40 * kMillisecond_ns);
  outbox.add(tone(1));
  CHECK(outbox.due_ns(kMuch) == 0);
  outbox.sent(2, 45 * kMillisecond_ns);
  CHECK(outbox.due_ns(kMuch) == 46 * kMillisecond_ns);
}

TEST_CASE("an Item that does not fit beside older ones leaves when those are acknowledged") {
  ItemOutbox outbox;
  outbox.add(item_of(900));
  outbox.add(item_of(900));
  outbox.sent(outbox.fitting(1100), 0);
  CHECK(outbox.due_ns(1100) == kMillisecond_ns);
  CHECK(outbox.acknowledge(1, 0));
  CHECK(outbox.due_ns(1100) == 0);
}

TEST_CASE("the 1025th Item is refused; the one that ends the session is not") {
  ItemOutbox outbox;
  for (std::uint32_t i = 0; i < 1024; ++i) CHECK(outbox.add(tone(i)).has_value());
  CHECK(!outbox.add(tone(0)).has_value());
  v1::Item bye;
  bye.mutable_bye()->set_reason(v1::BYE_REASON_BACKLOG);
  CHECK(outbox.add_last(bye) == 1025);
  outbox.sent(16, 0);
  CHECK(outbox.acknowledge(1, 0));
  CHECK(!outbox.add(tone(0)).has_value());
}

TEST_CASE("an Item of 1000 bytes travels as it is, one of 1001 in Chunks of 900") {
  ItemOutbox outbox;
  CHECK(outbox.add(item_of(1000)) == 1);
  const v1::Item large = item_of(1001);
  CHECK(outbox.add(large) == 3);
  CHECK(outbox.add(tone(9)) == 4);
  const v1::Packet packet = packet_of(outbox, outbox.fitting(kMuch));
  REQUIRE(packet.items_size() == 4);
  CHECK(!packet.items(0).has_chunk());
  const v1::Chunk& first = packet.items(1).chunk();
  const v1::Chunk& second = packet.items(2).chunk();
  CHECK(first.blob() == 1);
  CHECK(first.kind() == v1::CHUNK_KIND_ITEM);
  CHECK(first.offset() == 0);
  CHECK(first.total() == 1001);
  CHECK(first.bytes().size() == 900);
  CHECK(second.blob() == 1);
  CHECK(second.offset() == 900);
  CHECK(second.total() == 1001);
  CHECK(first.bytes() + second.bytes() == large.SerializeAsString());
}

TEST_CASE("the pieces of the largest blob pass through a window of 16") {
  ItemOutbox outbox;
  const v1::Item large = item_of(kBlobBytes);
  const std::uint64_t last = (kBlobBytes + 899) / 900;
  CHECK(outbox.add(large) == last);
  CHECK(outbox.next_id() == last + 1);
  std::string together;
  while (!outbox.empty()) {
    const std::size_t count = outbox.fitting(1081);
    REQUIRE(count >= 1);
    const v1::Packet packet = packet_of(outbox, count);
    for (const v1::Item& item : packet.items()) together += item.chunk().bytes();
    outbox.sent(count, 0);
    REQUIRE(outbox.acknowledge(outbox.first_id() + count - 1, 0));
  }
  CHECK(together == large.SerializeAsString());
  CHECK(outbox.first_id() == last + 1);
}

TEST_CASE("a blob beyond 4 MiB, and a third one of 4 MiB, are refused") {
  ItemOutbox outbox;
  CHECK(!outbox.add(item_of(kBlobBytes + 1)).has_value());
  CHECK(outbox.add(item_of(kBlobBytes)).has_value());
  CHECK(outbox.add(item_of(kBlobBytes)).has_value());
  CHECK(!outbox.add(item_of(kBlobBytes)).has_value());
  CHECK(outbox.add(tone(1)).has_value());
}

}  // namespace
}  // namespace hapticd::wire
