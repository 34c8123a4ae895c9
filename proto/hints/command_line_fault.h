// What is wrong with a command line, in words. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace hapticd::hints {

/// What the parser of `app` says; where it does not know a command or an option, the word, and
/// which one may have been meant. Ends with a full stop or a
/// question mark.
[[nodiscard]] std::string command_line_fault(const CLI::App& app, const CLI::Error& error);

/// The same with the way to help, for CLI::App::failure_message.
[[nodiscard]] std::string failure_message(const CLI::App* app, const CLI::Error& error);

}  // namespace hapticd::hints
