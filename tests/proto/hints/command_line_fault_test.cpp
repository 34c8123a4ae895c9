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
  app.add_option("--server", server, "where");
  app.require_subcommand(1);
  app.add_subcommand("status", "what is")->add_flag("--loud", loud, "more of it");
  app.add_subcommand("watch", "the same, live");
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
  CHECK(fault_of({"statuss"})
            .starts_with("There is no command or option statuss. Did you mean status?"));
  CHECK(fault_of({"record"}).starts_with("There is no command or option record. A subcommand"));
}

TEST_CASE("so is an option, of the program or of the command that was given") {
  CHECK(fault_of({"status", "--sever", "x"}) ==
        "There is no option --sever. Did you mean --server?");
  CHECK(fault_of({"status", "--luod"}) == "There is no option --luod. Did you mean --loud?");
  CHECK(fault_of({"watch", "--luod"}) == "There is no option --luod.");
  CHECK(fault_of({"status", "--sever=x"}) == "There is no option --sever. Did you mean --server?");
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
