// See program.h.
#include "clients/library/program.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "clients/library/endpoint.h"
#include "clients/library/named_key.h"
#include "proto/hints/command_line_fault.h"
#include "proto/wire/shown_text.h"

namespace hapticd::client {
namespace {

volatile std::sig_atomic_t ended = 0;

/// What is wrong with the address; nothing: it is one.
std::string address_problem(const std::string& text) {
  if (text.empty()) return "Give HOST:PORT.";
  try {
    (void)parse_endpoint(text);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

}  // namespace

CLI::Option* takes_endpoint(CLI::Option* option) {
  return option->check(CLI::Validator([](std::string& text) { return address_problem(text); }, ""));
}

void add_daemon_options(CLI::App& app, DaemonChoice& daemon) {
  takes_endpoint(app.add_option("--server", daemon.server, "where hapticd listens"))
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_option("--key", daemon.key_file, "key file, if hapticd has keys")->type_name("FILE");
  app.add_option("--role", daemon.role, "role of the key (its own)")
      ->check(CLI::IsMember({"view", "control"}))
      ->type_name("view|control");
}

std::unique_ptr<Client> open_client(const DaemonChoice& daemon, ClientHandlers handlers) {
  const Endpoint server = parse_endpoint(daemon.server);
  return std::make_unique<Client>(server.host, server.port, std::move(handlers),
                                  named_key(daemon.key_file, daemon.role));
}

std::string unanswered(const std::string& server) {
  return "no daemon answers at " + server +
         " yet; waiting for it. Start hapticd, or name where it listens with --server; if it has "
         "keys, give one of them with --key.";
}

void tell_silence(const char* program, const Client& client, Patience& patience) {
  if (!patience.ends(client.core().heard(), monotonic_now_ns())) return;
  std::fprintf(stderr, "%s: %s\n", program, wire::shown_lines(unanswered(client.server())).c_str());
}

std::uint32_t state_divisor(double tick_rate_hz, double rate_hz) {
  constexpr double kMost = 1e6;
  const double divisor = std::round(tick_rate_hz / rate_hz);
  return divisor >= 1.0 ? static_cast<std::uint32_t>(std::min(divisor, kMost)) : 1;
}

void set_rate(double tick_rate_hz, double rate_hz, v1::Subscribe& subscribe) {
  if (rate_hz > 0.0) subscribe.set_divisor(state_divisor(tick_rate_hz, rate_hz));
}

void end_on_signals() {
  std::signal(SIGINT, [](int) { ended = 1; });
  std::signal(SIGTERM, [](int) { ended = 1; });
}

bool has_ended() noexcept { return ended != 0; }

int run_program(const Program& program, int argc, char** argv) noexcept {
  try {
    CLI::App app(program.purpose, program.name);
    app.failure_message(hints::failure_message);
    const std::function<int()> run = program.prepare(app);
    const std::string empty =
        hints::fault_of_empty_option(app, {argv, static_cast<std::size_t>(argc)});
    if (!empty.empty()) throw std::invalid_argument(empty);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : kProgramUsage;
    }
    return run();
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "%s: %s\n", program.name, wire::shown_lines(error.what()).c_str());
    return kProgramUsage;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.name, wire::shown_lines(error.what()).c_str());
    return kProgramFailed;
  }
}

}  // namespace hapticd::client
