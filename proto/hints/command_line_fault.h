// What is wrong with a command line, in words. Not RT.
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>

namespace hapticd::hints {

/// What the parser of `app` says; where it does not know a command or an option, the word, and
/// which one may have been meant. Ends with a full stop or a question mark.
[[nodiscard]] std::string command_line_fault(const CLI::App& app, const CLI::Error& error);

/// What is wrong with a word "--server=" among `words`, where `app` or a command of it has that
/// option with a value: the parser would take the next word for it. Empty: nothing is.
[[nodiscard]] std::string fault_of_empty_option(const CLI::App& app,
                                                std::span<const char* const> words);

/// The same as command_line_fault() with the way to help, for CLI::App::failure_message.
[[nodiscard]] std::string failure_message(const CLI::App* app, const CLI::Error& error);

}  // namespace hapticd::hints
