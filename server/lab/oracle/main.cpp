// hapticd-oracle: numbers that need the daemon's own geometry, for hapticd-lab and for people who
// doubt. Exit codes: 0 good, 1 the input is bad or a check fails, 2 the command line makes no
// sense.
#include <array>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/lab/oracle/commands.h"

namespace {

constexpr int kInputBad = 1;
constexpr int kUsageBad = 2;

/// All commands, in the order of the help.
constexpr std::array kCommands{
    hapticd::add_gesture_command,  hapticd::add_poses_command,   hapticd::add_path_command,
    hapticd::add_baseline_command, hapticd::add_descent_command, hapticd::add_cases_command,
    hapticd::add_triangle_command, hapticd::add_measure_command, hapticd::add_strings_command,
};

/// Names the word that is not known, where the parser misses a command instead.
std::string explain(const CLI::App* app, const CLI::Error& error) {
  const std::vector<std::string> unknown = app->remaining(true);
  std::string text = CLI::FailureMessage::simple(app, error);
  if (error.get_name() == "RequiredError" && !unknown.empty()) {
    text.insert(0, "There is no command or option " + unknown.front() + ". ");
  }
  return text;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Truths about scenes, gestures and recordings of hapticd, by exhaustive search and closed "
      "forms, as CSV or JSON.",
      "hapticd-oracle");
  app.set_version_flag("--version", "hapticd-oracle " HAPTICD_VERSION);
  app.require_subcommand(1);
  app.failure_message(explain);
  for (const auto add : kCommands) add(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageBad;
  }
  return 0;
}

int complain(const char* what, int code) {
  std::fprintf(stderr, "hapticd-oracle: %s\n", what);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), kUsageBad);
  } catch (const std::bad_alloc&) {
    return complain("not enough memory", kInputBad);
  } catch (const std::exception& error) {
    return complain(error.what(), kInputBad);
  }
}
