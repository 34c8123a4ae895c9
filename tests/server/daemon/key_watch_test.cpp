// The keys of clients come and go while the daemon runs. A real folder, virtual time.
#include "server/daemon/key_watch.h"

#include <doctest/doctest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// A folder of keys that goes with the test.
struct KeyPlace {
  fs::path folder;

  KeyPlace() {
    std::string pattern = (fs::temp_directory_path() / "key_watch_XXXXXX").string();
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    folder = pattern;
    noise::make_key_folder(folder);
  }
  ~KeyPlace() { fs::remove_all(folder); }
  KeyPlace(const KeyPlace&) = delete;
  KeyPlace& operator=(const KeyPlace&) = delete;
};

TEST_CASE("a key that is made is known, one that is removed is not, and half a second is enough") {
  const KeyPlace place;
  noise::make_client_key(place.folder, "first", noise::Role::kView);
  KeyWatch watch(place.folder);
  REQUIRE(watch.keys().known.size() == 3);
  CHECK(watch.keys().known[2].name == "first");
  std::int64_t now_ns = kSecond_ns;
  CHECK(!watch.follow(now_ns));
  noise::make_client_key(place.folder, "second", noise::Role::kControl);
  CHECK(!watch.follow(now_ns + kSecond_ns / 2 - 1));
  now_ns += kSecond_ns / 2;
  CHECK(watch.follow(now_ns));
  REQUIRE(watch.keys().known.size() == 4);
  CHECK(watch.keys().known[3].role == noise::Role::kControl);
  CHECK(!watch.follow(now_ns + kSecond_ns));
  noise::revoke_client_key(place.folder, "first");
  CHECK(watch.follow(now_ns += 2 * kSecond_ns));
  REQUIRE(watch.keys().known.size() == 3);
  CHECK(watch.keys().known[2].name == "second");
  fs::remove_all(place.folder / "clients");
  CHECK(watch.follow(now_ns += kSecond_ns));
  CHECK(watch.keys().known.size() == 2);
  CHECK(watch.problems().empty());
}

TEST_CASE("another key in the place of one, and a mode that is put right, are seen") {
  const KeyPlace place;
  const fs::path file = noise::make_client_key(place.folder, "c", noise::Role::kView);
  KeyWatch watch(place.folder);
  const noise::SecretKey before = watch.keys().known[2].psk;
  noise::revoke_client_key(place.folder, "c");
  noise::make_client_key(place.folder, "c", noise::Role::kView);
  CHECK(watch.follow(kSecond_ns));
  CHECK(!(watch.keys().known[2].psk == before));
  fs::permissions(file, fs::perms::owner_read | fs::perms::others_read);
  CHECK(watch.follow(2 * kSecond_ns));
  CHECK(watch.keys().known.size() == 2);
  REQUIRE(watch.problems().size() == 1);
  CHECK(watch.problems()[0].find("chmod 600") != std::string::npos);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  CHECK(watch.follow(3 * kSecond_ns));
  CHECK(watch.keys().known.size() == 3);
  CHECK(watch.problems().empty());
}

}  // namespace
}  // namespace hapticd::test
