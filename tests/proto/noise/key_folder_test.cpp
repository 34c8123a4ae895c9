// The folder of a daemon's keys: made once, completed where an earlier version made it, and refused
// with a remedy when anything is wrong.
#include "proto/noise/key_folder.h"

#include <sodium.h>

#include "tests/proto/noise/key_place.h"

namespace hapticd::noise {
namespace {

constexpr const char* kAll[] = {kServerKeyName, kViewKeyName, kControlKeyName, kStopKeyName};

TEST_CASE("keygen makes four different keys that only their owner may touch") {
  const Folder folder;
  const fs::path made = folder.path() / "made";
  make_key_folder(made);
  const ServerKeys keys = read_key_folder(made);
  REQUIRE(keys.known.size() == 2);
  CHECK(keys.known[0].role == Role::kView);
  CHECK(keys.known[1].role == Role::kControl);
  CHECK(!(keys.known[0].psk == keys.known[1].psk));
  CHECK(!(keys.known[0].psk == SecretKey()));
  const SecretKey stop = read_bare_key(made / kStopKeyName);
  for (const SecretKey& other : {keys.known[0].psk, keys.known[1].psk, keys.own}) {
    CHECK(!(stop == other));
  }
  // Whoever has a file knows the daemon by the public half of server.key.
  Key server;
  REQUIRE(crypto_scalarmult_base(server.data(), keys.own.get().data()) == 0);
  CHECK(keys.server == server);
  CHECK(read_session_key(made / kViewKeyName).server == server);
  CHECK(read_session_key(made / kControlKeyName).server == server);
  for (const char* name : kAll) {
    struct stat status {};
    REQUIRE(::stat((made / name).c_str(), &status) == 0);
    CHECK((status.st_mode & 0777U) == 0600U);
  }
  make_key_folder(folder.path() / "again");
  CHECK(!(read_key_folder(folder.path() / "again").own == keys.own));
}

TEST_CASE("keygen gives a folder of an earlier version what it lacks, and keeps its psks") {
  const Folder folder;
  write(folder.path() / kViewKeyName, std::string(32, 'v'));
  write(folder.path() / kControlKeyName, std::string(32, 'c'));
  write(folder.path() / kStopKeyName, std::string(32, 's'));
  const std::string told = complaint([&] { (void)read_key_folder(folder.path()); });
  CHECK(says(told, "earlier version"));
  CHECK(says(told, "hapticctl keygen"));
  make_key_folder(folder.path());
  const ServerKeys keys = read_key_folder(folder.path());
  CHECK(keys.known[0].psk.get()[0] == 'v');
  CHECK(keys.known[1].psk.get()[0] == 'c');
  CHECK(content(folder.path() / kStopKeyName) == std::string(32, 's'));
  CHECK(says(complaint([&] { make_key_folder(folder.path()); }), "exists already"));
  CHECK(read_key_folder(folder.path()).own == keys.own);
}

TEST_CASE("keygen that was interrupted while it completed a folder goes on") {
  const Folder folder;
  make_key_folder(folder.path());
  const SecretKey own = read_key_folder(folder.path()).own;
  fs::remove(folder.path() / kViewKeyName);
  write(folder.path() / kViewKeyName, std::string(32, 'v'));
  fs::remove(folder.path() / kStopKeyName);
  make_key_folder(folder.path());
  CHECK(read_key_folder(folder.path()).own == own);
  CHECK(read_key_folder(folder.path()).known[0].psk.get()[0] == 'v');
  CHECK(fs::exists(folder.path() / kStopKeyName));
}

TEST_CASE("keygen overwrites no key, and makes none beside one") {
  const Folder folder;
  write(folder.path() / kControlKeyName, std::string(32, 'c'));
  CHECK(says(complaint([&] { make_key_folder(folder.path()); }), "exists already"));
  CHECK(!fs::exists(folder.path() / kViewKeyName));
  CHECK(content(folder.path() / kControlKeyName) == std::string(32, 'c'));
}

TEST_CASE("keygen says so where it may not write") {
  CHECK(says(complaint([] { make_key_folder("/proc/hapticd_keys"); }), "another folder"));
}

TEST_CASE("two equal keys are refused: who may look could control") {
  const Folder folder;
  make_key_folder(folder.path());
  const std::string server = content(folder.path() / kViewKeyName).substr(40);
  write(folder.path() / kViewKeyName, key_bytes(1, 'k', server));
  write(folder.path() / kControlKeyName, key_bytes(2, 'k', server));
  CHECK(says(complaint([&] { (void)read_key_folder(folder.path()); }), "equal"));
}

TEST_CASE("a key of another role, of another daemon or that is missing is refused by name") {
  const Folder folder;
  make_key_folder(folder.path());
  const std::string view = content(folder.path() / kViewKeyName);
  std::string other = view;
  other[7] = 2;
  write(folder.path() / kViewKeyName, other);
  CHECK(says(complaint([&] { (void)read_key_folder(folder.path()); }), "another role"));
  other = view;
  other[71] = static_cast<char>(other[71] ^ 1);
  write(folder.path() / kViewKeyName, other);
  CHECK(says(complaint([&] { (void)read_key_folder(folder.path()); }), "another daemon"));
  write(folder.path() / kViewKeyName, view);
  for (const char* name : {kServerKeyName, kViewKeyName, kControlKeyName}) {
    fs::rename(folder.path() / name, folder.path() / "away");
    CHECK(says(complaint([&] { (void)read_key_folder(folder.path()); }), name));
    fs::rename(folder.path() / "away", folder.path() / name);
  }
  fs::remove(folder.path() / kServerKeyName);
  CHECK(says(complaint([&] { make_key_folder(folder.path()); }), "server.key"));
}

}  // namespace
}  // namespace hapticd::noise
