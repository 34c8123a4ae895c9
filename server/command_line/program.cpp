// See program.h.
#include "server/command_line/program.h"

#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "proto/hints/command_line_fault.h"

namespace hapticd {
namespace {

constexpr int kInputBad = 1;
constexpr int kUsageBad = 2;

int parse_and_run(const Program& program, int argc, const char* const* argv) {
  CLI::App app(program.purpose, program.name);
  app.set_version_flag("--version", std::string(program.name) + " " HAPTICD_VERSION);
  app.require_subcommand(1);
  app.failure_message(hints::failure_message);
  for (const AddCommand add : program.commands) add(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageBad;
  }
  return 0;
}

int complain(const Program& program, const char* what, int code) {
  std::fprintf(stderr, "%s: %s\n", program.name, what);
  return code;
}

}  // namespace

int run_program(const Program& program, int argc, const char* const* argv) noexcept {
  try {
    return parse_and_run(program, argc, argv);
  } catch (const std::invalid_argument& error) {
    return complain(program, error.what(), kUsageBad);
  } catch (const std::bad_alloc&) {
    return complain(program, "not enough memory", kInputBad);
  } catch (const std::exception& error) {
    return complain(program, error.what(), kInputBad);
  }
}

}  // namespace hapticd
