// The command line of haptic-audio. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace hapticd::audio {

/// Exit codes, besides 0.
inline constexpr int kFileBad = 1;   ///< a file is bad, or the daemon refuses
inline constexpr int kUsageBad = 2;  ///< the command line makes no sense
inline constexpr int kNoServer = 3;  ///< no JACK server

/// From an event to its sound, where the sound card allows it; the page's own.
inline constexpr double kDelay_ms = 8.0;

/// What is to be done, and how.
struct Options {
  std::string host = "127.0.0.1";
  std::uint16_t port = 47800;
  std::string key_file;            ///< empty: the daemon has no keys
  std::optional<double> delay_ms;  ///< as given; none: kDelay_ms, or what the sound card needs
  double gain_db = 0.0;
  std::optional<std::string> tones;  ///< as given
  bool synth = false;
  bool list = false;
  bool wait = false;
  bool verbose = false;
  std::string name = "haptic-audio";
  std::vector<std::string> connect;
  bool no_connect = false;
  std::string render;     ///< file to render to
  std::string recording;  ///< to render from
  std::string render_tones;
  double rate_hz = 48000.0;
};

/// Reads the command line; an exit code when the program has to end with it.
std::optional<int> read_options(int argc, char** argv, Options& options);

}  // namespace hapticd::audio
