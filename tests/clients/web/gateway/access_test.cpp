// Who may look and control, by hand-made heads of handshakes.
#include "clients/web/gateway/access.h"

#include <doctest/doctest.h>

#include <set>

namespace hapticd::test {
namespace {

using web::carries_token;
using web::is_own_host;
using web::may_look;
using web::own_subprotocol;

TEST_CASE("addresses, localhost and names that were given are this machine, other names are not") {
  for (const char* host : {"127.0.0.1:8080", "127.0.0.1", "[::1]:8080", "[fe80::1]", "localhost",
                           "LOCALHOST:1", "10.0.0.2:443", "stage:8080", "Stage"}) {
    CAPTURE(host);
    CHECK(is_own_host(host, {"stage"}));
  }
  for (const char* host : {"", "evil.example:8080", "127.0.0.1.evil.example", "localhost.evil",
                           "stage.evil", "1.2.3", "[::1"}) {
    CAPTURE(host);
    CHECK_FALSE(is_own_host(host, {"stage.house"}));
  }
}

TEST_CASE("a page of elsewhere may not look, whatever name it gave this machine") {
  CHECK(may_look("http://127.0.0.1:8080", "127.0.0.1:8080", false, {}));
  CHECK(may_look("https://stage:8080", "stage:8080", true, {"stage"}));
  CHECK(may_look("", "127.0.0.1:8080", false, {}));
  CHECK_FALSE(may_look("http://evil.example", "127.0.0.1:8080", false, {}));
  CHECK_FALSE(may_look("http://127.0.0.1:9999", "127.0.0.1:8080", false, {}));
  CHECK_FALSE(may_look("https://127.0.0.1:8080", "127.0.0.1:8080", false, {}));
  CHECK_FALSE(may_look("null", "127.0.0.1:8080", false, {}));
  // A name that points here although we never heard of it.
  CHECK_FALSE(may_look("http://evil.example:8080", "evil.example:8080", false, {}));
}

TEST_CASE("our subprotocol is found among others, with and without a token") {
  CHECK(own_subprotocol("hapticd.v1") == "hapticd.v1");
  CHECK(own_subprotocol("mqtt, hapticd.v1.abc ,x") == "hapticd.v1.abc");
  CHECK(own_subprotocol("hapticd.v12").empty());
  CHECK(own_subprotocol("").empty());
}

TEST_CASE("only the whole token counts, and no token is nobody's") {
  CHECK(carries_token("hapticd.v1.0123", "0123"));
  CHECK_FALSE(carries_token("hapticd.v1.0124", "0123"));
  CHECK_FALSE(carries_token("hapticd.v1.012", "0123"));
  CHECK_FALSE(carries_token("hapticd.v1.01234", "0123"));
  CHECK_FALSE(carries_token("hapticd.v1", ""));
  CHECK_FALSE(carries_token("hapticd.v1.", ""));
}

TEST_CASE("tokens have 32 digits and do not repeat") {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string token = web::make_token();
    CHECK(token.size() == 32);
    CHECK(token.find_first_not_of("0123456789abcdef") == std::string::npos);
    tokens.insert(token);
  }
  CHECK(tokens.size() == 100);
}

}  // namespace
}  // namespace hapticd::test
