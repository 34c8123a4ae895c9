// The lease. PROTOCOL.md, section 9.
#include <doctest/doctest.h>

#include "tests/server/network/raw_peer.h"

namespace hapticd::test {
namespace {

TEST_CASE("Acquire gives the lease and its number, and everyone is told") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  other.keep_alive();
  peer.send(acquire_item("peer"));
  bench.pass(1);
  CHECK(peer.code(1) == v1::RESULT_CODE_OK);
  CHECK(peer.results().at(1).lease().fence() == 1);
  CHECK(peer.lease().yours());
  CHECK(peer.lease().fence() == 1);
  CHECK(!other.lease().yours());
  CHECK(other.lease().fence() == 1);
  CHECK(other.lease().holder() == "peer");
  CHECK(other.lease().ttl_ms() == 2000);
  // A late joiner learns it from its greeting.
  RawPeer late(bench, 7, 40'002);
  late.keep_alive();
  bench.pass(1);
  CHECK(late.lease().holder() == "peer");
}

TEST_CASE("a lease that is held is BUSY for others, and keeps its number for its holder") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  peer.send(acquire_item("peer"));
  other.send(acquire_item("other"));
  peer.send(acquire_item("peer"));
  bench.pass(1);
  CHECK(other.code(1) == v1::RESULT_CODE_BUSY);
  CHECK(peer.results().at(2).lease().fence() == 1);
  CHECK(bench.server->fence() == 1);
}

v1::Item take_over_item(const std::string& holder, const std::string& reason) {
  v1::Item item = acquire_item(holder);
  item.mutable_acquire()->set_take_over(reason);
  return item;
}

TEST_CASE("a lease is taken over with a reason, and all are told from whom and why") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  RawPeer looker(bench, 7, 40'002);
  looker.keep_alive();
  peer.send(acquire_item("peer"));
  other.send(take_over_item("other", "the desk was left"));
  bench.pass(1);
  CHECK(other.code(1) == v1::RESULT_CODE_OK);
  CHECK(bench.host.lease_ends == std::vector<LeaseEnd>{LeaseEnd::kTakenOver});
  for (const RawPeer* each : {&peer, &other, &looker}) {
    CHECK(each->lease().yours() == (each == &other));
    CHECK(each->lease().fence() == 2);
    CHECK(each->lease().holder() == "other");
    CHECK(each->lease().taken_from() == "peer");
    CHECK(each->lease().reason() == "the desk was left");
  }
  // Who has lost it moves nothing any more, and hears why.
  peer.send({engage_item(), engage_item(1)});
  bench.pass(1);
  CHECK(peer.code(2) == v1::RESULT_CODE_NOT_OWNER);
  CHECK(peer.code(3) == v1::RESULT_CODE_NOT_OWNER);
  CHECK(peer.results().at(2).message() == "the lease was taken over by 'other'");
  CHECK(bench.host.asked.empty());
}

TEST_CASE("the next grant tells of no take-over, and a free lease is not taken from anyone") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  peer.send(take_over_item("peer", "to be sure"));
  bench.pass(1);
  CHECK(peer.lease().yours());
  CHECK(peer.lease().reason().empty());
  CHECK(bench.host.lease_ends.empty());
  other.send(take_over_item("other", "my turn"));
  other.send(release_item());
  peer.send(acquire_item("peer"));
  bench.pass(1);
  CHECK(peer.lease().yours());
  CHECK(peer.lease().taken_from().empty());
  CHECK(peer.lease().reason().empty());
}

TEST_CASE(
    "a Run of steps of who loses the lease ends, answered NOT_OWNER, and so does what waits") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  peer.send(acquire_item("peer"));
  bench.host.answers = false;
  peer.send({run_item(v1::RUN_MODE_STEP, 1'000'000), engage_item()});
  bench.pass(1);
  REQUIRE(bench.host.asked.size() == 1);
  other.send(take_over_item("other", "it runs for an hour"));
  bench.pass(1);
  CHECK(bench.host.abandoned == std::vector<RequestId>{bench.host.asked[0].id});
  CHECK(peer.code(2) == v1::RESULT_CODE_NOT_OWNER);
  CHECK(peer.code(3) == v1::RESULT_CODE_NOT_OWNER);
  CHECK(peer.results().size() == 3);
  CHECK(other.code(1) == v1::RESULT_CODE_OK);
  other.send(engage_item());
  CHECK(bench.host.asked.size() == 2);
}

