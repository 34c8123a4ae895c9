// The receiving half of exactly once, in order. PROTOCOL.md, sections 4 and 5.
#include "proto/wire/item_inbox.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "proto/wire/item_outbox.h"

namespace hapticd::wire {
namespace {

v1::Packet tones(std::uint64_t first, std::uint64_t count) {
  v1::Packet packet;
  packet.set_first(first);
  for (std::uint64_t i = 0; i < count; ++i) {
    packet.add_items()->mutable_tone()->set_t_ns(first + i);
  }
  return packet;
}

std::vector<std::uint64_t> ids_of(const ReceivedItems& received) {
  std::vector<std::uint64_t> ids;
  for (const ReceivedItem& each : received.items) {
    CHECK(each.item.tone().t_ns() == each.id);
    ids.push_back(each.id);
  }
  return ids;
}

using Ids = std::vector<std::uint64_t>;

TEST_CASE("only the next id is applied; what was seen is ignored") {
  ItemInbox inbox;
  v1::Packet packet = tones(1, 3);
  CHECK(ids_of(inbox.take(packet)) == Ids{1, 2, 3});
  packet = tones(1, 3);
  const ReceivedItems again = inbox.take(packet);
  CHECK(again.items.empty());
  CHECK(again.any_listed);
  CHECK(!again.any_new);
  packet = tones(2, 4);
  CHECK(ids_of(inbox.take(packet)) == Ids{4, 5});
  CHECK(inbox.applied() == 5);
}

TEST_CASE("a gap breaks the session") {
  ItemInbox inbox;
  v1::Packet packet = tones(2, 1);
  CHECK(inbox.take(packet).broken != nullptr);
  CHECK(inbox.applied() == 0);
  packet = tones(~std::uint64_t{0}, 2);
  CHECK(inbox.take(packet).broken != nullptr);
}

TEST_CASE("a Packet without Items applies nothing, whatever its first") {
  ItemInbox inbox;
  v1::Packet packet = tones(77, 0);
  const ReceivedItems received = inbox.take(packet);
  CHECK(received.broken == nullptr);
  CHECK(!received.any_listed);
}

/// One Packet per piece, as an outbox cuts them.
std::vector<v1::Packet> pieces_of(const v1::Item& item) {
  ItemOutbox outbox;
  outbox.add(item);
  std::vector<v1::Packet> packets;
  while (!outbox.empty()) {
    std::string bytes;
    outbox.append(1, bytes);
    v1::Packet packet;
    REQUIRE(packet.ParseFromString(bytes));
    packet.set_first(outbox.first_id());
    packets.push_back(packet);
    outbox.sent(1, 0);
    REQUIRE(outbox.acknowledge(outbox.first_id(), 0));
  }
  return packets;
}

v1::Item long_item() {
  v1::Item item;
  item.set_fence(5);
  std::string& text = *item.mutable_load_scene()->mutable_text();
  for (int i = 0; text.size() < 3000; ++i) text += std::to_string(i);
  return item;
}

TEST_CASE("Chunks become the Item they were cut from, with the id of the last one") {
  ItemInbox inbox;
  std::vector<v1::Packet> pieces = pieces_of(long_item());
  REQUIRE(pieces.size() == 4);
  for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
    const ReceivedItems received = inbox.take(pieces[i]);
    CHECK(received.items.empty());
    CHECK(received.any_new);
    CHECK(received.broken == nullptr);
  }
  const ReceivedItems received = inbox.take(pieces.back());
  REQUIRE(received.items.size() == 1);
  CHECK(received.items[0].id == 4);
  CHECK(received.items[0].item.SerializeAsString() == long_item().SerializeAsString());
}

TEST_CASE("other Items may come between the pieces of a blob") {
  ItemInbox inbox;
  std::vector<v1::Packet> pieces = pieces_of(long_item());
  std::uint64_t id = 0;
  std::vector<std::uint64_t> applied;
  for (v1::Packet& piece : pieces) {
    v1::Packet packet = tones(id + 1, 1);
    *packet.add_items() = piece.items(0);
    id += 2;
    for (const ReceivedItem& each : inbox.take(packet).items) applied.push_back(each.id);
  }
  CHECK(applied == Ids{1, 3, 5, 7, 8});
}

/// Feeds the pieces, the one at `place` changed by `change`; the rule that was broken.
template <typename Change>
std::string broken_rule(std::size_t place, const Change& change) {
  ItemInbox inbox;
  std::vector<v1::Packet> pieces = pieces_of(long_item());
  change(*pieces[place].mutable_items(0)->mutable_chunk());
  for (v1::Packet& piece : pieces) {
    const ReceivedItems received = inbox.take(piece);
    if (received.broken != nullptr) return received.broken;
  }
  return {};
}

TEST_CASE("every rule about pieces is enforced") {
  CHECK(broken_rule(0, [](v1::Chunk&) {}).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.set_blob(2); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.set_blob(0); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.set_offset(900); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.set_total(0); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.set_total((4U << 20U) + 1); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.clear_bytes(); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.mutable_bytes()->append("x"); }).empty());
  CHECK(!broken_rule(0, [](v1::Chunk& c) { c.set_total(899); }).empty());
  CHECK(!broken_rule(1, [](v1::Chunk& c) { c.set_blob(2); }).empty());
  CHECK(!broken_rule(1, [](v1::Chunk& c) { c.set_offset(0); }).empty());
  CHECK(!broken_rule(1, [](v1::Chunk& c) { c.set_total(c.total() + 1); }).empty());
  CHECK(!broken_rule(1, [](v1::Chunk& c) { c.set_kind(v1::CHUNK_KIND_UNSPECIFIED); }).empty());
  CHECK(!broken_rule(3, [](v1::Chunk& c) { c.mutable_bytes()->append("x"); }).empty());
}

