// stop: zero force at once, by the Stop road, and where that is of no use by a session. Not RT.
#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "clients/library/named_key.h"
#include "clients/library/stop_road.h"
#include "proto/hints/shell_word.h"
#include "proto/hints/whole_number_option.h"

namespace hapticd::ctl {
namespace {

/// How long the road is tried before a session. Longer: a daemon without a road stops later;
/// shorter: a road full of junk is given up, though one datagram in ten would be heard.
constexpr std::chrono::milliseconds kRoadFirst{500};
/// And once more, where no session helped.
constexpr std::chrono::seconds kRoadAgain{2};

struct StopOptions {
  std::uint16_t port = stop::kDefaultPort;
  std::string key_file;
};

/// Who names a view key asks as one who looks. One that cannot be read keeps nobody from stopping.
bool only_looks(const GlobalOptions& options) {
  if (!options.daemon.role.empty()) return options.daemon.role == "view";
  try {
    const auto key = client::named_key(options.daemon.key_file);
    return key.has_value() && key->role == wire::Role::kView;
  } catch (const std::runtime_error&) {
    return false;
  }
}

client::StopPlace place_of(const GlobalOptions& options, const StopOptions& given) {
  const client::Endpoint server = server_of(options);
  client::StopPlace place;
  place.host = server.host;
  place.port = given.port;
  place.target.session_port = server.port;
  try {
    place.target.key = client::named_stop_key(given.key_file, options.daemon.key_file);
  } catch (const std::runtime_error& error) {
    throw Failure(kRefused, std::string("--stop-key: ") + error.what());
  }
  return place;
}

/// What ends the latch, to be typed.
std::string clear_command(const GlobalOptions& options) {
  const client::DaemonChoice& daemon = options.daemon;
  std::string command = "hapticctl ";
  if (daemon.server != client::DaemonChoice().server) {
    command += "--server " + hints::shell_word(daemon.server) + " ";
  }
  if (!daemon.key_file.empty()) command += "--key " + hints::shell_word(daemon.key_file) + " ";
  return command + "clear";
}

void print_stopped(const GlobalOptions& options, const std::string& how) {
  if (options.json) {
    v1::Result result;
    result.set_code(v1::RESULT_CODE_OK);
    result.set_message("stopped by " + how);
    print_text(to_json(result));
    return;
  }
  print_text("stopped by " + how + "; " + clear_command(options) +
             " ends it (where there are keys, with a control key)");
}

bool stop_by_road(const GlobalOptions& options, const client::StopPlace& place,
                  std::chrono::nanoseconds patience) {
  const client::StopReport report = client::stop_by_road(place, patience);
  if (!report.stopped) return false;
  print_stopped(options,
                report.latched ? "the Stop road" : "the Stop road, with the next tick of the loop");
  return true;
}

void stop_by_session(const GlobalOptions& options) {
  const auto client = connect(options);
  v1::Item stop;
  stop.mutable_stop();
  ask(*client, stop, options);
  print_stopped(options, "a session");
}

void run_stop(const GlobalOptions& options, const StopOptions& given) {
  if (only_looks(options) && given.key_file.empty()) {
    stop_by_session(options);
    return;
  }
  const client::StopPlace place = place_of(options, given);
  if (stop_by_road(options, place,
                   std::min<std::chrono::nanoseconds>(kRoadFirst, timeout_of(options))))
    return;
  try {
    stop_by_session(options);
  } catch (const Failure& failure) {
    if (failure.exit_code() != kUnreachable) throw;
    if (stop_by_road(options, place,
                     std::min<std::chrono::nanoseconds>(kRoadAgain, timeout_of(options))))
      return;
    throw Failure(kUnreachable, "no Stop road answers at port " + std::to_string(given.port) +
                                    " (--stop-port, --stop-key), and by a session " +
                                    failure.what());
  }
}

}  // namespace

void add_stop_command(CLI::App& app, const GlobalOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "stop", "Zero force at once, latched, by the Stop road or a session; needs no lease");
  const auto given = std::make_shared<StopOptions>();
  hints::takes_whole_number(
      command.add_option("--stop-port", given->port, "UDP port of the Stop road"), 1, 65535)
      ->capture_default_str();
  command
      .add_option("--stop-key", given->key_file,
                  "key of the Stop road (default: stop.key beside the file of --key)")
      ->type_name("FILE");
  command.callback([&options, given] { run_stop(options, *given); });
}

}  // namespace hapticd::ctl