TEST_CASE("a gateway takes the lease over from itself: a new number, and the old lease is over") {
  ServerBench bench;
  RawPeer gateway(bench, 5);
  gateway.send(acquire_item("page"));
  gateway.send(take_over_item("page", "lunch is over"));
  bench.pass(1);
  CHECK(gateway.code(2) == v1::RESULT_CODE_OK);
  CHECK(gateway.lease().yours());
  CHECK(gateway.lease().fence() == 2);
  CHECK(gateway.lease().taken_from() == "page");
  CHECK(bench.host.lease_ends == std::vector<LeaseEnd>{LeaseEnd::kTakenOver});
}

TEST_CASE("a reason of more than 400 bytes, or with control characters, takes nothing over") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  peer.send(acquire_item("peer"));
  other.send(take_over_item("other", std::string(401, 'x')));
  other.send(take_over_item("other", "\x1b[31m"));
  bench.pass(1);
  CHECK(other.code(1) == v1::RESULT_CODE_OUT_OF_RANGE);
  CHECK(other.code(2) == v1::RESULT_CODE_INVALID);
  CHECK(peer.lease().yours());
  CHECK(bench.host.lease_ends.empty());
}

TEST_CASE("without the lease, requests that need it are NOT_OWNER and do not reach the host") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send({engage_item(), run_item(v1::RUN_MODE_LIVE), release_item()});
  bench.pass(1);
  for (std::uint64_t id = 1; id <= 3; ++id) CHECK(peer.code(id) == v1::RESULT_CODE_NOT_OWNER);
  CHECK(bench.host.asked.empty());
}

TEST_CASE("a request under the number of a lease that is over is NOT_OWNER") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send({acquire_item("peer"), engage_item(1), release_item(), acquire_item("peer")});
  peer.send({engage_item(1), engage_item(2), engage_item()});
  bench.pass(1);
  CHECK(peer.code(2) == v1::RESULT_CODE_OK);
  CHECK(peer.results().at(4).lease().fence() == 2);
  CHECK(peer.code(5) == v1::RESULT_CODE_NOT_OWNER);
  CHECK(peer.code(6) == v1::RESULT_CODE_OK);
  CHECK(peer.code(7) == v1::RESULT_CODE_OK);
}

TEST_CASE("the lease ends after 2 s of silence, and any valid datagram renews it") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  RawPeer other(bench, 6, 40'001);
  other.keep_alive();
  peer.send(acquire_item("peer"));
  bench.pass(1999);
  CHECK(bench.server->fence() == 1);
  peer.keep_alive();
  bench.pass(1999);
  CHECK(bench.server->fence() == 1);
  bench.pass(2);
  CHECK(bench.server->fence() == 0);
  REQUIRE(bench.host.lease_ends.size() == 1);
  CHECK(bench.host.lease_ends[0] == LeaseEnd::kExpired);
  bench.pass(1);
  CHECK(other.lease().fence() == 0);
  CHECK(other.lease().holder().empty());
  other.send(acquire_item("other"));
  CHECK(bench.server->fence() == 2);
}

TEST_CASE("a datagram that is dropped renews nothing") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  v1::Packet packet;
  packet.set_first(1);
  *packet.add_items() = acquire_item("peer");
  const auto bytes = plain_datagram(5, 0, packet);
  for (int i = 0; i < 45; ++i) {
    bench.receive(peer.address(), bytes);
    bench.pass(50);
  }
  CHECK(bench.server->fence() == 0);
}

TEST_CASE("Release and Bye end the lease, and the host hears how") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send({acquire_item("peer"), release_item()});
  CHECK(bench.server->fence() == 0);
  peer.send({acquire_item("peer"), bye_item()});
  CHECK(bench.server->fence() == 0);
  CHECK(bench.host.lease_ends ==
        std::vector<LeaseEnd>{LeaseEnd::kReleased, LeaseEnd::kSessionEnded});
}

TEST_CASE("the lease does not expire during a Run of steps, and lives 2 s after it") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send(acquire_item("peer"));
  bench.host.answers = false;
  peer.send(run_item(v1::RUN_MODE_STEP, 1000));
  bench.pass(9000);
  CHECK(bench.server->fence() == 1);
  bench.server->answer(bench.host.asked.back().id, result_with());
  bench.pass(900);
  CHECK(bench.server->fence() == 1);
  // The session itself is dropped after 10 s of silence, lease or not.
  bench.pass(200);
  CHECK(bench.server->fence() == 0);
}

TEST_CASE("a name longer than 64 bytes is OUT_OF_RANGE and gives no lease") {
  ServerBench bench;
  RawPeer peer(bench, 5);
  peer.send(acquire_item(std::string(65, 'x')));
  bench.pass(1);
  CHECK(peer.code(1) == v1::RESULT_CODE_OUT_OF_RANGE);
  CHECK(peer.results().at(1).path() == "acquire.holder");
  CHECK(bench.server->fence() == 0);
}

}  // namespace
}  // namespace hapticd::test
