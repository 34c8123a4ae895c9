// What programs that follow a daemon have in common. Truth: what their manuals say.
#include "clients/library/program.h"

#include <doctest/doctest.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace hapticd::client {
namespace {

using Run = int (*)();

/// The exit code of a program that is called with these words and does `run`.
int exit_code(std::vector<std::string> words, Run run) {
  static Run runs;
  runs = run;
  const auto prepare = [](CLI::App& app) -> std::function<int()> {
    const auto daemon = std::make_shared<DaemonChoice>();
    add_daemon_options(app, *daemon);
    return [daemon] { return runs(); };
  };
  words.insert(words.begin(), "nothing");
  std::vector<char*> argv;
  argv.reserve(words.size());
  for (std::string& word : words) argv.push_back(word.data());
  return run_program({"nothing", "Does nothing.", prepare}, static_cast<int>(argv.size()),
                     argv.data());
}

TEST_CASE(
    "a program ends with its own code, 2 where the command line makes no sense, else with 1") {
  CHECK(exit_code({}, [] { return 0; }) == 0);
  CHECK(exit_code({"--server", "there:1", "--key", "k", "--role", "view"}, [] { return 7; }) == 7);
  const auto never = []() -> int { throw std::logic_error("it ran"); };
  CHECK(exit_code({"--help"}, never) == 0);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--bad"}, {"--server", "a:b"}, {"--role", "both"}}) {
    CAPTURE(words.front());
    CHECK(exit_code(words, never) == kProgramUsage);
  }
  CHECK(exit_code({}, []() -> int { throw std::invalid_argument("no"); }) == kProgramUsage);
  CHECK(exit_code({}, []() -> int { throw std::runtime_error("no"); }) == kProgramFailed);
}

TEST_CASE("whatever rate a server states, States are asked for every so many ticks as it takes") {
  v1::Subscribe subscribe;
  const auto asked = [&](double tick_rate_hz, double rate_hz) {
    subscribe.set_divisor(7);
    set_rate(tick_rate_hz, rate_hz, subscribe);
    return subscribe.divisor();
  };
  CHECK(asked(1000.0, 60.0) == 17);
  CHECK(asked(1000.0, 5000.0) == 1);
  CHECK(asked(1000.0, 0.0) == 7);
  CHECK(asked(1e300, 60.0) == 1'000'000);
  CHECK(asked(std::numeric_limits<double>::infinity(), 60.0) == 1'000'000);
  CHECK(asked(std::numeric_limits<double>::quiet_NaN(), 60.0) == 1);
  CHECK(asked(-1e300, 60.0) == 1);
}

TEST_CASE("a client is opened where the command line says, and not with a key that is none") {
  DaemonChoice daemon;
  daemon.server = "127.0.0.1:9";
  CHECK(open_client(daemon, {})->server() == "127.0.0.1:9");
  daemon.key_file = "/nowhere/view.key";
  CHECK_THROWS_AS((void)open_client(daemon, {}), std::runtime_error);
  daemon = {"a:b", "", ""};
  CHECK_THROWS_AS((void)open_client(daemon, {}), std::invalid_argument);
}

TEST_CASE("the rate asked for is the nearest that whole ticks give, and at most every tick") {
  const auto divisor = [](double ticks, double rate) {
    v1::Subscribe subscribe;
    set_rate(ticks, rate, subscribe);
    return subscribe.divisor();
  };
  CHECK(divisor(1000.0, 60.0) == 17);
  CHECK(divisor(1000.0, 1000.0) == 1);
  CHECK(divisor(250.0, 1000.0) == 1);
  CHECK(divisor(1000.0, 0.0) == 0);
}

TEST_CASE("patience ends once, after its time, and never with who has answered") {
  Patience alone(7);
  CHECK_FALSE(alone.ends(false, 7));
  CHECK_FALSE(alone.ends(false, 7 + kPatience_ns - 1));
  CHECK(alone.ends(false, 7 + kPatience_ns));
  CHECK_FALSE(alone.ends(false, 7 + 2 * kPatience_ns));
  Patience answered(0);
  CHECK_FALSE(answered.ends(true, 1));
  CHECK_FALSE(answered.ends(false, 2 * kPatience_ns));
  Patience late(0);
  CHECK_FALSE(late.ends(true, 2 * kPatience_ns));
}

TEST_CASE("a signal asks the program to end") {
  end_on_signals();
  CHECK(!has_ended());
  std::raise(SIGTERM);
  CHECK(has_ended());
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace
}  // namespace hapticd::client
