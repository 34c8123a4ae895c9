// Hosts and ports as people write them.
#include "clients/library/endpoint.h"

#include <doctest/doctest.h>

#include <stdexcept>
#include <string>
#include <tuple>

namespace hapticd::test {
namespace {

using client::parse_endpoint;

TEST_CASE("what is written is taken, what is left out is as it was") {
  const std::tuple<const char*, const char*, int> cases[] = {
      {"stage:4711", "stage", 4711},
      {"stage", "stage", 47800},
      {":4711", "127.0.0.1", 4711},
      {"[fe80::1]:9", "fe80::1", 9},
      {"[::1]", "::1", 47800},
      {"fe80::1", "fe80::1", 47800},
      {"10.0.0.2:65535", "10.0.0.2", 65535},
  };
  for (const auto& [text, host, port] : cases) {
    CAPTURE(text);
    const client::Endpoint endpoint = parse_endpoint(text);
    CHECK(endpoint.host == host);
    CHECK(endpoint.port == port);
  }
  CHECK(parse_endpoint(":9", {"0.0.0.0", 8080}).host == "0.0.0.0");
  CHECK(parse_endpoint("stage", {"0.0.0.0", 8080}).port == 8080);
}

TEST_CASE("what is no host and port is refused, and quoted") {
  for (const std::string text :
       {"stage:", "stage:x", "stage:65536", "stage:-1", "stage:0", "[::1", "[::1]9", "stage:9x"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_endpoint(text), std::invalid_argument);
    CHECK_THROWS_WITH(parse_endpoint(text), doctest::Contains(text.c_str()));
  }
  CHECK(parse_endpoint("stage:0", {}, true).port == 0);
}

}  // namespace
}  // namespace hapticd::test
