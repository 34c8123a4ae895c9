// See metrics.h.
#include "clients/web/gateway/metrics.h"

#include <array>
#include <cstdio>
#include <utility>
#include <vector>

namespace hapticd::web {
namespace {

/// A number with more digits than any of these is good for.
std::string number(double value) {
  std::array<char, 32> text{};
  const int length = std::snprintf(text.data(), text.size(), "%.9g", value);
  return {text.data(), static_cast<std::size_t>(length)};
}

/// Collects lines.
class Text {
 public:
  void counter(const std::string& name, const char* help, std::uint64_t value) {
    head(name, help, "counter");
    text_ += name + ' ' + std::to_string(value) + '\n';
  }
  /// One for each pair of labels and value.
  void counters(const std::string& name, const char* help,
                const std::vector<std::pair<std::string, std::uint64_t>>& samples) {
    head(name, help, "counter");
    for (const auto& [labels, value] : samples) {
      text_ += name + labels + ' ' + std::to_string(value) + '\n';
    }
  }
  void gauge(const std::string& name, const char* help, double value,
             const std::string& labels = "") {
    head(name, help, "gauge");
    text_ += name + labels + ' ' + number(value) + '\n';
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void head(const std::string& name, const char* help, const char* type) {
    text_ += "# HELP " + name + ' ' + help + "\n# TYPE " + name + ' ' + type + '\n';
  }

  std::string text_;
};

void add_viewers(Text& text, const Metrics& of) {
  text.gauge("haptic_web_viewers", "Viewers now.", static_cast<double>(of.viewers));
  text.counter("haptic_web_viewers_total", "Viewers so far.", of.hub.viewers_ever);
  text.counter("haptic_web_viewers_closed_slow_total",
               "Viewers closed because they did not keep up with events.", of.hub.closed_slow);
  text.counter("haptic_web_viewers_closed_garbage_total",
               "Viewers closed because of what they sent.", of.hub.closed_garbage);
  text.counter("haptic_web_viewers_closed_unfinished_total",
               "Viewers closed because a message of theirs did not end.", of.hub.closed_unfinished);
  text.counter("haptic_web_viewers_gave_way_total",
               "Viewers without the token that gave way to another.", of.hub.gave_way);
  text.counter("haptic_web_states_dropped_total", "States that viewers were too slow for.",
               of.dropped_states);
  text.counter("haptic_web_page_requests_total", "Messages of pages.", of.hub.requests);
  text.counter("haptic_web_page_requests_refused_total", "Requests refused by the gateway.",
               of.hub.refused);
  text.counter("haptic_web_http_requests_total", "HTTP requests.", of.server.requests);
  text.counter("haptic_web_origin_refused_total",
               "Requests under a foreign name or from a foreign page.", of.server.refused_origin);
  text.counter("haptic_web_full_refused_total", "Connections and viewers that found no place.",
               of.server.refused_full + of.server.door.refused_full);
  text.counter("haptic_web_address_refused_total", "Connections beyond those of one address.",
               of.server.door.refused_address);
  text.counter("haptic_web_idle_evicted_total", "Idle connections that gave way to another.",
               of.server.door.evicted);
  text.counter("haptic_web_bad_tokens_total", "Handshakes with a wrong token.",
               of.server.bad_tokens);
}

void add_link(Text& text, const Metrics& of) {
  text.gauge("haptic_web_link_state", "PageLinkState: 2 is live.",
             static_cast<double>(of.link.state()));
  text.gauge("haptic_web_link_loss_ratio", "Datagrams of the daemon lost in the last second.",
             of.link.loss());
  text.gauge("haptic_web_link_round_trip_seconds", "Round trip to the daemon.",
             of.link.round_trip_s());
  text.gauge("haptic_web_link_clock_error_seconds", "Bound of the clock offset's error.",
             of.link.clock_error_s());
  text.counter("haptic_web_link_received_bytes_total", "Bytes from the daemon.", of.received_bytes);
  text.counter("haptic_web_link_sessions_ended_total", "Sessions that ended.", of.sessions_ended);
  text.counter("haptic_web_states_total", "States of the source.", of.hub.states);
  text.counter("haptic_web_items_total", "Items of the source.", of.hub.items);
}

void add_daemon(Text& text, const v1::State& state) {
  text.gauge("hapticd_loop_state", "LoopState: 4 is engaged, 6 fault.",
             static_cast<double>(state.loop_state()));
  if (!state.has_timing()) return;
  text.gauge("hapticd_tick_cpu_p99_seconds", "CPU time of a tick, 99th percentile.",
             state.timing().p99_ns() * 1e-9);
  text.gauge("hapticd_tick_cpu_max_seconds", "CPU time of the longest tick.",
             state.timing().max_ns() * 1e-9);
  text.counter("hapticd_overruns_total", "Ticks that missed their period.",
               state.timing().overruns());
}

/// Only causes that are names: they come from the daemon.
void add_counts(Text& text, const v1::Counts& counts) {
  constexpr std::size_t kLongest = 64;
  std::vector<std::pair<std::string, std::uint64_t>> samples;
  for (const v1::Count& count : counts.counts()) {
    const std::string& cause = count.cause();
    const bool name = !cause.empty() && cause.size() <= kLongest &&
                      cause.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos;
    if (name) samples.emplace_back("{cause=\"" + cause + "\"}", count.count());
  }
  if (samples.empty()) return;
  text.counters("hapticd_network_total", "What the daemon's network has brought and lost.",
                samples);
}

}  // namespace

std::string metrics_text(const Metrics& metrics) {
  Text text;
  text.gauge("haptic_web_info", "What runs.", 1.0, "{version=\"" + metrics.version + "\"}");
  add_viewers(text, metrics);
  add_link(text, metrics);
  if (metrics.state.has_value()) add_daemon(text, *metrics.state);
  add_counts(text, metrics.counts);
  return text.take();
}

}  // namespace hapticd::web
