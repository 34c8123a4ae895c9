// Commands against a real server on loopback, and against nobody.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "clients/ctl/commands.h"
#include "tests/clients/library/real_server.h"

namespace hapticd::test {
namespace {

/// Runs a command line; its exit code, its complaint in `said`.
int run(const std::vector<std::string>& words, std::string& said) {
  ctl::GlobalOptions options;
  CLI::App app("test", "hapticctl");
  app.add_option("--server", options.daemon.server);
  app.add_option("--timeout", options.timeout_s);
  app.add_flag("--json", options.json);
  app.fallthrough();
  for (const auto add : ctl::kCommands) add(app, options);
  // CLI11 takes the words from the back.
  std::vector<std::string> reversed(words.rbegin(), words.rend());
  try {
    app.parse(reversed);
  } catch (const ctl::Failure& failure) {
    said = failure.what();
    return failure.exit_code();
  } catch (const CLI::ParseError& error) {
    said = error.what();
    return ctl::kUsageBad;
  }
  return 0;
}

std::string address(const RealServer& server) {
  return "127.0.0.1:" + std::to_string(server.port());
}

}  // namespace

TEST_CASE("without a daemon every command ends with exit code 3 and says what to do") {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"status"},
                                             {"scene", "list"},
                                             {"stop"},
                                             {"get"},
                                             {"gesture", "list"},
                                             {"device", "info"},
                                             {"device", "check"}}) {
    std::vector<std::string> all{"--server", "127.0.0.1:9", "--timeout", "0.05"};
    all.insert(all.end(), words.begin(), words.end());
    std::string said;
    CHECK(run(all, said) == ctl::kUnreachable);
    CHECK(said.find("Start hapticd") != std::string::npos);
  }
}

TEST_CASE("every request is made, under a lease where it needs one, and answered") {
  const RealServer server;
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"status"},
           {"status", "--json"},
           {"scene", "list"},
           {"scene", "load", "guqin"},
           {"scene", "check", HAPTICD_SOURCE_DIR "/deploy/scenes/wall.textproto"},
           {"get", "quality"},
           {"set", "quality=2", "strings[0].tension_n=70"},
           {"engage"},
           {"disengage"},
           {"clear", "--json"},
           {"recentre"},
           {"stop"},
           {"gesture", "list"},
           {"gesture", "play", "demonstration", "--arm", "firm", "--seed", "3", "--repeat", "0"},
           {"gesture", "play", HAPTICD_SOURCE_DIR "/deploy/gestures/glide.textproto"},
           {"gesture", "end"},
           {"record", "list"},
           {"device", "info"},
           {"device", "info", "--json"},
           {"run", "step", "10"},
           {"run", "step", "5", "--json"}}) {
    std::vector<std::string> all{"--server", address(server)};
    all.insert(all.end(), words.begin(), words.end());
    std::string said;
    CAPTURE(words.front());
    CAPTURE(words.back());
    CHECK(run(all, said) == 0);
    CHECK(said.empty());
  }
}

TEST_CASE("a command line that makes no sense ends with exit code 2") {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"set", "quality"},
                                             {"scene"},
                                             {"gesture", "play"},
                                             {"gesture", "play", "x", "--arm", "iron"},
                                             {"run", "step", "-1"},
                                             {"--server", "a:b", "status"},
                                             {"device"},
                                             {"device", "monitor", "--for", "-1"},
                                             {"fly"}}) {
    std::string said;
    CAPTURE(words.front());
    CHECK(run(words, said) == ctl::kUsageBad);
  }
}

TEST_CASE("a lease that somebody else holds is no riddle: the message names the holder") {
  const RealServer server;
  client::Client other("127.0.0.1", server.port());
  REQUIRE(other.connect());
  client::Controller holder(other);
  REQUIRE(holder.acquire("player one").code() == v1::RESULT_CODE_OK);
  std::string said;
  CHECK(run({"--server", address(server), "engage"}, said) == ctl::kRefused);
  CHECK(said.find("player one") != std::string::npos);
  // Stop needs no lease.
  CHECK(run({"--server", address(server), "stop"}, said) == 0);
}

TEST_CASE("a table of poses arrives row by row, and a bad row is named") {
  RealServer server;
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("hapticctl_poses_" + std::to_string(server.port()) + ".csv");
  {
    std::ofstream table(file);
    table << "x,y,z\n";
    for (int i = 0; i < 150; ++i) table << 1e-3 * i << ",0,0\n";
  }
  std::string said;
  CHECK(run({"--server", address(server), "pose", file.string()}, said) == 0);
  CHECK(server.poses == 150);
  std::ofstream(file, std::ios::app) << "1,2\n";
  CHECK(run({"--server", address(server), "pose", file.string()}, said) == ctl::kRefused);
  CHECK(said.find(file.string() + ":152: ") != std::string::npos);
  std::filesystem::remove(file);
  CHECK(run({"--server", address(server), "pose", file.string()}, said) == ctl::kRefused);
}

}  // namespace hapticd::test
