// haptic-relay: what a hapticd plays, published to an MQTT broker for large audiences. Exit codes:
// 0 ended by a signal, 1 a key, password or address is bad, 2 the command line makes no sense.
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

#include "clients/library/client.h"
#include "clients/library/endpoint.h"
#include "clients/library/patience.h"
#include "clients/library/program.h"
#include "clients/relay/broker.h"
#include "proto/hints/quantity_option.h"

namespace {

using hapticd::client::Client;
using hapticd::client::ClientHandlers;
namespace v1 = hapticd::v1;

/// Silence of the daemon after which it is called gone, ns.
constexpr std::int64_t kGone_ns = 1'000'000'000;

/// The command line.
struct Options {
  hapticd::client::DaemonChoice daemon;
  std::string broker = "127.0.0.1:1883";
  std::string prefix = "hapticd";
  std::string password_file;
  double rate_hz = 60.0;
  hapticd::relay::BrokerOptions at;
};

void add_options(CLI::App& app, Options& options) {
  app.set_version_flag("--version", "haptic-relay " HAPTICD_VERSION);
  hapticd::client::add_daemon_options(app, options.daemon);
  hapticd::client::takes_endpoint(
      app.add_option("--broker", options.broker, "where the MQTT broker listens, HOST:PORT"))
      ->capture_default_str();
  app.add_option("--user", options.at.user, "user name at the broker");
  app.add_option("--password-file", options.password_file, "file whose first line is its password")
      ->type_name("FILE");
  app.add_option("--cafile", options.at.certificates,
                 "certificates that vouch for the broker; turns on TLS")
      ->type_name("FILE");
  app.add_option("--prefix", options.prefix, "what all topics begin with")
      ->check(CLI::Validator(
          [](const std::string& text) { return hapticd::relay::prefix_problem(text); }, ""))
      ->capture_default_str();
  hapticd::hints::takes_unit(
      app.add_option("--rate", options.rate_hz, "States per second; 0: none"), "Hz")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
}

/// Opens what follows `option`. Throws std::runtime_error that names both where it cannot be read.
std::ifstream open_file(const char* option, const std::string& path) {
  std::error_code unknown;
  const bool folder = std::filesystem::is_directory(path, unknown);
  errno = 0;
  std::ifstream file(path);
  if (folder || !file) {
    const std::string why = std::generic_category().message(folder ? EISDIR : errno);
    throw std::runtime_error(std::string(option) + ": " + path + ": " + why +
                             ". Name a file that can be read.");
  }
  return file;
}

hapticd::relay::BrokerOptions broker_options(const Options& options) {
  hapticd::relay::BrokerOptions made = options.at;
  const auto at = hapticd::client::parse_endpoint(options.broker, {made.host, made.port});
  made.host = at.host;
  made.port = at.port;
  made.will = hapticd::relay::link_publication(options.prefix, false);
  if (!made.certificates.empty()) (void)open_file("--cafile", made.certificates.string());
  if (options.password_file.empty()) return made;
  std::ifstream file = open_file("--password-file", options.password_file);
  if (!std::getline(file, made.password)) {
    throw std::runtime_error("--password-file: " + options.password_file +
                             " has no line. Write the password into its first.");
  }
  return made;
}

void subscribe(Client& client, double tick_rate_hz, double rate_hz) {
  v1::Item item;
  hapticd::client::set_rate(tick_rate_hz, rate_hz, *item.mutable_subscribe());
  client.request(item);
}

/// Says on stderr when patience with the broker ends.
void tell_missing(const hapticd::relay::Broker& broker, const std::string& at,
                  hapticd::client::Patience& patience) {
  if (!patience.ends(broker.connections() != 0, hapticd::client::monotonic_now_ns())) return;
  const std::string refusal = broker.refusal();
  if (refusal.empty()) {
    std::fprintf(stderr,
                 "haptic-relay: no broker answers at %s yet; waiting for it. Start it, or name "
                 "where it listens with --broker; if it wants TLS, give --cafile.\n",
                 at.c_str());
  } else {
    std::fprintf(stderr,
                 "haptic-relay: the broker at %s says: %s Trying again; see --user and "
                 "--password-file.\n",
                 at.c_str(), refusal.c_str());
  }
}

int run(const Options& options) {
  hapticd::client::end_on_signals();
  const hapticd::relay::BrokerOptions at = broker_options(options);
  const std::string place =
      (at.host.find(':') == std::string::npos ? at.host : "[" + at.host + "]") + ":" +
      std::to_string(at.port);
  hapticd::relay::Broker broker(at);
  hapticd::relay::Relay relay(options.prefix,
                              [&](const auto& each) { return broker.publish(each); });
  Client* session = nullptr;
  ClientHandlers handlers;
  handlers.item = [&](const v1::Item& item) {
    if (item.has_scene_info()) {
      subscribe(*session, item.scene_info().rate_hz(), options.rate_hz);
    }
    relay.item(item);
  };
  handlers.state = [&](const v1::State& state) { relay.state(state); };
  const std::unique_ptr<Client> client = hapticd::client::open_client(options.daemon, handlers);
  session = client.get();
  bool live = false;
  std::uint64_t connections = 0;
  hapticd::client::Patience with_daemon(hapticd::client::monotonic_now_ns());
  hapticd::client::Patience with_broker = with_daemon;
  relay.link(false);
  while (!hapticd::client::has_ended()) {
    client->poll(std::chrono::milliseconds(10));
    hapticd::client::tell_silence("haptic-relay", *client, with_daemon);
    tell_missing(broker, place, with_broker);
    const std::int64_t heard_ns = client->core().heard_ns();
    const bool heard = heard_ns != 0 && hapticd::client::monotonic_now_ns() - heard_ns < kGone_ns;
    if (heard != live) {
      live = heard;
      relay.link(live);
      std::printf("%s: %s\n", client->server().c_str(), live ? "live" : "gone");
      std::fflush(stdout);
    }
    if (broker.connections() != connections) {
      connections = broker.connections();
      relay.connected();
      std::printf("broker %s: connected\n", options.broker.c_str());
      std::fflush(stdout);
    }
  }
  relay.link(false);
  std::printf("%llu messages published, %llu lost because no broker was there\n",
              static_cast<unsigned long long>(relay.counters().published),
              static_cast<unsigned long long>(relay.counters().lost));
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
      {"haptic-relay", "Publishes what a running hapticd plays to an MQTT broker.", prepare}, argc,
      argv);
}
