// What the server counts, how clients are told, and when the log says so.
#include "server/network/loss_report.h"

#include <doctest/doctest.h>

#include <map>
#include <string>

#include "tests/server/network/keyed_peer.h"

namespace hapticd::test {
namespace {

std::map<std::string, std::uint64_t> by_cause(const v1::Counts& counts) {
  std::map<std::string, std::uint64_t> all;
  for (const v1::Count& count : counts.counts())
    CHECK(all.emplace(count.cause(), count.count()).second);
  return all;
}

TEST_CASE("every cause has a name of its own in small letters") {
  const auto all = by_cause(counts_of({}));
  CHECK(all.size() == counted_causes().size());
  for (const auto& [name, count] : all) {
    CHECK(count == 0);
    CHECK(!name.empty());
    CHECK(name.size() <= 64);
    CHECK(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos);
  }
}

TEST_CASE("forged, repeated and malformed datagrams are each told by GetCounts") {
  ServerBench bench(keyed_options());
  KeyedPeer peer(bench, kViewRole);
  peer.shake_hands();
  peer.send({ping_item()});
  for (int i = 0; i < 500; ++i) {
    noise::Bytes forged = peer.captured[0];
    forged[8] = static_cast<std::uint8_t>(i);
    forged[9] = static_cast<std::uint8_t>(1 + i / 256);
    bench.receive(peer.address, forged);
  }
  for (int i = 0; i < 7; ++i) bench.receive(peer.address, peer.captured[0]);
  const noise::Bytes strangers = KeyedClient(kControlRole, 5, noise::Key{}).hello();
  for (int i = 0; i < 11; ++i) bench.receive(ipv4_address({10, 0, 0, 9}, 7), strangers);
  bench.receive(peer.address, std::span(strangers).first(1199));
  bench.receive(peer.address, std::span(strangers).first(3));
  v1::Item ask;
  ask.mutable_get_counts();
  peer.send({ask});
  bench.pass(1);
  for (const v1::Item& item : peer.received()) {
    if (!item.has_result() || item.result().item_id() != 2) continue;
    const auto told = by_cause(item.result().counts());
    CHECK(told.at("forged") == 500);
    CHECK(told.at("repeated") == 7);
    CHECK(told.at("hello_forged") == 11);
    CHECK(told.at("hello_malformed") == 1);
    CHECK(told.at("bad_header") == 1);
    CHECK(told.at("hello_retried") == 1);
    CHECK(told.at("hello_welcomed") == 1);
    CHECK(told.at("received") == 2 + 1 + 500 + 7 + 11 + 2 + 1);
  }
  CHECK(peer.code(2) == v1::RESULT_CODE_OK);
}

TEST_CASE("the log hears of losses once a second, and of nothing when none is new") {
  LossReport report;
  ServerCounters counters;
  std::int64_t now_ns = 5'000'000'000;
  counters.received = 9;
  CHECK(report.next(counters, now_ns).empty());
  counters.forged = 500;
  now_ns += 999'999'999;
  CHECK(report.next(counters, now_ns).empty());
  now_ns += 1;
  CHECK(report.next(counters, now_ns) == "forged 500 (500 so far)");
  now_ns += 1'000'000'000;
  CHECK(report.next(counters, now_ns).empty());
  counters.forged = 502;
  counters.hellos.limited = 3;
  CHECK(report.next(counters, now_ns).empty());
  now_ns += 1'000'000'000;
  CHECK(report.next(counters, now_ns) == "forged 2 (502 so far), hello_limited 3 (3 so far)");
  counters.repeated = 1;
  CHECK(report.rest(counters) == "repeated 1 (1 so far)");
}

}  // namespace
}  // namespace hapticd::test
