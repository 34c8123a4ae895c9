// The main function of every test executable: doctest's own, and one more end, skipped.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>
#include <string>

#include "tests/support/skip.h"

namespace hapticd::test {
namespace {

constexpr int kSkippedCode = 77;  // SKIP_RETURN_CODE of every test

bool any_skipped = false;

}  // namespace

void skip(const std::string& reason) {
  std::printf("SKIPPED: %s\n", reason.c_str());
  any_skipped = true;
}

}  // namespace hapticd::test

int main(int argc, char** argv) {
  const int code = doctest::Context(argc, argv).run();
  return code == 0 && hapticd::test::any_skipped ? hapticd::test::kSkippedCode : code;
}
