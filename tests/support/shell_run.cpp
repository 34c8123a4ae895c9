// See shell_run.h.
#include "tests/support/shell_run.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <stdexcept>

namespace hapticd::test {

ShellOutcome run_in_shell(const std::string& line) {
  std::FILE* const pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("no shell runs " + line);
  ShellOutcome outcome;
  std::array<char, 4096> part{};
  while (const std::size_t got = std::fread(part.data(), 1, part.size(), pipe)) {
    outcome.text.append(part.data(), got);
  }
  const int status = ::pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

}  // namespace hapticd::test
