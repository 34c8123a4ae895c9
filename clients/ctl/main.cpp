// hapticctl: watches and controls a running hapticd. Exit codes: 0 good, 1 the daemon
// refused or a file is bad, 2 the command line makes no sense, 3 no daemon answers.
#include <cstdio>
#include <exception>
#include <string>

#include "clients/ctl/commands.h"
#include "clients/ctl/text.h"
#include "proto/hints/command_line_fault.h"
#include "proto/hints/quantity_option.h"
#include "proto/wire/shown_text.h"

namespace {

using hapticd::ctl::Failure;
using hapticd::ctl::GlobalOptions;

/// What is wrong with the reason of a take-over, as the daemon takes it.
std::string fault_of_reason(const std::string& text) {
  const bool good = !text.empty() && text.size() <= 400 && hapticd::wire::is_plain(text);
  return good ? "" : "Say why, in 1 to 400 bytes of UTF-8 on one line.";
}

int run(int argc, char** argv) {
  CLI::App app("Watches and controls a running hapticd.", "hapticctl");
  GlobalOptions options;
  app.set_version_flag("--version", "hapticctl " HAPTICD_VERSION);
  hapticd::client::add_daemon_options(app, options.daemon);
  hapticd::hints::takes_unit(
      app.add_option("--timeout", options.timeout_s, "longest wait for an answer, s"), "s")
      ->check(CLI::Range(0.01, 3600.0))
      ->capture_default_str();
  app.add_option("--take-over", options.take_over,
                 "takes control also from a client that has it, and tells everyone this reason")
      ->type_name("REASON")
      ->check(fault_of_reason);
  app.add_flag("--json", options.json, "answers as JSON, for programs");
  hapticd::ctl::add_discover_option(app, options);
  app.require_subcommand(1);
  app.failure_message(hapticd::hints::failure_message);
  app.fallthrough();
  for (const auto add : hapticd::ctl::kCommands) add(app, options);
  const std::string empty =
      hapticd::hints::fault_of_empty_option(app, {argv, static_cast<std::size_t>(argc)});
  if (!empty.empty()) throw Failure(hapticd::ctl::kUsageBad, empty);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : hapticd::ctl::kUsageBad;
  } catch (const hapticd::ctl::Refusal& refusal) {
    if (options.json) hapticd::ctl::print_text(hapticd::ctl::to_json(refusal.result()));
    throw;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const hapticd::ctl::Failure& failure) {
    hapticd::ctl::print_problem(failure.what());
    return failure.exit_code();
  } catch (const std::exception& error) {
    hapticd::ctl::print_problem(error.what());
    return hapticd::ctl::kRefused;
  }
}
