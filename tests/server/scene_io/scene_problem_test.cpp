// Truth: what editors and compilers write, FILE:LINE:COLUMN: KIND: TEXT.
#include "server/scene_io/scene_problem.h"

#include <doctest/doctest.h>

namespace hapticd::test {

TEST_CASE("problems are told as a compiler tells them, and doubts are no faults") {
  const SceneProblem doubt{true, "a.textproto", 3, 9, "quality", "is unusual", ""};
  const SceneProblem fault{false, "a.textproto", 4, 1, "name", "is empty", "Give one."};
  const SceneProblem other{false, "inline", 0, 0, "", "is no text", ""};
  CHECK(to_text(doubt) == "a.textproto:3:9: warning: quality: is unusual.");
  CHECK(faults_text({doubt}).empty());
  CHECK_FALSE(any_fault({doubt}));
  CHECK(faults_text({fault, doubt, other}) ==
        "a.textproto:4:1: error: name: is empty. Give one.\ninline: error: is no text.");
  CHECK(any_fault({doubt, fault}));
}

TEST_CASE("what a text says of itself is shown, and no terminal obeys it") {
  const SceneProblem fault{false, "a.textproto", 1, 2, "name", "'\x1b[31m\xff' is no name", "\n"};
  CHECK(to_text(fault) == "a.textproto:1:2: error: name: '\\u001b[31m?' is no name. \\u000a");
}

}  // namespace hapticd::test
