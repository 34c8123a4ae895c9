// Packets of Items ahead of what is acknowledged, over networks that lose, double and reorder, with
// peers that know of it and peers that do not. PROTOCOL.md, sections 4 and 5.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "tests/proto/wire/channel_pair.h"
#include "tests/support/fresh_seed.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::wire {
namespace {

using test::LinkConditions;
using test::SplitMix64;

/// A road of 1 ms there and back.
constexpr LinkConditions kRoad{.delay_ns = kMillisecond_ns / 2};
constexpr int kStepsOfRoundTrip = 2;

v1::Item tone(std::uint64_t number) {
  v1::Item item;
  item.mutable_tone()->set_t_ns(number);
  return item;
}

/// A Result, of `bytes` bytes and some more.
v1::Item result(std::uint64_t number, std::size_t bytes) {
  v1::Item item;
  item.mutable_result()->set_item_id(number);
  if (bytes > 0) item.mutable_result()->mutable_listing()->add_names(std::string(bytes, 'r'));
  return item;
}

v1::Item scene(std::uint64_t number, std::size_t bytes) {
  v1::Item item;
  item.mutable_scene_info()->set_next_tick(number);
  item.mutable_scene_info()->set_server_version(std::string(bytes, 's'));
  return item;
}

v1::Item upload(std::uint64_t number, std::size_t bytes) {
  v1::Item item;
  item.set_fence(number);
  item.mutable_load_scene()->set_text(std::string(bytes, 'u'));
  return item;
}

std::size_t chunks(std::size_t bytes) { return (bytes + kChunkBytes - 1) / kChunkBytes; }

/// The number it was made with.
std::uint64_t number_of(const v1::Item& item) {
  if (item.has_tone()) return item.tone().t_ns();
  if (item.has_result()) return item.result().item_id();
  if (item.has_scene_info()) return item.scene_info().next_tick();
  return item.fence();
}

v1::Item any_item(SplitMix64& random, Side side, std::uint64_t number) {
  const std::size_t bytes = random.chance(0.8) ? random.below(900) : random.below(30'000);
  if (side == Side::kClient) return upload(number, bytes);
  if (random.chance(0.4)) return tone(number);
  return random.chance(0.7) ? result(number, bytes) : scene(number, bytes);
}

/// Whether `late`, sent after `early`, may arrive before it.
bool may_overtake(const v1::Item& late, const v1::Item& early) {
  return early.has_result() && early.ByteSizeLong() > kItemBytes && !late.has_scene_info() &&
         late.ByteSizeLong() <= kItemBytes;
}

/// Every Item that was sent arrived once, as it was, and in order but for those that may overtake.
void check_arrived(const std::vector<v1::Item>& sent, const std::vector<v1::Item>& heard,
                   bool overtaking) {
  REQUIRE(heard.size() == sent.size());
  std::vector<bool> here(sent.size(), false);
  std::size_t oldest = 0;  // All before have arrived.
  for (const v1::Item& item : heard) {
    const std::uint64_t number = number_of(item);
    REQUIRE(number < sent.size());
    REQUIRE(!here[number]);
    CHECK(item.SerializeAsString() == sent[number].SerializeAsString());
    for (std::size_t i = oldest; i < number; ++i) {
      if (!here[i]) REQUIRE((overtaking && may_overtake(item, sent[i])));
    }
    here[number] = true;
    while (oldest < here.size() && here[oldest]) ++oldest;
  }
}

TEST_CASE("every Item arrives once and in order, whichever side takes Packets ahead") {
  const std::uint64_t seed = test::fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (std::int64_t trial = 0; trial < test::scaled(400); ++trial) {
    CAPTURE(trial);
    LinkConditions conditions{.loss = random.uniform(0.0, 0.3),
                              .duplication = random.uniform(0.0, 0.25)};
    conditions.delay_ns = static_cast<std::int64_t>(random.below(3'000'000));
    if (random.chance(0.6)) {
      conditions.jitter_ns = static_cast<std::int64_t>(random.below(20'000'000));
    }
    const bool client_new = random.chance(0.7);
    const bool server_new = random.chance(0.7);
    CAPTURE(client_new);
    CAPTURE(server_new);
    ChannelPair pair(conditions, random.next(), client_new, server_new);
    const std::size_t count = 1 + random.below(60);
    const double pace = random.uniform(0.05, 3.0);  // Items a step.
    std::vector<v1::Item> asked;
    std::vector<v1::Item> told;
    // The server's Items begin when it has heard the client, as a session does.
    const auto feed = [&](std::vector<v1::Item>& all, ChannelSide& from, Side side) {
      double more = pace;
      for (; all.size() < count && random.chance(std::min(more, 1.0)); more -= 1.0) {
        all.push_back(any_item(random, side, all.size()));
        REQUIRE(from.channel.send(all.back()).has_value());
      }
    };
    bool open = false;
    const auto done = [&] {
      open = open || pair.server.channel.applied() > 0;
      feed(asked, pair.client, Side::kClient);
      if (open) feed(told, pair.server, Side::kServer);
      return asked.size() == count && told.size() == count && pair.client.heard.size() >= count &&
             pair.server.heard.size() >= count;
    };
    REQUIRE(pair.steps_until(240'000, done).has_value());
    pair.steps_until(4000, [&] {
      return pair.client.channel.all_acknowledged() && pair.server.channel.all_acknowledged();
    });
    CHECK(pair.client.channel.all_acknowledged());
    CHECK(pair.server.channel.all_acknowledged());
    check_arrived(asked, pair.server.heard, false);
    check_arrived(told, pair.client.heard, client_new && server_new);
  }
}

/// Round trips until `to` has heard an Item of 3.2 MB of `from`.
int round_trips_of_blob(ChannelPair& pair, ChannelSide& from, ChannelSide& to, const v1::Item& blob,
                        int most) {
  REQUIRE(from.channel.send(blob).has_value());
  const auto steps = pair.steps_until(most * kStepsOfRoundTrip, [&] { return !to.heard.empty(); });
  REQUIRE(steps.has_value());
  CHECK(to.heard.front().SerializeAsString() == blob.SerializeAsString());
  return *steps / kStepsOfRoundTrip;
}

constexpr std::size_t kLarge = 3'200'000;

/// Client and server have heard each other.
void open(ChannelPair& pair) {
  REQUIRE(pair.client.channel.send(upload(0, 0)).has_value());
  REQUIRE(pair.steps_until(4000,
                           [&] {
                             return pair.client.channel.all_acknowledged() &&
                                    pair.server.channel.applied() == 1;
                           })
              .has_value());
  pair.server.heard.clear();
}

TEST_CASE("3.2 MB are there after a 32nd of as many round trips as they have Chunks, both ways") {
  const int most = static_cast<int>(chunks(kLarge)) / 32 + 10;
  CHECK(most == 121);
  ChannelPair down(kRoad, 1);
  open(down);
  CHECK(round_trips_of_blob(down, down.server, down.client, scene(0, kLarge), 4000) <= most);
  CHECK(down.server.with_items <= chunks(kLarge) + 2);
  ChannelPair up(kRoad, 1);
  open(up);
  CHECK(round_trips_of_blob(up, up.client, up.server, upload(0, kLarge), 4000) <= most);
  CHECK(up.client.with_items <= chunks(kLarge) + 3);
}

TEST_CASE("3.2 MB take 1000 round trips with 2 % of loss, and 6 for each Chunk with 20 %") {
  const std::uint64_t seed = test::fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (const double loss : {0.02, 0.2}) {
    CAPTURE(loss);
    LinkConditions conditions = kRoad;
    conditions.loss = loss;
    ChannelPair pair(conditions, random.next());
    open(pair);
    const int trips = round_trips_of_blob(pair, pair.server, pair.client, scene(0, kLarge), 20'000);
    CHECK(trips <= (loss < 0.1 ? 1000 : static_cast<int>(6 * chunks(kLarge))));
  }
}

TEST_CASE("on a long road no Packet of a blob leaves twice") {
  LinkConditions conditions{.delay_ns = 20 * kMillisecond_ns};
  ChannelPair pair(conditions, 1);
  open(pair);
  const std::size_t before = pair.server.with_items;
  const int trips = round_trips_of_blob(pair, pair.server, pair.client, scene(0, 300'000), 2000);
  CHECK(trips <= 40 * (static_cast<int>(chunks(300'000)) / 32 + 6));
  // The first Packet is repeated until the road is known, as it always was.
  CHECK(pair.server.with_items - before <= chunks(300'000) + 8);
}

TEST_CASE("who takes no Packets ahead gets one at a time, and sends one at a time") {
  for (const bool client_new : {true, false}) {
    ChannelPair pair(kRoad, 1, client_new, !client_new);
    open(pair);
    const v1::Item blob = client_new ? upload(0, 90'000) : scene(0, 90'000);
    ChannelSide& from = client_new ? pair.client : pair.server;
    ChannelSide& to = client_new ? pair.server : pair.client;
    CHECK(round_trips_of_blob(pair, from, to, blob, 1000) >= static_cast<int>(chunks(90'000)));
  }
}

TEST_CASE("a small Item arrives within two round trips, whatever Result is under way") {
  ChannelPair pair(kRoad, 1);
  open(pair);
  REQUIRE(pair.server.channel.send(result(0, kLarge)).has_value());
  for (int i = 0; i < 20; ++i) pair.step();
  for (std::uint64_t number = 1; number < 9; ++number) {
    pair.client.heard.clear();
    REQUIRE(pair.server.channel.send(tone(number)).has_value());
    REQUIRE(pair.server.channel.send(result(number, 100)).has_value());
    const auto steps = pair.steps_until(1000, [&] { return pair.client.heard.size() == 2; });
    REQUIRE(steps.has_value());
    CHECK(*steps <= 2 * kStepsOfRoundTrip);
    CHECK(pair.client.heard[0].has_tone());
    CHECK(pair.client.heard[1].result().item_id() == number);
  }
}

TEST_CASE("nothing overtakes a scene, and neither a scene nor Bye a Result") {
  v1::Item bye;
  bye.mutable_bye()->set_reason(v1::BYE_REASON_SHUTDOWN);
  ChannelPair pair(kRoad, 1);
  open(pair);
  const std::vector<v1::Item> sent{scene(0, 50'000),  result(1, 50'000), scene(2, 10), tone(3),
                                   result(4, 50'000), result(5, 50'000), tone(6)};
  for (const v1::Item& item : sent) REQUIRE(pair.server.channel.send(item).has_value());
  pair.server.channel.send_last(bye);
  REQUIRE(pair.steps_until(1000, [&] { return pair.client.heard.size() == 8; }).has_value());
  std::vector<std::uint64_t> order;
  for (std::size_t i = 0; i < 7; ++i) order.push_back(number_of(pair.client.heard[i]));
  CHECK(order == std::vector<std::uint64_t>{0, 1, 2, 3, 6, 4, 5});
  CHECK(pair.client.heard[7].has_bye());
}

TEST_CASE("a client's Items never overtake: their ids are those of their Results") {
  ChannelPair pair(kRoad, 1);
  open(pair);
  const auto large = pair.client.channel.send(result(0, 50'000));
  const auto small = pair.client.channel.send(upload(1, 10));
  REQUIRE(large.has_value());
  CHECK(small == *large + 1);
  REQUIRE(pair.steps_until(1000, [&] { return pair.server.heard.size() == 2; }).has_value());
  CHECK(number_of(pair.server.heard[0]) == 0);
  CHECK(pair.server.channel.applied() == *small);
}

TEST_CASE("who announces and then acknowledges nothing is held 34 pieces, and sent few Packets") {
  ChannelPair pair(kRoad, 1);
  open(pair);
  REQUIRE(pair.server.channel.send(scene(0, kLarge)).has_value());
  REQUIRE(
      pair.steps_until(1000, [&] { return pair.server.channel.acknowledged() > 100; }).has_value());
  pair.client.out.set_blackhole(true);
  const std::size_t before = pair.server.packets;
  for (int i = 0; i < 2 * 9000; ++i) {
    pair.step();
    // One is the blob itself.
    CHECK(pair.server.channel.unacknowledged() <= 1 + kMaxAhead + 2);
  }
  // Twice all, and then one at a time every 50 ms.
  CHECK(pair.server.packets - before <= 2 * kMaxAhead + 9000 / 50 + 8);
  pair.client.out.set_blackhole(false);
  REQUIRE(pair.steps_until(1000, [&] { return !pair.client.heard.empty(); }).has_value());
}

TEST_CASE("a peer may acknowledge anything that left, in any order, and nothing else") {
  ChannelPair pair(kRoad, 1);
  open(pair);
  REQUIRE(pair.server.channel.send(scene(0, kLarge)).has_value());
  pair.steps_until(20, [&] { return pair.server.channel.acknowledged() > 64; });
  const std::uint64_t first = pair.server.channel.acknowledged() + 1;
  auto acknowledge = [&, counter = std::uint64_t{900}](std::uint64_t ack) mutable {
    v1::Packet packet;
    packet.set_first(1);
    packet.set_ack(ack);
    const std::string body = packet.SerializeAsString();
    const DatagramHeader header{DatagramKind::kPlain, 7, counter++};
    return pair.server.channel.receive(header, bytes_of(body), pair.now_ns).items.broken;
  };
  REQUIRE(pair.server.highest_id > first + 10);
  CHECK(acknowledge(first + 5) == nullptr);
  CHECK(acknowledge(first + 2) == nullptr);
  CHECK(acknowledge(pair.server.highest_id) == nullptr);
  CHECK(pair.server.channel.acknowledged() == pair.server.highest_id);
  CHECK(acknowledge(pair.server.highest_id + 1) != nullptr);
}

TEST_CASE("States leave while Packets are ahead, each of as many bytes as was said to fit") {
  ChannelPair pair(kRoad, 1);
  open(pair);
  REQUIRE(pair.server.channel.send(scene(0, kLarge)).has_value());
  v1::Packet rest;
  rest.set_boot_id(5);
  for (int i = 0; i < 400; ++i) {
    pair.step();
    std::string datagram;
    const std::size_t bytes = pair.server.channel.state_bytes(rest);
    REQUIRE(pair.server.channel.write(rest, pair.now_ns, datagram, std::string(bytes, '\0')));
    REQUIRE(datagram.size() <= kDatagramBytes - kTagBytes);
    pair.server.out.send(bytes_of(std::string(datagram.substr(0, kHeaderBytes)) + "\x10\x01"),
                         pair.now_ns);
  }
  CHECK(pair.steps_until(1000, [&] { return !pair.client.heard.empty(); }).has_value());
}

/// What the side says of `ahead` in its next Packet.
std::uint32_t announced(Channel& channel, std::int64_t now_ns) {
  std::string datagram;
  REQUIRE(channel.write({}, now_ns, datagram));
  v1::Packet packet;
  REQUIRE(parse_packet(bytes_of(datagram).subspan(kHeaderBytes), packet));
  return packet.ahead();
}

void give(Channel& to, std::uint64_t counter, std::uint64_t ack, std::uint32_t ahead) {
  v1::Packet packet;
  packet.set_first(1);
  packet.set_ack(ack);
  packet.set_ahead(ahead);
  const std::string body = packet.SerializeAsString();
  CHECK(to.receive({DatagramKind::kPlain, 7, counter}, bytes_of(body), 1).items.broken == nullptr);
}

TEST_CASE("a client announces until it hears the server, a server in return until it is heard") {
  Channel client(Side::kClient, 7);
  CHECK(announced(client, 1) == 32);
  CHECK(announced(client, 2) == 32);
  give(client, 0, 0, 0);
  CHECK(announced(client, 3) == 0);

  Channel server(Side::kServer, 7);
  server.send(tone(1));
  give(server, 0, 0, 0);
  CHECK(announced(server, 1) == 0);
  give(server, 1, 0, 1);
  CHECK(announced(server, 2) == 32);
  give(server, 2, 0, 0);
  CHECK(announced(server, 3) == 32);
  give(server, 3, 1, 32);
  CHECK(announced(server, 4) == 0);
  give(server, 4, 1, 32);
  CHECK(announced(server, 5) == 0);
}

/// What a Packet with the Items `first`, `first` + 1 and `first` + 2 does.
ReceivedItems give_three(Channel& to, std::uint64_t counter, std::uint64_t first,
                         std::int64_t now) {
  v1::Packet packet;
  packet.set_first(first);
  for (std::uint64_t i = 0; i < 3; ++i) *packet.add_items() = tone(first + i);
  const std::string body = packet.SerializeAsString();
  return to.receive({DatagramKind::kPlain, 7, counter}, bytes_of(body), now).items;
}

TEST_CASE("Items that come early are skipped and acknowledged like repeated ones, if announced") {
  Channel client(Side::kClient, 7);
  std::string datagram;
  REQUIRE(client.write({}, 1, datagram));
  for (const std::uint64_t first : {std::uint64_t{2}, std::uint64_t{1} << 63U, ~std::uint64_t{0}}) {
    const ReceivedItems early = give_three(client, first, first, 2);
    CHECK(early.broken == nullptr);
    CHECK(early.items.empty());
    CHECK(!early.any_new);
    CHECK(client.applied() == 0);
    CHECK(client.due_ns() <= 10 * kMillisecond_ns);
  }
  CHECK(give_three(client, 1, 1, 3).broken == nullptr);
  Channel fresh(Side::kClient, 7);
  CHECK(give_three(fresh, 5, 1, 3).items.size() == 3);
  CHECK(fresh.applied() == 3);

  Channel server(Side::kServer, 7);
  CHECK(give_three(server, 0, 2, 1).broken != nullptr);
  Channel answering(Side::kServer, 7);
  give(answering, 0, 0, 32);
  CHECK(give_three(answering, 1, 2, 1).broken == nullptr);
  CHECK(give_three(answering, 2, 1, 1).items.size() == 3);
}

TEST_CASE("Items that fit into one Packet leave as they always did, whatever the peer takes") {
  SplitMix64 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    ItemOutbox plain;
    ItemOutbox ahead;
    ahead.allow_ahead(32);
    std::uint64_t number = 0;
    for (std::int64_t now = 1; now < 60; ++now) {
      if (plain.unacknowledged() < 16 && random.chance(0.3)) {
        plain.add(tone(number));
        ahead.add(tone(number++));
      }
      const std::size_t count = plain.fitting(kItemsBytes);
      plain.prepare(now * kMillisecond_ns);
      ahead.prepare(now * kMillisecond_ns);
      REQUIRE(ahead.fitting(kItemsBytes) == count);
      CHECK(ahead.leaving_id() == plain.first_id());
      std::string of_plain;
      std::string of_ahead;
      plain.append(count, of_plain);
      ahead.append(count, of_ahead);
      CHECK(of_plain == of_ahead);
      CHECK((ahead.due_ns(kItemsBytes) == 0) == (plain.due_ns(kItemsBytes) == 0));
      if (random.chance(0.5)) {
        plain.sent(count, now * kMillisecond_ns);
        ahead.sent(count, now * kMillisecond_ns);
        if (count > 0 && random.chance(0.5)) {
          const std::uint64_t ack = plain.first_id() + random.below(count);
          REQUIRE(plain.acknowledge(ack, now * kMillisecond_ns));
          REQUIRE(ahead.acknowledge(ack, now * kMillisecond_ns));
        }
      }
    }
  }
}

}  // namespace
}  // namespace hapticd::wire
