// One request at a time, what overtakes, what is refused. PROTOCOL.md, section 8.
#include <doctest/doctest.h>

#include "server/network/session.h"
#include "tests/server/network/raw_peer.h"

namespace hapticd::test {
namespace {

/// Ids of the requests of `peer` that were answered, in the order of the answers.
std::vector<std::uint64_t> answered(const RawPeer& peer) {
  std::vector<std::uint64_t> ids;
  for (const auto& [id, item] : peer.items()) {
    if (item.has_result()) ids.push_back(item.result().item_id());
  }
  return ids;
}

using Ids = std::vector<std::uint64_t>;

v1::Item load_item() {
  v1::Item item;
  item.mutable_load_scene()->set_name("guqin");
  return item;
}

v1::Item pose_item() {
  v1::Item item;
  item.mutable_pose_batch()->add_poses()->set_tool_id(1);
  return item;
}

struct Controlled {
  ServerBench bench;
  RawPeer peer{bench, 5};

  Controlled() {
    peer.send(acquire_item("peer"));
    bench.host.answers = false;
  }
  void answer(std::size_t which, v1::ResultCode code = v1::RESULT_CODE_OK) {
    v1::Result result;
    result.set_code(code);
    bench.server->answer(bench.host.asked[which].id, result);
  }
};

TEST_CASE("a request waits until the one before it has been answered, the server's own as well") {
  Controlled session;
  session.peer.send({load_item(), ping_item(), engage_item()});
  session.bench.pass(1);
  CHECK(session.bench.host.asked.size() == 1);
  CHECK(answered(session.peer) == Ids{1});
  session.answer(0);
  session.bench.pass(1);
  CHECK(session.bench.host.asked.size() == 2);
  CHECK(answered(session.peer) == Ids{1, 2, 3});
  session.answer(1);
  session.bench.pass(1);
  CHECK(answered(session.peer) == Ids{1, 2, 3, 4});
}

TEST_CASE("sessions do not wait for each other") {
  Controlled session;
  RawPeer other(session.bench, 6, 40'001);
  session.peer.send(load_item());
  other.send(ping_item());
  session.bench.pass(1);
  CHECK(other.code(1) == v1::RESULT_CODE_OK);
}

TEST_CASE("Stop and Run{STOP} overtake a Run of steps, which is answered first") {
  Controlled session;
  session.peer.send(
      {run_item(v1::RUN_MODE_STEP, 100), ping_item(), stop_item(), run_item(v1::RUN_MODE_STOP)});
  REQUIRE(session.bench.host.asked.size() == 3);
  CHECK(session.bench.host.asked[1].item.has_stop());
  CHECK(session.bench.host.asked[2].item.run().mode() == v1::RUN_MODE_STOP);
  // Even if the host answers them before the Run.
  session.answer(1);
  session.answer(2);
  session.bench.pass(1);
  CHECK(answered(session.peer) == Ids{1});
  session.answer(0);
  session.bench.pass(1);
  CHECK(answered(session.peer) == Ids{1, 2, 4, 5, 3});
}

TEST_CASE("Stop overtakes whatever is under way, without a lease; Run{STOP} only a Run of steps") {
  Controlled session;
  session.peer.send({load_item(), run_item(v1::RUN_MODE_STOP), stop_item()});
  REQUIRE(session.bench.host.asked.size() == 2);
  CHECK(session.bench.host.asked[1].item.has_stop());
  session.answer(1);
  session.bench.pass(1);
  CHECK(session.peer.code(4) == v1::RESULT_CODE_OK);
  RawPeer other(session.bench, 6, 40'001);
  other.send(stop_item());
  CHECK(session.bench.host.asked.size() == 3);
}

TEST_CASE("a PoseBatch is answered when it fails and not else") {
  Controlled session;
  session.peer.send({pose_item(), pose_item()});
  session.answer(0);
  session.answer(1, v1::RESULT_CODE_BUSY);
  session.bench.pass(1);
  CHECK(session.peer.code(2) == v1::RESULT_CODE_UNSPECIFIED);
  CHECK(session.peer.code(3) == v1::RESULT_CODE_BUSY);
}

TEST_CASE("an Item without a body, and one only servers send, are UNSUPPORTED") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Item tone;
  tone.mutable_tone();
  peer.send({v1::Item(), tone, ping_item()});
  bench.pass(1);
  CHECK(peer.code(1) == v1::RESULT_CODE_UNSUPPORTED);
  CHECK(peer.code(2) == v1::RESULT_CODE_UNSUPPORTED);
  CHECK(peer.code(3) == v1::RESULT_CODE_OK);
}

TEST_CASE("Chunks that hold no Item are INVALID under the id of the last one") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Item piece;
  piece.mutable_chunk()->set_blob(1);
  piece.mutable_chunk()->set_kind(v1::CHUNK_KIND_ITEM);
  piece.mutable_chunk()->set_total(2);
  piece.mutable_chunk()->set_bytes("\xff");
  v1::Item last = piece;
  last.mutable_chunk()->set_offset(1);
  peer.send({piece, last});
  bench.pass(1);
  CHECK(peer.code(2) == v1::RESULT_CODE_INVALID);
  CHECK(peer.results().size() == 1);
}

TEST_CASE("requests beyond those that may wait are BUSY, and no other is") {
  Controlled session;
  session.peer.send(load_item());
  for (std::size_t i = 0; i < kMaxWaitingRequests; ++i) session.peer.send(ping_item());
  const std::uint64_t beyond = session.peer.next_id();
  session.peer.send(ping_item());
  session.bench.pass(1);
  CHECK(session.peer.code(beyond) == v1::RESULT_CODE_BUSY);
  CHECK(session.peer.code(beyond - 1) == v1::RESULT_CODE_UNSPECIFIED);
  session.answer(0);
  for (int i = 0; i < 200; ++i) {
    session.bench.pass(1);
    session.peer.keep_alive();
  }
  CHECK(session.peer.code(beyond - 1) == v1::RESULT_CODE_OK);
}

TEST_CASE("a host that answers at once is not called from inside its own answer") {
  Controlled session;
  session.peer.send(load_item());
  for (int i = 0; i < 100; ++i) session.peer.send(engage_item());
  session.bench.host.answers = true;
  session.answer(0);
  CHECK(session.bench.host.asked.size() == 101);
  CHECK(session.bench.host.deepest == 1);
}

TEST_CASE("Stops that the host does not answer are BUSY beyond their limit") {
  Controlled session;
  for (std::size_t i = 0; i < kMaxOvertaking; ++i) session.peer.send(stop_item());
  const std::uint64_t beyond = session.peer.next_id();
  session.peer.send(stop_item());
  session.bench.pass(1);
  CHECK(session.peer.code(beyond) == v1::RESULT_CODE_BUSY);
  CHECK(session.bench.host.asked.size() == kMaxOvertaking);
}

TEST_CASE("the host hears when the session of a request has ended; its answer is ignored") {
  Controlled session;
  session.peer.send({run_item(v1::RUN_MODE_STEP, 100), stop_item(), bye_item()});
  REQUIRE(session.bench.host.asked.size() == 2);
  CHECK(session.bench.host.abandoned.size() == 2);
  session.answer(0);
  session.answer(1);
  session.bench.pass(1);
  CHECK(answered(session.peer) == Ids{1});
}

TEST_CASE("a second answer to the same request is ignored") {
  Controlled session;
  session.peer.send({load_item(), load_item()});
  session.answer(0);
  session.answer(0, v1::RESULT_CODE_FAILED);
  session.bench.pass(1);
  CHECK(session.peer.code(2) == v1::RESULT_CODE_OK);
  CHECK(session.peer.code(3) == v1::RESULT_CODE_UNSPECIFIED);
}

TEST_CASE("the lease is asked for when a request's turn comes, not when it arrives") {
  Controlled session;
  session.peer.send({load_item(), release_item(), engage_item()});
  session.answer(0);
  session.bench.pass(1);
  CHECK(session.peer.code(3) == v1::RESULT_CODE_OK);
  CHECK(session.peer.code(4) == v1::RESULT_CODE_NOT_OWNER);
}

TEST_CASE("a subscription out of range is refused with the path, and changes nothing") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Item wide = subscribe_item(1);
  for (int i = 0; i < 33; ++i) wide.mutable_subscribe()->add_sections(v1::SECTION_TOOLS);
  v1::Item deep = subscribe_item(1);
  deep.mutable_subscribe()->set_max_contacts(257);
  peer.send({subscribe_item(2), subscribe_item(1'000'001), wide, deep});
  bench.pass(1);
  CHECK(peer.code(1) == v1::RESULT_CODE_OK);
  CHECK(peer.results().at(2).path() == "subscribe.divisor");
  CHECK(peer.results().at(3).path() == "subscribe.sections");
  CHECK(peer.results().at(4).path() == "subscribe.max_contacts");
  for (std::uint64_t id = 2; id <= 4; ++id) CHECK(peer.code(id) == v1::RESULT_CODE_OUT_OF_RANGE);
  for (std::uint64_t tick = 1; tick <= 4; ++tick) bench.offer(tick);
  CHECK(peer.states().size() == 2);
}

}  // namespace
}  // namespace hapticd::test
