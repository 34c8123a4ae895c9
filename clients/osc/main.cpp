// haptic-osc: what a hapticd plays, as OSC for SuperCollider, Pd and the like. Exit codes: 0 ended
// by a signal, 1 a key or address is bad, 2 the command line makes no sense.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>

#include "clients/library/client.h"
#include "clients/library/endpoint.h"
#include "clients/library/program.h"
#include "clients/osc/bridge.h"
#include "clients/osc/osc_sender.h"
#include "proto/hints/quantity_option.h"
#include "proto/wire/shown_text.h"

namespace {

using hapticd::client::Client;
using hapticd::client::ClientHandlers;
namespace v1 = hapticd::v1;

/// The command line.
struct Options {
  hapticd::client::DaemonChoice daemon;
  std::string to = "127.0.0.1:57120";
  double rate_hz = 60.0;
  double delay_s = 0.008;
};

void add_options(CLI::App& app, Options& options) {
  app.set_version_flag("--version", "haptic-osc " HAPTICD_VERSION);
  hapticd::client::add_daemon_options(app, options.daemon);
  hapticd::client::takes_endpoint(
      app.add_option("--to", options.to, "where OSC goes, HOST:PORT; sclang has port 57120"))
      ->capture_default_str();
  hapticd::hints::takes_unit(app.add_option("--rate", options.rate_hz, "poses per second; 0: none"),
                             "Hz")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  hapticd::hints::takes_unit(
      app.add_option("--delay", options.delay_s,
                     "time after which events are to be heard, s; 0: at once, without time tags"),
      "s")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
}

void subscribe(Client& client, double tick_rate_hz, double rate_hz) {
  v1::Item item;
  hapticd::client::set_rate(tick_rate_hz, rate_hz, *item.mutable_subscribe());
  item.mutable_subscribe()->add_sections(v1::SECTION_TOOLS);
  client.request(item);
}

int run(const Options& options) {
  hapticd::client::end_on_signals();
  const auto to = hapticd::client::parse_endpoint(options.to, {"127.0.0.1", 57120});
  hapticd::osc::OscSender sender(to.host, to.port);
  hapticd::osc::Bridge bridge(
      std::llround(options.delay_s * 1e9),
      [&](const auto& message, const auto& when) { return sender.send(message, when); });
  Client* session = nullptr;
  bool virtual_clock = false;
  const auto clocks = [&] { return hapticd::osc::clocks_now(session->clock(), virtual_clock); };
  ClientHandlers handlers;
  handlers.item = [&](const v1::Item& item) {
    if (item.has_scene_info()) {
      virtual_clock = item.scene_info().clock() == v1::CLOCK_MODE_VIRTUAL;
      subscribe(*session, item.scene_info().rate_hz(), options.rate_hz);
      std::printf("playing %s\n",
                  hapticd::wire::shown_text(item.scene_info().scene().name()).c_str());
      std::fflush(stdout);
    }
    bridge.item(item, clocks());
  };
  handlers.state = [&](const v1::State& state) { bridge.state(state, clocks()); };
  handlers.ended = [](hapticd::client::SessionEnd) {
    std::printf("the session ended; it starts again when hapticd is back\n");
    std::fflush(stdout);
  };
  const std::unique_ptr<Client> client = hapticd::client::open_client(options.daemon, handlers);
  session = client.get();
  hapticd::client::Patience patience(hapticd::client::monotonic_now_ns());
  while (!hapticd::client::has_ended()) {
    client->poll(std::chrono::milliseconds(10));
    hapticd::client::tell_silence("haptic-osc", *client, patience);
  }
  const auto& counters = bridge.counters();
  std::printf("%llu messages sent, %llu of them late; %llu not sent\n",
              static_cast<unsigned long long>(counters.sent),
              static_cast<unsigned long long>(counters.late),
              static_cast<unsigned long long>(counters.unsent));
  return 0;
}

std::function<int()> prepare(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  add_options(app, *options);
  return [options] { return run(*options); };
}

}  // namespace

int main(int argc, char** argv) {
  return hapticd::client::run_program(
      {"haptic-osc", "Sends what a running hapticd plays as OSC.", prepare}, argc, argv);
}
