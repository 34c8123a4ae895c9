// For the comparison of builds: `record FOLDER` records a session under both clocks, `verify
// FOLDER` replays what any build recorded there and compares every wrench. Prints what it came to.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdio>
#include <exception>
#include <string>

#include "tests/server/daemon/recorded_session.h"

int main(int argc, char** argv) {
  doctest::Context context;
  context.setAsDefaultForAssertsOutOfTestCases();
  const std::string what = argc == 3 ? argv[1] : "";
  if (what != "record" && what != "verify") {
    std::fprintf(stderr, "usage: recorded_session_probe record|verify FOLDER\n");
    return 2;
  }
  try {
    bool same = true;
    for (const bool virtual_time : {true, false}) {
      const std::string path =
          std::string(argv[2]) + (virtual_time ? "/virtual.mcap" : "/real.mcap");
      if (what == "record") {
        hapticd::test::record_session(path, virtual_time);
        continue;
      }
      const hapticd::ReplayReport report = hapticd::test::verify(path);
      std::printf("%llu ticks, %llu differ, %llu of %llu states differ %s\n",
                  static_cast<unsigned long long>(report.ticks),
                  static_cast<unsigned long long>(report.different_ticks),
                  static_cast<unsigned long long>(report.different_states),
                  static_cast<unsigned long long>(report.states), report.first_difference.c_str());
      same = same && report.ticks == hapticd::test::kSessionTicks && report.different_ticks == 0 &&
             report.different_states == 0;
    }
    return same ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
