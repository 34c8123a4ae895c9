// What a tick costs the network thread with 32 subscribers of every tick, sockets left out: all
// with the same subscription, and each with one of its own, which is what it costs without sharing.
// One tool, 16 contacts and 7 strings: the largest State that goes into one datagram with room for
// events. `different` over `equal` in the same run is what sharing gains.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/network/protocol_server.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kSessions = 32;
constexpr int kContacts = 16;
constexpr int kStrings = 7;

void fill(v1::State& state) {
  state.set_t_ns(1'000'000 * state.tick());
  state.set_loop_state(v1::LOOP_STATE_ENGAGED);
  v1::ToolState& tool = *state.add_tools();
  for (int k = 0; k < 3; ++k) {
    tool.add_p_wh_m(0.1 * k);
    tool.add_p_wg_m(0.1 * k);
  }
  for (int k = 0; k < 4; ++k) {
    tool.add_q_wh(0.5F);
    tool.add_q_wg(0.5F);
  }
  for (int k = 0; k < 6; ++k) tool.add_wrench_h_w(0.25F * static_cast<float>(k));
  v1::ContactPatch& patch = *state.add_contacts();
  for (int i = 0; i < kContacts; ++i) {
    patch.add_tool_sphere(20 * i);
    patch.add_gap_nanometres(-500 * i);
    patch.add_force_mn(static_cast<std::uint32_t>(100 * i));
    for (int k = 0; k < 3; ++k) {
      patch.add_p_wc_um(100'000 * k + i);
      patch.add_nhat_og_w_e4(5000 * k);
    }
  }
  for (int i = 0; i < kStrings; ++i) {
    v1::StringState& string = *state.add_strings();
    string.set_string_index(static_cast<std::uint32_t>(i));
    string.set_radius_m(0.01F);
    string.set_lambda(0.5F);
    for (int k = 0; k < 3; ++k) string.add_deflection_w_m(0.001F);
  }
}

std::string first_datagram(std::uint32_t session, std::uint32_t max_contacts) {
  v1::Packet packet;
  packet.set_first(1);
  v1::Subscribe& subscribe = *packet.add_items()->mutable_subscribe();
  subscribe.set_divisor(1);
  subscribe.set_max_contacts(max_contacts);
  std::string datagram{'H', 1, 5, 0, static_cast<char>(session), 0, 0, 0};
  datagram.resize(16);
  packet.AppendToString(&datagram);
  return datagram;
}

void offer_tick(benchmark::State& run, bool different) {
  ServerHost host;
  host.greeting = [] { return std::vector<v1::Item>(2); };
  host.request = [](const RequestId&, const v1::Item&) {};
  host.abandoned = [](const RequestId&) {};
  host.fill_state = [](const Subscription&, v1::State& state) { fill(state); };
  host.lease_lost = [](LeaseEnd) {};
  std::size_t sent = 0;
  std::size_t bytes = 0;
  ProtocolServer server({.boot_id = 3}, host,
                        [&](const Address&, std::span<const std::uint8_t> datagram) {
                          ++sent;
                          bytes += datagram.size();
                        });
  std::int64_t now_ns = 1'000'000'000;
  for (std::uint32_t i = 0; i < kSessions; ++i) {
    const std::string datagram = first_datagram(1 + i, different ? 100 + i : 100);
    const auto* const data = reinterpret_cast<const std::uint8_t*>(datagram.data());
    server.receive(ipv4_address({127, 0, 0, 1}, static_cast<std::uint16_t>(40'000 + i)),
                   {data, datagram.size()}, now_ns);
  }
  std::uint64_t tick = 0;
  sent = bytes = 0;
  // Time stands still: nobody falls silent, and nothing is repeated.
  for (auto _ : run) server.offer_tick(tick++, 1, now_ns);
  run.counters["datagrams"] = static_cast<double>(sent) / static_cast<double>(tick);
  run.counters["bytes each"] = static_cast<double>(bytes) / static_cast<double>(sent);
}

BENCHMARK_CAPTURE(offer_tick, equal_subscriptions, false);
BENCHMARK_CAPTURE(offer_tick, different_subscriptions, true);

}  // namespace
}  // namespace hapticd
