// How a program ends, by what its command throws; what it prints goes to a file meanwhile. Truth:
// the exit codes that program.h promises.
#include "server/command_line/program.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace hapticd::test {
namespace {

void add_good(CLI::App& app) {
  app.add_subcommand("good")->callback([] {});
}
void add_bad_input(CLI::App& app) {
  app.add_subcommand("bad_input")->callback([] { throw std::runtime_error("the file is torn"); });
}
void add_bad_option(CLI::App& app) {
  app.add_subcommand("bad_option")->callback([] {
    throw std::invalid_argument("--size: must be positive");
  });
}
void add_greedy(CLI::App& app) {
  app.add_subcommand("greedy")->callback([] { throw std::bad_alloc(); });
}
void add_outspoken(CLI::App& app) {
  app.add_subcommand("outspoken")->callback([] { throw CLI::RuntimeError(1); });
}

constexpr auto kCommands =
    std::to_array<AddCommand>({add_good, add_bad_input, add_bad_option, add_greedy, add_outspoken});

struct Outcome {
  int code = -1;
  std::string errors;  ///< stderr
};

/// The program sampler, run with these words.
Outcome run(std::vector<const char*> words) {
  words.insert(words.begin(), "sampler");
  std::FILE* const file = std::tmpfile();
  REQUIRE(file != nullptr);
  const int kept = ::dup(STDERR_FILENO);
  ::dup2(::fileno(file), STDERR_FILENO);
  Outcome outcome;
  outcome.code = run_program({"sampler", "Tries things.", kCommands},
                             static_cast<int>(words.size()), words.data());
  std::fflush(stderr);
  ::dup2(kept, STDERR_FILENO);
  ::close(kept);
  REQUIRE(std::fseek(file, 0, SEEK_SET) == 0);
  std::array<char, 1024> part{};
  outcome.errors.assign(part.data(), std::fread(part.data(), 1, part.size(), file));
  std::fclose(file);
  return outcome;
}

bool says(const Outcome& outcome, const std::string& text) {
  return outcome.errors.find(text) != std::string::npos;
}

}  // namespace

TEST_CASE("a program whose command does its work ends with 0, and so do --help and --version") {
  CHECK(run({"good"}).code == 0);
  CHECK(run({"good"}).errors.empty());
  CHECK(run({"--help"}).code == 0);
  CHECK(run({"--version"}).code == 0);
  CHECK(run({"good", "--help"}).code == 0);
}

TEST_CASE("bad input ends a program with 1, and it says in its name what is bad") {
  const Outcome bad = run({"bad_input"});
  CHECK(bad.code == 1);
  CHECK(bad.errors == "sampler: the file is torn\n");
  const Outcome greedy = run({"greedy"});
  CHECK(greedy.code == 1);
  CHECK(greedy.errors == "sampler: not enough memory\n");
}

TEST_CASE("a command that has said itself what is wrong is not talked over") {
  const Outcome outspoken = run({"outspoken"});
  CHECK(outspoken.code == 1);
  CHECK(outspoken.errors.empty());
}

TEST_CASE("a command line that makes no sense ends a program with 2, and the word is named") {
  const Outcome option = run({"bad_option"});
  CHECK(option.code == 2);
  CHECK(option.errors == "sampler: --size: must be positive\n");
  CHECK(run({}).code == 2);
  const Outcome unknown = run({"goood"});
  CHECK(unknown.code == 2);
  CHECK(says(unknown, "There is no command or option goood. "));
  CHECK(run({"good", "--size"}).code == 2);
}

}  // namespace hapticd::test
