// Truth: what a shell says of itself.
#include "tests/support/shell_run.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("a line of the shell gives its text to the last byte, and its exit code") {
  const ShellOutcome outcome = run_in_shell("{ seq 10000; echo no >&2; } 2>&1; exit 3");
  CHECK(outcome.code == 3);
  CHECK(outcome.text.size() == 9 * 2 + 90 * 3 + 900 * 4 + 9000 * 5 + 6 + 3);
  CHECK(outcome.says("\n10000\nno\n"));
  CHECK_FALSE(outcome.says("\n10001\n"));
}

TEST_CASE("a line that a signal ends has no exit code") {
  CHECK(run_in_shell("kill -KILL $$").code == -1);
  CHECK(run_in_shell("true").code == 0);
}

}  // namespace hapticd::test
