// The command that the log shows as the daemon starts.
#include "server/daemon/command_to_reach.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <string>

namespace hapticd::test {

TEST_CASE("who types the command that the log shows reaches the daemon, from any folder") {
  CHECK(command_to_reach("127.0.0.1:47800", "") == "hapticctl status");
  CHECK(command_to_reach("0.0.0.0:47800", "") == "hapticctl status");
  CHECK(command_to_reach("127.0.0.1:48910", "") == "hapticctl --server 127.0.0.1:48910 status");
  CHECK(command_to_reach("0.0.0.0:9", "") == "hapticctl --server 127.0.0.1:9 status");
  CHECK(command_to_reach("[::]:47800", "") == "hapticctl --server [::1]:47800 status");
  CHECK(command_to_reach("192.168.0.7:47800", "/etc/hapticd") ==
        "hapticctl --server 192.168.0.7:47800 --key /etc/hapticd/control.key status");
  const std::string here = std::filesystem::current_path().string();
  CHECK(command_to_reach("127.0.0.1:47800", "keys") ==
        "hapticctl --key " + here + "/keys/control.key status");
  CHECK(command_to_reach("127.0.0.1:47800", "/a b/it's") ==
        "hapticctl --key '/a b/it'\\''s/control.key' status");
}

}  // namespace hapticd::test
