// What is said of a command line that makes no sense, of a program made for it.
#include "proto/hints/command_line_fault.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace hapticd::hints::test {
namespace {

/// What is said of a command line of a program with two commands and an option.
std::string fault_of(std::vector<std::string> words) {
  CLI::App app("A sampler.", "sampler");
  std::string server;
  bool loud = false;
  int repeat = 0;
  double speed = 0.0;
  unsigned cpu = 0;
  app.add_option("--server", server, "where");
  app.add_option("--repeat", repeat, "how often");
  app.add_option("--speed", speed, "how fast");
  app.add_option("--cpu", cpu, "where it runs")->check(CLI::Range(0, 9));
  app.require_subcommand(1);
  app.add_subcommand("status", "what is")->add_flag("--loud", loud, "more of it");
  app.add_subcommand("watch", "the same, live");
  CLI::App* const run = app.add_subcommand("run", "time, by hand");
  run->require_subcommand(1);
  run->add_subcommand("step", "some ticks")->add_option("TICKS", cpu, "how many");
  app.add_subcommand("set", "a parameter");
  try {
    std::reverse(words.begin(), words.end());
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    return command_line_fault(app, error);
  }
  return "";
}

}  // namespace

TEST_CASE("a command that is not there is named, with the one that may be meant") {
  CHECK(fault_of({"statuss"}) == "There is no command or option statuss. Did you mean status?");
  CHECK(fault_of({"record"}) == "There is no command or option record.");
}

TEST_CASE("an option that was written as a command is named") {
  CHECK(fault_of({"speed"}) == "There is no command or option speed. Did you mean --speed?");
  CHECK(fault_of({"status", "loud"}).ends_with(" Did you mean --loud?"));
}

TEST_CASE("dashes make no option like another") {
  CHECK(fault_of({"status", "--spxxd"}) == "There is no option --spxxd.");
}

TEST_CASE("an option that ends with = lacks its value, wherever it belongs") {
  CLI::App app;
  std::string server;
  bool loud = false;
  app.add_option("--server", server)->type_name("HOST:PORT");
  CLI::App& status = *app.add_subcommand("status");
  status.add_option("--arm", server)->check(CLI::IsMember({"off"}))->type_name("off");
  status.add_flag("--loud", loud);
  const auto fault = [&app](const std::vector<const char*>& words) {
    return fault_of_empty_option(app, words);
  };
  CHECK(fault({"p", "--server=", "status"}) ==
        "--server: the value is missing. Give --server HOST:PORT.");
  CHECK(fault({"p", "status", "--arm="}) == "--arm: the value is missing. Give --arm off.");
  CHECK(fault({"p", "--server=x", "status", "--loud=", "--other=", "a="}).empty());
  CHECK(fault({"p", "--", "--server="}).empty());
}

TEST_CASE("so is an option, of the program or of the command that was given") {
  CHECK(fault_of({"status", "--sever", "x"}) ==
        "There is no option --sever. Did you mean --server?");
  CHECK(fault_of({"status", "--luod"}) == "There is no option --luod. Did you mean --loud?");
  CHECK(fault_of({"watch", "--luod"}) == "There is no option --luod.");
  CHECK(fault_of({"status", "--sever=x"}) == "There is no option --sever. Did you mean --server?");
}

TEST_CASE("what is meant is looked for where it can be written") {
  CHECK(fault_of({"run", "setp"}) == "There is no command or option setp. Did you mean step?");
  CHECK(fault_of({"setp"}) == "There is no command or option setp. Did you mean set?");
  CHECK(fault_of({"run", "statis"}) == "There is no command or option statis.");
}

TEST_CASE("a decimal comma is refused with what is right there") {
  CHECK(fault_of({"--speed", "0,5", "status"}).ends_with(" Write 0.5, with a point."));
  CHECK(fault_of({"--speed", "0,125", "status"}).ends_with(" Write 0.125, with a point."));
  CHECK(fault_of({"--speed", "1,125", "status"}).ends_with(" Give a number without commas."));
  for (const char* option : {"--repeat", "--cpu"}) {
    CHECK(fault_of({option, "1,5", "status"}).ends_with(" Give a whole number."));
    CHECK(fault_of({option, "1,000", "status"}).ends_with(" Give a whole number."));
  }
  CHECK(fault_of({"run", "step", "3,0"}).ends_with(" Give a whole number."));
}

TEST_CASE("a good command line has no fault, and other faults are said as the parser says them") {
  CHECK(fault_of({"status", "--loud"}).empty());
  CHECK(fault_of({"--server"}).find("--server") != std::string::npos);
  CHECK(fault_of({"status", "more"}).find("more") != std::string::npos);
  for (const auto& words : {std::vector<std::string>{"--server"}, {"status", "more"}, {}}) {
    CHECK(fault_of(words).ends_with('.'));
  }
}

}  // namespace hapticd::hints::test
