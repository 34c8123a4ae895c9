// Records a gesture of the simulated hand and writes its ticks and events as tables. For a daemon
// on this machine, in virtual time:
//   hapticd --clock virtual
// usage: record_gesture [HOST:PORT [GESTURE]]
#include <hapticd/client/session.h>
#include <hapticd/client/table.h>

#include <cstdio>
#include <exception>

using namespace hapticd;

/// Runs until the gesture has been played to its end.
void play(client::Session& session, const std::string& gesture) {
  session.subscribe(10, {v1::SECTION_GESTURES});
  session.play_gesture(gesture);
  while (session.run(100).states.back().gestures_size() > 0) {
  }
}

int main(int argc, char** argv) try {
  client::SessionOptions options;
  if (argc > 1) options.server = argv[1];
  const std::string gesture = argc > 2 ? argv[2] : "strum";
  client::Session session(options);
  session.acquire("record_gesture");
  session.record(v1::RECORD_MODE_START, gesture + ".mcap");
  play(session, gesture);
  const std::string recording = session.record(v1::RECORD_MODE_STOP);
  const std::uint64_t ticks =
      client::write_recording(recording, client::RecordedRows::kTicks, gesture + ".csv");
  const std::uint64_t events =
      client::write_recording(recording, client::RecordedRows::kEvents, gesture + "_events.csv");
  std::printf("%s: %llu ticks, %llu events\n", recording.c_str(),
              static_cast<unsigned long long>(ticks), static_cast<unsigned long long>(events));
} catch (const std::exception& error) {
  std::fprintf(stderr, "record_gesture: %s\n", error.what());
  return 1;
}
