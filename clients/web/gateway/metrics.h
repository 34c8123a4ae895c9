// The state of the gateway as text for Prometheus (format 0.0.4). Pure. Not RT.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "clients/web/gateway/http_server.h"
#include "clients/web/gateway/hub.h"
#include "hapticd/v1/answer.pb.h"
#include "hapticd/v1/gateway.pb.h"

namespace hapticd::web {

/// The contents of /metrics.
struct Metrics {
  std::string version;
  std::size_t viewers = 0;
  HubCounters hub;
  std::uint64_t dropped_states = 0;
  ServerCounters server;
  v1::PageLink link;  ///< as last reported
  std::uint64_t received_bytes = 0;
  std::uint64_t sessions_ended = 0;
  std::optional<v1::State> state;  ///< newest
  v1::Counts counts;               ///< of the daemon's network, newest
};

[[nodiscard]] std::string metrics_text(const Metrics& metrics);

}  // namespace hapticd::web
