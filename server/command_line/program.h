// How a program with commands runs: it parses the command line, does what the command's callback
// does, says in words what is wrong, and ends with its exit code: 0 good, 1 the input is bad, 2 the
// command line makes no sense. A callback throws std::invalid_argument for an option that makes no
// sense, std::runtime_error for input that is bad, or CLI::RuntimeError(1) when it has said itself
// what is wrong. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <span>

namespace hapticd {

/// Adds a subcommand whose callback does the work.
using AddCommand = void (*)(CLI::App& app);

/// A program, as its --help shows it.
struct Program {
  const char* name;
  const char* purpose;                   ///< a sentence
  std::span<const AddCommand> commands;  ///< in the order of the help
};

/// Runs it and returns its exit code.
[[nodiscard]] int run_program(const Program& program, int argc, const char* const* argv) noexcept;

}  // namespace hapticd
