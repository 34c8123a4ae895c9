// See datagram_target.h.
#include "tests/fuzz/datagram_target.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "proto/wire/channel.h"
#include "server/network/protocol_server.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint32_t kSession = 0x1234abcd;
/// Datagrams in one input: more only cost time.
constexpr int kMaxDatagrams = 64;

void require(bool condition) {
  if (!condition) throw std::logic_error("the server did what it must not");
}

v1::Result result_of(const v1::Item& request) {
  v1::Result result;
  result.set_code(request.has_run() ? v1::RESULT_CODE_FAILED : v1::RESULT_CODE_OK);
  if (request.has_list_scenes()) {
    for (int i = 0; i < 200; ++i) result.mutable_listing()->add_names("a scene");
  }
  return result;
}

/// A State with more of everything than fits.
void fill(v1::State& state) {
  for (std::uint32_t id = 0; id < 8; ++id) {
    v1::ToolState& tool = *state.add_tools();
    tool.set_tool_id(id);
    for (int k = 0; k < 6; ++k) tool.add_p_wh_m(0.5);
    for (int k = 0; k < 20; ++k) tool.add_q_wh(0.5F);
    v1::ContactPatch& patch = *state.add_contacts();
    patch.set_tool_id(id);
    for (int i = 0; i < 8; ++i) {
      patch.add_gap_nanometres(i);
      patch.add_tool_sphere(i);
      patch.add_force_mn(5);
      for (int k = 0; k < 3; ++k) {
        patch.add_p_wc_um(k);
        patch.add_nhat_og_w_e4(k);
      }
    }
    state.add_strings()->set_string_index(id);
  }
}

/// A server whose host answers every second request at once, the others after the next datagram.
class FuzzedServer {
 public:
  FuzzedServer() : server_({.boot_id = 5, .virtual_clock = true}, host(), sender()) {
    v1::Packet hello;
    hello.set_first(1);
    receive_packet(hello);
  }

  void receive(std::span<const std::uint8_t> bytes, bool elsewhere) {
    const Address from =
        ipv4_address({127, 0, 0, elsewhere ? std::uint8_t{2} : std::uint8_t{1}}, 4);
    server_.receive(from, bytes, now_ns_);
  }

  void receive_packet(const std::string& body) {
    const auto header = wire::encode_header({wire::DatagramKind::kPlain, kSession, counter_++});
    std::vector<std::uint8_t> datagram(header.begin(), header.end());
    datagram.insert(datagram.end(), body.begin(), body.end());
    receive(datagram, false);
  }
  void receive_packet(const v1::Packet& packet) { receive_packet(packet.SerializeAsString()); }

  void pass(std::int64_t ns) {
    now_ns_ += ns;
    server_.poll(now_ns_);
    for (const auto& [id, result] : std::exchange(later_, {})) server_.answer(id, result);
    if (server_.may_step(now_ns_)) server_.offer_tick(tick_++, 1, now_ns_);
    server_.poll(now_ns_);
    require(server_.session_count() <= 32);
  }

  /// Some datagram was taken.
  [[nodiscard]] bool finish() {
    const ServerCounters& counters = server_.counters();
    const std::uint64_t dropped =
        counters.bad_header + counters.unknown_session + counters.repeated + counters.unreadable;
    require(dropped <= counters.received);
    for (int i = 0; i < 12; ++i) pass(1000 * kMs);
    require(server_.session_count() == 0);
    require(server_.fence() == 0);
    return counters.received - dropped > 1;
  }

 private:
  ServerHost host() {
    ServerHost host;
    host.greeting = [] {
      std::vector<v1::Item> items(2);
      items[0].mutable_scene_info()->mutable_server_version()->assign(1500, 'x');
      items[1].mutable_record_info();
      return items;
    };
    host.request = [this](const RequestId& id, const v1::Item& item) {
      if (++asked_ % 2 == 0) {
        server_.answer(id, result_of(item));
      } else {
        later_.emplace_back(id, result_of(item));
      }
    };
    host.abandoned = [](const RequestId&) {};
    host.fill_state = [](const Subscription&, v1::State& state) { fill(state); };
    host.lease_lost = [](LeaseEnd) {};
    return host;
  }

  static ProtocolServer::Send sender() {
    return [](const Address&, std::span<const std::uint8_t> bytes) {
      const auto header = wire::decode_header(bytes);
      require(header.has_value() && header->kind == wire::DatagramKind::kPlain);
      v1::Packet packet;
      require(wire::parse_packet(bytes.subspan(wire::kHeaderBytes), packet));
      require(packet.boot_id() == 5);
    };
  }

  std::int64_t now_ns_ = 1000 * kMs;
  std::uint64_t counter_ = 0;
  std::uint64_t tick_ = 0;
  std::uint64_t asked_ = 0;
  std::vector<std::pair<RequestId, v1::Result>> later_;
  ProtocolServer server_;
};

}  // namespace

bool check_datagram_bytes(std::span<const std::uint8_t> bytes) {
  FuzzedServer server;
  for (int n = 0; n < kMaxDatagrams && bytes.size() >= 2; ++n) {
    const unsigned head = bytes[0] | static_cast<unsigned>(bytes[1]) << 8U;
    bytes = bytes.subspan(2);
    const auto datagram = bytes.first(std::min<std::size_t>(head & 0x7ffU, bytes.size()));
    bytes = bytes.subspan(datagram.size());
    server.pass((head & 0x4000U) != 0 ? 3000 * kMs : kMs);
    if ((head & 0x8000U) != 0) {
      server.receive_packet(std::string(datagram.begin(), datagram.end()));
    } else {
      server.receive(datagram, (head & 0x2000U) != 0);
    }
  }
  return server.finish();
}

}  // namespace hapticd::test
