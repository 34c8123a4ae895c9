// What hapticctl shows of daemons that it has found on the network.
#include "clients/ctl/discovery.h"

#include <doctest/doctest.h>

using hapticd::ctl::FoundDaemon;
using hapticd::ctl::printable;
using hapticd::ctl::server_text;

TEST_CASE("a name from the network becomes printable ASCII of bounded length") {
  CHECK(printable("hapticd on studio #2") == "hapticd on studio #2");
  for (int byte = 0; byte < 256; ++byte) {
    const std::string shown = printable(std::string(1, static_cast<char>(byte)));
    const bool plain = byte >= 0x20 && byte < 0x7f;
    CHECK(shown == (plain ? std::string(1, static_cast<char>(byte)) : "?"));
  }
  CHECK(printable(std::string(10000, 'a')).size() == 128);
}

TEST_CASE("where a found daemon is can be given to --server, IPv6 in brackets") {
  FoundDaemon found;
  found.port = 47800;
  found.address = "192.168.1.7";
  CHECK(server_text(found) == "192.168.1.7:47800");
  found.address = "fe80::1%eth0";
  CHECK(server_text(found) == "[fe80::1%eth0]:47800");
}
