// See stop_opening.h.
#include "server/daemon/stop_opening.h"

#include <sodium.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "proto/noise/key_folder.h"
#include "server/daemon/daemon_options.h"

namespace hapticd {
namespace {

constexpr const char* kForm = "Give ADDR:PORT with a numeric address, 127.0.0.1:47801, or off.";

constexpr const char* kKeyRemedy =
    "make stop.key with 'hapticctl keygen DIR' and start with --keys DIR or --stop-key FILE";

/// An address as people write it.
struct Place {
  std::string host;
  std::uint16_t port = 0;
};

[[noreturn]] void refuse(const std::string& text) {
  throw StartError(kExitAddress, "--stop-listen: " + text);
}

std::optional<Place> place_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  Place place{text.substr(0, colon), 0};
  const char* const end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + colon + 1, end, place.port);
  if (parsed.ec != std::errc{} || parsed.ptr != end) return std::nullopt;
  if (place.host.size() > 2 && place.host.front() == '[' && place.host.back() == ']') {
    place.host = place.host.substr(1, place.host.size() - 2);
  } else if (place.host.empty() || place.host.find(':') != std::string::npos) {
    return std::nullopt;
  }
  return place;
}

std::optional<stop::SecretKey> key_of(const v1::Config& config) {
  std::filesystem::path file = config.stop_key();
  if (file.empty()) {
    if (config.keys().empty()) return std::nullopt;
    file = std::filesystem::path(config.keys()) / noise::kStopKeyName;
    std::error_code unknown;
    // A folder made by an earlier version has none.
    if (!std::filesystem::exists(std::filesystem::symlink_status(file, unknown))) {
      return std::nullopt;
    }
  }
  try {
    return noise::read_bare_key(file);
  } catch (const std::runtime_error& error) {
    throw StartError(kExitInput, std::string("--stop-key: ") + error.what());
  }
}

bool is_loopback(const std::string& host) { return host == "::1" || host.starts_with("127."); }

std::unique_ptr<StopRoad> bind(const StopRoadOptions& options, StopLine& line) {
  const std::string place = "'" + options.host + "', port " + std::to_string(options.port);
  try {
    return std::make_unique<StopRoad>(options, line);
  } catch (const std::invalid_argument& error) {
    refuse(std::string(error.what()) + ". " + kForm);
  } catch (const std::system_error& error) {
    refuse("cannot listen on " + place + ": " + error.code().message() +
           ". If another hapticd runs, end it, or choose another port, or off.");
  }
}

}  // namespace

StopPlan stop_plan(const v1::Config& config) {
  StopPlan plan;
  plan.key = key_of(config);
  const std::string& listen = config.stop_listen();
  plan.off = listen == "off";
  if (plan.off || listen.empty()) return plan;
  const std::optional<Place> place = place_of(listen);
  if (!place) refuse("'" + listen + "' is not an address. " + kForm);
  plan.host = place->host;
  plan.port = place->port;
  return plan;
}

void check_stop_plan(const StopPlan& plan) {
  if (plan.off || plan.host.empty()) return;
  try {
    check_stop_address(plan.host);
  } catch (const std::invalid_argument& error) {
    refuse(std::string(error.what()) + ". " + kForm);
  }
  if (plan.key || is_loopback(plan.host)) return;
  refuse(std::string("without stop.key everyone who reaches it could stop; ") + kKeyRemedy);
}

std::unique_ptr<StopRoad> open_stop_road(const StopPlan& plan, const std::string& listened,
                                         StopLine& line) {
  if (plan.off) {
    spdlog::warn("--stop-listen off: a Stop comes by sessions alone, and waits for what they do");
    return nullptr;
  }
  check_stop_plan(plan);
  const Place sessions = place_of(listened).value_or(Place{});
  const bool named = !plan.host.empty();
  StopRoadOptions options;
  options.host = named ? plan.host : sessions.host;
  options.port = plan.port;
  options.elsewhere = !named;
  options.rules.key = plan.key;
  options.rules.session_port = sessions.port;
  randombytes_buf(options.rules.secret.data(), options.rules.secret.size());
  if (!plan.key && !is_loopback(options.host)) {
    options.host = options.host.find(':') == std::string::npos ? "127.0.0.1" : "::1";
    spdlog::warn("there is no stop.key, so the Stop road hears this machine alone; {}", kKeyRemedy);
  }
  std::unique_ptr<StopRoad> road = bind(options, line);
  if (!named && road->port() != plan.port) {
    spdlog::warn("port {} is taken, by another hapticd perhaps; the Stop road has another one",
                 plan.port);
  }
  spdlog::info("Stop road on {}", road->local_address());
  return road;
}

}  // namespace hapticd
