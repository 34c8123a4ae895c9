// Prints what is touched at once, and what sounds 8 ms after it happened, when viewer and speakers
// present it too. usage: listen [HOST:PORT [TONES]]; TONES: end after so many
#include <hapticd/client/session.h>

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <exception>

using namespace hapticd;

/// Whether 8 ms have passed since the event.
bool is_due(const client::Session& session, std::uint64_t t_ns) {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::nanoseconds(session.own_time_ns(t_ns).value_or(0)) +
             std::chrono::milliseconds(8) <=
         now;
}

int main(int argc, char** argv) try {
  client::SessionOptions options;
  if (argc > 1) options.server = argv[1];
  long left = argc > 2 ? std::strtol(argv[2], nullptr, 10) : -1;
  client::Session session(options);
  std::deque<v1::Tone> waiting;
  while (left != 0) {
    session.poll(std::chrono::milliseconds(1));
    while (const auto event = session.next_event()) {
      if (event->has_tone()) waiting.push_back(event->tone());
      if (event->has_contact() && event->contact().phase() == v1::CONTACT_PHASE_BEGIN) {
        std::printf("tool %u touches\n", event->contact().tool_id());
      }
    }
    while (!waiting.empty() && is_due(session, waiting.front().t_ns())) {
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
