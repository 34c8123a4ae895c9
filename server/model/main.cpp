// hapticd-model: sphere-trees from triangle meshes, meshes from models, reports and pictures of
// both. Exit codes: 0 good, 1 the input is bad, 2 the command line makes no sense.
#include <array>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/model/commands.h"

namespace {

constexpr int kInputBad = 1;
constexpr int kUsageBad = 2;

/// All commands, in the order of the help.
constexpr std::array kCommands{
    hapticd::add_build_command,   hapticd::add_make_command,  hapticd::add_list_command,
    hapticd::add_inspect_command, hapticd::add_check_command, hapticd::add_explain_command,
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
      "Models and scenes for hapticd: sphere-trees from triangle meshes, and what scenes make of "
      "them.",
      "hapticd-model");
  app.set_version_flag("--version", "hapticd-model " HAPTICD_VERSION);
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
  std::fprintf(stderr, "hapticd-model: %s\n", what);
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
