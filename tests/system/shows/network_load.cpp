// Load for a daemon under test: a flood of junk datagrams, or many clients that take every State.
// Prints one JSON object when it is over. Not RT.
//
//   network_load flood HOST PORT PACKETS_PER_S SECONDS SEED
//   network_load clients HOST PORT CLIENTS SECONDS
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "clients/library/client.h"

namespace {

using hapticd::client::Client;
using hapticd::client::monotonic_now_ns;

/// Datagrams handed to the system at once.
constexpr std::size_t kBatch = 50;
/// Longest datagram of the protocol, bytes.
constexpr std::size_t kMax = 1200;

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// A datagram that nobody can want: noise, or a header that promises something and noise behind it.
std::size_t write_junk(std::mt19937_64& random, std::array<std::uint8_t, kMax>& out) {
  const std::uint64_t choice = random();
  const bool with_header = (choice & 7U) != 0;
  // Mostly short, as floods are; the longest now and then.
  const std::size_t length = (choice >> 3U & 15U) == 0 ? kMax : 1 + (choice >> 8U) % 96;
  for (std::size_t k = 0; k < length; k += 8) {
    const std::uint64_t noise = random();
    std::memcpy(out.data() + k, &noise, std::min<std::size_t>(8, kMax - k));
  }
  if (with_header) {
    out[0] = 'H';
    out[1] = 1;
    out[2] = static_cast<std::uint8_t>(choice >> 32U) % 7;
    out[3] = 0;
  }
  return length;
}

int flood(const char* host, int port, double rate, double seconds, std::uint64_t seed) {
  const int socket_ = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  if (socket_ < 0 || inet_pton(AF_INET, host, &to.sin_addr) != 1 ||
      connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) != 0) {
    return 1;
  }
  std::mt19937_64 random(seed);
  std::array<std::array<std::uint8_t, kMax>, kBatch> bytes{};
  std::array<iovec, kBatch> vectors{};
  std::array<mmsghdr, kBatch> messages{};
  std::uint64_t sent = 0;
  std::uint64_t refused = 0;
  const std::int64_t begin_ns = monotonic_now_ns();
  const auto wanted = static_cast<std::uint64_t>(rate * seconds);
  while (sent + refused < wanted) {
    for (std::size_t k = 0; k < kBatch; ++k) {
      vectors[k] = {bytes[k].data(), write_junk(random, bytes[k])};
      messages[k] = {};
      messages[k].msg_hdr.msg_iov = &vectors[k];
      messages[k].msg_hdr.msg_iovlen = 1;
    }
    const int taken = sendmmsg(socket_, messages.data(), kBatch, 0);
    sent += taken > 0 ? static_cast<std::uint64_t>(taken) : 0;
    refused += kBatch - (taken > 0 ? static_cast<std::uint64_t>(taken) : 0);
    const double due_s = static_cast<double>(sent + refused) / rate;
    const std::int64_t due_ns = begin_ns + static_cast<std::int64_t>(1e9 * due_s);
    const std::int64_t early_ns = due_ns - monotonic_now_ns();
    if (early_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(early_ns));
  }
  const double took_s = 1e-9 * static_cast<double>(monotonic_now_ns() - begin_ns);
  std::printf("{\"sent\": %llu, \"refused\": %llu, \"seconds\": %.3f, \"cpu_s\": %.3f}\n",
              static_cast<unsigned long long>(sent), static_cast<unsigned long long>(refused),
              took_s, processor_seconds());
  close(socket_);
  return 0;
}

/// What one client saw.
struct Seen {
  std::uint64_t states = 0;
  std::uint64_t ended = 0;
};

void subscribe(const char* host, int port, double seconds, Seen& seen) {
  hapticd::client::ClientHandlers handlers;
  handlers.state = [&](const hapticd::v1::State&) { ++seen.states; };
  handlers.ended = [&](hapticd::client::SessionEnd) { ++seen.ended; };
  Client client(host, static_cast<std::uint16_t>(port), handlers);
  if (!client.connect()) return;
  client.subscribe(1, {hapticd::v1::SECTION_TOOLS});
  const std::int64_t end_ns = monotonic_now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  while (monotonic_now_ns() < end_ns) client.poll();
}

int run_clients(const char* host, int port, std::size_t count, double seconds) {
  std::vector<Seen> seen(count);
  std::vector<std::thread> threads;
  threads.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    threads.emplace_back([&, k] { subscribe(host, port, seconds, seen[k]); });
  }
  for (std::thread& thread : threads) thread.join();
  std::printf("{\"cpu_s\": %.3f, \"states\": [", processor_seconds());
  for (std::size_t k = 0; k < count; ++k) {
    std::printf("%s%llu", k == 0 ? "" : ", ", static_cast<unsigned long long>(seen[k].states));
  }
  std::uint64_t ended = 0;
  for (const Seen& each : seen) ended += each.ended;
  std::printf("], \"ended\": %llu}\n", static_cast<unsigned long long>(ended));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  if (what == "flood" && argc == 7) {
    return flood(argv[2], std::stoi(argv[3]), std::stod(argv[4]), std::stod(argv[5]),
                 std::strtoull(argv[6], nullptr, 10));
  }
  if (what == "clients" && argc == 6) {
    return run_clients(argv[2], std::stoi(argv[3]), std::strtoul(argv[4], nullptr, 10),
                       std::stod(argv[5]));
  }
  std::fprintf(stderr, "network_load flood|clients: see its source\n");
  return 2;
}