/// One Chunk that is a whole blob.
v1::Packet blob_of(std::uint64_t id, std::uint32_t number, const std::string& bytes, int kind = 1) {
  v1::Packet packet;
  packet.set_first(id);
  v1::Chunk& chunk = *packet.add_items()->mutable_chunk();
  chunk.set_blob(number);
  chunk.set_kind(static_cast<v1::ChunkKind>(kind));
  chunk.set_total(static_cast<std::uint32_t>(bytes.size()));
  chunk.set_bytes(bytes);
  return packet;
}

TEST_CASE("a Chunk in a Chunk breaks the session") {
  ItemInbox inbox;
  v1::Item inner;
  inner.mutable_chunk()->set_blob(1);
  v1::Packet packet = blob_of(1, 1, inner.SerializeAsString());
  CHECK(inbox.take(packet).broken != nullptr);
}

TEST_CASE("a blob that is no Item is told apart, and the next one is taken") {
  ItemInbox inbox;
  v1::Packet packet = blob_of(1, 1, "\xff\xff\xff");
  const ReceivedItems bad = inbox.take(packet);
  REQUIRE(bad.items.size() == 1);
  CHECK(bad.broken == nullptr);
  CHECK(bad.items[0].undecodable);
  v1::Item ping;
  ping.mutable_ping();
  packet = blob_of(2, 2, ping.SerializeAsString());
  const ReceivedItems good = inbox.take(packet);
  REQUIRE(good.items.size() == 1);
  CHECK(good.items[0].item.has_ping());
}

TEST_CASE("a blob of a kind of a later version is an Item without a body") {
  ItemInbox inbox;
  v1::Packet packet = blob_of(1, 1, "\xff\xff\xff", 7);
  const ReceivedItems received = inbox.take(packet);
  REQUIRE(received.items.size() == 1);
  CHECK(!received.items[0].undecodable);
  CHECK(received.items[0].item.body_case() == v1::Item::BODY_NOT_SET);
}

}  // namespace
}  // namespace hapticd::wire
