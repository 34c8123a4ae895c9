// What a State costs on its way to one subscriber over loopback: encoding it beside the sendto()
// that follows, and a whole tick, from the offer to the client's handler, in one thread. Both sides
// of each comparison are timed in turn in the same rounds. Prints a markdown table of medians, less
// what the clock costs; heap calls are the most of any round. The times are wall times of single
// calls with everything in the caches. The ticks are made up: a free finger, one that presses a
// string, and the largest that goes into one datagram. --quick runs a tenth of the rounds.
// usage: network_table [--quick]
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

#include "clients/library/client_core.h"
#include "core/rt/monotonic_clock.h"
#include "server/encoding/encode_state.h"
#include "server/network/encoded_states.h"
#include "server/network/udp_transport.h"
#include "tests/support/no_heap.h"

namespace hapticd::test {
namespace {

constexpr int kWarmUp = 1000;
constexpr int kRounds = 20'000;
/// Room for a State in a datagram, bytes; what a PLAIN one leaves is a little more.
constexpr std::size_t kRoom = 1100;
/// What is asked for: the encoding over the sendto(), and the whole tick, us.
constexpr double kAskedShare = 0.15;
constexpr double kAskedTick_us = 8.0;

/// A tick to be sent.
struct Case {
  const char* what;
  int contacts;
  int strings;
  std::uint32_t sections;
};

constexpr std::uint32_t kUsual =
    1U << v1::SECTION_TOOLS | 1U << v1::SECTION_STRINGS | 1U << v1::SECTION_CONTACTS;
constexpr Case kCases[] = {
    {"a free finger", 0, 0, kUsual},
    {"a finger presses a string", 3, 1, kUsual},
    {"the same, all sections", 3, 1, kCanonicalSections},
    {"16 contacts, 7 strings", 16, 7, kUsual},
};

std::unique_ptr<Tick> tick_of(const Case& c) {
  auto tick = std::make_unique<Tick>();
  tick->scene_id = 1;
  tick->state = LoopState::kEngaged;
  ToolTick tool;
  tool.X_WH.p = {0.33, 3.1e-3, 0.021};
  tool.X_WG.p = {0.33, 5.3e-3, 0.022};
  tool.X_WH.q = tool.X_WG.q = {0.8, 0.36, 0.48, 0.0};
  tool.F_written_H_W.f = {0.1, 1.7, 0.3};
  tool.F_computed_H_W = tool.F_written_H_W;
  tool.contacts = c.contacts;
  tick->tools.push_back(tool);
  for (int k = 0; k < c.contacts; ++k) {
    ContactTick contact;
    contact.key.kind = c.strings > 0 && k % 2 == 0 ? ObstacleKind::kCapsule : ObstacleKind::kBody;
    contact.key.obstacle = contact.key.kind == ObstacleKind::kBody ? 0 : k / 2 % c.strings;
    contact.key.tool_sphere = 20 * k;
    contact.p_WC = {0.33 + 1e-4 * k, 1e-3, 0.02};
    contact.nhat_OG_W = {0.1, 0.98, 0.17};
    contact.gap = -5e-7 * k;
    contact.force = 0.1 * k;
    tick->contacts.push_back(contact);
  }
  tick->contacts_total = c.contacts;
  for (int k = 0; k < c.strings; ++k) {
    tick->strings.push_back(
        {k, 0, StringPhase::kStatic, true, true, 0.3, 1e-3, {1e-4, -1e-3, 2e-4}});
    tick->string_forces.push_back({0, k, {0.0, 1.1, 0.2}});
  }
  return tick;
}

SceneIndex index_of(const Case& c) {
  SceneIndex index;
  index.tool_ids = {0};
  for (int k = 0; k < c.strings; ++k) {
    index.pieces.push_back({static_cast<std::uint32_t>(k), true, 1e-3, 0.0, 1.0});
  }
  return index;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// ns of reading the clock twice.
double clock_cost() {
  std::vector<double> times;
  for (int k = 0; k < 1000; ++k) {
    const std::int64_t before = monotonic_now_ns();
    times.push_back(static_cast<double>(monotonic_now_ns() - before));
  }
  return median(times);
}

/// A client's socket, connected to the server's.
class ClientSocket {
 public:
  explicit ClientSocket(std::uint16_t port) : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval second{1, 0};
    if (socket_ < 0 || connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0 ||
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &second, sizeof second) != 0) {
      throw std::runtime_error("no socket to be had on loopback");
    }
  }
  ClientSocket(const ClientSocket&) = delete;
  ClientSocket& operator=(const ClientSocket&) = delete;
  ~ClientSocket() { close(socket_); }

  void write(std::span<const std::uint8_t> bytes) const {
    (void)!::send(socket_, bytes.data(), bytes.size(), 0);
  }
  /// Hands a datagram to the client; waits a second for one at most, or not at all.
  bool read(client::ClientCore& client, bool wait) {
    const ssize_t bytes = recv(socket_, buffer_.data(), buffer_.size(), wait ? 0 : MSG_DONTWAIT);
    if (bytes < 0) return false;
    client.receive({buffer_.data(), static_cast<std::size_t>(bytes)}, monotonic_now_ns());
    return true;
  }

 private:
  int socket_;
  std::array<std::uint8_t, 2048> buffer_{};
};

/// Of all rounds, ns.
struct Times {
  std::vector<double> encode, send, whole;
  std::int64_t encode_heap_calls = 0, publish_heap_calls = 0;
  std::size_t bytes = 0;  ///< of the State
};

/// One server and one client that gets every tick, and what the rounds took.
class Rounds {
 public:
  explicit Rounds(const Case& c) : case_(c), tick_(tick_of(c)), index_(index_of(c)) {
    v1::Item item;
    item.mutable_subscribe()->set_divisor(1);
    for (int section = 1; section < 32; ++section) {
      if ((c.sections >> section & 1U) == 0) continue;
      item.mutable_subscribe()->add_sections(static_cast<v1::Section>(section));
    }
    client_.request(item);
  }

