// What the log says of who opened a session.
#include "server/daemon/session_log.h"

#include <doctest/doctest.h>

namespace hapticd::test {
namespace {

TEST_CASE("a session is told by the name of its key, what it may and where it is") {
  SessionNotice notice{true, 7, ipv4_address({10, 0, 0, 2}, 5000), true, "stage"};
  CHECK(who_is(notice) == "key stage (control) at 10.0.0.2:5000");
  notice.may_control = false;
  CHECK(who_is(notice) == "key stage (view) at 10.0.0.2:5000");
  notice.key_name.clear();
  CHECK(who_is(notice) == "view.key at 10.0.0.2:5000");
  notice.may_control = true;
  notice.address = {};
  notice.address.ip[0] = 0x20;
  notice.address.ip[1] = 0x01;
  notice.address.ip[15] = 9;
  notice.address.port = 1;
  CHECK(who_is(notice) == "control.key at [2001::9]:1");
}

}  // namespace
}  // namespace hapticd::test
