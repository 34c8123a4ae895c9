// What hapticd refuses of its options and configuration, and in which words.
#include "server/daemon/daemon_options.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "proto/wire/shown_text.h"

namespace hapticd::test {
namespace {

/// What is said of a configuration with one device, changed; "" where it is taken.
template <typename Change>
std::string refusal_of(const Change& change) {
  DaemonOptions options;
  change(options.given);
  try {
    settle_config(options);
  } catch (const StartError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a value that is refused is quoted so that no terminal obeys it") {
  CHECK(refusal_of([](v1::Config&) {}).empty());
  for (const std::string& text :
       {refusal_of([](auto& given) { given.set_quality("\x1b[31m"); }),
        refusal_of([](auto& given) { given.set_inject("\x1b[31m"); }),
        refusal_of([](auto& given) { given.add_device()->set_source("\x1b[31m\xff"); })}) {
    CAPTURE(text);
    CHECK(text.find("'\\u001b[31m") != std::string::npos);
    CHECK(wire::is_plain(text));
  }
}

TEST_CASE("a device that plays a file, and a fault without a seed, are told their forms") {
  const auto of_source = [](const char* source) {
    return refusal_of([source](auto& given) { given.add_device()->set_source(source); });
  };
  for (const char* source : {"replay", "replay:"}) {
    CAPTURE(source);
    CHECK(of_source(source).find("the name of the file is missing") != std::string::npos);
    CHECK(of_source(source).find("Give replay:FILE.") != std::string::npos);
  }
  CHECK(of_source("replya:x").find("Did you mean replay:FILE?") != std::string::npos);
  CHECK(of_source("simulatd").find("Did you mean simulated?") != std::string::npos);
  CHECK(refusal_of([](auto& given) { given.set_inject("lost"); }).empty());
  CHECK(refusal_of([](auto& given) { given.set_inject("lost:"); }).find("Give WHAT or WHAT:SEED") !=
        std::string::npos);
}

TEST_CASE("a configuration that is a folder is refused, an empty file is not") {
  v1::Config config;
  CHECK_THROWS_WITH_AS(read_config_file("/", config),
                       "/: is a folder. Name a readable file with --config.", StartError);
  read_config_file("/dev/null", config);
  CHECK(config.ByteSizeLong() == 0);
}

TEST_CASE("whole numbers of the command line are whole, and in range") {
  const auto said = [](std::vector<const char*> words) -> std::string {
    DaemonOptions options;
    words.insert(words.begin(), "hapticd");
    try {
      (void)read_options(static_cast<int>(words.size()), words.data(), options);
    } catch (const StartError& error) {
      CHECK(error.exit_code() == kExitUsage);
      return error.what();
    }
    return "";
  };
  for (const char* seed : {"-1", "99999999999999999999999", "1.5", "1e3"}) {
    CAPTURE(seed);
    CHECK(said({"--seed", seed})
              .starts_with("--seed: '" + std::string(seed) +
                           "' is not a whole number from 0 to "
                           "18446744073709551615."));
  }
  CHECK(said({"--seed", "18446744073709551615"}).empty());
  CHECK(said({"--cpu", "-1"}).find("from 0 to 1023.") != std::string::npos);
  CHECK(said({"--scene=", "--check"}).starts_with("--scene: the value is missing."));
}

}  // namespace hapticd::test
