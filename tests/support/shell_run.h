// A program run as a user runs it: a line of the shell, what it prints and how it ends. Not RT.
#pragma once

#include <string>

namespace hapticd::test {

/// What came of a line.
struct ShellOutcome {
  int code = -1;     ///< exit code; -1: ended by a signal
  std::string text;  ///< all that was printed where the line lets it: stderr by 2>&1 alone

  [[nodiscard]] bool says(const std::string& part) const {
    return text.find(part) != std::string::npos;
  }
};

/// Runs `line` to its end. Throws std::runtime_error where there is no shell.
[[nodiscard]] ShellOutcome run_in_shell(const std::string& line);

}  // namespace hapticd::test
