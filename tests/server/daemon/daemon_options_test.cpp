// What hapticd refuses of its options and configuration, and in which words.
#include "server/daemon/daemon_options.h"

#include <doctest/doctest.h>

#include <string>

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

}  // namespace hapticd::test
