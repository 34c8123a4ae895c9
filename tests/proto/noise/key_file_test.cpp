// Key files: written for their owner alone, read whole, and refused with a remedy when anything is
// wrong.
#include "proto/noise/key_file.h"

#include "tests/proto/noise/key_place.h"

namespace hapticd::noise {
namespace {

const std::string kServer(32, 's');

TEST_CASE("a key file has 72 bytes: mark, role, psk and the public half of the daemon's key") {
  const Folder folder;
  const fs::path file = folder.path() / "k";
  write(file, key_bytes(1, 'p', kServer));
  const SessionKey key = read_session_key(file);
  CHECK(key.role == Role::kView);
  CHECK(key.psk.get()[31] == 'p');
  CHECK(key.server[0] == 's');
  write_session_key(folder.path() / "copy", key);
  CHECK(content(folder.path() / "copy") == key_bytes(1, 'p', kServer));
  CHECK(says(complaint([&] { write_session_key(file, key); }), "k: "));
}

TEST_CASE("whatever the umask, only the owner may touch what was written") {
  const Folder folder;
  for (const mode_t mask : {0U, 0777U, 022U}) {
    const mode_t before = ::umask(mask);
    const fs::path file = folder.path() / std::to_string(mask);
    write_bare_key(file, random_key());
    ::umask(before);
    struct stat status {};
    REQUIRE(::stat(file.c_str(), &status) == 0);
    CHECK((status.st_mode & 0777U) == 0600U);
  }
}

TEST_CASE("a key that others may touch is refused with the command that helps") {
  const Folder folder;
  const fs::path file = folder.path() / "k";
  for (const mode_t mode : {0640U, 0604U, 0610U, 0602U, 0666U}) {
    write(file, key_bytes(2, 'k', kServer), mode);
    CHECK(says(complaint([&] { (void)read_session_key(file); }), "chmod 600 " + file.string()));
    write(file, std::string(32, 'k'), mode);
    CHECK(says(complaint([&] { (void)read_bare_key(file); }), "chmod 600 " + file.string()));
  }
  for (const mode_t mode : {0600U, 0400U}) {
    write(file, key_bytes(2, 'k', kServer), mode);
    CHECK(read_session_key(file).psk.get()[31] == 'k');
    REQUIRE(::chmod(file.c_str(), 0600) == 0);
  }
}

TEST_CASE("a key of an earlier version is told from what is none, with its file and the remedy") {
  const Folder folder;
  const fs::path file = folder.path() / "k";
  write(file, std::string(32, 'k'));
  const std::string old = complaint([&] { (void)read_session_key(file); });
  CHECK(says(old, "earlier version"));
  CHECK(says(old, "hapticctl keygen"));
  CHECK(says(old, file.string()));
  std::string other_mark = key_bytes(1, 'k', kServer);
  other_mark[0] = 'H';
  for (const std::string& none :
       {std::string(), std::string(31, 'k'), std::string(64, 'k'), std::string(73, 'k'), other_mark,
        key_bytes(0, 'k', kServer), key_bytes(3, 'k', kServer), key_bytes(1, 'k', kServer + "s")}) {
    write(file, none);
    const std::string told = complaint([&] { (void)read_session_key(file); });
    CHECK(says(told, "72 bytes"));
    CHECK(!says(told, "earlier version"));
  }
  CHECK(says(complaint([&] { (void)read_session_key(folder.path()); }), "keygen"));
  CHECK(says(complaint([&] { (void)read_session_key(folder.path() / "none"); }), "keygen"));
}

TEST_CASE("a bare key has 32 bytes") {
  const Folder folder;
  for (const std::size_t size : {0U, 31U, 33U, 72U}) {
    write(folder.path() / "k", std::string(size, 'k'));
    CHECK(says(complaint([&] { (void)read_bare_key(folder.path() / "k"); }), "32 bytes"));
  }
  write(folder.path() / "k", std::string(32, 'k'));
  CHECK(read_bare_key(folder.path() / "k").get()[0] == 'k');
}

}  // namespace
}  // namespace hapticd::noise
