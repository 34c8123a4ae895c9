// Follows who plays: for each tone a bar as long as it is loud, and the tempo since the tone
// before. For any daemon. usage: metronome [HOST:PORT [TONES]]; TONES: end after so many
#include <hapticd/client/session.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

using namespace hapticd;

int main(int argc, char** argv) try {
  client::SessionOptions options;
  if (argc > 1) options.server = argv[1];
  long left = argc > 2 ? std::strtol(argv[2], nullptr, 10) : -1;
  client::Session session(options);
  std::puts("listening");
  std::fflush(stdout);
  std::uint64_t last_ns = 0;
  while (left != 0) {
    session.poll();
    const auto event = session.next_event();
    if (!event || !event->has_tone()) continue;
    const v1::Tone& tone = event->tone();
    const std::string bar(static_cast<std::size_t>(tone.level() * 40.0F), '#');
    const double gap_s = static_cast<double>(tone.t_ns() - last_ns) * 1e-9;
    if (last_ns != 0) std::printf("%6.1f bpm %s\n", 60.0 / gap_s, bar.c_str());
    std::fflush(stdout);
    last_ns = tone.t_ns();
    if (left > 0) --left;
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "metronome: %s\n", error.what());
  return 1;
}
