// Key files: made once, for their owner alone, and refused with a remedy when anything is wrong.
#include "proto/noise/key_file.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace hapticd::noise {
namespace {

namespace fs = std::filesystem;

/// A folder that goes with the test.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("hapticd_keys_" + std::to_string(::getpid()))) {
    fs::remove_all(path_);
    fs::create_directory(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void write(const fs::path& file, const std::string& bytes, mode_t mode = 0600) {
  std::ofstream(file, std::ios::binary) << bytes;
  REQUIRE(::chmod(file.c_str(), mode) == 0);
}

template <typename Call>
std::string complaint(const Call& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_CASE("keygen makes three different keys that only their owner may touch") {
  const Folder folder;
  make_key_folder(folder.path() / "made");
  const KeyPair keys = read_key_folder(folder.path() / "made");
  CHECK(keys.view != keys.control);
  CHECK(keys.view != Key{});
  const Key stop = read_key_file(folder.path() / "made" / kStopKeyName);
  CHECK(stop != keys.view);
  CHECK(stop != keys.control);
  for (const char* name : {kViewKeyName, kControlKeyName, kStopKeyName}) {
    struct stat status {};
    REQUIRE(::stat((folder.path() / "made" / name).c_str(), &status) == 0);
    CHECK((status.st_mode & 0777U) == 0600U);
    CHECK(status.st_size == 32);
  }
  make_key_folder(folder.path() / "again");
  CHECK(read_key_folder(folder.path() / "again").control != keys.control);
}

TEST_CASE(
    "keygen gives a folder of an earlier version the key that it lacks, and touches no other") {
  const Folder folder;
  write(folder.path() / kViewKeyName, std::string(32, 'v'));
  write(folder.path() / kControlKeyName, std::string(32, 'c'));
  make_key_folder(folder.path());
  CHECK(read_key_folder(folder.path()).view[0] == 'v');
  CHECK(read_key_folder(folder.path()).control[0] == 'c');
  const Key made = read_key_file(folder.path() / kStopKeyName);
  CHECK(says(complaint([&] { make_key_folder(folder.path()); }), "exists already"));
  CHECK(read_key_file(folder.path() / kStopKeyName) == made);
}

TEST_CASE("keygen overwrites no key, and makes none beside one") {
  const Folder folder;
  write(folder.path() / kControlKeyName, std::string(32, 'c'));
  CHECK(says(complaint([&] { make_key_folder(folder.path()); }), "exists already"));
  CHECK(!fs::exists(folder.path() / kViewKeyName));
  CHECK(read_key_file(folder.path() / kControlKeyName)[0] == 'c');
}

TEST_CASE("keygen says so where it may not write") {
  CHECK(says(complaint([] { make_key_folder("/proc/hapticd_keys"); }), "another folder"));
}

TEST_CASE("a key that others may touch is refused with the command that helps") {
  const Folder folder;
  const fs::path file = folder.path() / "k";
  for (const mode_t mode : {0640U, 0604U, 0610U, 0602U, 0666U}) {
    write(file, std::string(32, 'k'), mode);
    CHECK(says(complaint([&] { (void)read_key_file(file); }), "chmod 600 " + file.string()));
  }
  for (const mode_t mode : {0600U, 0400U}) {
    write(file, std::string(32, 'k'), mode);
    CHECK(read_key_file(file)[31] == 'k');
    REQUIRE(::chmod(file.c_str(), 0600) == 0);
  }
}

TEST_CASE("what is no file of 32 bytes is no key") {
  const Folder folder;
  for (const std::size_t size : {0U, 31U, 33U, 64U}) {
    write(folder.path() / "k", std::string(size, 'k'));
    CHECK(says(complaint([&] { (void)read_key_file(folder.path() / "k"); }), "32 bytes"));
  }
  CHECK(says(complaint([&] { (void)read_key_file(folder.path()); }), "32 bytes"));
  CHECK(says(complaint([&] { (void)read_key_file(folder.path() / "none"); }), "keygen"));
}

TEST_CASE("two equal keys are refused: who may look could control") {
  const Folder folder;
  write(folder.path() / kViewKeyName, std::string(32, 'k'));
  CHECK(says(complaint([&] { (void)read_key_folder(folder.path()); }), kControlKeyName));
  write(folder.path() / kControlKeyName, std::string(32, 'k'));
  CHECK(says(complaint([&] { (void)read_key_folder(folder.path()); }), "equal"));
}

}  // namespace
}  // namespace hapticd::noise
