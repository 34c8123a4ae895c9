// The command line of haptic-web. Not RT.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "clients/library/stop_road.h"
#include "clients/web/gateway/daemon_link.h"
#include "clients/web/gateway/experiment_link.h"
#include "clients/web/gateway/http_server.h"
#include "proto/recording/default_recordings.h"

namespace hapticd::web {

/// What was asked for.
struct WebOptions {
  LinkOptions link;
  client::StopPlace stop;  ///< the daemon's Stop road, until the daemon tells its port
  ServerOptions server;
  std::vector<std::filesystem::path> assets;
  std::filesystem::path recording;  ///< empty: a daemon is the source
  /// Folder of those that pages may have shown meanwhile.
  std::filesystem::path recordings = default_recordings();
  /// How experiments are run; its folder is that of all participants.
  ExperimentOptions experiments{{}, default_experiments(), "127.0.0.1:47800", {}};
  double presentation_delay_s = 0.008;
};

/// What the program is to do: run with options, or end with this exit code, its words printed.
struct ParsedOptions {
  WebOptions options;
  std::optional<int> exit_code;  ///< 0 after --help, 1 for a key that cannot be read, 2 bad usage
};

/// Reads the command line.
[[nodiscard]] ParsedOptions parse_options(int argc, const char* const* argv);

}  // namespace hapticd::web
