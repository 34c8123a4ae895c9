// What is served from folders. The hashes are those that the published program b2sum gives
// (`printf abc | b2sum -l 256`).
#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "clients/web/gateway/asset_store.h"
#include "clients/web/gateway/page_folder.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHashOfAbc =
    "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319";

/// A folder of its own that goes with it.
struct Folder {
  Folder() {
    std::string name = (fs::temp_directory_path() / "hapticd_web_XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  void write(const std::string& name, const std::string& bytes) const {
    fs::create_directories((path / name).parent_path());
    std::ofstream(path / name, std::ios::binary) << bytes;
  }
  fs::path path;
};

TEST_CASE("a file is found by what is in it, in whichever folder it is") {
  const Folder one;
  const Folder other;
  other.write("deep/body.ply", "abc");
  web::AssetStore store({one.path, other.path});
  CHECK(store.find(kHashOfAbc, 1) == "abc");
  CHECK(store.find(std::string(64, '0'), 1) == std::nullopt);
  CHECK(store.find("../deep/body.ply", 1) == std::nullopt);
}

TEST_CASE("a file that came later is found, one that changed is not given for what it was") {
  const Folder folder;
  web::AssetStore store({folder.path});
  CHECK(store.find(kHashOfAbc, 10) == std::nullopt);
  folder.write("late.tree", "abc");
  CHECK(store.find(kHashOfAbc, 2'000'000'000) == "abc");
  folder.write("late.tree", "abd");
  CHECK(store.find(kHashOfAbc, 2'000'000'001) == std::nullopt);
}

TEST_CASE("links are not followed out of a folder of assets") {
  const Folder folder;
  const Folder elsewhere;
  elsewhere.write("secret", "abc");
  fs::create_symlink(elsewhere.path / "secret", folder.path / "link.ply");
  fs::create_directory_symlink(elsewhere.path, folder.path / "more");
  web::AssetStore store({folder.path});
  CHECK(store.find(kHashOfAbc, 5'000'000'000) == std::nullopt);
}

TEST_CASE("the page's files are found by their path, with their type") {
  const Folder folder;
  folder.write("index.html", "<html>");
  folder.write("assets/app-1a2b.js", "go()");
  const auto index = web::page_file(folder.path, "/");
  REQUIRE(index.has_value());
  CHECK(index->bytes == "<html>");
  CHECK(index->type == "text/html; charset=utf-8");
  CHECK_FALSE(index->lasting);
  const auto script = web::page_file(folder.path, "/assets/app-1a2b.js?x=1");
  REQUIRE(script.has_value());
  CHECK(script->type == "text/javascript; charset=utf-8");
  CHECK(script->lasting);
}

TEST_CASE("no path leads out of the page's folder, nor to hidden files") {
  const Folder folder;
  folder.write("site/index.html", "<html>");
  folder.write("site/.env", "secret");
  folder.write("secret", "secret");
  fs::create_symlink(folder.path / "secret", folder.path / "site" / "link");
  for (const char* target :
       {"/../secret", "/%2e%2e/secret", "/link", "/.env", "//secret", "secret",
        "/site/../../secret", "/a b", "/nothing", "", "/..", "/assets/../.env"}) {
    CAPTURE(target);
    CHECK_FALSE(web::page_file(folder.path / "site", target).has_value());
  }
}

}  // namespace
}  // namespace hapticd::test
