// Keys of single clients: made, read by the daemon, and revoked.
#include "proto/noise/client_keys.h"

#include <algorithm>

#include "tests/proto/noise/key_place.h"

namespace hapticd::noise {
namespace {

/// A folder with the keys of a daemon.
struct KeyPlace {
  Folder folder;
  ServerKeys keys;

  KeyPlace() {
    make_key_folder(folder.path());
    keys = read_key_folder(folder.path());
  }
  [[nodiscard]] const fs::path& path() const { return folder.path(); }
  [[nodiscard]] ClientKeys read() const { return read_client_keys(folder.path(), keys); }
};

TEST_CASE("the name of a client is 1 to 64 small letters, digits, underscores and hyphens") {
  for (const std::string& name : {std::string("a"), std::string("lab-1_b"), std::string(64, 'z')}) {
    CHECK(is_client_name(name));
  }
  for (const std::string& name :
       {std::string(), std::string(65, 'z'), std::string("A"), std::string("a.b"),
        std::string("../x"), std::string("a b"), std::string("a\n"), std::string("\xc3\xa4")}) {
    CHECK(!is_client_name(name));
    const KeyPlace place;
    CHECK(says(complaint([&] { make_client_key(place.path(), name, Role::kView); }), "name"));
    CHECK(says(complaint([&] { revoke_client_key(place.path(), name); }), "name"));
  }
}

TEST_CASE("the key of a client is its own, names the daemon, and is gone once revoked") {
  const KeyPlace place;
  CHECK(place.read().known.empty());
  const fs::path file = make_client_key(place.path(), "stage", Role::kControl);
  make_client_key(place.path(), "hall", Role::kView);
  CHECK(file == place.path() / "clients" / "stage.key");
  struct stat status {};
  REQUIRE(::stat(file.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777U) == 0600U);
  const SessionKey held = read_session_key(file);
  CHECK(held.role == Role::kControl);
  CHECK(held.server == place.keys.server);
  const ClientKeys read = place.read();
  CHECK(read.problems.empty());
  REQUIRE(read.known.size() == 2);
  CHECK(read.known[0].name == "hall");
  CHECK(read.known[0].role == Role::kView);
  CHECK(read.known[1].name == "stage");
  CHECK(read.known[1].psk == held.psk);
  CHECK(!(read.known[0].psk == read.known[1].psk));
  for (const KnownKey& shared : place.keys.known) CHECK(!(shared.psk == held.psk));
  revoke_client_key(place.path(), "stage");
  CHECK(place.read().known.size() == 1);
  CHECK(says(complaint([&] { revoke_client_key(place.path(), "stage"); }), "no such key"));
}

TEST_CASE("no key of a client is overwritten, and none made where hapticd would not know it") {
  const KeyPlace place;
  const fs::path file = make_client_key(place.path(), "c", Role::kView);
  const std::string before = content(file);
  const auto again = [&] { make_client_key(place.path(), "c", Role::kControl); };
  CHECK(says(complaint(again), "exists already"));
  CHECK(content(file) == before);
  for (int i = 1; i < 64; ++i) make_client_key(place.path(), "c" + std::to_string(i), Role::kView);
  CHECK(says(complaint([&] { make_client_key(place.path(), "more", Role::kView); }), "64 keys"));
  CHECK(place.read().known.size() == 64);
  const Folder empty;
  CHECK(says(complaint([&] { make_client_key(empty.path(), "c", Role::kView); }), "server.key"));
}

TEST_CASE("a file that is no key of a client costs the others nothing, and is named") {
  const KeyPlace place;
  const fs::path good = make_client_key(place.path(), "good", Role::kView);
  const fs::path clients = good.parent_path();
  write(clients / "short.key", "x");
  write(clients / "old.key", std::string(32, 'o'));
  write(clients / "open.key", content(good), 0644);
  write(clients / "twin.key", content(good));
  write(clients / "view.key", content(place.path() / kViewKeyName));
  write(clients / "Big.key", content(good));
  write(clients / "other.key", key_bytes(1, 'p', std::string(32, 's')));
  fs::create_directory(clients / "folder.key");
  write(clients / "note.txt", "no key, and not looked at");
  write(clients / "late.key.part", "being written");
  const ClientKeys read = place.read();
  REQUIRE(read.known.size() == 1);
  CHECK(read.known[0].name == "good");
  CHECK(read.problems.size() == 8);
  for (const char* name : {"short", "old", "open", "twin", "view", "Big", "other", "folder"}) {
    CAPTURE(name);
    const auto named = [&](const std::string& problem) {
      return says(problem, std::string(name) + ".key: ");
    };
    CHECK(std::any_of(read.problems.begin(), read.problems.end(), named));
  }
}

}  // namespace
}  // namespace hapticd::noise
