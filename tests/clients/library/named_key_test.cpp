// Truth: the keys that make_key_folder() wrote, and what --role promises.
#include "clients/library/named_key.h"

#include <doctest/doctest.h>
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>

#include "proto/noise/key_folder.h"

namespace hapticd::test {

TEST_CASE("a key has the role that is named, else its own, and no file is no key") {
  std::string pattern = (std::filesystem::temp_directory_path() / "named_key_XXXXXX").string();
  REQUIRE(mkdtemp(pattern.data()) != nullptr);
  const std::filesystem::path folder = pattern;
  noise::make_key_folder(folder);
  const std::string view = folder / noise::kViewKeyName;
  const std::string control = folder / noise::kControlKeyName;
  CHECK_FALSE(client::named_key("").has_value());
  CHECK_FALSE(client::named_key("", "view").has_value());
  CHECK(client::named_key(view).value().role == wire::Role::kView);
  CHECK(client::named_key(control).value().role == wire::Role::kControl);
  CHECK(client::named_key(view, "control").value().role == wire::Role::kControl);
  CHECK(client::named_key(control, "view").value().role == wire::Role::kView);
  CHECK(client::named_key(control).value().psk == noise::read_session_key(control).psk);
  CHECK_THROWS_AS((void)client::named_key(control, "owner"), std::invalid_argument);
  CHECK_THROWS_AS((void)client::named_key(folder / "none.key"), std::runtime_error);
  std::filesystem::remove_all(folder);
}

}  // namespace hapticd::test
