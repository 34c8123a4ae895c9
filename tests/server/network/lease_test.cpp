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
