// Texts that people type: addresses, values. Truth: the cases.
#include "clients/ctl/text.h"

#include <doctest/doctest.h>

#include "clients/ctl/connection.h"
#include "hapticd/v1/gesture.pb.h"

namespace hapticd::test {

using namespace hapticd::ctl;

namespace {

/// Exit code of the Failure that `action` ends with; 0: none.
template <typename Action>
int failure_of(const Action& action) {
  try {
    action();
  } catch (const Failure& failure) {
    CHECK(std::string(failure.what()).size() > 5);
    return failure.exit_code();
  }
  return 0;
}

/// What hapticctl --server `text` asks for.
GlobalOptions asking(const char* text) {
  GlobalOptions options;
  options.daemon.server = text;
  return options;
}

}  // namespace

TEST_CASE("an address is a host, a host with a port, or an IPv6 address in brackets") {
  const auto reads = [](const char* text, const char* host, int port) {
    const client::Endpoint endpoint = server_of(asking(text));
    return endpoint.host == host && endpoint.port == port;
  };
  CHECK(reads("127.0.0.1:47800", "127.0.0.1", 47800));
  CHECK(reads("desk", "desk", 47800));
  CHECK(reads(":5000", "127.0.0.1", 5000));
  CHECK(reads("[::1]:5000", "::1", 5000));
  CHECK(reads("[fe80::1]", "fe80::1", 47800));
  CHECK(reads("fe80::1", "fe80::1", 47800));
  for (const char* bad : {"a:b", "a:0", "a:65536", "a:1x", "a:", "[::1", "[::1]x"}) {
    CAPTURE(bad);
    CHECK(failure_of([&] { (void)server_of(asking(bad)); }) == kUsageBad);
  }
}

TEST_CASE("a value is a number, a truth value, a list or a text, and prints as it was typed") {
  CHECK(parse_assignment("strings[3].tension_n=80.5").number() == 80.5);
  CHECK(parse_assignment("a=-1e-3").number() == -1e-3);
  CHECK(parse_assignment("a=true").flag());
  CHECK(parse_assignment("a=false").value_case() == v1::Assignment::kFlag);
  CHECK(parse_assignment("quality=auto").text() == "auto");
  CHECK(parse_assignment("p=[1, 2,3]").numbers().values_size() == 3);
  CHECK(parse_assignment("p=[1,x]").text() == "[1,x]");
  for (const char* text :
       {"strings[3].tension_n=80.5", "a=0.1", "b=true", "c=auto", "d=[1,-2,0.3]"}) {
    CHECK(to_text(parse_assignment(text)) == text);
  }
  for (const char* bad : {"", "a", "=1", "a="}) {
    CHECK(failure_of([&] { (void)parse_assignment(bad); }) == kUsageBad);
  }
}

TEST_CASE("names lose what all values of their enum begin with") {
  CHECK(plain_name("LOOP_STATE_ENGAGED", "LOOP_STATE_") == "engaged");
  CHECK(plain_name("CAUSE_INPUT_STALE", "CAUSE_") == "input stale");
}

TEST_CASE("a text that is no message is refused with its line, a file that is not there by name") {
  v1::Gesture gesture;
  parse_text("name: \"g\"", "g.textproto", gesture);
  CHECK(gesture.name() == "g");
  try {
    parse_text("name: \"g\"\nwood: 1", "g.textproto", gesture);
    CHECK(false);
  } catch (const Failure& failure) {
    CHECK(std::string(failure.what()).starts_with("g.textproto:2:"));
  }
  const auto said = [](const char* source) -> std::string {
    try {
      (void)read_source(source);
    } catch (const Failure& failure) {
      CHECK(failure.exit_code() == kRefused);
      return failure.what();
    }
    return "";
  };
  CHECK(said("/nowhere/at/all") == "/nowhere/at/all: there is no such file.");
  CHECK(said("/") == "/: is a folder. Name a file.");
  CHECK(said("No") ==
        "No: there is no such file. What is installed has a name of a-z 0-9 _ - alone.");
  CHECK(names_file("./a"));
  CHECK(names_file("a.textproto"));
  for (const char* file : {"gugin.txt", "Guqin", "my scene", "x.", "\xc3\xa9"}) {
    CAPTURE(file);
    CHECK(names_file(file));
  }
  for (const char* name : {"guqin", "single_string", "a-1", ""}) CHECK(!names_file(name));
}

}  // namespace hapticd::test
