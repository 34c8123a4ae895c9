// Hosts and ports as people write them.
#include "clients/library/endpoint.h"

#include <doctest/doctest.h>

#include <stdexcept>
#include <string>

namespace hapticd::test {
namespace {

using client::parse_endpoint;

TEST_CASE("what is written is taken, what is left out is as it was") {
  struct Case {
    const char* text;
    const char* host;
    int port;
  };
  const Case cases[] = {
      {"stage:4711", "stage", 4711},
      {"stage", "stage", 47800},
      {":4711", "127.0.0.1", 4711},
      {"[fe80::1]:9", "fe80::1", 9},
      {"[::1]", "::1", 47800},
      {"fe80::1", "fe80::1", 47800},
      {"fe80::1%eth0", "fe80::1%eth0", 47800},
      {"[::ffff:10.0.0.2]:9", "::ffff:10.0.0.2", 9},
      {"10.0.0.2:65535", "10.0.0.2", 65535},
  };
  for (const Case& each : cases) {
    CAPTURE(each.text);
    const client::Endpoint endpoint = parse_endpoint(each.text);
    CHECK(endpoint.host == each.host);
    CHECK(endpoint.port == each.port);
  }
  CHECK(parse_endpoint(":9", {"0.0.0.0", 8080}).host == "0.0.0.0");
  CHECK(parse_endpoint("stage", {"0.0.0.0", 8080}).port == 8080);
}

TEST_CASE("what is no host and port is refused, and quoted") {
  for (const std::string text : {"stage:", "stage:x", "stage:65536", "stage:-1", "stage:0", "[::1",
                                 "[::1]9", "stage:9x", "http://stage", "http://stage:9", "stage/x",
                                 "me@stage:9", "sta ge", "x:b:c", "udp:stage:9"}) {
    CAPTURE(text);
    CHECK_THROWS_AS((void)parse_endpoint(text), std::invalid_argument);
    CHECK_THROWS_WITH((void)parse_endpoint(text), doctest::Contains(text.c_str()));
  }
  CHECK(parse_endpoint("stage:0", {}, true).port == 0);
}

}  // namespace
}  // namespace hapticd::test
