// Prints what is touched at once, and what sounds 8 ms after it happened, when viewer and speakers
// present it too. usage: listen [HOST:PORT [TONES]]; TONES: end after so many
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>

#include "clients/library/client.h"
#include "clients/library/endpoint.h"

using namespace hapticd;

/// The instant of the own clock at which an event of `t_ns` is to be presented.
std::int64_t due_ns(const client::Client& client, std::uint64_t t_ns) {
  const std::int64_t now_ns = client::monotonic_now_ns();
  if (!client.clock().known()) return now_ns;
  return static_cast<std::int64_t>(t_ns) - client.clock().at(now_ns).offset_ns + 8'000'000;
}

int main(int argc, char** argv) try {
  const client::Endpoint server = client::parse_endpoint(argc > 1 ? argv[1] : "127.0.0.1:47800");
  long left = argc > 2 ? std::strtol(argv[2], nullptr, 10) : -1;
  std::deque<v1::Tone> waiting;
  client::ClientHandlers handlers;
  handlers.item = [&waiting](const v1::Item& item) {
    if (item.has_contact() && item.contact().phase() == v1::CONTACT_PHASE_BEGIN) {
      std::printf("tool %u touches\n", item.contact().tool_id());
    }
    if (item.has_tone()) waiting.push_back(item.tone());
  };
  handlers.ended = [](client::SessionEnd) { std::puts("the session is over, another begins"); };
  client::Client client(server.host, server.port, handlers);
  while (!client.connect()) std::fputs("no hapticd is there yet\n", stderr);
  while (left != 0) {
    client.poll(std::chrono::milliseconds(1));
    while (!waiting.empty() &&
           due_ns(client, waiting.front().t_ns()) <= client::monotonic_now_ns()) {
      const v1::Tone& tone = waiting.front();
      std::printf("string %u sounds at %.2f Hz, level %.2f\n", tone.string_index(),
                  static_cast<double>(tone.frequency_hz()), static_cast<double>(tone.level()));
      std::fflush(stdout);
      waiting.pop_front();
      if (left > 0) --left;
    }
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "listen: %s\n", error.what());
  return 1;
}
