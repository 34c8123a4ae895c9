// What an answer may say: text of the length that answer.proto allows, which no terminal obeys.
#include "proto/wire/request_result.h"

#include <doctest/doctest.h>

#include <string>

#include "proto/wire/shown_text.h"

namespace hapticd::wire {
namespace {

TEST_CASE("what a request said is quoted in its answer so that no terminal obeys it") {
  const v1::Result result =
      result_of(v1::RESULT_CODE_NOT_FOUND, "a\x1b[31m\n", "'\x1b]0;\x07' is not there.\nNor is b.");
  CHECK(result.path() == "a\\u001b[31m\\u000a");
  CHECK(result.message() == "'\\u001b]0;\\u0007' is not there.\nNor is b.");
}

TEST_CASE("an answer is as short as it has to be, whatever is quoted in it") {
  for (const char* piece : {"a", "\x1b", "\xff", "\u00e9", "\U0001d11e"}) {
    std::string text;
    for (int k = 0; k < 1000; ++k) text += piece;
    const v1::Result result = result_of(v1::RESULT_CODE_INVALID, text, text);
    CHECK(result.path().size() <= 256);
    CHECK(result.path().size() > 250);
    CHECK(result.message().size() <= 400);
    CHECK(result.message().size() > 394);
    CHECK(is_plain(result.path()));
    CHECK(is_plain(result.message()));
  }
}

}  // namespace
}  // namespace hapticd::wire
