// Items that are too long for the wire: the session lives, and is told what it was not told.
// PROTOCOL.md, section 5.
#include <doctest/doctest.h>

#include "tests/server/network/raw_peer.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

/// As much as a blob may have, bytes, from the document.
constexpr std::size_t kBlob = std::size_t{4} << 20U;

/// A SceneInfo whose Item has `bytes`.
v1::Item scene_of(std::uint32_t id, std::size_t bytes) {
  v1::Item item;
  v1::SceneInfo& info = *item.mutable_scene_info();
  info.set_scene_id(id);
  info.set_hash(std::string(32, 'h'));
  info.set_server_version("1.2.3");
  info.set_rate_hz(1000.0);
  info.mutable_scene()->set_name("large");
  info.mutable_scene()->add_lines()->set_name("");
  std::string& text = *info.mutable_scene()->mutable_lines(0)->mutable_name();
  while (item.ByteSizeLong() < bytes) text.append(bytes - item.ByteSizeLong(), 'n');
  while (item.ByteSizeLong() > bytes) text.pop_back();
  REQUIRE(item.ByteSizeLong() == bytes);
  return item;
}

}  // namespace

TEST_CASE("a greeting that is longer than a blob is told in short, and the session says Stop") {
  for (const std::size_t beyond : {std::size_t{1}, std::size_t{1000}, 3 * kBlob}) {
    CAPTURE(beyond);
    ServerBench bench;
    bench.host.greeting[0] = scene_of(1, kBlob + beyond);
    RawPeer peer(bench, 5);
    peer.send(stop_item());
    bench.pass(1);
    const auto items = peer.items();
    REQUIRE(items.size() == 4);
    const v1::SceneInfo& told = items.at(1).scene_info();
    CHECK(told.scene_id() == 1);
    CHECK(told.scene().name() == "large");
    CHECK(told.scene().lines_size() == 0);
    CHECK(told.hash() == std::string(32, 'h'));
    CHECK(told.server_version() == "1.2.3");
    CHECK(told.rate_hz() == 1000.0);
    CHECK(told.scene().tools_size() == 0);
    CHECK(told.parameters_size() == 0);
    CHECK(items.at(2).has_lease_info());
    CHECK(items.at(3).has_record_info());
    CHECK(peer.code(1) == v1::RESULT_CODE_OK);
    REQUIRE(bench.host.asked.size() == 1);
    CHECK(bench.host.asked[0].item.has_stop());
    CHECK(bench.server->counters().backlogs == 0);
  }
}

TEST_CASE("a greeting of a whole blob is told as it is") {
  ServerBench bench;
  bench.host.greeting[0] = scene_of(1, kBlob);
  RawPeer peer(bench, 5);
  peer.keep_alive();
  bench.pass(1);
  REQUIRE(!peer.items().empty());
  CHECK(peer.items().at(1).chunk().total() == kBlob);
}

TEST_CASE("scenes that change faster than a session takes them never end it") {
  ServerBench bench;
  bench.host.greeting[0] = scene_of(1, kBlob);
  RawPeer peer(bench, 5);
  peer.keep_alive();
  SplitMix64 random(21);
  for (std::uint32_t id = 2; id < 12; ++id) {
    bench.server->broadcast(scene_of(id, kBlob - random.below(kBlob / 2)));
  }
  peer.send(stop_item());
  bench.pass(1);
  CHECK(bench.host.asked.size() == 1);
  CHECK(peer.bye() == v1::BYE_REASON_UNSPECIFIED);
  CHECK(bench.server->counters().backlogs == 0);
  CHECK(bench.server->session_count() == 1);
}

TEST_CASE("an answer that is too long is FAILED with what to do, and the session lives") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  bench.host.answers = false;
  v1::Item list;
  list.mutable_list_recordings();
  peer.send({list, ping_item()});
  bench.pass(1);
  REQUIRE(bench.host.asked.size() == 1);
  v1::Result result = result_with();
  for (int i = 0; i < 80'000; ++i) result.mutable_listing()->add_names(std::string(64, 'r'));
  bench.server->answer(bench.host.asked[0].id, result);
  bench.pass(1);
  CHECK(peer.code(1) == v1::RESULT_CODE_FAILED);
  CHECK(peer.results().at(1).message().find("bytes") != std::string::npos);
  CHECK(peer.code(2) == v1::RESULT_CODE_OK);
  CHECK(peer.bye() == v1::BYE_REASON_UNSPECIFIED);
}

TEST_CASE("a refusal that quotes too much is cut to whole characters, its code kept") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  bench.host.answers = false;
  v1::Item get;
  get.mutable_get_parameters();
  peer.send({get, get});
  std::string umlauts = "a";
  for (std::size_t i = 0; i < kBlob / 2 + 500; ++i) umlauts += "\xc3\xa4";
  for (std::size_t k = 0; k < 2; ++k) {
    bench.pass(1);
    REQUIRE(bench.host.asked.size() == k + 1);
    v1::Result result = result_with(v1::RESULT_CODE_NOT_FOUND);
    (k == 0 ? *result.mutable_path() : *result.mutable_message()) = umlauts;
    bench.server->answer(bench.host.asked[k].id, result);
  }
  bench.pass(1);
  for (std::uint64_t id = 1; id <= 2; ++id) {
    CHECK(peer.code(id) == v1::RESULT_CODE_NOT_FOUND);
    const v1::Result result = peer.results().at(id);
    const std::string& text = id == 1 ? result.path() : result.message();
    CHECK(text.size() >= 254);
    CHECK(text.size() <= 400);
    CHECK(text.size() % 2 == 1);  // the first letter, and whole umlauts
  }
}

}  // namespace hapticd::test
