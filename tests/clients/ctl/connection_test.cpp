// What an answer means to hapticctl, whatever the daemon puts into it.
#include "clients/ctl/connection.h"

#include <doctest/doctest.h>

#include <string>

namespace hapticd::test {

using namespace hapticd::ctl;

TEST_CASE("an answer that is not OK ends the program with its code, path and message") {
  v1::Result result;
  result.set_code(v1::RESULT_CODE_OK);
  CHECK_NOTHROW(require(result));
  result.set_code(v1::RESULT_CODE_INVALID);
  result.set_path("run.mode");
  result.set_message("Say LIVE.");
  CHECK_THROWS_WITH_AS(require(result), "refused (INVALID) run.mode: Say LIVE.", Failure);
  // Of a later version.
  result.set_code(static_cast<v1::ResultCode>(99));
  CHECK_THROWS_WITH_AS(require(result), "refused (99) run.mode: Say LIVE.", Failure);
}

}  // namespace hapticd::test
