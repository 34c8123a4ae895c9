// What --check refuses of addresses and files. Truth: that nothing is made, and what the system
// says of a file that is really made.
#include "server/daemon/start_check.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "server/daemon/daemon_options.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// Exit code that a start with this configuration ends with, as far as it is checked; 0: none.
template <typename Change>
int code_of(const Change& change) {
  v1::Config config;
  config.set_listen("127.0.0.1:0");
  change(config);
  try {
    check_start(config, stop_plan(config));
  } catch (const StartError& error) {
    return error.exit_code();
  }
  return 0;
}

}  // namespace

TEST_CASE("addresses that cannot be listened on are refused without a socket") {
  CHECK(code_of([](v1::Config&) {}) == 0);
  for (const char* bad : {"x", "127.0.0.1:99999", "localhost:1", "127.0.0.1", "0.0.0.0:1"}) {
    CAPTURE(bad);
    CHECK(code_of([&](v1::Config& config) { config.set_listen(bad); }) == kExitAddress);
    CHECK(code_of([&](v1::Config& config) { config.set_stop_listen(bad); }) == kExitAddress);
  }
  for (const char* good : {"127.0.0.1:1", "[::1]:1"}) {
    CAPTURE(good);
    CHECK(code_of([&](v1::Config& config) { config.set_listen(good); }) == 0);
    CHECK(code_of([&](v1::Config& config) { config.set_stop_listen(good); }) == 0);
  }
  CHECK(code_of([](v1::Config& config) { config.set_stop_listen("off"); }) == 0);
}

TEST_CASE("a recording that cannot be begun is refused, and nothing is made") {
  std::string folder = (fs::temp_directory_path() / "start_check_XXXXXX").string();
  REQUIRE(mkdtemp(folder.data()) != nullptr);
  std::ofstream(folder + "/there").put('x');
  for (const std::string& bad : {folder + "/there", folder, folder + "/there/x.mcap", folder + "/",
                                 std::string("/proc/x.mcap"), std::string("/proc/none/x.mcap")}) {
    CAPTURE(bad);
    CHECK(!fault_of_new_file(bad).empty());
    CHECK(::open(bad.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0600) < 0);
    CHECK(code_of([&](v1::Config& config) { config.set_record(bad); }) == kExitRecord);
  }
  for (const std::string& good : {folder + "/x.mcap", folder + "/new/newer/x.mcap"}) {
    CAPTURE(good);
    CHECK(fault_of_new_file(good).empty());
    CHECK(code_of([&](v1::Config& config) { config.set_record(good); }) == 0);
  }
  CHECK(std::distance(fs::directory_iterator(folder), {}) == 1);
  fs::remove_all(folder);
}

}  // namespace hapticd::test
