// haptic-relay: what a hapticd plays, published to an MQTT broker for large audiences. Exit codes:
// 0 ended by a signal, 1 a key, password or address is bad, 2 the command line makes no sense.
#include <CLI/CLI.hpp>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "clients/library/client.h"
#include "clients/library/endpoint.h"
#include "clients/library/named_key.h"
#include "clients/relay/broker.h"

namespace {

using hapticd::client::Client;
using hapticd::client::ClientHandlers;
namespace v1 = hapticd::v1;

volatile std::sig_atomic_t ended = 0;

/// Silence of the daemon after which it is called gone, ns.
constexpr std::int64_t kGone_ns = 1'000'000'000;

/// The command line.
struct Options {
  std::string server = "127.0.0.1:47800";
  std::string broker = "127.0.0.1:1883";
  std::string prefix = "hapticd";
  std::string key_file;
  std::string role;
  std::string password_file;
  double rate_hz = 60.0;
  hapticd::relay::BrokerOptions at;
};

void add_options(CLI::App& app, Options& options) {
  app.set_version_flag("--version", "haptic-relay " HAPTICD_VERSION);
  app.add_option("--server", options.server, "where hapticd listens, HOST:PORT")
      ->capture_default_str();
  app.add_option("--key", options.key_file, "key file, if hapticd has keys")->type_name("FILE");
  app.add_option("--role", options.role,
                 "role of the key (control, unless the file is called view.key)")
      ->check(CLI::IsMember({"view", "control"}))
      ->type_name("view|control");
  app.add_option("--broker", options.broker, "where the MQTT broker listens, HOST:PORT")
      ->capture_default_str();
  app.add_option("--user", options.at.user, "user name at the broker");
  app.add_option("--password-file", options.password_file, "file whose first line is its password")
      ->type_name("FILE");
  app.add_option("--cafile", options.at.certificates,
                 "certificates that vouch for the broker; turns on TLS")
      ->type_name("FILE");
  app.add_option("--prefix", options.prefix, "what all topics begin with")->capture_default_str();
  app.add_option("--rate", options.rate_hz, "States per second; 0: none")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
}

hapticd::relay::BrokerOptions broker_options(const Options& options) {
  hapticd::relay::BrokerOptions made = options.at;
  const auto at = hapticd::client::parse_endpoint(options.broker, {made.host, made.port});
  made.host = at.host;
  made.port = at.port;
  made.will = hapticd::relay::link_publication(options.prefix, false);
  if (options.password_file.empty()) return made;
  std::ifstream file(options.password_file);
  if (!std::getline(file, made.password)) {
    throw std::runtime_error("--password-file: " + options.password_file + " has no line");
  }
  return made;
}

void subscribe(Client& client, double tick_rate_hz, double rate_hz) {
  v1::Item item;
  if (rate_hz > 0.0) {
    const double divisor = std::max(1.0, std::round(tick_rate_hz / rate_hz));
    item.mutable_subscribe()->set_divisor(static_cast<std::uint32_t>(divisor));
  }
  client.request(item);
}

int run(const Options& options) {
  const auto server = hapticd::client::parse_endpoint(options.server);
  hapticd::relay::Broker broker(broker_options(options));
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
  Client client(server.host, server.port, handlers,
                hapticd::client::named_key(options.key_file, options.role));
  session = &client;
  bool live = false;
  std::uint64_t connections = 0;
  relay.link(false);
  while (ended == 0) {
    client.poll(std::chrono::milliseconds(10));
    const std::int64_t heard_ns = client.core().heard_ns();
    const bool heard = heard_ns != 0 && hapticd::client::monotonic_now_ns() - heard_ns < kGone_ns;
    if (heard != live) {
      live = heard;
      relay.link(live);
      std::printf("%s: %s\n", client.server().c_str(), live ? "live" : "gone");
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

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app("Publishes what a running hapticd plays to an MQTT broker.", "haptic-relay");
    Options options;
    add_options(app, options);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : 2;
    }
    std::signal(SIGINT, [](int) { ended = 1; });
    std::signal(SIGTERM, [](int) { ended = 1; });
    return run(options);
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "haptic-relay: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-relay: %s\n", error.what());
    return 1;
  }
}
