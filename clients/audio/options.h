// The command line of haptic-audio. Not RT.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/library/program.h"

namespace hapticd::audio {

/// Exit codes, besides 0 and those of client::run_program().
inline constexpr int kFileBad = client::kProgramFailed;  ///< a file or key is bad
inline constexpr int kNoServer = 3;                      ///< no JACK server

/// From an event to its sound, where the sound card allows it; the page's own.
inline constexpr double kDelay_ms = 8.0;

/// What is to be done, and how.
struct Options {
  client::DaemonChoice daemon;
  std::optional<double> delay_ms;  ///< as given; none: kDelay_ms, or what the sound card needs
  double gain_db = 0.0;
  std::optional<std::string> tones;  ///< as given
  bool synth = false;
  bool list = false;
  bool json = false;  ///< the list is for programs
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

/// What the command line may say, to be read into `options`.
void add_options(CLI::App& app, Options& options);

}  // namespace hapticd::audio
