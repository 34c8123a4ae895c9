// What hapticd was asked to do: command line over configuration file over defaults. Not RT.
#pragma once

#include <stdexcept>
#include <string>

#include "hapticd/v1/config.pb.h"

namespace hapticd {

/// Exit codes of hapticd.
inline constexpr int kExitGood = 0;
inline constexpr int kExitInput = 1;     ///< a scene, gesture, profile or configuration is bad
inline constexpr int kExitUsage = 2;     ///< the command line makes no sense
inline constexpr int kExitAddress = 3;   ///< the address cannot be listened on
inline constexpr int kExitRealtime = 4;  ///< --realtime require, and a privilege is missing
inline constexpr int kExitReplay = 5;    ///< --verify, and a wrench differed
inline constexpr int kExitRecord = 7;    ///< --record, and the file cannot be begun; 6 is doctor's
inline constexpr int kExitPhysics = 8;   ///< --verify, and only the poses could be compared

/// The start failed; the text names option or file:line, and the remedy.
class StartError : public std::runtime_error {
 public:
  StartError(int exit_code, const std::string& what)
      : std::runtime_error(what), exit_code_(exit_code) {}
  [[nodiscard]] int exit_code() const noexcept { return exit_code_; }

 private:
  int exit_code_;
};

struct DaemonOptions {
  v1::Config config;           ///< every default filled in
  bool gesture_given = false;  ///< asked for, so it has to exist and fit the scene
  bool check_only = false;     ///< check everything, play nothing
  bool announce = false;       ///< by mDNS
  bool old_handshake = false;  ///< clients of 0.1 are served too
  std::string config_file;     ///< read again at SIGHUP; empty: none
  v1::Config given;            ///< on the command line
};

/// The options of a command line. Throws StartError; prints help or version and returns false when
/// that was asked for.
[[nodiscard]] bool read_options(int argc, const char* const* argv, DaemonOptions& options);

/// Fills in options.config: the defaults, overridden by the configuration file, which is read now,
/// and that by the command line; checked. Throws StartError.
void settle_config(DaemonOptions& options);

/// Reads `file` in protobuf text format into `config`. Throws StartError with file:line.
void read_config_file(const std::string& file, v1::Config& config);

/// Refuses what is out of range or not supported. Throws StartError naming the option.
void check_config(const v1::Config& config);

}  // namespace hapticd