  Times run(int rounds) {
    rounds_ = rounds;
    transport_.run(server_, [this](std::int64_t now_ns) { return round(now_ns); });
    return std::move(times_);
  }

 private:
  ServerHost host() {
    ServerHost host;
    host.greeting = [] {
      std::vector<v1::Item> items(2);
      items[0].mutable_scene_info()->set_scene_id(1);
      items[1].mutable_record_info();
      return items;
    };
    host.request = [](const RequestId&, const v1::Item&) {};
    host.abandoned = [](const RequestId&) {};
    host.fill_state = fill_;
    host.lease_lost = [](LeaseEnd) {};
    return host;
  }

  void send(const Address& to, std::span<const std::uint8_t> datagram) {
    publish_calls_ = publish_ ? publish_->count() : 0;
    const std::int64_t before_ns = monotonic_now_ns();
    transport_.send(to, datagram);
    send_ns_ = monotonic_now_ns() - before_ns;
  }

  void encode() {
    const NoHeapScope scope;
    const std::int64_t before_ns = monotonic_now_ns();
    encoded_.begin(tick_->tick, 1);
    const auto state = encoded_.get({1, case_.sections, 256}, kRoom, fill_, {});
    encode_ns_ = monotonic_now_ns() - before_ns;
    encode_calls_ = scope.count();
    if (state->parts.size() != 1) throw std::runtime_error("the State is no single datagram");
    times_.bytes = state->parts[0].size();
  }

  /// The tick goes out and comes in; true once the client's handler has it.
  bool pass(bool measured) {
    publish_.emplace();
    const std::int64_t before_ns = monotonic_now_ns();
    server_.offer_tick(tick_->tick, 1, before_ns);
    publish_.reset();
    while (seen_ != tick_->tick && socket_.read(client_, measured)) {
    }
    whole_ns_ = monotonic_now_ns() - before_ns;
    return seen_ == tick_->tick;
  }

  bool round(std::int64_t now_ns) {
    client_.poll(now_ns);
    ++tick_->tick;
    const bool measured = done_ >= kWarmUp;
    encode();
    if (!pass(measured) && measured) throw std::runtime_error("a State did not arrive");
    if (measured) {
      times_.encode.push_back(static_cast<double>(encode_ns_));
      times_.send.push_back(static_cast<double>(send_ns_));
      times_.whole.push_back(static_cast<double>(whole_ns_));
      times_.encode_heap_calls = std::max(times_.encode_heap_calls, encode_calls_);
      times_.publish_heap_calls = std::max(times_.publish_heap_calls, publish_calls_);
    }
    if (++done_ == kWarmUp + rounds_) transport_.stop();
    return true;
  }

  Case case_;
  std::unique_ptr<Tick> tick_;
  SceneIndex index_;
  EncodedStates::Fill fill_ = [this](const Subscription& wanted, v1::State& state) {
    encode_state(*tick_, index_, {wanted.sections, wanted.max_contacts}, state);
  };
  EncodedStates encoded_;
  UdpTransport transport_{"127.0.0.1:0"};
  ProtocolServer server_{
      {.boot_id = 3}, host(), [this](const Address& to, std::span<const std::uint8_t> datagram) {
        send(to, datagram);
      }};
  ClientSocket socket_{transport_.port()};
  std::uint64_t seen_ = 0;
  client::ClientCore client_{[this](std::span<const std::uint8_t> bytes) { socket_.write(bytes); },
                             [] { return 7U; },
                             {.item = {},
                              .state = [this](const v1::State& s) { seen_ = s.tick(); },
                              .pose_refused = {},
                              .ended = {}}};
  Times times_;
  int rounds_ = 0;
  int done_ = 0;
  std::optional<NoHeapScope> publish_;  ///< while a tick is being offered
  std::int64_t encode_ns_ = 0, send_ns_ = 0, whole_ns_ = 0;
  std::int64_t encode_calls_ = 0, publish_calls_ = 0;
};

const char* verdict(bool met) { return met ? "met" : "**not met**"; }

void run(int rounds) {
  std::printf(
      "| State | bytes | encode ns | sendto ns | encode / sendto | asked %g | publish + receive us "
      "| asked %g | heap calls, encode | publish "
      "|\n|---|---:|---:|---:|---:|---|---:|---|---:|---:|\n",
      kAskedShare, kAskedTick_us);
  const double clock = clock_cost();
  for (const Case& c : kCases) {
    Times t = std::make_unique<Rounds>(c)->run(rounds);
    const double encode = median(t.encode) - clock;
    const double send = median(t.send) - clock;
    // The clock is read twice more inside.
    const double whole_us = 1e-3 * (median(t.whole) - 2.0 * clock);
    std::printf("| %s | %zu | %.0f | %.0f | %.3f | %s | %.2f | %s | %lld | %lld |\n", c.what,
                t.bytes, encode, send, encode / send, verdict(encode <= kAskedShare * send),
                whole_us, verdict(whole_us <= kAskedTick_us),
                static_cast<long long>(t.encode_heap_calls),
                static_cast<long long>(t.publish_heap_calls));
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace hapticd::test

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::strcmp(argv[1], "--quick") == 0;
  try {
    hapticd::test::run(hapticd::test::kRounds / (quick ? 10 : 1));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "network_table: %s\n", error.what());
    return 1;
  }
}
