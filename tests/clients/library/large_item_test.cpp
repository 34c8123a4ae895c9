// Items of megabytes between a real client and a real server, both ways, PLAIN and with keys, in
// virtual time. PROTOCOL.md, sections 4 and 5.
#include <doctest/doctest.h>

#include <optional>
#include <string>

#include "tests/clients/library/virtual_network.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kLarge = 3'200'000;
constexpr std::int64_t kChunks = (kLarge + 899) / 900;
/// There and back, 500 us each way.
constexpr std::int64_t kRoundTrip_ns = kTestMillisecond_ns;
constexpr std::int64_t kMostRoundTrips = kChunks / 32 + 20;

v1::Item stop_request() {
  v1::Item item;
  item.mutable_stop();
  return item;
}

struct Joined {
  explicit Joined(bool keyed)
      : network(keyed ? keyed_network() : ServerOptions{.boot_id = 7}),
        mine(network.add_client({.delay_ns = kRoundTrip_ns / 2}, 1,
                                keyed ? std::optional(control_key()) : std::nullopt)) {}

  VirtualNetwork network;
  VirtualClient& mine;
};

TEST_CASE("a scene of 3.2 MB is told in 131 round trips, PLAIN and with keys") {
  for (const bool keyed : {false, true}) {
    CAPTURE(keyed);
    Joined joined(keyed);
    v1::SceneInfo& info = *joined.network.host.greeting[0].mutable_scene_info();
    info.set_server_version(std::string(kLarge, 'v'));
    CHECK(joined.network.run_until(kMostRoundTrips * kRoundTrip_ns,
                                   [&] { return !joined.mine.items.empty(); }));
    CHECK(joined.mine.items.at(0).SerializeAsString() ==
          joined.network.host.greeting[0].SerializeAsString());
    CHECK(joined.mine.ends.empty());
  }
}

TEST_CASE("a text of 3.2 MB arrives in 131 round trips, and a Stop behind it is obeyed after it") {
  for (const bool keyed : {false, true}) {
    CAPTURE(keyed);
    Joined joined(keyed);
    REQUIRE(
        joined.network.run_until(kTestSecond_ns, [&] { return joined.mine.items.size() == 3; }));
    joined.network.run_for(10 * kTestMillisecond_ns);
    v1::Item acquire;
    acquire.mutable_acquire()->set_holder("test");
    joined.mine.core->request(acquire);
    v1::Item load;
    load.mutable_load_scene()->set_text(std::string(kLarge, 't'));
    std::optional<std::uint64_t> answered;
    const std::uint64_t id = joined.mine.core->request(
        load, [&](const v1::Result* result) { answered = result->item_id(); });
    joined.mine.core->request(stop_request());
    CHECK(joined.network.run_until(kMostRoundTrips * kRoundTrip_ns,
                                   [&] { return joined.network.host.asked.size() == 2; }));
    REQUIRE(joined.network.host.asked.size() == 2);
    CHECK(joined.network.host.asked[0].item.SerializeAsString() == load.SerializeAsString());
    CHECK(joined.network.host.asked[1].item.has_stop());
    CHECK(joined.network.run_until(10 * kRoundTrip_ns, [&] { return answered == id; }));
  }
}

TEST_CASE("a Tone is heard within three round trips while a listing is under way") {
  Joined joined(false);
  REQUIRE(joined.network.run_until(kTestSecond_ns, [&] { return joined.mine.items.size() == 3; }));
  joined.network.run_for(10 * kTestMillisecond_ns);
  joined.network.host.answers = false;
  v1::Item list;
  list.mutable_list_recordings();
  std::size_t names = 0;
  joined.mine.core->request(list, [&](const v1::Result* result) {
    names = static_cast<std::size_t>(result->listing().names_size());
  });
  REQUIRE(
      joined.network.run_until(kTestSecond_ns, [&] { return !joined.network.host.asked.empty(); }));
  v1::Result listing = result_with();
  for (int i = 0; i < 50'000; ++i) listing.mutable_listing()->add_names(std::string(60, 'r'));
  joined.network.server->answer(joined.network.host.asked[0].id, listing);
  joined.network.run_for(20 * kRoundTrip_ns);
  for (std::uint32_t number = 0; number < 5; ++number) {
    joined.network.server->broadcast(tone_item(number));
    CHECK(joined.network.run_until(3 * kRoundTrip_ns,
                                   [&] { return joined.mine.tones().size() == number + 1; }));
  }
  CHECK(names == 0);
  CHECK(joined.network.run_until(kMostRoundTrips * kRoundTrip_ns, [&] { return names == 50'000; }));
}

}  // namespace
}  // namespace hapticd::test
